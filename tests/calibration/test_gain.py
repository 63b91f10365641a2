"""The turning gain is freed where the drives show it, and nowhere else."""

import numpy as np
import pytest
from planted import BELIEVED, TRUE, counted, ideal, mixed, noisy, similar, vector

import diffdrive_mj as dd
from diffdrive_mj.calibration._gain import SEPARATED, by_chance, separated
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.estimation.derivatives import PARAMETERS

ALONE = {
    "squares": [dd.maneuvers.square(BELIEVED, side=1.0, clockwise=way) for way in (False, True)],
    "spins": [dd.maneuvers.spin(BELIEVED, turns=turns) for turns in (2.0, -2.0)],
    "spins and lines": [
        dd.maneuvers.spin(BELIEVED, turns=2.0),
        dd.maneuvers.straight(BELIEVED, speed=0.5, distance=3.0),
    ],
    "circles": [dd.maneuvers.arc(BELIEVED, radius=radius, distance=6.0, speed=0.5) for radius in (1.0, -1.0)],
}
MIXED = {
    "mixed": [mixed()],
    "an eight and a square": [dd.maneuvers.figure_eight(BELIEVED), dd.maneuvers.square(BELIEVED, clockwise=True)],
}


def share(commands, truth_rate=0.2):
    """What part of the gain's influence is its own, on ideal drives."""
    drives = [ideal(TRUE, command, rate=truth_rate) for command in commands]
    return separated(Problem(drives, BELIEVED, start="estimated", clock_offset=False, headings=True), vector(TRUE))


@pytest.mark.parametrize("name", ALONE)
def test_turns_of_one_kind_do_not_separate_a_gain_from_the_track(name):
    assert share(ALONE[name]) < SEPARATED / 5


@pytest.mark.parametrize("name", MIXED)
def test_turns_of_several_kinds_do(name):
    assert share(MIXED[name]) > SEPARATED


def test_the_share_is_that_of_a_regression():
    """Of the gain's derivative on the others', by differences of odometry itself; the start pinned."""
    drive = ideal(TRUE, rate=0.1)
    problem = Problem([drive], BELIEVED, start="truth", clock_offset=False, headings=True)
    columns = []
    for name, value in zip(PARAMETERS, vector(TRUE), strict=True):
        up, down = (drive.odometry(TRUE.replace(**{name: value + d})) for d in (1e-6, -1e-6))
        columns.append((up - down).ravel() / 2e-6)
    *others, gain = columns
    _, (left_over,), _, _ = np.linalg.lstsq(np.stack(others, axis=1), gain, rcond=None)
    assert separated(problem, vector(TRUE)) == pytest.approx(np.sqrt(left_over / (gain @ gain)), rel=1e-5)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name == "spins" else ()) for name in (*ALONE, *MIXED)]
)
def test_quantised_logs_with_exact_truth_free_no_gain(name):
    """`false_gains.py` says how often in 500 fits."""
    rng = np.random.default_rng(3)
    for ticks, every in ((512, 1), (1024, 2), (4096, 5)):
        robot = similar(BELIEVED, rng)
        drives = [counted(ideal(robot, command), ticks, every, rng) for command in {**ALONE, **MIXED}[name]]
        # Spins leave the radii open, so that rounding decides on them: refused unless accepted.
        assert least_squares(drives, BELIEVED, anyway=name == "spins").parameters == PARAMETERS[:3]


@pytest.mark.parametrize("name", MIXED)
@pytest.mark.parametrize("times", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_gain_of_two_per_cent_is_found(name, times):
    """By one drive, and by a few of which the scatter shows little."""
    rng = np.random.default_rng(4)
    robot = similar(BELIEVED, rng).replace(turning_gain=0.02)
    for ticks, noise in ((1024, 0.0), (4096, 1e-3)):
        drives = [noisy(counted(ideal(robot, command), ticks, 2, rng), noise, rng) for command in MIXED[name] * times]
        found = least_squares(drives, BELIEVED)
        assert found.parameters == PARAMETERS
        assert found.values[3] == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize(
    ("gain", "freed"), [(9e-4, False), (1.2e-3, True), (-1.2e-3, True), (0.19, True), (0.21, False)]
)
def test_a_gain_too_small_to_matter_or_too_large_for_tyres_is_not_freed(gain, freed):
    drives = [noisy(ideal(TRUE.replace(turning_gain=gain)), 1e-5, np.random.default_rng(5))]
    estimate = least_squares(drives, BELIEVED, turning_gain=True, anyway=True)
    assert estimate.values[3] == pytest.approx(gain, abs=5 * estimate.std[3])
    assert estimate.std[3] < 5e-5
    assert (least_squares(drives, BELIEVED, anyway=True).parameters == PARAMETERS) == freed


def test_chance_makes_gains_of_four_deviations_and_more_where_these_come_from_a_few_parts():
    """Against Student's quantiles in closed form, with one and two degrees of freedom."""
    assert by_chance(1e-3, 0.0, 0) == pytest.approx(4e-3, rel=1e-9)
    tail = 3.167124183e-5  # beyond four standard deviations, on one side
    assert by_chance(1e-3, 0.0, 2) == pytest.approx(1e-3 / np.tan(np.pi * tail), rel=1e-6)
    assert by_chance(1e-3, 0.0, 3) == pytest.approx(1e-3 * (1 - 2 * tail) / np.sqrt(2 * tail * (1 - tail)), rel=1e-6)
    # What ticks do is known, whatever the number of parts; and it is never more than all.
    assert by_chance(1e-3, 1e-6, 2) == pytest.approx(4e-3, rel=1e-9)
    assert by_chance(1e-3, 2e-6, 2) == pytest.approx(4e-3 * np.sqrt(2), rel=1e-9)
    assert by_chance(5e-3, 9e-6, 0) == pytest.approx(20e-3, rel=1e-9)


@pytest.mark.parametrize(("times", "freed"), [(1.9, False), (2.2, True)])
def test_a_gain_is_more_than_twice_what_a_slow_encoder_makes_of_one(monkeypatch, times, freed):
    bias = 0.02 / times
    monkeypatch.setattr(Problem, "sampling_bias", lambda self, x: np.full(len(x), -bias))
    drives = [noisy(ideal(TRUE.replace(turning_gain=0.02)), 1e-5, np.random.default_rng(5))]
    assert (least_squares(drives, BELIEVED, anyway=True).parameters == PARAMETERS) == freed


def test_a_gain_that_was_asked_for_and_is_not_shown_is_said_to_be_none():
    rng = np.random.default_rng(6)
    drives = [noisy(ideal(TRUE, command), 1e-3, rng) for command in ALONE["squares"]]
    found = least_squares(drives, BELIEVED, turning_gain=True, anyway=True)
    assert any("hardly separate the turning gain" in warning for warning in found.warnings)
    shown = least_squares([noisy(ideal(TRUE), 1e-3, rng)], BELIEVED, turning_gain=True)
    assert not any("hardly separate" in warning for warning in shown.warnings)


def test_a_rejected_gain_leaves_no_trace():
    """The scales and weights of the fit with a gain are not those of the one without."""
    drive = noisy(ideal(TRUE), 1e-3, np.random.default_rng(7))
    plain, tried = (least_squares([drive], BELIEVED, turning_gain=gain) for gain in (False, None))
    assert tried.values == pytest.approx(plain.values, rel=1e-15)
    assert tried.warnings == plain.warnings
    assert tried.details == plain.details
