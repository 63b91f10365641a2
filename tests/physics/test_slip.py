"""How far the tyres slide, read at the contacts: closed forms, the true motion, and no odometry in it."""

import warnings

import numpy as np
import pytest
from helpers import refused
from scipy.spatial.transform import Rotation

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.estimation import sliding
from diffdrive_mj.physics._probes import Steps
from diffdrive_mj.physics._slip import SlipProbe
from diffdrive_mj.physics.effects.soft_tyres import rolling_radii
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.physics.tilt import level_twin

ROBOT = dd.Robot.load("mismatched")
STRAIGHT = dd.maneuvers.straight(ROBOT, speed=0.5, distance=1.0)
HALF = ROBOT.track_width / 2
ICE = dd.World(patches=(dd.Patch(x=(0.7, 0.95), y=(0.5 * HALF, 1.5 * HALF), friction=0.02),))
SKIDDING = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
PUSH = dd.World(friction=0.3, pushes=(dd.Push(start=1.0, duration=0.2, acceleration=(0.0, 4.0, 0.0)),))


def driven(robot, commands, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return dd.simulate(robot, commands, **{"sample_rate": 500.0, "slip": True, **options})


def test_without_being_asked_nothing_is_recorded():
    plain, asked = dd.simulate(ROBOT, STRAIGHT), dd.simulate(ROBOT, STRAIGHT, slip=True)
    assert plain.slip is None
    assert asked.slip.shape == (len(asked.t), 2, 2)
    np.testing.assert_array_equal(asked.truth, plain.truth)
    np.testing.assert_array_equal(asked.at_rate(10.0).slip, asked.slip[::10])


@pytest.mark.parametrize("maneuver", ["straight", "square", "slalom", "spin", "figure_eight"])
def test_rolling_wheels_do_not_slide(maneuver):
    recording = driven(ROBOT, getattr(dd.maneuvers, maneuver)(ROBOT))
    # A force leaves some slip, in proportion to it: up and down the ramps it comes and goes.
    assert np.abs(recording.slip).max() < 1e-6


def test_locked_wheels_slide_as_far_as_the_robot_is_pushed():
    """A robot that stands with its wheels locked and is pushed hard slides on both, forward and sideways alike."""
    stand = dd.Commands(0.01, np.zeros((200, 2)))
    push = dd.World(friction=0.2, pushes=(dd.Push(start=0.2, duration=0.3, acceleration=(3.0, 1.0, 0.0)),))
    recording = driven(ROBOT, stand, world=push, start=(0.0, 0.0, 0.4), physics=dd.Physics.sliding())
    moved = recording.truth[-1] - recording.truth[0]
    assert np.hypot(*moved[:2]) > 0.05
    rolled = (recording.wheel_angles[-1] * (ROBOT.left_radius, ROBOT.right_radius)).mean()
    # Its way in its own axes, a sum of small steps in the plane by hand.
    steps = np.diff(recording.truth[:, :2], axis=0)
    heading = (recording.truth[1:, 2] + recording.truth[:-1, 2]) / 2
    forward = (np.cos(heading) * steps[:, 0] + np.sin(heading) * steps[:, 1]).sum()
    left = (np.cos(heading) * steps[:, 1] - np.sin(heading) * steps[:, 0]).sum()
    np.testing.assert_allclose(recording.slip[-1].mean(axis=0), [forward - rolled, left], atol=2e-3 * abs(left))


def test_a_wheel_that_spins_on_ice_slides_back_by_what_it_turns_too_far():
    """On ice under both wheels the tyres go as the servos say, and the robot lags: the difference is the slip."""
    both = dd.World(friction=0.02)
    recording = driven(ROBOT, dd.maneuvers.straight(ROBOT, speed=1.0, distance=2.0, ramp=0.2), world=both)
    middle = len(recording.t) // 3
    rolled = recording.wheel_angles[middle] * (ROBOT.left_radius, ROBOT.right_radius)
    lag = recording.truth[middle, 0] - rolled.mean()
    assert lag < -0.05
    assert recording.slip[middle, :, 0].mean() == pytest.approx(lag, rel=1e-3)


@pytest.mark.parametrize("world", [ICE, PUSH], ids=["ice", "push"])
@pytest.mark.parametrize(
    "physics", [dd.Physics(), dd.Physics.fast(), dd.Physics(friction_damping=1.5)], ids=["default", "fast", "damped"]
)
def test_rolling_and_sliding_together_are_the_true_path(world, physics):
    recording = driven(ROBOT, STRAIGHT, world=world, physics=physics, sample_rate=1 / physics.timestep)
    off = np.hypot(*(recording.odometry(ROBOT) - recording.truth)[-1, :2])
    assert off > 1e-3
    apart = np.hypot(*(sliding.path(recording) - recording.truth)[:, :2].T)
    assert apart[-1] < 5e-3 * off
    # On the way a robot that is pushed leans, and takes its axle along while its wheels hold.
    assert apart.max() < 1e-3


@pytest.mark.parametrize("load", [{}, {"mass": 15.0, "x": 0.1, "y": 0.05, "height": 0.3}], ids=["even", "uneven"])
def test_four_wheels_that_roll_and_slide_go_the_true_path(load):
    """Half of a side's wheels would say where their axle goes, half a wheelbase off the robot's middle."""
    robot = SKIDDING.replace(payload=load, right_radius=0.15)
    recording = driven(robot, dd.maneuvers.arc(robot, speed=0.5, radius=1.0))
    assert recording.drift(robot).max_position > 0.3
    np.testing.assert_allclose(sliding.path(recording), recording.truth, rtol=0, atol=2e-3)


def test_the_wheels_of_a_skid_steer_robot_slide_as_its_spin_says():
    """In a spin all four slide equally fast, by omega wheelbase / 2 to the side and what is left over along."""
    recording = driven(SKIDDING, dd.maneuvers.spin(SKIDDING, turns=1.0, yaw_rate=0.5))
    turned, half = recording.truth[-1, 2], SKIDDING.skid_steer.wheelbase / 2
    along = half * 2 * half / SKIDDING.track_width * turned
    expected = [[along, 0.0], [-along, 0.0]]
    np.testing.assert_allclose(recording.slip[-1], expected, rtol=0, atol=3e-3 * along)
    np.testing.assert_allclose(recording.grip.slide, np.hypot(along, half * turned), rtol=0.01)


def test_soft_tyres_roll_on_a_smaller_radius_which_is_read_as_slip():
    robot = dd.Robot.load("matched").replace(tyres={"stiffness": 20_000})
    recording = driven(robot, STRAIGHT)
    shrunk = np.array([robot.left_radius, robot.right_radius]) - rolling_radii(robot, dd.World())
    np.testing.assert_allclose(recording.slip[-1, :, 0], -shrunk * recording.wheel_angles[-1], rtol=0.01)
    np.testing.assert_allclose(sliding.path(recording), recording.truth, rtol=0, atol=2e-5)  # it pitches


def test_a_rigid_axle_tilts_and_its_wheels_roll_on_other_radii_than_their_own_without_sliding():
    robot = ROBOT.replace(axle="rigid")
    recording = driven(robot, dd.maneuvers.square(robot, side=1.0))
    assert np.abs(recording.odometry(robot) - recording.truth).max() > 1e-4
    assert np.abs(recording.odometry(level_twin(robot)) - recording.truth).max() < 1e-6
    assert np.abs(recording.slip).max() < 1e-6


def test_the_slip_does_not_depend_on_how_the_drive_is_cut_or_on_company():
    together = driven([ROBOT, dd.Robot.load("matched")], STRAIGHT, world=ICE)
    alone = driven(ROBOT, STRAIGHT, world=ICE)
    np.testing.assert_array_equal(together.slip[0], alone.slip)
    coarse = driven(ROBOT, STRAIGHT, world=ICE, sample_rate=100.0)
    np.testing.assert_array_equal(coarse.slip, alone.slip[::5])


@pytest.mark.parametrize("seed", range(5))
def test_in_any_attitude_it_is_how_the_lowest_point_of_the_tyre_moves(seed):
    """Points of the tyre moved by rotations of scipy's, the lowest of many taken as the contact."""
    rng = np.random.default_rng(seed)
    model = compile_model(ROBOT)
    tilted = Rotation.from_euler("ZYX", rng.uniform((-3, -0.4, -0.4), (3, 0.4, 0.4)))
    turned = tilted * Rotation.from_rotvec(1e-5 * rng.normal(size=3))
    before, after = np.zeros((2, 1, 1, model.nq))
    move, spun = 1e-5 * rng.normal(size=3), 1e-4 * rng.normal(size=2)
    before[..., 3:7] = tilted.as_quat(scalar_first=True)
    after[..., :3], after[..., 3:7] = move, turned.as_quat(scalar_first=True)
    joints = [int(model.joint(side).qposadr[0]) for side in ("left", "right")]
    after[..., joints] = spun
    steps = Steps(np.array([0.002]), after, np.zeros((1, 1, 0)), np.ones((1, 1, 2)), np.zeros((1, 2, 3)))
    (found,) = SlipProbe([model], dd.Physics(), before[:, 0]).read(steps)[0]
    ahead = tilted.apply((1.0, 0.0, 0.0)) * (1, 1, 0)
    ahead /= np.linalg.norm(ahead)
    around, across = np.meshgrid(np.linspace(0, 2 * np.pi, 4001), np.linspace(-np.pi / 2, np.pi / 2, 2001))
    sphere = np.stack([np.cos(across) * np.cos(around), np.sin(across), np.cos(across) * np.sin(around)], axis=-1)
    for side, name in enumerate(("left", "right")):
        surface = (sphere * model.geom(f"{name}_tyre").size).reshape(-1, 3)
        arm = surface[np.argmin(tilted.apply(surface)[:, 2])]
        hub, rolled = model.body(f"{name}_wheel").pos, Rotation.from_rotvec((0, spun[side], 0))
        moved = move + turned.apply(hub + rolled.apply(arm)) - tilted.apply(hub + arm)
        left = np.cross((0, 0, 1), ahead)
        np.testing.assert_allclose(found[side], (moved @ ahead, moved @ left), atol=2e-8)


def test_a_path_needs_slip_and_one_run():
    with refused(ValueError, "simulate(..., slip=True)"):
        sliding.path(dd.simulate(ROBOT, STRAIGHT))
    with refused(ValueError, "recording.runs"):
        sliding.path(dd.simulate([ROBOT, ROBOT], STRAIGHT, slip=True))


@pytest.mark.parametrize("drive", ["spin", "square"])
def test_the_path_of_skid_steer_is_that_of_its_middle(drive):
    """Its slip is the mean of both axles, and so how its middle moves."""
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.5, skid_steer={"wheelbase": 0.4})
    commands = dd.maneuvers.spin(robot, turns=1) if drive == "spin" else dd.maneuvers.square(robot, side=1.0)
    recording = driven(robot, commands)
    off = sliding.path(recording)[-1] - recording.truth[-1]
    np.testing.assert_allclose(off, 0, atol=1e-6)
