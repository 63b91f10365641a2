from diffdrive_mj import calibration as calibration
from diffdrive_mj import commands as commands
from diffdrive_mj import controller as controller
from diffdrive_mj import diagnosis as diagnosis
from diffdrive_mj import drive as drive
from diffdrive_mj import errors as errors
from diffdrive_mj import estimation as estimation
from diffdrive_mj import kinematics as kinematics
from diffdrive_mj import logs as logs
from diffdrive_mj import maneuvers as maneuvers
from diffdrive_mj import metrics as metrics
from diffdrive_mj import odometry as odometry
from diffdrive_mj import parts as parts
from diffdrive_mj import physics as physics
from diffdrive_mj import pose_log as pose_log
from diffdrive_mj import report as report
from diffdrive_mj import se2 as se2
from diffdrive_mj import sensors as sensors
from diffdrive_mj import sweeps as sweeps
from diffdrive_mj.calibration import _square as _square
from diffdrive_mj.calibration import export as export
from diffdrive_mj.calibration import paths as _paths
from diffdrive_mj.calibration import squares as _squares
from diffdrive_mj.calibration import straights as _straights
from diffdrive_mj.commands import ClosedLoop as ClosedLoop
from diffdrive_mj.commands import Commands as Commands
from diffdrive_mj.controller import GoToPose as GoToPose
from diffdrive_mj.drive import Drive as Drive
from diffdrive_mj.errors import DiffdriveError as DiffdriveError
from diffdrive_mj.errors import SimulationDiverged as SimulationDiverged
from diffdrive_mj.estimation import closed_forms as closed_forms
from diffdrive_mj.estimation import course as course
from diffdrive_mj.estimation import course_noise as course_noise
from diffdrive_mj.estimation import course_tracker as course_tracker
from diffdrive_mj.estimation import gyrodometry as gyrodometry
from diffdrive_mj.estimation import obstacles as obstacles
from diffdrive_mj.estimation.attribution import attribute as attribute
from diffdrive_mj.estimation.set_membership import guarantee as guarantee
from diffdrive_mj.gyro_log import GyroLog as GyroLog
from diffdrive_mj.judging.evaluation import evaluate as evaluate
from diffdrive_mj.judging.tasks import Task as Task
from diffdrive_mj.judging.verdict import judge as judge
from diffdrive_mj.parts import Caster as Caster
from diffdrive_mj.parts import Motor as Motor
from diffdrive_mj.parts import Payload as Payload
from diffdrive_mj.parts import Servo as Servo
from diffdrive_mj.parts import SkidSteer as SkidSteer
from diffdrive_mj.parts import Tyres as Tyres
from diffdrive_mj.parts import WheelEncoder as WheelEncoder
from diffdrive_mj.physics import model as model
from diffdrive_mj.physics import simulation as simulation
from diffdrive_mj.physics import tilt as tilt
from diffdrive_mj.physics.mjcf import to_mjcf as to_mjcf
from diffdrive_mj.physics.simulation import simulate as simulate
from diffdrive_mj.pose_log import PoseLog as PoseLog
from diffdrive_mj.recording import Recording as Recording
from diffdrive_mj.report import plots as plots
from diffdrive_mj.report.filming.films import film as film
from diffdrive_mj.report.filming.strobes import strobe as strobe
from diffdrive_mj.robot import Robot as Robot
from diffdrive_mj.sensors import encoder as encoder
from diffdrive_mj.sensors import optical_flow as optical_flow
from diffdrive_mj.sensors import passive_wheels as passive_wheels
from diffdrive_mj.sensors.encoder import Encoder as Encoder
from diffdrive_mj.sensors.gyro import Gyro as Gyro
from diffdrive_mj.sensors.optical_flow import FlowSensor as FlowSensor
from diffdrive_mj.sensors.passive_wheels import PassiveWheel as PassiveWheel
from diffdrive_mj.sensors.passive_wheels import PassiveWheels as PassiveWheels
from diffdrive_mj.sensors.tracker import Tracker as Tracker
from diffdrive_mj.solver import Physics as Physics
from diffdrive_mj.sweeps.runner import sweep as sweep
from diffdrive_mj.terrain import Cable as Cable
from diffdrive_mj.terrain import RoughFloor as RoughFloor
from diffdrive_mj.terrain import Slope as Slope
from diffdrive_mj.tolerances import Tolerances as Tolerances
from diffdrive_mj.world import Patch as Patch
from diffdrive_mj.world import Push as Push
from diffdrive_mj.world import World as World

__version__: str

# The calibration's modules under the names of what they do.
bidirectional = _square
compensation = _straights
least_squares = _paths
umbmark = _squares
