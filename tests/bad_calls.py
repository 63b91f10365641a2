"""Kinds of bad input to the Python API: each a cause of its own, the call, the builtin of its error and words of it."""

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import maneuvers, metrics, sweeps
from diffdrive_mj.calibration import jung_chung, least_squares, speed_ratio, umbmark
from diffdrive_mj.estimation import covariance_export, regions
from diffdrive_mj.judging.consistency import nees, nis
from diffdrive_mj.sensors.allan import allan_deviation

SIZES = {"left_radius": 0.1, "right_radius": 0.1, "track_width": 0.4}
ROBOT = dd.Robot(**SIZES)
T, ANGLES, POSES = np.arange(3.0), np.zeros((3, 2)), np.zeros((3, 3))
GO = maneuvers.straight(ROBOT, distance=1.0)
SENSOR, ENCODER = dd.FlowSensor(x=0.1), dd.Encoder(ticks_per_revolution=100, sample_rate=1.0)
PODS = dd.PassiveWheels(wheels=(dd.PassiveWheel(y=0.1), dd.PassiveWheel(y=-0.1)))
IN_LINE = dd.PassiveWheels(wheels=(dd.PassiveWheel(x=0.1), dd.PassiveWheel(x=-0.1)))
RECORDING = dd.Recording(T, ANGLES, POSES, ROBOT, GO, dd.World(), dd.Physics(), flow=ANGLES)
Segment, Encoder, Tracker, Physics, World = maneuvers.Segment, dd.Encoder, dd.Tracker, dd.Physics, dd.World
PHASE = "random"


def drive(angles=((0, 0), (9, 10), (20, 19)), truth=None, **options):
    angles = np.asarray(angles, dtype=float)
    return dd.Drive(T, angles, dd.odometry.integrate(angles, ROBOT) if truth is None else truth, **options)


DRIVE = drive()


def robot(**fields):
    return dd.Robot(**{**SIZES, **fields})


def rough(**fields):
    return dd.RoughFloor(**{"x": (-1, 3), "y": (-1, 1), "rms": 0.002, "wavelength": 0.2, **fields})


def encoder(**fields):
    return Encoder(**{"ticks_per_revolution": 100, "sample_rate": 1.0, **fields})


def study(**fields):
    return sweeps.Study(**{"robot": ROBOT, "maneuver": {"name": "spin"}, "vary": {}, "trials": 4, **fields})


RATIO = {"robot.radius_ratio": sweeps.Normal(mean=1.0, sigma=0.01)}


def trials():
    ends = np.full(3, "ok")
    return sweeps.Trials(np.arange(3), {}, {"final_position": np.arange(3) / 1e3}, ends, np.full(3, ""))


def square(clockwise=False):
    commands = maneuvers.square(ROBOT, side=1.0, clockwise=clockwise, period=0.1)
    angles = np.vstack([(0.0, 0.0), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    return dd.Drive(0.1 * np.arange(len(angles)), angles, dd.odometry.integrate(angles, ROBOT))


def used_controller():
    controller = dd.GoToPose(ROBOT, goal=(1.0, 0.0, 0.0))
    controller(1.0, (0.0, 0.0))
    controller(0.0, (0.0, 0.0))


CALLS = {
    # A robot
    "size of zero": (lambda: robot(left_radius=0), ValueError, "Robot.left_radius = 0: must be positive"),
    "size that is a word": (lambda: robot(left_radius="0.1"), TypeError, "Robot.left_radius = '0.1': must be a number"),
    "size that is True": (lambda: robot(left_radius=True), TypeError, "must be a number"),
    "size that is not a number": (lambda: robot(left_radius=np.nan), ValueError, "must be finite"),
    "integer beyond every float": (lambda: robot(left_radius=10**400), ValueError, "an integer of 1329 bits"),
    "number beyond all sizes": (lambda: robot(body_mass=1e101), ValueError, "within 1e+100 of zero"),
    "number too small to divide by": (lambda: robot(body_mass=1e-101), ValueError, "at least 1e-100"),
    "radius in millimetres": (lambda: robot(left_radius=32.5), ValueError, "in millimetres? then 0.0325"),
    "radius in centimetres": (lambda: robot(left_radius=3.25), ValueError, "in centimetres? then 0.0325"),
    "track in millimetres": (lambda: robot(track_width=160), ValueError, "in millimetres? then 0.16"),
    "size left out": (lambda: dd.Robot(left_radius=0.1, right_radius=0.1), TypeError, "track_width missing"),
    "fields without names": (lambda: dd.Robot(0.1, 0.1, 0.4), TypeError, "by name"),
    "field that a robot does not have": (lambda: robot(track=0.4), KeyError, "did you mean 'track_width'"),
    "former field": (lambda: robot(wheel_mass=0.3), TypeError, "tyres=Tyres(mass=...)"),
    "former axle": (lambda: robot(hanging="coaxial"), TypeError, 'axle="rigid"'),
    "former servo": (lambda: robot(servo="P"), TypeError, "Servo(law='P')"),
    "unknown axle": (lambda: robot(axle="rigd"), KeyError, "did you mean 'rigid'"),
    "name that is not a string": (lambda: robot(name=7), TypeError, "Robot.name = 7: must be a string"),
    "part that is not a part": (lambda: robot(caster=-0.2), TypeError, "Caster(...)"),
    "field that a part does not have": (lambda: robot(caster={"y": 0.1}), KeyError, "Caster field 'y'"),
    "unknown servo law": (lambda: dd.Servo(law="PID"), KeyError, "choose from P, PI, voltage"),
    "negative inertia": (lambda: dd.Motor(rotor_inertia=-1), ValueError, "must not be negative"),
    "resistance in per cent": (lambda: dd.Tyres(rolling_resistance=1.5), ValueError, "must be at most 1 of the load"),
    "tyre of no stiffness": (lambda: dd.Tyres(stiffness=0), ValueError, "Tyres.stiffness = 0: must be positive"),
    "tyre too soft to stand on": (
        lambda: dd.simulate(robot(tyres={"stiffness": 100}), GO), ValueError, "its chassis lies on the floor"),
    "swivel caster that drags": (lambda: dd.Caster(kind="swivel", friction=0.1), ValueError, "whose wheel rolls"),
    "unknown caster": (lambda: dd.Caster(kind="omni"), KeyError, "choose from ball, swivel"),
    "casters of two kinds": (
        lambda: dd.simulate([robot(), robot(caster={"kind": "swivel"})], GO), ValueError, "in one batch"),
    "back-EMF of no torque": (lambda: dd.Motor(no_load_speed=20), ValueError, "needs a stall_torque"),
    "voltage of an ideal motor": (lambda: robot(servo={"law": "voltage"}), ValueError, "needs a motor with"),
    "motor without a gain": (lambda: dd.Motor(gain_ratio=0), ValueError, "Motor.gain_ratio = 0"),
    "centre of mass ahead of the axle": (lambda: robot(center_of_mass_x=0.01), ValueError, "tips over"),
    "payload beside the wheels": (lambda: robot(payload={"mass": 50, "y": 0.5}), ValueError, "triangle"),
    "wheelbase that is negative": (lambda: robot(skid_steer={"wheelbase": -0.3}), ValueError, "must not be negative"),
    "caster beside four wheels": (
        lambda: robot(skid_steer={"wheelbase": 0.3}, caster={"x": -0.2}), ValueError, "stands on four wheels alone"),
    "weight over an axle": (
        lambda: robot(skid_steer={"wheelbase": 0.3}, center_of_mass_x=0.15), ValueError, "skid_steer.wheelbase"),
    "rigid axle shorter than a step": (
        lambda: robot(axle="rigid", left_radius=0.9, track_width=0.4), ValueError, "difference of the radii"),
    "gain beyond reason": (lambda: robot(turning_gain=0.6), ValueError, "between -0.5 and 0.5"),
    "unknown preset": (lambda: dd.Robot.load("turtlebot3"), KeyError, "did you mean 'turtlebot3_burger'"),
    "neither a name nor a path": (lambda: dd.Robot.load(3), TypeError, "a preset's name or a path"),
    "robot's file of another name": (lambda: ROBOT.save("robot.yaml"), ValueError, "named .toml"),
    "folder that is not there": (lambda: ROBOT.save("nowhere/robot.toml"), ValueError, "No such file or directory"),
    "robot by name": (lambda: dd.odometry.Odometer("matched"), TypeError, "Robot.load('matched')"),
    # A world and how it is solved
    "frictionless floor": (lambda: World(friction=0), ValueError, "World.friction = 0"),
    "patch from right to left": (lambda: dd.Patch(x=(2, 1), y=(0, 1), friction=1), ValueError, "smaller to a larger"),
    "patch of four corners": (lambda: dd.Patch(x=POSES, y=(0, 1), friction=1), ValueError, "Patch.x has shape (3, 3)"),
    "patches that are not": (lambda: World(patches=(1,)), TypeError, "World.patches[0] = 1: must be Patch(...)"),
    "patch of hardly any friction": (
        lambda: dd.Patch(x=(0, 1), y=(0, 1), friction=1e-6), ValueError, "Patch.friction = 1e-06: must be at"),
    "floor of hardly any friction": (lambda: World(friction=9e-6), ValueError, "must be at least 1e-05"),
    "cable of no height": (lambda: dd.Cable(x=0, y=(0, 1), height=0), ValueError, "Cable.height = 0"),
    "cable above the floor": (
        lambda: dd.Cable(x=0, y=(0, 1), height=0.01, radius=0.004), ValueError, "at least half of the height, 0.005 m"),
    "cable of no length": (lambda: dd.Cable(x=1, y=2, height=0.01), ValueError, "its ends must lie apart"),
    "cable of three ends": (lambda: dd.Cable(x=(0, 1, 2), y=0, height=0.01), ValueError, "Cable.x has shape (3,)"),
    "cable of ragged ends": (lambda: dd.Cable(x=[[1], [1, 2]], y=0, height=0.01), TypeError, "Cable.x: must be"),
    "cable of hardly any length": (lambda: dd.Cable(x=(1, 1 + 1e-9), y=2, height=0.01), ValueError, "must lie apart"),
    "cables that are not": (lambda: World(cables=(1,)), TypeError, "must be Cable(...) or a mapping"),
    "floor of walls": (lambda: rough(rms=0.02), ValueError, "below a tenth of the wavelength, 0.02 m"),
    "floor shorter than its waves": (lambda: rough(x=(0, 0.5)), ValueError, "4 to 125 wavelengths of 0.2 m long"),
    "floor of too many waves": (lambda: rough(wavelength=0.01, rms=1e-4), ValueError, "not 400"),
    "floor the wrong way round": (lambda: rough(y=(1, -1)), ValueError, "RoughFloor.y = (1, -1)"),
    "floor of half a seed": (lambda: rough(seed=0.5), TypeError, "RoughFloor.seed = 0.5"),
    "bump up to the hub": (lambda: dd.obstacles.extra_distance(0.1, 0.1), ValueError, "meets the bump at its hub"),
    "bump below the floor": (lambda: dd.obstacles.meeting_angle(0.1, -0.1), ValueError, "must be positive"),
    "climb without friction": (lambda: dd.obstacles.highest_climb(0.1, 0.0), ValueError, "must be positive"),
    "slope in degrees": (lambda: World(slope={"angle": 10}), ValueError, "in degrees? then 0.1745 rad"),
    "slope that is a number": (lambda: World(slope=0.1), TypeError, "World.slope = 0.1: must be Slope(...)"),
    "patch without friction": (lambda: dd.Patch(x=(0, 1), y=(0, 1)), TypeError, "Patch(...): friction missing"),
    "field that a world does not have": (lambda: World(frction=1), KeyError, "did you mean 'friction'"),
    "weightlessness": (lambda: World(gravity=0), ValueError, "World.gravity = 0"),
    "unknown world": (lambda: World.load("offce"), KeyError, "did you mean 'office'"),
    "world that is neither a name nor a path": (lambda: World.load(3), TypeError, "a preset's name or a path"),
    "world's file of another name": (lambda: World().save("world.yaml"), ValueError, "a world's file is named .toml"),
    "world by name": (lambda: dd.simulate(ROBOT, GO, world="office"), TypeError, "must be a World"),
    "slope too steep to stand on": (
        lambda: dd.simulate(ROBOT, GO, world=World(slope={"angle": 1.2})), ValueError, "World.slope.angle = 1.2 rad"),
    "steepest slope of a floor": (
        lambda: dd.physics.limits.steepest_slope(ROBOT, "garden"), TypeError, "must be a World"),
    "forces under two headings": (
        lambda: dd.physics.mechanics.contact_forces(ROBOT, heading="north"), TypeError, "heading"),
    "push that has been": (lambda: dd.Push(start=-1, duration=1, acceleration=(0, 0, 0)), ValueError, "Push.start"),
    "push of no time": (lambda: dd.Push(start=0, duration=0, acceleration=(0, 0, 0)), ValueError, "Push.duration = 0"),
    "push in the plane": (lambda: dd.Push(start=0, duration=1, acceleration=(0, 0)), ValueError, "has shape (2,)"),
    "wheels of the physics": (lambda: Physics(wheel_shape="cylinder"), TypeError, "tyres=Tyres(shape='cylinder')"),
    "unknown wheel": (lambda: dd.Tyres(shape="sphere"), KeyError, "choose from crowned, cylinder"),
    "unknown integrator": (lambda: Physics(integrator="euler"), KeyError, "did you mean 'Euler'"),
    "step too coarse for any physics": (lambda: Physics(timestep=1.0), ValueError, "must be at most"),
    "slip that grows": (lambda: Physics(friction_damping=2), ValueError, "must be below 2"),
    "truth that the integrator does not have": (lambda: Physics(integrator="RK4"), ValueError, "truth='engine'"),
    "impedances in the wrong order": (
        lambda: Physics(contact_impedance=(0.9, 0.8)), ValueError, "0 < touching <= deep < 1"),
    "free wheel that diverges": (lambda: Physics(servo_stiffness=2), ValueError, "a free wheel diverges"),
    "contacts that bounce": (lambda: Physics(contact_damping=2), ValueError, "or contacts bounce"),
    # Commands and maneuvers
    "rates of three wheels": (lambda: dd.Commands(0.1, POSES), ValueError, "must be (..., T, 2)"),
    "commands shorter than they are": (lambda: GO.extended(0.1), ValueError, "at least that of the commands"),
    "driver that cannot be called": (lambda: dd.ClosedLoop(3, 0.1, 1.0), TypeError, "must be a function"),
    "no legs": (lambda: maneuvers.sequence(ROBOT, []), ValueError, "at least one leg"),
    "leg that is not a list": (lambda: maneuvers.sequence(ROBOT, [3]), TypeError, "legs[0] = 3: must be a list"),
    "segment that is a tuple": (lambda: maneuvers.sequence(ROBOT, [[(1, 0, 1)]]), TypeError, "must be a Segment"),
    "segment of no time": (lambda: Segment(1.0, 0.0, 0.0), ValueError, "Segment.duration = 0.0"),
    "negative ramp": (lambda: maneuvers.spin(ROBOT, ramp=-1), ValueError, "ramp = -1"),
    "circle without a radius": (lambda: maneuvers.arc(ROBOT, radius=0), ValueError, "`spin` turns on the spot"),
    "way of no length": (lambda: maneuvers.straight(ROBOT, distance=0), ValueError, "distance = 0"),
    "word for a flag": (lambda: maneuvers.square(ROBOT, clockwise="no"), TypeError, "must be True or False"),
    "more samples than memory holds": (lambda: maneuvers.straight(ROBOT, distance=1e9), ValueError, "at most 10000000"),
    # Simulation and recordings
    "no robots": (lambda: dd.simulate([], GO), ValueError, "robot: must hold at least one"),
    "commands for other robots": (lambda: dd.simulate([ROBOT] * 3, [GO] * 2), ValueError, "2 entries: must be 1 or 3"),
    "commands of two durations": (
        lambda: dd.simulate(ROBOT, [GO, GO.extended(99)]), ValueError, "see Commands.extended"),
    "two drivers": (
        lambda: dd.simulate(ROBOT, [dd.ClosedLoop(max, 0.1, 1.0)] * 2), ValueError, "must hold one ClosedLoop"),
    "drive that is no commands": (
        lambda: dd.simulate(ROBOT, [ANGLES]), TypeError, "must be a Commands or a ClosedLoop"),
    "driver with rates for others": (
        lambda: dd.simulate(ROBOT, dd.ClosedLoop(lambda t, angles: (1.0, 2.0, 3.0), 0.1, 1.0)), ValueError,
        "must be (..., 2)"),
    "driver without a rate": (
        lambda: dd.simulate(ROBOT, dd.ClosedLoop(lambda t, angles: (1.0, np.nan), 0.1, 1.0)), ValueError, "at 0 s"),
    "period between two steps": (
        lambda: dd.simulate(ROBOT, dd.Commands(0.003, ANGLES)), ValueError, "whole multiple of Physics.timestep"),
    "rate between two steps": (lambda: dd.simulate(ROBOT, GO, sample_rate=300), ValueError, "sampling interval"),
    "start that is a place": (lambda: dd.simulate(ROBOT, GO, start=(0, 0)), ValueError, "start has shape (2,)"),
    "start beyond all floors": (lambda: dd.simulate(ROBOT, GO, start=(1e12, 0, 0)), ValueError, "of zero"),
    "threads below none": (lambda: dd.simulate(ROBOT, GO, threads=-1), ValueError, "threads = -1: must be at least 0"),
    "unknown end of a fall": (lambda: dd.simulate(ROBOT, GO, on_fall="ignore"), KeyError, "on_fall 'ignore'"),
    "floor that is None": (lambda: dd.simulate(ROBOT, GO, world=None), TypeError, "world = None: must be a World"),
    "robot that believes in a gain": (
        lambda: dd.simulate(robot(turning_gain=0.1), GO), ValueError, "odometry may believe in one"),
    "robot that tips over": (
        lambda: dd.simulate(dd.Robot.load("ct_bot"), maneuvers.straight(
            dd.Robot.load("ct_bot"), speed=1.0, distance=1.0, ramp=0.2)), RuntimeError, "ct_bot"),
    "masses beyond the engine": (
        lambda: dd.simulate(robot(body_mass=1e-20), GO), ValueError, "check its masses and sizes"),
    "rate between two samples": (lambda: RECORDING.at_rate(0.7), ValueError, "whole multiple"),
    "time that was not recorded": (lambda: RECORDING.during(5.0, 9.0), ValueError, "no sample there"),
    "grip that was not recorded": (lambda: RECORDING.friction_use, ValueError, "Recording.grip is None"),
    # Sensors
    "unusual counter": (lambda: encoder(counter_bits=8), ValueError, "must be None, 16 or 32"),
    "readings that overtake": (lambda: encoder(jitter=0.6), ValueError, "overtake"),
    "probability above one": (lambda: encoder(missed_ticks=1.5), ValueError, "probability below 1"),
    "one flag for two wheels": (lambda: encoder(reversed=True), TypeError, "(left, right)"),
    "chance without a generator": (lambda: ENCODER.read(T, ANGLES, phase=PHASE), ValueError, "rng = None"),
    "seed for a generator": (lambda: ENCODER.read(T, ANGLES, 3, phase=PHASE), TypeError, "default_rng(seed)"),
    "drive between two readings": (lambda: ENCODER.read(T / 10, ANGLES), ValueError, "too short for two readings"),
    "half a count": (lambda: ENCODER.to_angles([[0, 0], [1, 0.5]]), ValueError, "0.5 must be whole"),
    "count beyond its bits": (
        lambda: encoder(counter_bits=16).to_angles([[0, 0], [0, 70000]]), ValueError, "does not fit in 16 bits"),
    "jump of half a counter": (
        lambda: encoder(counter_bits=16).to_angles([[0, 0], [0, 32768]]), ValueError, "jumps by"),
    "gap that ends before it starts": (lambda: Tracker(gaps=[(2, 1)]), ValueError, "must end after"),
    "gaps everywhere": (lambda: Tracker(gaps=[(-1, 9)]).read(T, POSES), ValueError, "leave at least one pose"),
    "noise without a seed": (
        lambda: dd.sensors.measure(RECORDING, tracker=Tracker(position_noise=0.1)), ValueError, "such as seed=0"),
    "seed that is a word": (lambda: dd.sensors.measure(RECORDING, seed="0"), TypeError, "must be a whole number"),
    "negative seed": (lambda: dd.sensors.measure(RECORDING, seed=-1), ValueError, "must be at least 0"),
    "drive for a recording": (lambda: dd.sensors.measure(DRIVE), TypeError, "must be a Recording"),
    "sensor on the axle": (lambda: dd.FlowSensor(x=0), ValueError, "rotation cannot be seen"),
    "one sample of a flow": (lambda: SENSOR.from_flow([(0, 0)]), ValueError, "at least two"),
    "flow beyond every count": (lambda: SENSOR.counts([[0, 0], [1e12, 0]]), ValueError, "2^53"),
    "phase of a count or more": (lambda: SENSOR.counts(ANGLES, phase=1.0), ValueError, "below 1 count"),
    "gyro of zero range": (lambda: dd.Gyro(range=0.0), ValueError, "Gyro.range = 0.0: must be positive"),
    "gyro that reads nothing": (lambda: dd.Gyro(scale_error=-1.0), ValueError, "must be above -1"),
    "gyro on its side": (lambda: dd.Gyro(roll=1.6), ValueError, "does not see the robot turn"),
    "resolution above the range": (lambda: dd.Gyro(range=1.0, resolution=2.0), ValueError, "not be above its range"),
    "gyro of no grade": (lambda: dd.Gyro.load("mpu"), KeyError, "unknown gyro 'mpu'"),
    "gyro that is a grade": (lambda: dd.sensors.measure(RECORDING, gyro="mpu6050"), TypeError, "must be a Gyro"),
    "gyro without a seed": (lambda: dd.sensors.measure(RECORDING, gyro=dd.Gyro.load("bmi088")), ValueError, "gyro's"),
    "gyro slower than the drive": (lambda: dd.Gyro(sample_rate=0.6).read(T, POSES), ValueError, "too short"),
    "rates that are too few": (lambda: dd.GyroLog(T, [0.0, 1.0]), ValueError, "must be as many"),
    "saturation that is a number": (lambda: dd.GyroLog(T, T, [0, 1, 0]), TypeError, "array of bool"),
    "gyro that is an array": (lambda: drive(gyro=T), TypeError, "must be a GyroLog"),
    "gyrodometry without a gyro": (lambda: dd.gyrodometry.by_gyro(DRIVE, ROBOT), ValueError, "has no gyro"),
    "averages of nothing": (lambda: allan_deviation([1.0, 2.0], 1.0, 3.0), ValueError, "half of the readings"),
    "lift that is a number": (lambda: SENSOR.counts(ANGLES, lifted=[0, 1, 0]), TypeError, "array of bool"),
    "lever arm without a turn": (lambda: dd.optical_flow.lever_arm((1, 0), 0), ValueError, "turned = 0"),
    "mounting without a drive": (lambda: dd.optical_flow.mounting_angle((0, 0)), ValueError, "must not be zero"),
    "passive wheel without a radius": (lambda: dd.PassiveWheel(radius=0), ValueError, "must be positive"),
    "no passive wheels": (lambda: dd.PassiveWheels(wheels=()), ValueError, "at least one PassiveWheel"),
    "passive wheels that do not see a slide": (
        lambda: PODS.motion([[1, 1]]), ValueError, "cannot see a slide to the side"),
    "passive wheels in line with the turn": (
        lambda: IN_LINE.motion([[1, 1]], slides=False), ValueError, "cannot see a turn about (0, 0) m"),
    "angles of another number of wheels": (lambda: PODS.from_angles(POSES, slides=False), ValueError, "must be (..."),
    "turns that do not fit the angles": (
        lambda: PODS.from_angles(ANGLES, turn=T, slides=False), ValueError, "turn has shape (3,): must be (..., 2)"),
    "ticks beyond every number": (lambda: PODS.ticks([[0, 0], [1e15, 0]]), ValueError, "2^53"),
    # Arrays, odometry and metrics
    "array of words": (lambda: dd.se2.exp(["1", "2", "3"]), TypeError, "array of real numbers"),
    "array of flags": (lambda: dd.se2.exp([True] * 3), TypeError, "not of bool"),
    "complex numbers": (lambda: dd.se2.exp([1j, 0, 0]), TypeError, "not of complex128"),
    "rows of unequal length": (lambda: dd.se2.exp([[1, 2], [3]]), TypeError, "inhomogeneous"),
    "structures": (lambda: dd.se2.exp(np.zeros(3, [("x", float)])), TypeError, "array of real numbers"),
    "masked values": (lambda: dd.se2.exp(np.ma.masked_equal([1.0, 2, 3], 2)), ValueError, "fill or drop them"),
    "hole in an array": (lambda: dd.odometry.integrate([[0, 0], [1, np.nan]], ROBOT), ValueError, "[1, 1] = nan"),
    "array without elements": (lambda: dd.odometry.integrate(np.zeros((0, 2)), ROBOT), ValueError, "is empty"),
    "array of another shape": (lambda: dd.se2.log((0, 0)), ValueError, "must be (..., 3)"),
    "leading dimensions that do not fit": (
        lambda: dd.se2.compose(np.zeros((2, 3)), POSES), ValueError, "must broadcast"),
    "unknown method": (lambda: dd.odometry.integrate(ANGLES, ROBOT, "midpont"), KeyError, "did you mean 'midpoint'"),
    "turn of no size": (lambda: dd.odometry.subdivide(ANGLES, ROBOT, max_turn=0), ValueError, "max_turn = 0"),
    "estimate of fewer samples": (lambda: metrics.drift(POSES, POSES[:2]), ValueError, "must be the same samples"),
    "unknown alignment": (lambda: metrics.ate(POSES, POSES, align="se3"), KeyError, "did you mean 'se2'"),
    "relative to nothing": (lambda: metrics.rpe(POSES, POSES), ValueError, "either distance"),
    "duration without times": (lambda: metrics.rpe(POSES, POSES, duration=1), ValueError, "t = ..."),
    "times that run backwards": (lambda: metrics.rpe(POSES, POSES, duration=1, t=-T), ValueError, "must increase"),
    "step beyond the drive": (lambda: metrics.rpe(POSES, POSES, duration=9, t=T), ValueError, "longer than the whole"),
    # Drives, diagnosis and calibration
    "time that stands still": (lambda: dd.Drive([0, 1, 1], ANGLES, POSES), ValueError, "times must increase"),
    "one time": (lambda: dd.Drive([0], ANGLES[:1], POSES[:1]), ValueError, "at least two times"),
    "angles of other times": (lambda: dd.Drive(T, ANGLES[:2], POSES), ValueError, "must be as many"),
    "poses without times": (lambda: dd.Drive(T, ANGLES, POSES[:2]), ValueError, "truth_t must say"),
    "clocks that never meet": (lambda: dd.Drive(T, ANGLES, POSES, T + 99), ValueError, "within the encoder's times"),
    "time beyond a drive": (lambda: DRIVE.angles_at([0.0, 99.0]), ValueError, "99"),
    "recording for a drive": (lambda: dd.diagnosis.suspicions(RECORDING, ROBOT), TypeError, "sensors.measure"),
    "one drive for a list": (lambda: least_squares(DRIVE, ROBOT), TypeError, "give one as [drive]"),
    "no drives": (lambda: least_squares([], ROBOT), ValueError, "at least one"),
    "wheels that never turn": (lambda: least_squares([drive(ANGLES)], ROBOT), ValueError, "the wheels never turn"),
    "truth that never moves": (lambda: least_squares([drive(truth=POSES)], ROBOT), ValueError, "never moves"),
    "drive given twice": (lambda: least_squares([square(), square()], ROBOT), ValueError, "anyway=True accepts it"),
    "unknown start": (lambda: least_squares([DRIVE], ROBOT, start="true"), KeyError, "did you mean 'truth'"),
    "more unknowns than poses": (
        lambda: least_squares([drive(truth=[(0, 0, 0), (1.95, 0.1, 0)], truth_t=[0.0, 2.0])], ROBOT, clock_offset=True),
        ValueError, "unknowns"),
    "squares in one direction": (lambda: umbmark([square()], ROBOT, side=1.0), ValueError, "in both directions"),
    "squares of another side": (
        lambda: umbmark([square(), square(True)], ROBOT, side=2.0), ValueError, "four sides of 2 m"),
    "drives that are no squares": (lambda: jung_chung([DRIVE], ROBOT, side=1.0), ValueError, "must be a square"),
    "unknown update": (lambda: umbmark([square()], ROBOT, side=1.0, update="both"), KeyError, "'both'"),
    "ratio of a turn on the spot": (
        lambda: speed_ratio([drive([(0, 0), (-9, 9), (-20, 20)])], ROBOT), ValueError, "turn the same way"),
    "ratio on a square": (lambda: speed_ratio([square()], ROBOT), ValueError, "straight drives"),
    "unknown target": (lambda: dd.export.text("ros1", ROBOT, ROBOT), KeyError, "did you mean 'ros2'"),
    "target without a gain": (
        lambda: dd.export.text("ros2", ROBOT, robot(turning_gain=0.1)), ValueError, "ros2 has none"),
    # Course, control, budgets
    "fixes at one place": (
        lambda: dd.course.from_fixes((0, 0), (0, 0), 1.0, fix_noise=0.01), ValueError, "coincide"),
    "direction of no length": (lambda: dd.course.bearing_of((0, 0)), ValueError, "must have a direction"),
    "noise below zero": (
        lambda: dd.course.from_fixes((0, 0), (1, 0), 1.0, fix_noise=-1), ValueError, "must not be negative"),
    "heading before the first course": (
        lambda: dd.course_tracker.CourseTracker().yaw, ValueError, "before the first straight drive"),
    "course of a bent drive": (
        lambda: dd.course_tracker.CourseTracker().update(
            dd.course.from_fixes((0, 0), (1, 0), 2.0, fix_noise=0.01)), ValueError, "must be straight"),
    "bend beyond a circle": (
        lambda: dd.estimation.straightness.chord_shortening(7.0, 1.0), ValueError, "at most a full circle"),
    "goals for other robots": (
        lambda: dd.GoToPose(ROBOT, goal=np.zeros((2, 3)), waypoints=np.zeros((3, 1, 2))), ValueError, "same robots"),
    "controller's second drive": (used_controller, ValueError, "an instance is for one drive"),
    "tolerance of a whole": (
        lambda: dd.estimation.sensitivities.error_budget(ROBOT, tolerance=1.0), ValueError, "at most 0.5"),
    "tolerance of more than all": (lambda: dd.Tolerances(radius=1.5), ValueError, "must be at most 0.5"),
    "guarantee for no drive": (lambda: dd.guarantee("square", ROBOT), TypeError, "drive: must be an array"),
    "guarantee for a command of rates alone": (
        lambda: dd.guarantee(ANGLES, ROBOT, acceleration=1.0), ValueError, "give period"),
    "guarantee for a number": (lambda: dd.guarantee(ANGLES, ROBOT, 0.01), TypeError, "must be a Tolerances"),
    "guarantee for robots that cannot be": (
        lambda: dd.guarantee(ANGLES, ROBOT, track_width=(-0.1, 0.4)), ValueError, "hold robots that cannot be"),
    "guarantee from larger to smaller": (
        lambda: dd.guarantee(ANGLES, ROBOT, track_width=(0.5, 0.4)), ValueError, "from a smaller to a larger"),
    "guarantee for one radius": (
        lambda: dd.guarantee(ANGLES, ROBOT, left_radius=(0.09, 0.1)), ValueError, "give both intervals"),
    "guarantee for a heading in degrees": (
        lambda: dd.guarantee(ANGLES, ROBOT, heading=10), ValueError, "in degrees? then 0.1745"),
    "guarantee for a turning gain": (
        lambda: dd.guarantee(ANGLES, robot(turning_gain=0.1)), ValueError, "turning_gain = 0.1: must be 0"),
    "guarantee for several runs": (
        lambda: dd.guarantee(np.zeros((2, 3, 2)), ROBOT), ValueError, "of one run"),
    "guarantee for a drive without end": (
        lambda: dd.guarantee([(0, 0), (-1e9, 1e9)], ROBOT), ValueError, "must be at most 5e+05 rad"),
    "guarantee for ticks of nothing": (lambda: dd.guarantee(ANGLES, ROBOT, ticks=0), ValueError, "ticks = 0"),
    "error of no drive": (lambda: dd.attribute(ANGLES, ROBOT), TypeError, "drive = "),
    "error of a log without a reference": (lambda: dd.attribute(DRIVE, ROBOT), ValueError, "true = None"),
    "log that is read once more": (
        lambda: dd.attribute(DRIVE, ROBOT, true=ROBOT, encoder=ENCODER), ValueError, "leave it out"),
    "recording with another true robot": (
        lambda: dd.attribute(RECORDING, ROBOT, true=ROBOT), ValueError, "a recording has the true robot"),
    "clock beyond the log": (
        lambda: dd.attribute(DRIVE, ROBOT, true=ROBOT, clock_offset=9.0), ValueError, "must be at least two"),
    "start that is no pose": (
        lambda: dd.attribute(RECORDING, ROBOT, start_error=(0.0, 0.0)), ValueError, "start_error has shape (2,)"),
    "path without slip": (lambda: dd.estimation.sliding.path(RECORDING), ValueError, "slip=True"),
    "noise that is nothing": (lambda: dd.covariance(ANGLES, ROBOT, noise=None), TypeError, "() for none"),
    "noise that is a class": (
        lambda: dd.covariance(ANGLES, ROBOT, noise=dd.WheelNoise), TypeError, "must be a model of noise"),
    "parameters that are a number": (
        lambda: dd.covariance(ANGLES, ROBOT, parameters=0.001), TypeError, "must be a calibration"),
    "a single pair of phases": (
        lambda: dd.CounterPhases(tick=0.1, phases=1), ValueError, "phases = 1: must be at least 21"),
    "topic of two lines": (
        lambda: covariance_export.robot_localization("odom\nrate: 5"), ValueError, "must be a ROS 2 name"),
    "durations of other steps": (
        lambda: dd.estimation.heading.filtered(T, T[1:], T > 0, dd.Gyro()), ValueError, "must be a number or (3,)"),
    "noise that is a number": (lambda: dd.covariance(ANGLES, ROBOT, noise=0.002), TypeError, "noise = 0.002"),
    "noise below zero of a wheel": (
        lambda: dd.WheelNoise(left=-0.1, right=0.0), ValueError, "WheelNoise.left = -0.1: must not be negative"),
    "noise without its right wheel": (lambda: dd.WheelNoise(left=0.1), TypeError, "right missing"),
    "variance below zero of a wheel": (
        lambda: dd.WheelNoise.of_variances(left=-1e-6, right=0.0), ValueError, "left = -1e-06: must not be negative"),
    "gyro noise without times": (
        lambda: dd.covariance(ANGLES, ROBOT, noise=dd.GyroNoise(random_walk=0.1)), ValueError, "times = ..."),
    "times that a drive has": (lambda: dd.covariance(DRIVE, ROBOT, times=T), ValueError, "a drive has its own"),
    "times of other samples": (lambda: dd.covariance(ANGLES, ROBOT, times=T[:2]), ValueError, "must be (..., 3)"),
    "covariance of one sample": (lambda: dd.covariance(ANGLES[:1], ROBOT), ValueError, "two samples at least"),
    "covariance by no method": (
        lambda: dd.covariance(ANGLES, ROBOT, method="exactly"), KeyError, "did you mean 'exact'"),
    "ticks of no size": (lambda: dd.CounterPhases(tick=0.0), ValueError, "CounterPhases.tick = 0.0: must be positive"),
    "ticks of no encoder": (lambda: dd.CounterPhases.of(0.1), TypeError, "encoder = 0.1"),
    "parameter that a robot does not have": (
        lambda: dd.covariance(ANGLES, ROBOT, parameters={"track": 0.1}), KeyError, "did you mean 'track_width'"),
    "parameter that is too vague": (
        lambda: dd.covariance(ANGLES, ROBOT, parameters={"track_width": 0.1}), ValueError, "must be known to a tenth"),
    "parameters that lose the heading": (
        lambda: dd.covariance([[0, 0], [900, -900]], ROBOT, parameters={"track_width": 0.01}), ValueError, "a turn"),
    "parameters of another shape": (
        lambda: dd.covariance(ANGLES, ROBOT, parameters=np.eye(2)), ValueError, "must be (3, 3) or (4, 4)"),
    "start covariance that is not symmetric": (
        lambda: dd.covariance(ANGLES, ROBOT, start_covariance=np.triu(np.ones((3, 3)))), ValueError, "symmetric"),
    "start covariance that is not positive": (
        lambda: dd.covariance(ANGLES, ROBOT, start_covariance=np.diag([1.0, -1.0, 1.0])), ValueError, "negative"),
    "start covariance of another shape": (
        lambda: dd.covariance(ANGLES, ROBOT, start_covariance=np.eye(2)), ValueError, "must be (..., 3, 3)"),
    "starts of other drives": (
        lambda: dd.covariance(np.zeros((2, 3, 2)), ROBOT, start=np.zeros((5, 3))), ValueError, "must broadcast"),
    "steps of thousands of turns": (
        lambda: dd.covariance([[0, 0], [1e6, -1e6]], ROBOT, noise=dd.WheelNoise(left=1e-6, right=1e-6)),
        ValueError, "sample the drive more often"),
    "covariance as it runs, of a gyro": (
        lambda: dd.MomentOdometer(ROBOT, dd.GyroNoise(random_walk=0.1)), TypeError, "must be a WheelNoise"),
    "even motion without noise": (
        lambda: dd.estimation.moment_closed_forms.even_motion(1.0, 0.0, 0.4, dd.WheelNoise(left=0, right=0)),
        ValueError, "without noise"),
    "derivatives of five parameters": (
        lambda: dd.estimation.derivatives.motion([[1, 2]], [0.1, 0.1, 0.4, 0.0], 5), ValueError, "must be 3 or 4"),
    "box of a number": (lambda: dd.physics.mechanics.box_lift(3), TypeError, "must be a Robot"),
    "skid turn of a robot that rolls": (
        lambda: dd.physics.skidding.skid_turn(ROBOT), ValueError, "has no skid steer"),
    "skid turn of wheels that drive straight": (
        lambda: dd.physics.skidding.skid_turn(
            robot(skid_steer={"wheelbase": 0.3}), (1, 1)), ValueError, "turns no robot"),
    "turn of a robot that stood": (
        lambda: dd.physics.skidding.measured_turn(RECORDING), ValueError, "has not turned"),
    # Consumers of covariances
    "covariance that is not symmetric": (
        lambda: nees(POSES, POSES, np.eye(3) + np.eye(3, k=1)),
        ValueError, "[0, 1] is 1 and [1, 0] is 0: must be symmetric"),
    "variance below zero": (
        lambda: nees(POSES, POSES, [np.eye(3), np.eye(3), -np.eye(3)]), ValueError, "covariance[2]: variance 0 is -1"),
    "correlation beyond 1": (
        lambda: nis(np.zeros((3, 2)), [[1, 2], [2, 1]]), ValueError, "covariance: must be positive"),
    "covariance that states nothing": (
        lambda: nees(POSES, POSES, np.zeros((3, 3))), ValueError, "singular at every sample"),
    "error where none is stated": (
        lambda: nees(POSES + 1, POSES, np.zeros((3, 3))), ValueError, "the variance of x is zero at sample 0"),
    "confidence of more than all": (lambda: nees(POSES, POSES, np.eye(3), confidence=2), ValueError, "must be below 1"),
    "frame that is none": (lambda: nees(POSES, POSES, np.eye(3), frame="map"), KeyError, "frame"),
    "noise of few drives": (lambda: dd.fit_noise([square()] * 2, ROBOT, stretch=9.0), ValueError, "must be at least 5"),
    "noise of wheels that never turn": (
        lambda: dd.fit_noise([drive(ANGLES)], ROBOT), ValueError, "drives[0]: the wheels never turn"),
    "noise of wheels that are read too rarely": (
        lambda: dd.fit_noise([square()], ROBOT, stretch=0.01), ValueError, "take a longer stretch"),
    "noise of a number": (lambda: dd.fit_noise([square()], 0.1), TypeError, "must be a Robot"),
    "ellipse of a number": (lambda: regions.ellipse(0.0, np.eye(2)), ValueError, "mean"),
    "level of all": (lambda: regions.threshold(1.0), ValueError, "must be below 1"),
    "banana before the start": (
        lambda: regions.squared_distance((0, 0), (0, 0, 0), np.zeros((3, 3))), ValueError, "must not be singular"),
    "message of a covariance in space": (
        lambda: covariance_export.pose_message(np.eye(6)), ValueError, "must be (..., 3, 3)"),
    "twist of no interval": (
        lambda: covariance_export.twist_message((1, 1), ROBOT, dd.WheelNoise(left=0.1, right=0.1), 0),
        ValueError, "interval = 0: must be positive"),
    "diagonal of no noise": (
        lambda: covariance_export.diagonals(T, DRIVE.wheel_angles, ROBOT, dd.WheelNoise(left=0, right=0)),
        ValueError, "leaves no doubt"),
    "poses with a covariance of one": (
        lambda: dd.PoseLog(T, POSES, covariance=np.eye(3)), ValueError, "must be (T, 3, 3)"),
    # Films
    "film under a name that is none": (lambda: dd.film(RECORDING, ROBOT, "new.gif"), KeyError, "choose from .mp4"),
    "film from a camera that is none": (
        lambda: dd.film(RECORDING, ROBOT, "new.webp", camera="folow"), KeyError, "did you mean 'follow'?"),
    "film of a path": (lambda: dd.film("log.csv", ROBOT, "new.webp"), TypeError, "must be a Recording or a Drive"),
    "film of poses of other times": (
        lambda: dd.film(RECORDING, {"a": POSES[:2]}, "new.webp"), ValueError, "believed['a']"),
    "film of a log without a robot": (lambda: dd.film(DRIVE, {"a": POSES}, "new.webp"), ValueError, "a Robot too"),
    "film of true poses that are rare": (
        lambda: dd.film(dd.Drive([0, 5], ANGLES[:2], POSES[:2]), ROBOT, "new.webp"), ValueError, "5 s apart"),
    "film that is too slow": (lambda: dd.film(RECORDING, ROBOT, "new.webp", speed=1e-9), ValueError, "at most 20000"),
    "strobe of a single time": (lambda: dd.strobe(RECORDING, ROBOT, "new.png", times=1), ValueError, "at least 2"),
    "strobe after the drive": (lambda: dd.strobe(RECORDING, ROBOT, "new.png", times=[9]), ValueError, "on the drive"),
    "strobe that moves": (lambda: dd.strobe(RECORDING, ROBOT, "new.mp4"), KeyError, "choose from .png, .webp"),
    # Sweeps
    "spread without a width": (lambda: sweeps.Normal(mean=0.1, sigma=0), ValueError, "Normal.sigma = 0: must"),
    "share beyond one": (lambda: sweeps.Uniform(low=0, high=1).at(1.1), ValueError, "share = 1.1: must lie between"),
    "choice of numbers and words": (lambda: sweeps.Choice(values=(1, "PI")), TypeError, "must be all numbers"),
    "grid of nothing": (lambda: sweeps.Grid(values=()), ValueError, "must have at least one value"),
    "study of a path": (lambda: study(robot="ct_bot"), TypeError, "must be Robot(...)"),
    "study of what cannot vary": (
        lambda: study(vary={"robot.mass": sweeps.Normal(mean=1, sigma=0.1)}), KeyError, "did you mean"),
    "study of an encoder that it lacks": (
        lambda: study(vary={"encoder.latency": sweeps.Uniform(low=0, high=0.1)}), ValueError, "has no encoder"),
    "study in another unit": (
        lambda: study(vary={"robot.track_width": sweeps.Normal(mean=400, sigma=1)}), ValueError, "in millimetres?"),
    "study of half a grid": (
        lambda: study(vary={"world.friction": sweeps.Grid(values=(0.5, 0.6, 0.7))}), ValueError, "such as 3 or 6"),
    "percentile of all": (lambda: trials().percentile("final_position", 1), ValueError, "share = 1: must be between"),
    "percentile in per cent": (lambda: trials().percentile("final_position", 99), ValueError, "as 0.99"),
    "percentile of what was not kept": (lambda: trials().percentile("final_pose", 0.5), KeyError, "did you mean"),
    "limit below zero": (lambda: trials().exceedance("final_position", -0.01), ValueError, "must not be negative"),
    "more robots than there are": (lambda: sweeps.percentiles.share_of(3, 2), ValueError, "must be at most trials = 2"),
    "indices of chance": (lambda: sweeps.indices.indices_of(trials(), "final_position"), ValueError, "whole design"),
    "indices of a path": (lambda: sweeps.indices.indices_of("out", "final_position"), TypeError, "must be a Trials"),
    "budget of nothing": (lambda: sweeps.budget(study(), trials(), "final_position"), ValueError, "nothing varies"),
    "budget of too few": (lambda: sweeps.budget(few := study(vary=RATIO, truth="kinematics"), dd.sweep(few, workers=1)),
        ValueError, "drive more"),
    "trials by what did not vary": (lambda: trials().by("robot.track_width"), KeyError, "name of what varied"),
    "budget of other trials": (lambda: sweeps.budget(study(vary=RATIO), trials()), ValueError, "of this study"),
    "tolerance that grows": (
        lambda: sweeps.prices.weights_when_tightened(RATIO["robot.radius_ratio"], [1.0], 2), ValueError, "at most 1"),
    "tolerance that does not vary": (
        lambda: sweeps.prices.tightened(study(vary=RATIO), "robot.mean_radius"), KeyError, "choose from"),
    "first order of a floor": (
        lambda: sweeps.linear.first_order(study(vary={"world.friction": sweeps.Uniform(low=0.5, high=0.6)})),
        ValueError, "first order knows"),
    "study of no rows": (lambda: study(design="saltelli"), ValueError, "needs something that varies"),
    "sweep of something else": (lambda: dd.sweep(ROBOT), TypeError, "study = "),
    "chunk of none": (lambda: dd.sweep(study(), chunk=0), ValueError, "chunk = 0: must be"),
    "workers that are a word": (lambda: dd.sweep(study(), workers="all"), TypeError, "workers = 'all': must be"),
    "workers and a scheduler": (
        lambda: dd.sweep(study(), workers=2, scheduler="tcp://127.0.0.1:1"), ValueError, "only one of them"),
    "scheduler that is no address": (
        lambda: dd.sweep(study(), scheduler="nonsense://here"), RuntimeError, "scheduler = 'nonsense://here': cannot"),
    "scheduler that is a number": (lambda: dd.sweep(study(), scheduler=8786), TypeError, "scheduler = 8786: must be"),
    "sweep at a rate that does not fit": (lambda: dd.sweep(study(sample_rate=300)), ValueError, "sampling interval"),
    "sweep's folder that is no path": (lambda: dd.sweep(study(), 3), TypeError, "out = 3: must be a path"),
    "folder of no sweep": (lambda: sweeps.load("/no/such/folder"), FileNotFoundError, "no sweep has been kept there"),
    "run of a recording of one": (lambda: RECORDING.run(0), ValueError, "must be below the number of runs"),
    "study that is not there": (lambda: sweeps.Study.load("squars"), KeyError, "did you mean 'squares'?"),
    "trial that a study does not have": (lambda: study().trial(4), ValueError, "must be some of the 4"),
    "blocks of a random design": (lambda: study().blocks, ValueError, "must be 'saltelli'"),
    # Reports
    "page of a folder that is not there": (lambda: dd.report.page("nowhere"), FileNotFoundError, "no such folder"),
    "page of no results": (lambda: dd.report.page("folder"), ValueError, "holds no results"),
    "page of a number": (lambda: dd.report.page(3), TypeError, "must be a path"),
    "metric of the report's own name": (
        lambda: dd.report.Report("Why?", "So.", "", [], {"bounds": 1}), ValueError, "choose another name"),
    "replay without a belief": (
        lambda: dd.report.Replay("x", T, POSES, {}, ROBOT), ValueError, "must be 1 to 20"),
    "replay of other times": (
        lambda: dd.report.Replay("x", T[:2], POSES, {"a": POSES}, ROBOT), ValueError, "as t has 2 times"),
    "drive for a log": (lambda: dd.logs.write_csv("new.csv", RECORDING), TypeError, "sensors.measure"),
}  # fmt: skip
