"""Leading dimensions broadcast, each drive has its own answer, and shapes that do not fit are named."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.estimation import course, course_noise, straightness
from diffdrive_mj.physics import mechanics

ROBOT = dd.Robot.load("mismatched")
# By function: its array arguments by name, each for one drive; and how to read an array of its result.
FUNCTIONS = {
    dd.se2.rotate: {"points": (1.0, 2.0), "theta": 0.3},
    dd.se2.compose: {"a": (1.0, 2.0, 0.3), "b": (0.5, -1.0, 2.0)},
    dd.se2.between: {"a": (1.0, 2.0, 0.3), "b": (0.5, -1.0, 2.0)},
    dd.kinematics.turning_center: {"pose": (1.0, 2.0, 0.3), "twist": (0.5, 0.7)},
    dd.kinematics.constraint_residuals: {"body_velocity": (0.5, 0.1, 0.7), "wheel_rates": (4.0, 6.0)},
    straightness.chord_shortening: {"bend": 0.4, "travelled": 1.2},
    straightness.smallest_visible_bend: {"fix_noise": 1e-3, "travelled": 1.2},
    straightness.share_noticed: {"chord": 1.0, "travelled": 1.02, "fix_noise": 0.01},
    course.missing_angle: {"yaw": 0.3, "position": (0.0, 1.0), "goal": (2.0, 0.5)},
    course.from_fixes: {
        "first": (0.0, 1.0), "second": (1.0, 1.5), "travelled": 1.12, "fix_noise": 0.01, "threshold": 0.02
    },
    course_noise.first_order_std: {"fix_noise": 0.01, "baseline": 1.2},
    course_noise.direction_density: {"angle": 0.02, "fix_noise": 0.01, "baseline": 1.2},
    course_noise.end_std: {"fix_noise": 0.01, "baseline": 1.2, "random_walk": 1e-4},
    course_noise.best_baseline: {"fix_noise": 0.01, "random_walk": 1e-4},
    mechanics.contact_forces: {"twist": (0.5, 0.7), "acceleration": (0.2, 0.1)},
}  # fmt: skip
WITH_ROBOT = {dd.kinematics.constraint_residuals: "robot", mechanics.contact_forces: "robot"}
READ = {course.from_fixes: lambda found: found.yaw, mechanics.contact_forces: lambda found: found.load}


def called(function, values):
    robot = {WITH_ROBOT[function]: ROBOT} if function in WITH_ROBOT else {}
    return READ.get(function, np.asarray)(function(**values, **robot))


def spread(value, *leading):
    """Equal values for so many drives, each a little larger than the last."""
    value = np.asarray(value, dtype=float)
    steps = 1 + 0.01 * np.arange(np.prod(leading)).reshape(*leading, *[1] * value.ndim)
    return value * steps


PAIRS = [(function, name) for function, values in FUNCTIONS.items() for name in values]


@pytest.mark.parametrize(("function", "name"), PAIRS)
def test_shapes_that_do_not_fit_are_named(function, name):
    values = {other: spread(value, 3 if other == name else 2) for other, value in FUNCTIONS[function].items()}
    with refused(ValueError, "must broadcast", f"{name} (3,)", *(f"{other} (2,)" for other in values if other != name)):
        called(function, values)


@pytest.mark.parametrize(("function", "name"), PAIRS)
def test_each_drive_has_its_own_answer(function, name):
    one = FUNCTIONS[function]
    many = {other: spread(value, 3, 1) if other == name else spread(value, 2) for other, value in one.items()}
    found = called(function, many)
    for i in range(3):
        for k in range(2):
            alone = {other: many[other][i, 0] if other == name else many[other][k] for other in one}
            assert np.allclose(found[i, k], called(function, alone), rtol=1e-12, atol=0)
