"""`physics_floor` with any number of random drives and any seed; its bounds break when the physics does."""

import numpy as np
import pytest
from experiment_runs import answer, broken
from helpers import experiment

from diffdrive_mj.judging.standards import STANDARD_MANEUVERS, Residual

SCRIPT = experiment("physics_floor")


@pytest.fixture
def shortened(monkeypatch):
    """The experiment without what does not depend on its options: the script's own test measures that."""
    tilt = 1e6 * abs(SCRIPT.belief_matrix(SCRIPT.RIGID, SCRIPT.level_twin(SCRIPT.RIGID))[1, 1] - 1)

    def standard(robot, physics=None, believed=None):
        heading = tilt if robot.axle == "rigid" and believed is None else 0.02
        return {name: Residual(0.07, heading) for name in STANDARD_MANEUVERS}

    def converging(robot, maneuver, physics):
        return 1e3 * physics.timestep * 128 if physics.truth == "engine" else 0.07

    monkeypatch.setattr(SCRIPT, "standard_residuals", standard)
    monkeypatch.setattr(SCRIPT, "at_every_step", converging)
    return monkeypatch


@pytest.mark.parametrize(("random", "seed"), [(1, 5), (2, 88), (4, 10**9), (6, 7)])
def test_any_number_of_random_drives_and_any_seed(shortened, random, seed):
    found = answer(SCRIPT, random=random, seed=seed)
    if isinstance(found, str):
        assert "none of the drives keeps its grip" in found


@pytest.mark.parametrize(
    ("options", "said"),
    [({"seed": -1}, "seed = -1: must be at least 0"), ({"random": 0}, "random = 0: must be at least 1")],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_what_is_wrong_with_the_physics_breaks_a_bound(shortened):
    assert broken(SCRIPT.run(random=3)) == []
    shortened.setattr(SCRIPT, "at_every_step", lambda robot, maneuver, physics: 1e6 * physics.timestep**2)
    lines = broken(SCRIPT.run(random=3))
    assert any("halves with the step" in line for line in lines)
    loose = {name: Residual(0.5, 0.4) for name in STANDARD_MANEUVERS}
    shortened.setattr(SCRIPT, "standard_residuals", lambda *given, **options: loose)
    lines = broken(SCRIPT.run(random=3))
    assert any("as delivered: position error" in line for line in lines)
    assert any("heading error" in line for line in lines)


@pytest.mark.parametrize(
    ("outcomes", "name"),
    [
        ([(True, 1.2, True)], "position error"),
        ([(False, 1.2, False)], "without a warning"),
        ([(True, 0.5, False)] * 120, "above 0.05 ppm"),
        ([(True, 0.01, True)] * 60, "needlessly"),
    ],
)
def test_random_drives_break_the_bound_that_is_meant_for_them(shortened, outcomes, name):
    cases = iter([(True, 0.01, False)] * 40 + outcomes)
    shortened.setattr(SCRIPT, "random_cases", lambda count, seed: list(range(count)))
    shortened.setattr(SCRIPT, "outcome", lambda case: SCRIPT.Outcome(*next(cases)))
    (line,) = broken(SCRIPT.run(random=40 + len(outcomes)))
    assert name in line


def test_outcomes_are_what_the_bounds_are_of(shortened):
    report = answer(SCRIPT, random=4, seed=3)
    assert len(report.metrics["random_position_ppm"]) <= 4
    assert np.all(report.metrics["random_position_ppm"] < 1)
