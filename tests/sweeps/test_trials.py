"""What trials say in print and in files, and whom they count."""

import csv

import numpy as np
import pytest

from diffdrive_mj.sweeps import Trials
from diffdrive_mj.sweeps.trials import joined

ENDS = np.array(["ok"] * 996 + ["fell", "fell", "diverged", "refused"])
WHY = np.array(
    [""] * 996 + ["tipped over at 1.2 s", "tipped over", "run 3 diverged", "left_radius = -0.1: must, <b>be"]
)


def trials():
    off = np.where(ENDS == "ok", np.linspace(0, 0.1, 1000), np.nan)
    figures = {"final_position": off, "final_heading": -off, "position_along": np.stack([off / 2, off], axis=-1)}
    return Trials(np.arange(1000), {"robot.left_radius": np.linspace(0.09, 0.11, 1000)}, figures, ENDS, WHY)


def test_who_is_counted():
    sizes = trials().sizes("final_heading")
    assert len(sizes) == 999  # the refused one is no robot
    assert np.isinf(sizes).sum() == 3
    assert np.all(sizes >= 0)
    assert trials().counted == {"ok": 996, "fell": 2, "diverged": 1, "refused": 1}


def test_lost_robots_exceed_every_limit():
    assert trials().exceedance("final_position", 1.0).value == 3 / 999
    assert trials().exceedance("final_position", 0.05).value == pytest.approx(0.5, abs=0.005)
    assert trials().percentile("final_position", 0.5).value == pytest.approx(0.05, rel=0.01)
    assert np.isinf(trials().percentile("final_position", 0.998).value)
    assert trials().percentile("position_along", 0.5).value.shape == (2,)


def test_some_of_them_are_trials():
    some = trials().where(trials().drawn["robot.left_radius"] < 0.1)
    assert (len(some), some.index[-1], some.counted) == (500, 499, {"ok": 500})
    assert some.percentile("position_along", 0.5).value == pytest.approx(
        trials().percentile("position_along", 0.25).value, rel=0.01
    )
    with pytest.raises(ValueError, match="none of them"):
        trials().where(np.zeros(1000, dtype=bool))


def test_the_print_says_what_to_know():
    text = str(trials())
    for line in (
        "1000 trials: 996 ok, 2 fell, 1 diverged, 1 refused",
        "99 % of the robots stay under 99 mm (98.2 to 99.6 mm) of final position error.",
        "Fallen or diverged, and counted as farther off than any limit: 3.",
        "Refused, since they cannot be built or driven, and left out of the shares: 1.",
        "fell, trial 996: tipped over at 1.2 s",
        "refused, trial 999: left_radius = -0.1: must, <b>be",
    ):
        assert line in text.splitlines()
    assert "final heading error [deg]" in text
    assert "&lt;b&gt;" in trials()._repr_html_()
    assert "<b>" not in trials()._repr_html_()


def test_few_trials_say_how_many_are_needed():
    few = Trials(np.arange(20), {}, {"final_position": np.arange(20) / 1e3}, np.full(20, "ok"), np.full(20, ""))
    said = "The 99th percentile of the final position error is 18 mm or more: an upper limit takes 368 trials."
    assert said in str(few).splitlines()
    assert "stay under" not in str(few)


def test_a_distance_is_no_error_that_robots_stay_under():
    kept = {"distance": np.full(1000, 4.0), "final_heading": np.arange(1000) / 1e5}
    text = str(Trials(np.arange(1000), {}, kept, np.full(1000, "ok"), np.full(1000, "")))
    assert "99 % of the robots stay under 0.567 deg (0.563 to 0.571 deg) of final heading error." in text.splitlines()


def test_trials_apart_by_what_varied_in_them():
    speeds, sides = np.tile([0.1, 0.2], 6), np.repeat(["left", "right", "left"], 4)
    some = Trials(np.arange(12), {"speed": speeds, "side": sides}, {}, np.full(12, "ok"), np.full(12, ""))
    parts = some.by("speed", "side")
    assert list(parts) == [(0.1, "left"), (0.2, "left"), (0.1, "right"), (0.2, "right")]
    assert [part.index.tolist() for part in parts.values()] == [[0, 2, 8, 10], [1, 3, 9, 11], [4, 6], [5, 7]]
    assert some.by() == {(): some}
    with pytest.raises(LookupError, match="did you mean 'speed'"):
        some.by("sped")


def test_trials_that_all_are_refused_print():
    none = Trials(
        np.arange(2), {}, {"final_position": np.full(2, np.nan)}, np.full(2, "refused"), np.full(2, "no wheel")
    )
    assert str(none).splitlines()[0] == "2 trials: 2 refused"
    with pytest.raises(ValueError, match="no wheel"):
        none.percentile("final_position", 0.5)


def test_a_file_has_every_row_with_all_digits(tmp_path):
    trials().to_csv(tmp_path / "trials.csv")
    with open(tmp_path / "trials.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["index", "outcome", "robot.left_radius", "final_position", "final_heading", "why"]
    assert [float(row["final_position"]) for row in rows[:996]] == trials().figures["final_position"][:996].tolist()
    assert [row["why"] for row in rows] == WHY.tolist()
    assert rows[-1]["final_position"] == ""


def test_bad_input_is_refused(tmp_path):
    with pytest.raises(LookupError, match="final_position"):
        trials().percentile("final_positon", 0.5)
    with pytest.raises(ValueError, match="single one"):
        trials().exceedance("position_along", 0.1)
    with pytest.raises(ValueError, match="must not be negative"):
        trials().exceedance("final_position", -0.1)
    with pytest.raises(ValueError, match="cannot be written"):
        trials().to_csv(tmp_path / "nowhere" / "trials.csv")


def test_one_long_line_takes_no_room_in_every_row():
    rows = [Trials(np.array([k]), {}, {}, np.array(["fell"]), np.array(["x" * 1000 * (k == 7)])) for k in range(100)]
    why = joined(rows).why
    assert [len(line) for line in why] == [1000 * (k == 7) for k in range(100)]
    assert why.nbytes <= 8 * 100
