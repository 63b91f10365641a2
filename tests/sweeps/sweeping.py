"""Small studies for the tests of sweeps, and what makes two outcomes the same."""

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.sweeps import Maneuver, Normal, Study, Trials, Uniform

ROBOT = dd.Robot.load("matched")
SPREAD = {
    "robot.left_radius": Normal(mean=ROBOT.left_radius, sigma=0.0005),
    "robot.track_width": Normal(mean=ROBOT.track_width, sigma=0.002),
}
SHORT = Maneuver("straight", {"speed": 0.5, "distance": 0.3, "ramp": 0.2, "rest": 0.1})


def small(trials=10, **changes):
    """A study of short drives."""
    fields = {"robot": ROBOT, "maneuver": SHORT, "vary": SPREAD, "trials": trials, **changes}
    return Study(**fields)


def eventful(trials=24):
    """A study in which trials end in all four ways."""
    return small(
        trials,
        robot=dd.Robot.load("turtlebot3_burger"),
        vary={
            "robot.center_of_mass_height": Uniform(low=0.03, high=0.12),
            "robot.center_of_mass_x": Uniform(low=-0.09, high=0.005),
            "believed.track_width": Normal(mean=0.16, sigma=0.001),
        },
        maneuver=Maneuver("straight", {"speed": 0.8, "distance": 0.4, "ramp": 0.2, "rest": 0.3}),
    )


def assert_same(one: Trials, other: Trials) -> None:
    """Every row once, in the same order, with the same bits."""
    assert np.array_equal(one.index, other.index)
    assert one.outcome.tolist() == other.outcome.tolist()
    assert one.why.tolist() == other.why.tolist()
    for mine, theirs in ((one.drawn, other.drawn), (one.figures, other.figures)):
        assert list(mine) == list(theirs)
        for name, values in mine.items():
            assert values.dtype.kind == theirs[name].dtype.kind
            assert values.tobytes() == theirs[name].tobytes(), name
