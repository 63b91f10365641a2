import inspect
import math
import re

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from real_data import optiodom_folder
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration import _square as square
from diffdrive_mj.calibration._square_drives import driving_directions
from diffdrive_mj.calibration._square_scatter import heading_ambiguity, outliers
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.calibration.squares import jung_chung, umbmark
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.optiodom import FOLDERS
from diffdrive_mj.judging.published_squares import PUBLISHED, umbmark_figures
from diffdrive_mj.logs import optiodom_robot, read_optiodom

BELIEVED = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
BOTH_WAYS = (False, True)


def wheels(ratio, track=0.4):
    """The robot of a radius ratio and a track, with the believed mean radius."""
    return square.corrected(BELIEVED, ratio, track)


def driven(true, believed, side, ends_only=False, pieces=1):
    """The square of the believed robot, driven both ways by the true one whose wheels roll as they are told."""
    drives = []
    for clockwise in BOTH_WAYS:
        legs = [(side, 0.0), (0.0, -math.pi / 2 if clockwise else math.pi / 2)] * 4
        steps = np.repeat(dd.kinematics.wheel_rates(legs, believed) / pieces, pieces, axis=0)
        angles = np.vstack([np.zeros(2), steps.cumsum(axis=0)])
        t = np.arange(float(len(angles)))
        truth = dd.odometry.integrate(angles, true)
        seen = truth[[0, -1]] if ends_only else truth
        seen = np.column_stack([seen[:, :2], dd.se2.wrap_angle(seen[:, 2])])
        name = "clockwise" if clockwise else "counter-clockwise"
        drives.append(Drive(t, angles, seen, t[[0, -1]] if ends_only else t, name=name))
    return drives


def noisy(drive, rng, sigma):
    """The drive with the last true pose measured with an error."""
    truth = drive.truth.copy()
    truth[-1] += sigma * rng.normal(size=3)
    return Drive(drive.t, drive.wheel_angles, truth, drive.clock, name=drive.name)


def runs(true, side, count, rng, sigma):
    return [noisy(drive, rng, sigma) for drive in driven(true, BELIEVED, side, ends_only=True) for _ in range(count)]


def gain(result):
    return result.details["E_max_before"] / max(result.details["E_max_after"], 1e-12)


def taped(drives):
    """The drives with what a tape measures: where they end, and no heading."""
    ends = [[(0, 0, 0), (*drive.truth[-1, :2], 0)] for drive in drives]
    return [Drive(drive.t, drive.wheel_angles, end, drive.t[[0, -1]]) for drive, end in zip(drives, ends, strict=True)]


# --- planted errors, rolling wheels


def test_a_tape_that_measures_no_heading_is_enough():
    true = wheels(0.97, 0.43)  # the corners turn by 0.6 rad less than a heading of zero says
    found = umbmark(taped(driven(true, BELIEVED, 2.0)), BELIEVED, side=2.0, headings=False)
    assert found.values == pytest.approx([0.97, 0.43], rel=1e-5)
    assert not {"alpha_theta", "beta_theta", "mismatch"} & set(found.details)
    assert not any("true poses" in warning for warning in found.warnings)


@pytest.mark.parametrize("ratio", [0.8, 0.9, 0.92, 0.94, 1.06, 1.2])
def test_sides_that_bend_are_refused_without_headings_too(ratio):
    with pytest.raises(dd.errors.CalibrationRefused, match=r"m off: unequal wheels and a wrong track do not"):
        umbmark(taped(driven(wheels(ratio), BELIEVED, 4.0)), BELIEVED, side=4.0, headings=False, anyway=True)


@pytest.mark.parametrize("method", [umbmark, jung_chung])
@pytest.mark.parametrize("ends_only", [False, True])
@pytest.mark.parametrize(
    ("ratio", "track"), [(0.97, 0.4), (1.03, 0.44), (1.0, 0.37), (0.98, 0.36), (1.001, 0.401), (0.97, 0.44), (1, 0.4)]
)
def test_planted_errors_come_out(ratio, track, method, ends_only):
    # A wider true track makes the same side fit.
    side = 0.29 * track / max(abs(1 - ratio), 0.029)
    result = method(driven(wheels(ratio, track), BELIEVED, side, ends_only), BELIEVED, side=side)
    assert result.values == pytest.approx([ratio, track], rel=1e-5)
    assert result.calibrated.mean_radius == pytest.approx(BELIEVED.mean_radius)
    assert result.details["E_max_after"] <= 1e-4
    assert result.parameters == ("radius_ratio", "track_width")


def test_jung_and_chung_need_one_round():
    """Heading is linear in the wheel angles, so that nothing is left for a second."""
    result = jung_chung(driven(wheels(0.98, 0.43), BELIEVED, 4.0), BELIEVED, side=4.0, rounds=1)
    assert result.values == pytest.approx([0.98, 0.43], rel=1e-11)


def test_what_is_left_are_positions_of_the_one_and_headings_of_the_other():
    """Of each run, and zero in the mean of its direction."""
    drives = runs(wheels(0.99, 0.41), 2.0, 4, np.random.default_rng(3), np.full(3, 2e-3))
    headings, positions = jung_chung(drives, BELIEVED, side=2.0), umbmark(drives, BELIEVED, side=2.0)
    assert headings.residuals.shape == (8,)
    for result, left in ((headings, headings.residuals[:, None]), (positions, positions.residuals.reshape(8, 2))):
        truth, odometry = (
            np.array([path[-1] for path in paths])
            for paths in ([drive.truth for drive in drives], [drive.odometry(result.calibrated) for drive in drives])
        )
        gap = truth - odometry
        gap[:, 2] = dd.se2.wrap_angle(gap[:, 2])
        expected = gap[:, 2:] if result is headings else gap[:, :2]
        assert left == pytest.approx(expected, abs=1e-12)
    assert headings.residuals.reshape(2, 4).mean(axis=1) == pytest.approx([0.0, 0.0], abs=1e-10)


@pytest.mark.parametrize("sign", [1, -1])
def test_positions_decide_on_another_round_of_umbmark(sign):
    """However wrong the headings of the truth are: in one of the two cases a round would make them worse."""
    drives = []
    for drive, wrong in zip(driven(wheels(0.98), BELIEVED, 2.0), (sign * 0.05, 0.0), strict=True):
        truth = drive.truth.copy()
        truth[-1, 2] += wrong
        drives.append(Drive(drive.t, drive.wheel_angles, truth, drive.clock, name=drive.name))
    once, thrice = (umbmark(drives, BELIEVED, side=2.0, forms="both", rounds=rounds) for rounds in (1, 3))
    assert thrice.details["rounds"] == 3
    assert gain(thrice) > 16 * gain(once)


def test_each_limit_of_an_outcome_is_for_its_own_error():
    """Headings may be left 0.4 rad off, positions a tenth of the side."""

    def moved(*change):
        return [Drive(d.t, d.wheel_angles, np.vstack([d.truth[:-1], d.truth[-1] + change]), d.clock) for d in exact]

    exact = driven(BELIEVED, BELIEVED, 2.0)
    assert umbmark(moved(0, 0, 0.3), BELIEVED, side=2.0).values == pytest.approx([1.0, 0.4], rel=1e-6)
    with refused(ValueError, "do not explain these drives"):
        umbmark(moved(0.2, 0.2, 0), BELIEVED, side=2.0)
    assert umbmark(moved(0.15, 0.0, 0), BELIEVED, side=2.0).values == pytest.approx([1.0, 0.4], rel=0.2)


@given(start=numbers(-3, 3), x=numbers(-5, 5))
def test_the_start_pose_does_not_matter(start, x):
    drives = driven(wheels(0.99, 0.41), BELIEVED, 2.0)
    moved = [
        Drive(d.t, d.wheel_angles, dd.se2.compose((x, -x, start), d.truth), d.clock, name=d.name) for d in drives[::-1]
    ]
    assert umbmark(moved, BELIEVED, side=2.0).values == pytest.approx(umbmark(drives, BELIEVED, side=2.0).values)


def test_more_rounds_help_the_first_order_forms():
    drives = driven(wheels(0.98), BELIEVED, 2.0)
    gains = [gain(umbmark(drives, BELIEVED, side=2.0, forms="both", rounds=rounds)) for rounds in (1, 2, 3)]
    assert gains[0] > 5
    assert gains[1] > 4 * gains[0]
    assert gains[2] > 4 * gains[1]


@pytest.mark.parametrize("forms", ["exact", "both", "x", "y"])
def test_from_unequal_wheels_composition_holds_and_the_published_update_oscillates(forms):
    true, side = wheels(1.01), 2.0
    drives = driven(true, BELIEVED, side)
    ratios = {"composed": [0.985], "published": [0.985]}
    for update, found in ratios.items():
        believed = wheels(found[0])
        for _ in range(4):
            result = umbmark(drives, believed, side=side, forms=forms, update=update, rounds=1, anyway=True)
            believed = result.calibrated
            found.append(believed.radius_ratio)
    assert ratios["composed"][-1] == pytest.approx(1.01, abs=2e-3)
    signs = np.sign(np.array(ratios["published"][1:]) - 1.005)
    assert list(signs) == [1, -1, 1, -1]
    assert max(ratios["published"][2::2]) < 0.995
    assert min(ratios["published"][1::2]) > 1.015
    # From equal wheels the first round is the same.
    first = [umbmark(drives, BELIEVED, side=side, update=u, rounds=1).values for u in ratios]
    assert first[0] == pytest.approx(first[1], rel=1e-14)


def test_the_published_update_is_refused_when_it_makes_things_worse():
    drives = driven(wheels(0.985), wheels(0.985), 2.0)
    with refused(ValueError, "E_max rises from", "keep the nominal values", "anyway=True"):
        umbmark(drives, wheels(0.99), side=2.0, update="published", rounds=1)
    result = umbmark(drives, wheels(0.99), side=2.0, update="published", rounds=1, anyway=True)
    assert any("keep the nominal values" in warning for warning in result.warnings)


def test_what_is_not_observed_is_said():
    """A robot larger all over drives the same squares."""
    result = umbmark(driven(wheels(0.99), BELIEVED, 2.0), BELIEVED, side=2.0)
    assert any("mean radius is not observed" in warning for warning in result.warnings)
    assert any("two runs in each direction" in warning for warning in result.warnings)
    assert np.isnan(result.covariance).all()
    assert 1 < result.condition < 20
    larger = wheels(0.99).replace(left_radius=0.11, right_radius=0.11 * 0.99, track_width=0.44)
    believed = BELIEVED.replace(left_radius=0.11 * 0.995, right_radius=0.11 * 0.995, track_width=0.44)
    scaled = umbmark(driven(larger, BELIEVED, 2.0), BELIEVED, side=2.0)
    assert scaled.values[0] == pytest.approx(0.99, rel=1e-3)
    assert scaled.values[1] == pytest.approx(0.44 * 0.1 / believed.mean_radius, rel=1e-3)


def test_the_result_reads():
    result = umbmark(driven(wheels(0.99), BELIEVED, 2.0), BELIEVED, side=2.0)
    assert isinstance(result, Calibration)
    assert "radius_ratio" in str(result)
    assert result.before.final_position.max() > 1000 * result.after.final_position.max()
    assert result.residuals.shape == (4,)
    assert result.details["mismatch"] == pytest.approx(2.0 * 0.01 / 0.4, rel=1e-3)
    assert result.details["E_d"] == pytest.approx(0.99, rel=1e-3)


# --- scatter


@pytest.mark.slow
def test_the_covariance_is_that_of_many_repetitions():
    rng, sigma = np.random.default_rng(0), np.array([2e-3, 2e-3, 2e-3])
    true, count = wheels(1.005, 0.41), 3
    for method in (umbmark, jung_chung):
        results = [method(runs(true, 2.0, count, rng, sigma), BELIEVED, side=2.0, rounds=1) for _ in range(60)]
        scatter = np.cov([result.values for result in results], rowvar=False)
        said = np.mean([result.covariance for result in results], axis=0)
        assert np.diag(said) == pytest.approx(np.diag(scatter), rel=0.35)
        spread = np.sqrt(scatter[0, 0] * scatter[1, 1])
        assert abs(said[0, 1] - scatter[0, 1]) < 0.2 * spread
        # So few runs say little of their spread: Student, not Gauss.
        away = [(result.values - (1.005, 0.41)) / result.std for result in results]
        assert np.mean(np.abs(away) < 4.6) > 0.95


def test_outliers_are_named_and_left_out_when_asked():
    rng, sigma = np.random.default_rng(1), np.full(3, 1e-3)
    drives = runs(wheels(0.995), 2.0, 6, rng, sigma)
    truth = drives[2].truth.copy()
    truth[-1, 1] += 0.2
    drives[2] = Drive(drives[2].t, drives[2].wheel_angles, truth, drives[2].clock, name="the pushed one")
    kept = umbmark(drives, BELIEVED, side=2.0)
    assert any("the pushed one" in warning and "left out" not in warning for warning in kept.warnings)
    assert kept.residuals.size == 24
    clean = umbmark(drives, BELIEVED, side=2.0, reject_outliers=True)
    assert any("the pushed one (left out)" in warning for warning in clean.warnings)
    assert clean.residuals.size == 22
    assert abs(clean.values[0] - 0.995) < 3e-4 < abs(kept.values[0] - 0.995)


# --- refusals


@pytest.mark.parametrize("method", [umbmark, jung_chung])
@pytest.mark.parametrize(("ratio", "side"), [(0.91, 4.0), (0.96, 4.0), (1.05, 4.0), (0.985, 10.0), (0.5, 1.0)])
def test_bent_sides_are_refused(ratio, side, method):
    drives = driven(wheels(ratio), BELIEVED, side)
    with refused(ValueError, "side", "drive a square of at most"):
        method(drives, BELIEVED, side=side)
    # With the ratio known the same robot may drive as large a square as it likes.
    known = wheels(ratio)
    assert method(driven(known, known, side), known, side=side).values == pytest.approx([ratio, 0.4])


@pytest.mark.parametrize("ends_only", [False, True])
def test_no_wrong_answer(ends_only):
    """Anything is refused or right; of a drive known at its ends alone a warning says what else it may be."""
    for ratio in np.r_[0.6:1.4:0.08]:
        for track in (0.36, 0.4, 0.44):
            for side in (1.0, 4.0, 10.0):
                within = side * abs(1 - ratio) / track <= 0.3
                try:
                    drives = driven(wheels(ratio, track), BELIEVED, side, ends_only, pieces=8)
                    result = umbmark(drives, BELIEVED, side=side)
                except InvalidValue:
                    assert not within, (ratio, track, side)
                    continue
                warned = any("count turns" in warning for warning in result.warnings)
                assert warned == ends_only
                assert warned or result.values == pytest.approx([ratio, track], rel=0.01), (ratio, track, side)


def test_drives_that_are_no_such_squares():
    drives = driven(BELIEVED, BELIEVED, 2.0)
    with refused(ValueError, "none clockwise"):
        umbmark(drives[:1], BELIEVED, side=2.0)
    with refused(ValueError, "none counter-clockwise"):
        jung_chung(drives[1:], BELIEVED, side=2.0)
    with refused(ValueError, "drives: must hold at least one"):
        umbmark([], BELIEVED, side=2.0)
    with refused(ValueError, "drives 8 m", "four sides of 2.5 m"):
        umbmark(drives, BELIEVED, side=2.5)
    still = Drive([0, 1], np.zeros((2, 2)), np.zeros((2, 3)), name="parked")
    with refused(ValueError, "parked", "never turn"):
        umbmark([*drives, still], BELIEVED, side=2.0)
    # Not even with counters that show different counts.
    parked = Drive([0, 1], np.outer([1, 1], [3.0, 5.0]), np.zeros((2, 3)), name="parked")
    with refused(ValueError, "parked", "never turn"):
        umbmark([*drives, parked], BELIEVED, side=2.0)
    for name, legs, why in [
        ("line", [(8, 0)], "turns by 0 rad"),
        ("there and back", [(4, 0), (0, math.pi)] * 2, "along its side 1"),
        ("triangle", [(8 / 3, 0), (0, 2 * math.pi / 3)] * 3, "along its side 2"),
        ("circle", [(8, 2 * math.pi)], "along its side 1"),
        ("long", [(3, 0), (0, math.pi / 2), (1, 0), (0, math.pi / 2)] * 2, "along its side 2"),
        ("corners first", [(0, math.pi / 2), (2, 0)] * 4, "corner after it"),
    ]:
        angles = np.vstack([np.zeros(2), dd.kinematics.wheel_rates(legs, BELIEVED).cumsum(axis=0)])
        other = Drive(np.arange(len(angles)), angles, dd.odometry.integrate(angles, BELIEVED), name=name)
        with refused(ValueError, name, why):
            umbmark([*drives, other], BELIEVED, side=2.0)


@pytest.mark.parametrize(("off", "square"), [(0.7, True), (-0.7, True), (0.85, False)])
@pytest.mark.parametrize("where", ["all", "one"])
def test_a_square_may_turn_by_an_eighth_too_little_or_too_much(off, square, where):
    """In all as about each corner: pi / 4."""
    corners = {"all": np.full(4, np.pi / 2 + off / 4), "one": np.pi / 2 + np.array([off, -off, 0, 0])}[where]
    drives = []
    for way in (1, -1):
        legs = [leg for corner in corners for leg in ((2.0, 0.0), (0.0, way * corner))]
        angles = np.vstack([np.zeros(2), dd.kinematics.wheel_rates(legs, BELIEVED).cumsum(axis=0)])
        drives.append(Drive(np.arange(9.0), angles, dd.odometry.integrate(angles, BELIEVED)))
    if square:
        assert driving_directions(drives, BELIEVED, 2.0).tolist() == [1, -1]
    else:
        with refused(ValueError, "must be a square"):
            driving_directions(drives, BELIEVED, 2.0)


def test_drives_that_wheels_and_track_do_not_explain():
    drives = driven(BELIEVED, BELIEVED, 2.0)
    moved = []
    for drive in drives:
        truth = drive.truth.copy()
        truth[-1, :2] += 0.5
        moved.append(Drive(drive.t, drive.wheel_angles, truth, drive.clock))
    with refused(ValueError, "explain these drives"):
        umbmark(moved, BELIEVED, side=2.0)


@pytest.mark.parametrize("method", [umbmark, jung_chung])
def test_bad_arguments(method):
    drives = driven(BELIEVED, BELIEVED, 2.0)
    for side in (0.0, -1.0, math.nan):
        with refused(ValueError, "side"):
            method(drives, BELIEVED, side=side)
    with refused(TypeError, "side"):
        method(drives, BELIEVED, side="long")
    with refused(TypeError, "believed"):
        method(drives, 0.4, side=2.0)
    with refused(TypeError, "drives"):
        method(drives[0], BELIEVED, side=2.0)
    with refused(TypeError, "drives", "Drive"):
        method([1, 2], BELIEVED, side=2.0)
    with refused(TypeError, "rounds"):
        method(drives, BELIEVED, side=2.0, rounds=1.5)
    with refused(ValueError, "rounds"):
        method(drives, BELIEVED, side=2.0, rounds=0)


def test_unknown_words():
    drives = driven(BELIEVED, BELIEVED, 2.0)
    with refused(ValueError, "update", "composed"):
        umbmark(drives, BELIEVED, side=2.0, update="composd")
    with refused(ValueError, "form", "exact"):
        umbmark(drives, BELIEVED, side=2.0, forms="exakt")


# --- the physics


def test_in_the_ideal_physics_it_takes_the_error_out():
    combinations = [(ratio, wrong) for ratio in (0.97, 0.985, 1.01, 1.03) for wrong in (0.9, 1.0, 1.1)]
    true, beliefs, commands = [], [], []
    for ratio, wrong in combinations:
        believed = BELIEVED.replace(track_width=0.4 * wrong)
        for clockwise in BOTH_WAYS:
            true.append(wheels(ratio))
            beliefs.append(believed)
            commands.append(dd.maneuvers.square(believed, side=4.0, speed=1.0, yaw_rate=2.0, clockwise=clockwise))
    longest = max(plan.duration for plan in commands)
    recording = dd.simulate(true, [plan.extended(longest) for plan in commands], sample_rate=50.0)
    drives = [Drive(recording.t, a, b) for a, b in zip(recording.wheel_angles, recording.truth, strict=True)]
    gains = []
    for i, (ratio, _) in enumerate(combinations):
        result = umbmark(drives[2 * i : 2 * i + 2], beliefs[2 * i], side=4.0)
        assert result.values == pytest.approx([ratio, 0.4], rel=1e-4)
        gains.append(gain(result))
    assert np.median(gains) > 50_000
    assert min(gains) > 1000


# --- the real robot


@pytest.mark.parametrize("recording", PUBLISHED)
def test_the_published_figures_of_a_real_robot(recording):
    """Sousa et al. 2022: their UMBmark reads x alone, one round, with the published update."""
    published, side = PUBLISHED[recording]
    assert umbmark_figures(optiodom_folder(), recording).digits_off(published) < 0.51
    # With x and y together the centroids are left nearer.
    folder = optiodom_folder() / FOLDERS[recording]
    drives, nominal = read_optiodom(folder), optiodom_robot(folder)
    by_x = umbmark(drives, nominal, side=side, update="published", forms="x", rounds=1)
    both = umbmark(drives, nominal, side=side)
    assert both.details["E_max_after"] < by_x.details["E_max_after"]
    assert both.std[0] < 3e-4


@pytest.mark.parametrize("method", [umbmark, jung_chung])
def test_by_default_there_are_three_rounds_and_no_run_is_left_out(method):
    """Far from the believed robot each round still changes the outcome, and one run lies far off."""
    drives = runs(wheels(0.97, 0.44), 3.0, 5, np.random.default_rng(5), 1e-3)
    truth = drives[0].truth.copy()
    truth[-1, :2] += 0.1
    drives[0] = Drive(drives[0].t, drives[0].wheel_angles, truth, drives[0].clock, name="kicked")
    default = method(drives, BELIEVED, side=3.0)
    same = method(drives, BELIEVED, side=3.0, rounds=3, reject_outliers=False, anyway=False)
    assert np.array_equal(default.values, same.values)
    assert any("kicked" in warning for warning in default.warnings)
    assert inspect.signature(method).parameters["rounds"].default == 3
    if method is umbmark:
        exact = method(driven(wheels(0.97, 0.44), BELIEVED, 3.0), BELIEVED, side=3.0, forms="both").values
        by_rounds = [
            method(driven(wheels(0.97, 0.44), BELIEVED, 3.0), BELIEVED, side=3.0, forms="both", rounds=n).values
            for n in (2, 3, 4)
        ]
        assert [np.array_equal(values, exact) for values in by_rounds] == [False, True, False]


@pytest.mark.parametrize("method", [umbmark, jung_chung])
def test_refusals_hold_unless_told_otherwise(method):
    drives = driven(wheels(0.98, 0.43), BELIEVED, 2.0)
    with pytest.raises(dd.errors.CalibrationRefused, match="given twice"):
        method([*drives, drives[0]], BELIEVED, side=2.0)
    assert method([*drives, drives[0]], BELIEVED, side=2.0, anyway=True).warnings


def test_far_runs_are_far_from_their_own_direction():
    """Two tight clusters far apart: what lies in the other one's is far off."""
    rng = np.random.default_rng(3)
    errors = np.concatenate([rng.normal(0, 1e-3, (6, 3)), rng.normal((1.0, 0, 0), 1e-3, (6, 3))])
    directions = np.repeat([1, -1], 6)
    assert not outliers(errors, directions).any()
    errors[2, :2] += (0, 0.05)
    assert np.flatnonzero(outliers(errors, directions)).tolist() == [2]
    # The median distance is 1.1774 standard deviations, of which eight are far.
    angles = np.arange(8) * np.pi / 4
    circle = 1.1774 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    for far, said in ((7.9, []), (8.1, [8])):
        assert np.flatnonzero(outliers(np.concatenate([circle, [[far, 0, 0]]]), np.ones(9))).tolist() == said
    # Of three runs none is.
    assert not outliers(np.eye(3) * [1e-3, 1e-3, 5.0], np.ones(3)).any()


def test_headings_are_ambiguous_from_half_a_turn_between_two_poses():
    """pi b / d: with the corners alone seen, from one side to the next."""
    drives = driven(wheels(1.0), BELIEVED, 2.0)
    assert heading_ambiguity(drives, BELIEVED) == pytest.approx(np.pi * 0.4 / 2.0)
    ends = driven(wheels(1.0), BELIEVED, 2.0, ends_only=True)
    assert heading_ambiguity(ends, BELIEVED) == pytest.approx(np.pi * 0.4 / 8.0)


@pytest.mark.parametrize(("side", "told"), [(2.4, False), (2.6, True)])
def test_turns_that_may_be_miscounted_are_told_below_half_of_a_radius(side, told):
    """pi b / d: 0.52 and 0.48."""
    result = umbmark(driven(wheels(1.0), BELIEVED, side), BELIEVED, side=side)
    assert any("count turns" in warning for warning in result.warnings) == told


def test_what_more_rounds_would_leave_is_told_in_millimetres():
    """One round of the paper's first order leaves what its warning says, and the rounds that it names take that out."""
    drives = driven(wheels(0.97, 0.44), BELIEVED, 3.0)
    short = umbmark(drives, BELIEVED, side=3.0, forms="both", rounds=1)
    (said,) = [warning for warning in short.warnings if "not converged" in warning]
    left, more, would_leave = (
        float(x) for x in re.findall(r"at ([\d.]+) mm, (\d+) more would leave ([\d.e-]+) mm", said)[0]
    )
    assert left == pytest.approx(1e3 * short.details["E_max_after"], rel=0.01)
    longer = umbmark(drives, BELIEVED, side=3.0, forms="both", rounds=1 + int(more))
    assert 1e3 * longer.details["E_max_after"] == pytest.approx(would_leave, rel=0.01)


@pytest.mark.parametrize(("mismatch", "accepted"), [(0.302, True), (0.304, False)])
def test_a_mismatch_may_be_a_hundredth_above_its_limit(mismatch, accepted):
    """It is itself an estimate."""
    side = 2.0
    ratio = 1 - mismatch * 0.4 / side
    drives = driven(wheels(ratio), BELIEVED, side)
    if accepted:
        assert jung_chung(drives, BELIEVED, side=side).details["mismatch"] == pytest.approx(mismatch, rel=1e-3)
    else:
        with pytest.raises(dd.errors.CalibrationRefused, match="the sides are no longer straight") as caught:
            jung_chung(drives, BELIEVED, side=side)
        assert "anyway" not in str(caught.value)  # it would not help
