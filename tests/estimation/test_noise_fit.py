"""Noise that was planted is found within its stated deviation, whatever maneuver, tracker and calibration."""

import numpy as np
import pytest
from helpers import refused
from planar_noise import measured_drive

import diffdrive_mj as dd
from diffdrive_mj.estimation import noise_fit
from diffdrive_mj.estimation.noise_fit import fit_noise

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
K = np.array([0.003, 0.0015])
U = np.linspace(0, 1, 121)[:, None]
WAYS = {"straight": (80.0, 80 / 0.91), "arc": (80.0, 120.0), "back": (-120.0, -90.0), "spin": (-50.0, 50.0)}
MIXED = ("arc", "back", "spin")


def drives(kinds, count, seed=0, k=K, robot=ROBOT, **options):
    rng = np.random.default_rng(seed)
    return [measured_drive(U * WAYS[kind], robot, k, rng, **options) for kind in kinds for _ in range(count)]


def found(fit):
    return np.array([fit.noise.left, fit.noise.right])


def pulls(seeds, kinds, count, robot=ROBOT, **options):
    tracked = options.get("tracked", (0.0, 0.0))
    fits = [
        fit_noise(drives(kinds, count, seed, **options), robot, position_noise=tracked[0], heading_noise=tracked[1])
        for seed in range(seeds)
    ]
    return np.array([(found(fit) - K) / fit.std for fit in fits])


def assert_unbiased(scores, stretches):
    """Mean 0 and deviation 1, but for chance and for the skew of a deviation that scales with what is estimated."""
    skew = 0.75 * (2 / stretches) ** 0.5
    assert np.all(np.abs(scores.mean(axis=0)) < 4 / len(scores) ** 0.5 + skew)
    assert np.all(np.abs(scores.std(axis=0) - 1) < 4 / (2 * len(scores)) ** 0.5 + skew)


@pytest.mark.parametrize(
    ("kinds", "options"),
    [
        (("straight",), {"every": 4}),
        (MIXED, {"every": 4}),
        (MIXED, {"every": 4, "tracked": (0.002, 0.002)}),
    ],
)
def test_it_is_unbiased_within_its_stated_deviation(kinds, options):
    assert_unbiased(pulls(20, kinds, 3 // len(kinds), **options), stretches=24)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "tracked"),
    [(("spin",), (0.0, 0.0)), (("straight",), (0.0, 0.0)), (MIXED, (0.0, 0.0)), (MIXED, (0.003, 0.001))],
)
def test_the_same_many_times(kinds, tracked):
    assert_unbiased(pulls(150, kinds, 6 // len(kinds), every=4, tracked=tracked), stretches=40)


def test_two_true_poses_a_drive_are_enough_where_there_are_many():
    fit = fit_noise(drives(("arc",), 30, every=120), ROBOT)
    assert fit.stretches == 30
    assert np.all(np.abs(found(fit) - K) < 4 * fit.std)


def test_scale_mirror_place_and_order_are_laws():
    some = drives(MIXED, 2, every=4)
    fit = fit_noise(some, ROBOT)
    scaled = [dd.Drive(d.t, d.wheel_angles, d.truth * (4, 4, 1), d.clock) for d in some]
    big = ROBOT.replace(left_radius=0.4, right_radius=0.364, track_width=1.6)
    np.testing.assert_allclose(found(fit_noise(scaled, big, stretch=4.0)), 2 * found(fit), rtol=1e-5)
    moved = [dd.Drive(d.t, d.wheel_angles, dd.se2.compose((3, -1, 2), d.truth), d.clock) for d in some]
    np.testing.assert_allclose(found(fit_noise(moved[::-1], ROBOT)), found(fit), rtol=1e-6)
    mirrored = [dd.Drive(d.t, d.wheel_angles[:, ::-1], d.truth * (1, -1, -1), d.clock) for d in some]
    other = ROBOT.replace(left_radius=0.091, right_radius=0.100)
    np.testing.assert_allclose(found(fit_noise(mirrored, other)), found(fit)[::-1], rtol=1e-6)


def test_an_error_of_the_parameters_is_not_read_as_noise():
    """Track 1 % wide, radii 0.2 % apart: without taking that out k of 3 mm would be read as several."""
    some = drives(MIXED, 2, every=4)
    right, wrong = fit_noise(some, ROBOT), fit_noise(some, ROBOT.replace(track_width=0.404, left_radius=0.1002))
    assert not any("systematically" in words for words in right.warnings)
    assert np.all(np.abs(found(wrong) - found(right)) < 0.5 * right.std)
    assert any("odometry is systematically off" in words and "calibrate" in words for words in wrong.warnings)
    planted = np.array([0.1 / 0.1002 - 1, 0.0, 0.4 / 0.404 - 1])
    assert np.all(np.abs(wrong.systematic - planted) < 4 * wrong.systematic_std)
    assert np.all(wrong.systematic_std < 1e-3)


def test_straight_lines_on_a_poor_tracker_show_the_sum_alone():
    """A heading takes both wheels alike; which of them it was, the position says, where it can be seen."""
    tracked = {"every": 4, "tracked": (0.03, 0.001)}
    known = {"position_noise": 0.03, "heading_noise": 0.001}
    straight = fit_noise(drives(("straight",), 8, **tracked), ROBOT, **known)
    assert straight.correlation < -0.8
    assert any("not separated" in words and "arcs both ways" in words for words in straight.warnings)
    seen = fit_noise(drives(("straight",), 8, every=4), ROBOT)
    assert abs(seen.correlation) < 0.3
    assert seen.warnings == ()
    # Arcs both ways and turns, on which one wheel goes further, separate them.
    arcs = fit_noise(drives(("arc", "back"), 4, **tracked), ROBOT, **known)
    assert arcs.correlation > straight.correlation


def test_where_there_is_no_noise_none_is_found():
    fit = fit_noise(drives(MIXED, 2, k=np.zeros(2), every=4), ROBOT)
    assert found(fit) == pytest.approx([0, 0], abs=1e-6)
    fit = fit_noise(drives(MIXED, 2, k=np.array([0.002, 0.0]), every=4), ROBOT)
    assert fit.noise.right < 0.05 * fit.noise.left


def test_noise_of_the_tracker_is_not_that_of_the_wheels():
    """Of wheels without noise nothing is found; a tracker whose noise is not told is read as theirs."""
    some = drives(MIXED, 3, k=np.zeros(2), every=4, tracked=(0.002, 0.002))
    told = fit_noise(some, ROBOT, position_noise=0.002, heading_noise=0.002)
    assert np.all(found(told) < 3 * told.std)
    assert fit_noise(some, ROBOT).noise.left > 0.002


def test_a_bump_is_seen():
    some = drives(MIXED, 2, every=4)
    bumped = some[0].truth.copy()
    bumped[10:] = dd.se2.compose(bumped[10], dd.se2.compose((0, 0, 0.2), dd.se2.between(bumped[10], bumped[10:])))
    some[0] = dd.Drive(some[0].t, some[0].wheel_angles, bumped, some[0].clock)
    assert any("deviations off: slip, a bump" in words for words in fit_noise(some, ROBOT).warnings)


def test_few_drives_say_how_many_more():
    fit = fit_noise(drives(("arc",), 1, every=4), ROBOT)
    assert any("is known to" in words and "times as much" in words for words in fit.warnings)


def test_it_reads_as_a_report():
    fit = noise_fit.NoiseFit(
        dd.WheelNoise(left=0.002, right=0.001),
        np.diag([1e-8, 4e-8]),
        *np.zeros((2, 3)),
        4,
        80,
        ("hm",),
    )
    assert str(fit).splitlines()[1:] == [
        "  left   0.002 +- 0.0001 m / sqrt(m)", "  right  0.001 +- 0.0002 m / sqrt(m)", "  warning: hm",
    ]  # fmt: skip
    assert "<td>hm</td>" in fit._repr_html_()


def test_bad_input_is_refused():
    some = drives(("arc",), 2, every=4)
    with refused(ValueError, "drives: 2 stretches of 50 m: must be at least 5; give more drives"):
        fit_noise(some, ROBOT, stretch=50.0)
    with refused(
        ValueError, "drives[1]", "steps of the wheels in a stretch: must be at least 5; take a longer stretch"
    ):
        fit_noise([some[0], dd.Drive(some[1].t[::40], some[1].wheel_angles[::40], some[1].truth[::10])], ROBOT)
    still = dd.Drive(np.arange(9.0), np.zeros((9, 2)), np.zeros((9, 3)))
    with refused(ValueError, "drives[0]: the wheels never turn between the true poses"):
        fit_noise([still], ROBOT)
    with refused(TypeError, "robot"):
        fit_noise(some, K)
    with refused(TypeError, "give one as [drive]"):
        fit_noise(some[0], ROBOT)
    with refused(ValueError, "stretch"):
        fit_noise(some, ROBOT, stretch=0.0)
    with refused(ValueError, "position_noise", "must not be negative"):
        fit_noise(some, ROBOT, position_noise=-1.0)
