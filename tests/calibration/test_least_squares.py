"""Calibration by least squares: planted robots come back, surely enough, and what cannot be seen is said."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import refused
from planted import BELIEVED, TRUE, ideal, mixed, vector
from planted import noisy as with_noise

import diffdrive_mj as dd
from diffdrive_mj.calibration.paths import from_fixes, least_squares
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import PARAMETERS
from diffdrive_mj.judging.accuracy import mixed_drive

RNG = np.random.default_rng(5)


def noisy(drive, noise=1e-3, rng=RNG):
    return with_noise(drive, noise, rng)


@pytest.mark.parametrize("start", ["estimated", "truth"])
def test_a_planted_robot_comes_back(start):
    found = least_squares([ideal(TRUE, start=(3, -2, 1.0))], BELIEVED, start=start)
    assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-8)
    assert found.parameters == PARAMETERS[:3]
    assert found.after.final_position_rms < 1e-6 < found.before.final_position_rms
    assert "left_radius" in str(found)


def test_a_planted_turning_gain_is_found_and_an_absent_one_is_not():
    with_gain = [noisy(ideal(TRUE.replace(turning_gain=0.01)), 1e-4)]
    found = least_squares(with_gain, BELIEVED)
    assert found.parameters == PARAMETERS
    assert found.values[3] == pytest.approx(0.01, rel=0.01)
    assert least_squares([noisy(ideal(TRUE), 1e-4)], BELIEVED).parameters == PARAMETERS[:3]


@pytest.mark.parametrize(("sigmas", "freed"), [(3.5, False), (4.5, True)])
def test_a_turning_gain_is_freed_at_four_standard_deviations(sigmas, freed):
    """The same noise throughout, and a gain planted so that its estimate comes out at so many deviations."""
    none = least_squares([noisy(ideal(TRUE), 0.02, np.random.default_rng(8))], BELIEVED, turning_gain=True)
    assert none.parameters == PARAMETERS
    planted = TRUE.replace(turning_gain=float(sigmas * none.std[3] - none.values[3]))
    drives = [noisy(ideal(planted), 0.02, np.random.default_rng(8))]
    estimate = least_squares(drives, BELIEVED, turning_gain=True)
    assert estimate.values[3] == pytest.approx(sigmas * estimate.std[3], rel=0.02)
    assert (least_squares(drives, BELIEVED).parameters == PARAMETERS) == freed
    assert least_squares(drives, BELIEVED, turning_gain=False).parameters == PARAMETERS[:3]


def test_a_gain_that_no_tyre_has_is_not_freed():
    drives = [noisy(ideal(TRUE.replace(turning_gain=0.25)), 1e-4)]
    assert least_squares(drives, BELIEVED, turning_gain=True).values[3] == pytest.approx(0.25, rel=0.01)
    assert least_squares(drives, BELIEVED).parameters == PARAMETERS[:3]


def test_one_wheel_that_stands_still_shows_the_rest():
    t = np.arange(0, 10, 0.02)
    angles = np.stack([np.zeros_like(t), 3 * t], axis=-1)
    found = least_squares([noisy(Drive(t, angles, dd.odometry.integrate(angles, TRUE)))], BELIEVED, turning_gain=False)
    assert found.values[1:] == pytest.approx(vector(TRUE)[1:3], rel=1e-3)
    assert any("do not show left_radius (" in warning for warning in found.warnings)


def test_a_belief_30_percent_off_is_no_obstacle():
    belief = BELIEVED.replace(left_radius=0.07, right_radius=0.13, track_width=0.52)
    found = least_squares([noisy(ideal(TRUE))], belief, anyway=True)
    assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-3)
    assert sum("times the believed" in warning for warning in found.warnings) == 2


def test_several_drives_with_starts_clocks_and_gaps_of_their_own():
    rng = np.random.default_rng(0)
    drives = []
    for start in ((0, 0, 0), (5, 5, -2), (-1, 3, 3)):
        whole = noisy(ideal(TRUE, start=start, rate=0.2), rng=rng)
        kept = np.sort(rng.permutation(len(whole.truth))[: len(whole.truth) // 2])
        drives.append(
            Drive(t=whole.t, wheel_angles=whole.wheel_angles, truth=whole.truth[kept], truth_t=whole.clock[kept])
        )
    found = least_squares(drives, BELIEVED)
    assert (np.abs(found.values - vector(TRUE)[:3]) < 4 * found.std).all()


def test_wrapped_headings_are_no_obstacle():
    drive = ideal(TRUE)
    truth = drive.truth.copy()
    truth[:, 2] = dd.se2.wrap_angle(truth[:, 2])
    wrapped = Drive(t=drive.t, wheel_angles=drive.wheel_angles, truth=truth)
    assert least_squares([wrapped], BELIEVED).values == pytest.approx(vector(TRUE)[:3], rel=1e-8)


def test_endpoints_alone_are_enough():
    whole = ideal(TRUE)
    drives = [
        Drive(
            t=whole.t[:n],
            wheel_angles=whole.wheel_angles[:n],
            truth=whole.truth[[0, n - 1]],
            truth_t=whole.t[[0, n - 1]],
        )
        for n in (400, 900, 1500, 2200, len(whole.t))
    ]
    assert least_squares(drives, BELIEVED).values == pytest.approx(vector(TRUE)[:3], rel=1e-6)
    with refused(ValueError, "more drives or poses are needed"):
        least_squares(drives[:1], BELIEVED, headings=False)


def test_a_clock_that_is_off_is_found():
    whole = ideal(TRUE, rate=0.2)
    inside = slice(5, -5)
    late = Drive(
        t=whole.t, wheel_angles=whole.wheel_angles, truth=whole.truth[inside], truth_t=whole.clock[inside] + 0.04
    )
    found = least_squares([late], BELIEVED, clock_offset=True)
    by_fixes = from_fixes([late], BELIEVED, clock_offset=True)
    for estimate in (found, by_fixes):
        assert estimate.details["clock_offset_s"] == pytest.approx(0.04, abs=1e-4)
        assert estimate.values == pytest.approx(vector(TRUE)[:3], rel=1e-4)


def test_fixes_without_headings_are_enough_and_headings_are_not_read():
    drive = noisy(ideal(TRUE, rate=0.1))
    found = from_fixes([drive], BELIEVED)
    assert (np.abs(found.values - vector(TRUE)[:3]) < 4 * found.std).all()
    scrambled = drive.truth.copy()
    scrambled[:, 2] = RNG.normal(size=len(scrambled))
    other = Drive(t=drive.t, wheel_angles=drive.wheel_angles, truth=scrambled, truth_t=drive.clock)
    assert from_fixes([other], BELIEVED).values == pytest.approx(found.values, rel=1e-7)


def test_fixes_of_several_drives_find_a_robot_far_from_the_belief():
    """The drives are so long that from the belief the far ends lie on the wrong side of the plane."""
    drives = [noisy(ideal(TRUE, start=start, rate=0.02)) for start in ((0, 0, 0), (5, 5, -2), (-1, 3, 3))]
    far = BELIEVED.replace(left_radius=0.11, right_radius=0.095, track_width=0.37)
    found = from_fixes(drives, far)
    assert (np.abs(found.values - vector(TRUE)[:3]) < 4 * found.std).all()
    assert found.std == pytest.approx(0, abs=1e-3)


def test_the_stated_uncertainty_is_that_of_many_repetitions():
    rng = np.random.default_rng(1)
    drive = ideal(TRUE, rate=0.2)
    runs = [least_squares([noisy(drive, rng=rng)], BELIEVED, turning_gain=False) for _ in range(60)]
    errors = np.array([run.values - vector(TRUE)[:3] for run in runs])
    stated = np.mean([run.std for run in runs], axis=0)
    assert errors.std(axis=0) == pytest.approx(stated, rel=0.3)
    assert (np.abs(errors) < 2 * stated).mean() > 0.9
    assert np.corrcoef(errors.T) == pytest.approx(runs[0].correlation, abs=0.35)


def test_correlated_residuals_are_allowed_for_roughly():
    """Noise of the truth that remembers 95 % of itself: taken for independent, errors would be five sigma each."""
    rng, drive = np.random.default_rng(3), ideal(TRUE, rate=0.2)
    ratios = []
    for _ in range(12):
        noise = np.zeros_like(drive.truth)
        for k, fresh in enumerate(rng.normal(size=noise.shape)[1:], 1):
            noise[k] = 0.95 * noise[k - 1] + fresh
        drifting = Drive(
            t=drive.t, wheel_angles=drive.wheel_angles, truth=drive.truth + 1e-3 * noise, truth_t=drive.clock
        )
        found = least_squares([drifting], BELIEVED, turning_gain=False)
        assert any("correlated along the drives" in warning for warning in found.warnings)
        ratios.append((found.values - vector(TRUE)[:3]) / found.std)
    assert np.sqrt(np.mean(np.square(ratios), axis=0)) == pytest.approx(1.0, abs=0.5)
    assert not any("correlated" in warning for warning in least_squares([noisy(drive)], BELIEVED).warnings)


def test_a_straight_line_cannot_show_the_track():
    straight = dd.maneuvers.straight(BELIEVED, distance=5)
    found = least_squares([noisy(ideal(BELIEVED, straight))], BELIEVED.replace(left_radius=0.11, right_radius=0.11))
    assert any("do not show track_width (" in warning for warning in found.warnings)
    assert found.calibrated.left_radius == pytest.approx(0.1, rel=1e-3)
    assert found.condition > 1e3
    # It stays as believed, and as unsure as that, whatever the noise and its outliers are.
    assert found.std[2] == pytest.approx(0.04, rel=0.1)
    drive = noisy(ideal(BELIEVED, straight))
    truth = drive.truth.copy()
    truth[::20, 1] += 0.5
    assert least_squares([replace(drive, truth=truth)], BELIEVED).std[2] == pytest.approx(0.04, rel=0.1)


def test_the_condition_is_that_of_the_relative_derivatives():
    """By differences of odometry itself, in units of the truth's scatter; the start pinned, so that nothing else is
    estimated."""
    drive = noisy(ideal(TRUE, rate=0.2))
    found = least_squares([drive], BELIEVED, start="truth", turning_gain=False)
    columns = []
    for name, value in zip(PARAMETERS[:3], found.values, strict=True):
        up, down = (drive.odometry(found.calibrated.replace(**{name: value + d})) for d in (1e-6, -1e-6))
        columns.append((up - down) / 2e-6 * getattr(BELIEVED, name))
    scatter = [found.details[name] for name in ("position_residual_m", "position_residual_m", "heading_residual_rad")]
    relative = (np.stack(columns, axis=-1) / np.array(scatter)[:, None]).reshape(-1, 3)
    assert found.condition == pytest.approx(np.linalg.cond(relative), rel=0.02)


def test_what_the_truths_scatter_is_does_not_depend_on_its_outliers():
    drive = noisy(ideal(TRUE, rate=0.2), 1e-3)
    truth = drive.truth.copy()
    truth[::25, :2] += 0.5
    found = least_squares([replace(drive, truth=truth)], BELIEVED, turning_gain=False)
    assert found.details["position_residual_m"] == pytest.approx(1e-3, rel=0.15)
    assert found.details["heading_residual_rad"] == pytest.approx(1e-3, rel=0.15)


def test_turns_on_the_spot_cannot_show_the_scale():
    found = least_squares([noisy(ideal(BELIEVED, dd.maneuvers.spin(BELIEVED)), 1e-4)], BELIEVED)
    assert any("left_radius, right_radius, track_width" in warning for warning in found.warnings)


def test_outlying_poses_are_reported_and_do_little_harm():
    drive = noisy(ideal(TRUE, rate=0.2), rng=np.random.default_rng(2))
    truth = drive.truth.copy()
    truth[50:60, :2] += 0.5
    odd = Drive(t=drive.t, wheel_angles=drive.wheel_angles, truth=truth, truth_t=drive.clock, name="odd")
    found = least_squares([odd], BELIEVED)
    assert any(warning.startswith("odd: 10 true poses") for warning in found.warnings)
    assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-3)
    # Ten standard deviations off they are outliers, four off they are not.
    for offset, named in ((0.01, True), (0.004, False)):
        truth = drive.truth.copy()
        truth[::80, 1] = ideal(TRUE, rate=0.2).truth[::80, 1] + offset
        found = least_squares([replace(odd, truth=truth)], BELIEVED, turning_gain=False)
        assert any(f"odd: {len(truth[::80])} true poses" in warning for warning in found.warnings) == named


def test_an_outlying_drive_is_reported():
    rng = np.random.default_rng(4)
    drives = [noisy(ideal(TRUE, rate=0.1), rng=rng) for _ in range(4)]
    bent = TRUE.replace(track_width=0.43)
    other = noisy(ideal(bent, rate=0.1), rng=rng)
    odd = Drive(t=other.t, wheel_angles=other.wheel_angles, truth=other.truth, truth_t=other.clock, name="other robot")
    found = least_squares([*drives, odd], BELIEVED, turning_gain=False)
    assert next(w for w in found.warnings if "times worse" in w).startswith("other robot: fits")


def test_a_slow_encoder_is_warned_of():
    slalom = dd.maneuvers.slalom(BELIEVED)
    quick = ideal(TRUE, slalom)
    assert not any("slowly" in warning for warning in least_squares([noisy(quick)], BELIEVED).warnings)
    slow = Drive(t=quick.t[::20], wheel_angles=quick.wheel_angles[::20], truth=quick.truth[::20])
    assert any("read slowly for this path (5 Hz)" in w for w in least_squares([noisy(slow, 1e-5)], BELIEVED).warnings)
    # A bias far below the stated uncertainty is not worth a warning.
    assert not any("slowly" in warning for warning in least_squares([noisy(slow, 0.1)], BELIEVED).warnings)


def test_a_hundred_thousand_samples():
    drive = ideal(TRUE, mixed(period=0.0003))
    assert len(drive.t) > 90_000
    assert least_squares([noisy(drive)], BELIEVED, turning_gain=False).values == pytest.approx(
        vector(TRUE)[:3], rel=1e-4
    )


def test_200_robots_in_physics():
    """4096 ticks at 200 Hz, 20 m of mixed driving, start pose estimated: 24 of them here.

    All 200, of another seed: 3.3, 3.3 and 2.9 ppm, and 96.7 % within two deviations.
    """
    rng = np.random.default_rng(3)
    robots = [
        BELIEVED.replace(**{name: getattr(BELIEVED, name) * (1 + rng.uniform(-0.1, 0.1)) for name in PARAMETERS[:3]})
        for _ in range(24)
    ]
    recording = dd.simulate(robots, mixed_drive(BELIEVED), physics=dd.Physics.fast(), sample_rate=200)
    tick = 2 * np.pi / 4096
    errors, sure = [], []
    for robot, angles, truth in zip(robots, recording.wheel_angles, recording.truth, strict=True):
        counted = np.floor(angles / tick + rng.random(2)) * tick
        exact = Drive(t=recording.t, wheel_angles=counted, truth=truth[::5], truth_t=recording.t[::5])
        found = least_squares([exact], BELIEVED, turning_gain=False)
        errors.append(np.abs(found.values / vector(robot)[:3] - 1))
        at_20_hz = Drive(t=recording.t, wheel_angles=counted, truth=truth[::10], truth_t=recording.t[::10])
        rough = least_squares([noisy(at_20_hz, rng=rng)], BELIEVED, turning_gain=False)
        sure.append(np.abs(rough.values - vector(robot)[:3]) < 2 * rough.std)
    assert (np.percentile(errors, 95, axis=0) < (4.0e-6, 4.0e-6, 3.7e-6)).all()
    assert np.mean(sure) == pytest.approx(0.95, abs=0.03)


@pytest.mark.parametrize(
    ("drives", "builtin", "words"),
    [
        ([], ValueError, "must hold at least one"),
        ([1], TypeError, "drives[0] = 1: must be a Drive"),
        (ideal(TRUE), TypeError, "give one as [drive]"),
    ],
)
def test_bad_drives_are_named(drives, builtin, words):
    with refused(builtin, words):
        least_squares(drives, BELIEVED)


def test_a_robot_that_is_right_already_stays_as_it_is():
    """Wheels and truth agree to the last bit: nothing is left, and nothing is divided by."""
    t = np.arange(20.0)
    straight = Drive(t, np.stack([t, t], axis=1), np.stack([0.125 * t, 0 * t, 0 * t], axis=1))
    right = BELIEVED.replace(left_radius=0.125, right_radius=0.125)
    for method in (least_squares, from_fixes):
        assert method([straight], right).values == pytest.approx(vector(right)[:3])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"headings": "no"}, "headings = 'no': must be True or False"),
        ({"turning_gain": 0.3}, "turning_gain = 0.3: must be True or False"),
        ({"clock_offset": np.array([True, False])}, "clock_offset = array([ True, False]): must be True or False"),
        ({"believed": "matched"}, "believed = 'matched': must be a Robot; Robot.load('matched') gives that preset"),
        ({"drives": "log.csv"}, "drives[0] = 'l': must be a Drive"),
    ],
)
def test_other_kinds_of_values_are_refused(options, words):
    with refused(TypeError, words):
        least_squares(**{"drives": [ideal(TRUE)], "believed": BELIEVED} | options)


def test_a_recording_is_not_a_drive():
    recording = dd.simulate(BELIEVED, dd.maneuvers.straight(BELIEVED, distance=0.05, speed=0.1))
    for drives in (recording, [recording]):
        with refused(TypeError, "sensors.measure(recording) makes drives of it"):
            least_squares(drives, BELIEVED)


def test_drives_on_which_nothing_moves_are_refused():
    t = np.arange(10.0)
    with refused(ValueError, "the wheels never turn"):
        least_squares([Drive(t=t, wheel_angles=np.zeros((10, 2)), truth=np.zeros((10, 3)))], BELIEVED)
    with refused(ValueError, "the true pose never moves"):
        least_squares([Drive(t=t, wheel_angles=np.stack([t, t], axis=1), truth=np.zeros((10, 3)))], BELIEVED)
    with refused(ValueError, "unknown start 'guess'"):
        least_squares([ideal(TRUE)], BELIEVED, start="guess")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"t": [0.0, 1.0, 1.0]}, "d: t[2] = 1 s after 1 s: times must increase"),
        ({"t": [0.0, 2.0, 1.0]}, "times must increase"),
        ({"t": [0.0, 1.0, math.nan]}, "d: t[2] = nan"),
        ({"wheel_angles": np.zeros((2, 2))}, "wheel_angles has 2 samples and t 3"),
        ({"wheel_angles": np.full((3, 2), math.nan)}, "must be finite"),
        ({"truth": np.zeros((2, 3))}, "truth_t must say when they were"),
        ({"truth_t": [5.0, 6.0, 7.0]}, "the true poses span 5 to 7 s and the encoder 0 to 2 s"),
        ({"t": [0.0], "wheel_angles": np.zeros((1, 2)), "truth": np.zeros((1, 3))}, "at least two times"),
    ],
)
def test_bad_recordings_are_named(changes, words):
    fields = {"t": [0.0, 1.0, 2.0], "wheel_angles": np.zeros((3, 2)), "truth": np.zeros((3, 3)), "name": "d"}
    with refused(ValueError, words):
        Drive(**fields | changes)
