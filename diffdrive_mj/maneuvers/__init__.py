"""Maneuvers: wheel rates in advance, computed for the robot that the driver believes in."""

from diffdrive_mj.maneuvers.legs import PERIOD as PERIOD
from diffdrive_mj.maneuvers.legs import RAMP as RAMP
from diffdrive_mj.maneuvers.legs import REST as REST
from diffdrive_mj.maneuvers.legs import Segment as Segment
from diffdrive_mj.maneuvers.legs import constant_rates as constant_rates
from diffdrive_mj.maneuvers.legs import sequence as sequence
from diffdrive_mj.maneuvers.standard import BY_NAME as BY_NAME
from diffdrive_mj.maneuvers.standard import arc as arc
from diffdrive_mj.maneuvers.standard import figure_eight as figure_eight
from diffdrive_mj.maneuvers.standard import slalom as slalom
from diffdrive_mj.maneuvers.standard import spin as spin
from diffdrive_mj.maneuvers.standard import square as square
from diffdrive_mj.maneuvers.standard import straight as straight
