"""Lever arms of passive wheels from a spin and a straight: planted mountings, stated noise, what drives do not show."""

import dataclasses
import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj import PassiveWheel, PassiveWheels
from diffdrive_mj.calibration import KnownMotion, lever_arms

QUARTER = math.pi / 2
ROBOT = dd.Robot.load("matched")
TRUE = PassiveWheels(
    wheels=(
        PassiveWheel(x=0.01, y=0.0815, radius=0.01605),
        PassiveWheel(x=0.01, y=-0.079, radius=0.01592),
        PassiveWheel(x=-0.052, angle=QUARTER + 0.02),
    )
)
BELIEVED = PassiveWheels(
    wheels=(PassiveWheel(x=0.01, y=0.08), PassiveWheel(x=0.01, y=-0.08), PassiveWheel(x=-0.05, angle=QUARTER))
)
ARMS = [wheel.lever_arm for wheel in TRUE.wheels]
STD, TURNS, DISTANCE = 0.0005, 10, 5.0
SPIN = KnownMotion.stated((0.0, 0.0, 2 * math.pi * TURNS), std=(STD, STD, 0.001))
STRAIGHT = KnownMotion.stated((DISTANCE, 0.0, 0.0), std=(STD, STD, 0.001))


@pytest.fixture(scope="module")
def drives():
    """A spin of ten turns and a straight of 5 m, in physics."""
    maneuvers = (dd.maneuvers.spin(ROBOT, turns=TURNS), dd.maneuvers.straight(ROBOT, distance=DISTANCE))
    return [dd.simulate(ROBOT, commands, passive_wheels=TRUE) for commands in maneuvers]


def summed(poses):
    """The motion along poses, by chords in the mean heading."""
    middle = (poses[1:, 2] + poses[:-1, 2]) / 2
    dx, dy = np.diff(poses[:, :2], axis=0).T
    ahead = np.cos(middle) * dx + np.sin(middle) * dy
    left = -np.sin(middle) * dx + np.cos(middle) * dy
    return np.array([ahead.sum(), left.sum(), poses[-1, 2] - poses[0, 2]])


def exact(recording):
    return KnownMotion.stated(summed(recording.truth), std=(1e-6, 1e-6, 1e-6))


def found_arms(found):
    return [wheel.lever_arm for wheel in found.calibrated.wheels]


def test_planted_mountings_are_found(drives):
    """The radius of the wheel across is known here, as no drive moves across."""
    found = lever_arms([drive.passive_angles[-1] for drive in drives], [exact(drive) for drive in drives], BELIEVED)
    assert found_arms(found) == pytest.approx(ARMS, abs=1e-7)
    assert found.calibrated.radii == pytest.approx(TRUE.radii, rel=1e-6)
    assert found.calibrated.wheels[2].angle == pytest.approx(QUARTER + 0.02, abs=1e-6)
    assert found.parameters == (
        "lever_arm[0]", "radius[0]", "lever_arm[1]", "radius[1]", "lever_arm[2]", "angle[2]",
    )  # fmt: skip
    assert found.believed is BELIEVED
    assert len(found.warnings) == 3
    assert "radius[2] is held at 0.016" in found.warnings[2]


def test_what_is_calibrated_drives_as_true(drives):
    found = lever_arms([drive.passive_angles[-1] for drive in drives], [exact(drive) for drive in drives], BELIEVED)
    other = dd.simulate(ROBOT, dd.maneuvers.square(ROBOT, side=1.0), passive_wheels=TRUE)
    for wheels, least, most in ((BELIEVED, 0.01, 1.0), (found.calibrated, 0.0, 1e-5)):
        path = dd.odometry.accumulate(wheels.from_angles(other.passive_angles), start=other.truth[0])
        assert least <= float(dd.metrics.drift(other.truth, path).max_position) <= most


def by_tracker(drives, rng):
    angles = [TRUE.from_ticks(TRUE.ticks(drive.passive_angles, phase=rng.random(3)))[-1] for drive in drives]
    noise = (STD, STD, 0.001)
    poses = [drive.truth + noise * rng.normal(size=drive.truth.shape) for drive in drives]
    return lever_arms(
        angles, [KnownMotion.along(path, position_std=STD, heading_std=0.001) for path in poses], BELIEVED
    )


def by_tape(drives, rng, turn_std=0.001):
    """Whole turns and a tape measure, or a gyro, whose turn is off by more."""
    angles = [TRUE.from_ticks(TRUE.ticks(drive.passive_angles, phase=rng.random(3)))[-1] for drive in drives]
    std = np.array([(STD, STD, turn_std), (STD, STD, 0.001)])
    motions = [summed(drive.truth) + spread * rng.normal(size=3) for drive, spread in zip(drives, std, strict=True)]
    known = [KnownMotion.stated(motion, std=spread) for motion, spread in zip(motions, std, strict=True)]
    return lever_arms(angles, known, BELIEVED)


@pytest.mark.parametrize("measured", [by_tracker, by_tape], ids=["tracker", "tape"])
def test_a_tenth_of_a_millimetre_and_the_stated_deviation_is_the_scatter(drives, measured):
    rng, seeds = np.random.default_rng(1), 300
    outcomes = [measured(drives, rng) for _ in range(seeds)]
    arms = np.array([found_arms(found) for found in outcomes])
    assert np.abs(arms - ARMS).max() < 1e-4
    values = np.array([found.values for found in outcomes])
    truth = [ARMS[0], 0.01605, ARMS[1], 0.01592, ARMS[2], QUARTER + 0.02]
    score = (values - truth) / outcomes[0].std
    # 300 draws of a chi-squared, and of a mean: four deviations of each.
    assert np.sqrt((score**2).mean(axis=0)) == pytest.approx(1, abs=4 / math.sqrt(2 * seeds))
    assert score.mean(axis=0) == pytest.approx(0, abs=4 / math.sqrt(seeds))
    correlation = np.corrcoef(values.T)
    assert correlation == pytest.approx(outcomes[0].correlation, abs=4 / math.sqrt(seeds))


def test_the_stated_deviation_of_coarse_ticks_is_the_scatter(drives):
    """Where 40 ticks a turn are all the noise there is; the phases are uniform at both ends."""
    coarse = PassiveWheels(wheels=tuple(dataclasses.replace(wheel, ticks_per_revolution=40) for wheel in TRUE.wheels))
    rng, seeds, motions = np.random.default_rng(3), 400, [exact(drive) for drive in drives]
    found = []
    for _ in range(seeds):
        # A robot stops somewhere within a tick: so far it has turned beyond the whole ones.
        more = rng.uniform(0, 2 * math.pi / 40, (len(drives), 3))
        angles = np.array([drive.passive_angles[-1] for drive in drives]) + more
        read = np.floor(angles / (2 * math.pi / 40) + rng.random((len(drives), 3))) * 2 * math.pi / 40
        found.append(lever_arms(read - more, motions, coarse))
    scatter = np.std([one.values for one in found], axis=0)
    assert scatter == pytest.approx(found[0].std, rel=4 / math.sqrt(2 * seeds))


def test_a_gyro_whose_scale_is_off_moves_the_arms_by_as_much(drives):
    rng = np.random.default_rng(2)
    arms = np.array([found_arms(by_tape(drives, rng, turn_std=0.001 * 2 * math.pi * TURNS)) for _ in range(200)])
    assert arms.std(axis=0) == pytest.approx(0.001 * np.abs(ARMS), rel=0.3)


def test_a_spin_shows_arms_about_the_point_that_stands_still():
    """A robot that believes its wheels equal spins about another point; a tracker tells, whole turns alone do not."""
    robot = dd.Robot.load("mismatched")
    believed = robot.replace(right_radius=robot.left_radius)
    spin = dd.simulate(robot, dd.maneuvers.spin(believed, turns=3), passive_wheels=TRUE)
    motion = summed(spin.truth)
    center_left = -motion[0] / motion[2]
    assert abs(center_left) > 0.005
    straight = TRUE.angles(STRAIGHT.motion)
    turns = KnownMotion.stated((0.0, 0.0, motion[2]), std=(1e-6, 1e-6, 1e-6))
    without = lever_arms([spin.passive_angles[-1], straight], [turns, STRAIGHT], BELIEVED)
    shift = [center_left * math.cos(wheel.angle) for wheel in TRUE.wheels]
    assert np.array(found_arms(without)) - ARMS == pytest.approx(np.negative(shift), rel=1e-3)
    tracked = KnownMotion.along(spin.truth, position_std=1e-6, heading_std=1e-6)
    within = lever_arms([spin.passive_angles[-1], straight], [tracked, STRAIGHT], BELIEVED)
    assert found_arms(within) == pytest.approx(ARMS, abs=1e-6)


def test_a_push_to_the_side_shows_the_rest():
    push = KnownMotion.stated((0.0, 2.0, 0.0), std=(STD, STD, 0.001))
    angles = [TRUE.angles(known.motion) for known in (SPIN, STRAIGHT, push)]
    found = lever_arms(angles, [SPIN, STRAIGHT, push], BELIEVED)
    assert found.warnings == ()
    assert found_arms(found) == pytest.approx(ARMS, abs=1e-9)
    assert found.calibrated.radii == pytest.approx(TRUE.radii, abs=1e-12)
    assert [wheel.angle for wheel in found.calibrated.wheels] == pytest.approx([0.0, 0.0, QUARTER + 0.02], abs=1e-9)


mountings = st.builds(
    PassiveWheel, x=numbers(-0.3, 0.3), y=numbers(-0.3, 0.3), angle=numbers(-3.0, 3.0), radius=numbers(0.01, 0.05)
)
off = st.tuples(numbers(-0.005, 0.005), numbers(0.98, 1.02), numbers(-0.05, 0.05))


@given(st.lists(st.tuples(mountings, off), min_size=1, max_size=4), numbers(-2.0, 2.0))
def test_any_wheels_are_found_from_moves_along_spins_and_pushes(some, bend):
    """Whatever was believed nearby; the moves are no pure ones."""
    true = PassiveWheels(wheels=tuple(wheel for wheel, _ in some))
    believed = PassiveWheels(
        wheels=tuple(
            dataclasses.replace(wheel, angle=wheel.angle + turned, radius=wheel.radius * scaled).moved(
                wheel.lever_arm + moved
            )
            for wheel, (moved, scaled, turned) in some
        )
    )
    motions = [
        KnownMotion.stated(motion, std=(1e-4, 1e-4, 1e-4))
        for motion in ((0.1, bend / 10, 60.0), (5.0, 0.3, bend), (-0.2, 2.0, bend / 2))
    ]
    found = lever_arms([true.angles(known.motion) for known in motions], motions, believed)
    assert found_arms(found) == pytest.approx([wheel.lever_arm for wheel in true.wheels], abs=1e-9)
    assert found.calibrated.radii == pytest.approx(true.radii, rel=1e-9)
    assert [w.angle for w in found.calibrated.wheels] == pytest.approx([w.angle for w in true.wheels], abs=1e-9)


def test_a_straight_alone_leaves_the_arms_as_believed():
    found = lever_arms([TRUE.angles(STRAIGHT.motion)], [STRAIGHT], BELIEVED)
    assert found.parameters == ("radius[0]", "radius[1]", "angle[2]")
    assert found_arms(found)[:2] == pytest.approx([-0.08, 0.08])
    assert "lever_arm[0] is held at -0.08" in str(found)


def test_the_place_along_the_rolling_direction_is_kept():
    found = lever_arms([TRUE.angles(SPIN.motion), TRUE.angles(STRAIGHT.motion)], [SPIN, STRAIGHT], BELIEVED)
    assert [(wheel.x, round(wheel.y, 9)) for wheel in found.calibrated.wheels[:2]] == [(0.01, 0.0815), (0.01, -0.079)]


def test_another_spin_makes_it_surer_and_disagreement_shows():
    back = KnownMotion.stated(-SPIN.motion, std=(STD, STD, 0.001))
    motions = [SPIN, STRAIGHT, back]
    angles = np.array([TRUE.angles(known.motion) for known in motions])
    once = lever_arms(angles[:2], motions[:2], BELIEVED)
    twice = lever_arms(angles, motions, BELIEVED)
    assert (twice.std <= once.std * (1 + 1e-9)).all()
    assert twice.std[0] < 0.9 * once.std[0]
    assert not any("disagree" in warning for warning in twice.warnings)
    angles[2] *= 1.01
    assert any("the drives disagree" in warning for warning in lever_arms(angles, motions, BELIEVED).warnings)


@pytest.mark.parametrize("reverse", [(1, 1, -1), (-1, -1, -1)])
def test_an_arm_on_the_other_side_is_warned_of(reverse):
    """A wheel across that counts backwards, and a spin the other way."""
    angles = [reverse * TRUE.angles(SPIN.motion), np.multiply(reverse, (-1, -1, 1) if reverse[0] < 0 else 1)
              * TRUE.angles(STRAIGHT.motion)]  # fmt: skip
    found = lever_arms(angles, [SPIN, STRAIGHT], BELIEVED)
    assert found_arms(found)[2] == pytest.approx(-ARMS[2], abs=1e-6)
    assert sum("does the wheel count backwards" in warning for warning in found.warnings) == reverse.count(-1)


@pytest.mark.parametrize("name", ["spin", "square", "straight"])
def test_the_noise_of_a_path_is_that_of_many(name):
    options = {"spin": {"turns": 1}, "square": {"side": 0.5}, "straight": {"distance": 1.0}}[name]
    path = dd.simulate(ROBOT, getattr(dd.maneuvers, name)(ROBOT, **options), sample_rate=10.0).truth
    rng, draws = np.random.default_rng(0), 4000
    noisy = path + (0.002, 0.002, 0.01) * rng.normal(size=(draws, *path.shape))
    known = [KnownMotion.along(poses, position_std=0.002, heading_std=0.01) for poses in noisy]
    spread = np.cov(np.array([drive.motion for drive in known]).T)
    predicted = KnownMotion.along(path, position_std=0.002, heading_std=0.01).covariance
    size = np.sqrt(np.diag(predicted))
    assert spread / np.outer(size, size) == pytest.approx(predicted / np.outer(size, size), abs=0.09)


ANGLES = [TRUE.angles(SPIN.motion), TRUE.angles(STRAIGHT.motion)]
REVERSED = np.array(ANGLES) * (1, -1, 1)


@pytest.mark.parametrize(
    ("call", "builtin", "words"),
    [
        (lambda: lever_arms(REVERSED, [SPIN, STRAIGHT], BELIEVED), ValueError, ["wheel 1 comes out", "backwards"]),
        (
            lambda: lever_arms(np.array(ANGLES)[:, ::-1], [SPIN, STRAIGHT], BELIEVED),
            ValueError,
            ["wheel 0 comes out", "the order of the wheels"],
        ),
        (
            lambda: lever_arms([(0, 0, 0)], [KnownMotion.stated((0, 0, 0), std=(1, 1, 1))], BELIEVED),
            ValueError,
            ["show nothing", "a spin of whole turns and a straight"],
        ),
        (lambda: lever_arms(ANGLES, [SPIN], BELIEVED), ValueError, ["angles has shape (2, 3): must be (..., 1, 3)"]),
        (lambda: lever_arms([ANGLES], [SPIN, STRAIGHT], BELIEVED), ValueError, ["(1, 2, 3): must be (2, 3)"]),
        (lambda: lever_arms(ANGLES, [SPIN, (5, 0, 0)], BELIEVED), TypeError, ["motions[1]", "a KnownMotion"]),
        (lambda: lever_arms(ANGLES, [SPIN, STRAIGHT], ROBOT), TypeError, ["believed = a Robot: must be a Passive"]),
        (
            lambda: lever_arms(ANGLES, [SPIN, STRAIGHT], BELIEVED, angle_std=0),
            ValueError,
            ["angle_std = 0: must be positive"],
        ),
        (lambda: lever_arms(ANGLES, [SPIN, STRAIGHT], BELIEVED, angle_std=(1, 1)), ValueError, ["angle_std"]),
        (lambda: KnownMotion(motion=(1, 0, 0), covariance=np.eye(2)), ValueError, ["KnownMotion.covariance has shape"]),
        (lambda: KnownMotion(motion=(1, 0, 0), covariance=-np.eye(3)), ValueError, ["must be (3, 3), symmetric"]),
        (
            lambda: KnownMotion(motion=(1, 0, 0), covariance=[(1e-6, 5e-6, 0), (5e-6, 1e-6, 0), (0, 0, 1)]),
            ValueError,
            ["not negative in any direction"],
        ),
        (lambda: KnownMotion.stated((1, 0), std=(1, 1, 1)), ValueError, ["motion has shape (2,): must be (..., 3)"]),
        (lambda: KnownMotion.stated((1, 0, 0), std=(1, 1, -1)), ValueError, ["std = -1: must not be negative"]),
        (
            lambda: KnownMotion.along([(0, 0, 0)], position_std=0.0, heading_std=0.0),
            ValueError,
            ["must be (T, 3) with at least two poses"],
        ),
        (
            lambda: KnownMotion.along(np.zeros((3, 3)), position_std=-1.0, heading_std=0.0),
            ValueError,
            ["position_std = -1.0: must not be negative"],
        ),
    ],
)
def test_bad_input_is_named(call, builtin, words):
    with refused(builtin, *words):
        call()
