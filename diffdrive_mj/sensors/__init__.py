"""What a robot and a tracker measure: a recording becomes the readings of real sensors."""

from diffdrive_mj.sensors.allan import allan_deviation as allan_deviation
from diffdrive_mj.sensors.encoder import Encoder as Encoder
from diffdrive_mj.sensors.gyro import Gyro as Gyro
from diffdrive_mj.sensors.measuring import measure as measure
from diffdrive_mj.sensors.optical_flow import FlowSensor as FlowSensor
from diffdrive_mj.sensors.passive_wheels import PassiveWheel as PassiveWheel
from diffdrive_mj.sensors.passive_wheels import PassiveWheels as PassiveWheels
from diffdrive_mj.sensors.tracker import Tracker as Tracker
