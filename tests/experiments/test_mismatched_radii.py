"""`mismatched_radii` with a user's own options: the bounds follow from them, and break when the law does."""

import pytest
from experiment_runs import FEW, answer, broken
from figure_checks import check_layout
from helpers import experiment
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, sizes

import diffdrive_mj as dd
from diffdrive_mj.judging.standards import PRESETS

SCRIPT = experiment("mismatched_radii")


@FEW
@given(
    st.fixed_dictionaries(
        {
            "robot": st.sampled_from(PRESETS),
            "distance": st.one_of(numbers(-3.0, -0.2), numbers(0.2, 5.0)),
            "speed": sizes(0.1, 3.0),
            "side": sizes(0.1, 1.0),
        }
    )
)
def test_any_options_have_the_right_answer(options):
    assert not isinstance(answer(SCRIPT, **options), str)


def test_a_robot_of_ones_own(tmp_path):
    """Servos that are not matched, on an axle that tilts, with a load to one side: the law asks for none of it."""
    robot = dd.Robot.load("mismatched").replace(
        axle="rigid", servo={"gains": "equal", "law": "P"}, payload={"mass": 1.0, "y": 0.05, "height": 0.1}
    )
    robot.save(tmp_path / "mine.toml")
    report = answer(SCRIPT, robot=str(tmp_path / "mine.toml"), distance=3.0, side=0.5)
    for picture in report.pictures.values():
        check_layout(picture)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"distance": 0.0}, "distance = 0"),
        ({"speed": -1.0}, "speed = -1.0: must be positive"),
        ({"side": float("nan")}, "side = nan: must be finite"),
        ({"distance": 1e12}, "samples"),
        ({"robot": "nobody.toml"}, "nobody.toml: no such robot file"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_a_wrong_law_breaks_a_bound(monkeypatch):
    right = SCRIPT.believed_path
    monkeypatch.setattr(SCRIPT, "believed_path", lambda path, believed, true: right(path, true, believed))
    assert len(broken(SCRIPT.run(distance=2.0, side=0.5))) == 4
