"""Trails of few pieces that stay on the path, and what is written beside the pictures."""

import itertools

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.report.filming import _cameras, _scene
from diffdrive_mj.report.filming._captions import caption, finding, legend
from diffdrive_mj.report.filming._sheet import Group, Sheet
from diffdrive_mj.report.filming._take import Take
from diffdrive_mj.report.filming._trails import corners

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
CIRCLE = np.stack([f(np.linspace(0, 2 * np.pi, 5001)) for f in (np.cos, np.sin)], axis=-1)
THERE_AND_BACK = np.stack([[*np.linspace(0, 3, 50), *np.linspace(3, -1, 50)], np.zeros(100)], axis=-1)


def off(path, kept):
    """How far the points of a path are from the pieces between those that are kept."""
    worst = 0.0
    for a, b in itertools.pairwise(kept):
        along = path[b] - path[a]
        for point in path[a : b + 1]:
            share = np.clip((point - path[a]) @ along / max(along @ along, 1e-30), 0, 1)
            worst = max(worst, float(np.hypot(*(point - path[a] - share * along))))
    return worst


@pytest.mark.parametrize("path", [CIRCLE, THERE_AND_BACK, np.zeros((7, 2))], ids=["circle", "reversing", "rest"])
def test_a_trail_stays_on_its_path_with_few_pieces(path):
    kept = corners(path, 1e-3)
    assert kept[0] == 0 and kept[-1] == len(path) - 1  # noqa: PT018
    assert off(path, kept) <= 1e-3
    # A chord of a unit circle leaves it by 1e-3 where it spans 2 sqrt(2e-3): 70, or twice as many.
    assert len(kept) <= 142


def test_a_long_path_is_drawn_more_coarsely():
    noise = np.cumsum(np.random.default_rng(0).normal(size=(20_000, 2)), axis=0)
    assert len(corners(noise, 1e-6)) <= 400


def take(off_by, angles=None, world=dd.World()):
    t = np.linspace(0, 4, 5)
    truth = np.stack([t, 0 * t, 0 * t], axis=-1)
    ghosts = {name: truth + np.stack([0 * t, distance * t / 4, 0 * t], axis=-1) for name, distance in off_by.items()}
    wheels = np.stack([0.91 * t, t], axis=-1) if angles is None else np.asarray(angles)
    return Take(ROBOT, world, t, truth, wheels, ghosts)


def texts(entries):
    return [entry.text for entry in entries]


def test_the_caption_says_time_k_and_distance():
    whole = take({"odometry": 2.0})
    seen = whole.at(np.array([0.0, 1.0, 4.0]))
    assert texts(caption(whole, seen, 1)) == [
        "t = 1.00 s", "k = 0.910", "robot", "odometry: 0.50 m off", "squares of 0.2 m",
    ]  # fmt: skip
    assert texts(caption(whole, seen, 2, speed=4.0))[1] == "speed x 4"
    assert caption(whole, seen, 0)[3].colour == _scene.GHOSTS[0]


def test_k_is_left_out_where_it_changes():
    whole = take({"a": 1.0}, angles=[(0, 0), (1, 1), (1, 2), (2, 2), (3, 3)])
    assert not any(text.startswith("k") for text in texts(caption(whole, whole, 0)))


@pytest.mark.parametrize(
    ("largest", "text"),
    [(2.0, "0.50 m"), (20.0, "5.0 m"), (0.02, "5.0 mm"), (2e-5, "5.0 µm"), (2e-6, "0.50 µm"), (5e-7, "less than 1 µm")],
)
def test_distances_keep_the_unit_of_the_largest(largest, text):
    whole = take({"a": largest})
    assert texts(caption(whole, whole, 1))[3] == f"a: {text} off"


def test_the_finding_has_the_numbers():
    one, two = take({"odometry": 1.25}), take({"a": 1.25, "b": 1e-8})
    assert finding(one) == "After 4.00 m odometry is 1.25 m off"
    assert finding(one, "Equal radii") == "Equal radii: odometry 1.25 m off after 4.00 m"
    assert finding(two) == "After 4.00 m: a 1.25 m off, b less than 1 µm off"
    assert finding(two, "Both") == "Both, after 4.00 m: a 1.25 m off, b less than 1 µm off"


def test_who_turns_on_the_spot_is_measured_by_time():
    whole = take({"odometry": 1.0})
    spun = Take(ROBOT, whole.world, whole.t, 0 * whole.truth, whole.wheel_angles, whole.ghosts)
    assert finding(spun).startswith("After 4.00 s ")


def test_patches_are_named():
    ice = dd.Patch(x=(1, 2), y=(-1, 1), friction=0.05)
    wood, glass = (dd.Patch(x=(3, 4), y=(-1, 1), friction=friction) for friction in (1.3, 0.2))
    one, many = (take({"a": 1.0}, world=dd.World(patches=patches)) for patches in ((ice,), (ice, wood, glass)))
    assert texts(legend(one, one))[-2:] == ["friction 0.05", "squares of 0.2 m"]
    assert texts(legend(many, many))[-3:] == ["friction 0.05, ...", "friction 1.3", "squares of 0.2 m"]


def test_a_slope_is_said_since_the_floor_is_drawn_level():
    sloping, level = (take({"a": 1.0}, world=dd.World(slope={"angle": a, "direction": 1.0})) for a in (0.05, 0.0))
    assert texts(legend(sloping, sloping))[-2:] == ["slope of 5 %, up towards 57°", "squares of 0.2 m"]
    assert not any("slope" in text for text in texts(legend(level, level)))


def test_a_caption_that_is_too_wide_takes_another_line_and_stays_on_the_sheet():
    whole = take({"a name that is rather long": 1.0, "another name that is rather long": 2.0})
    group = Group("", whole, whole, ("follow",))
    wide, narrow = (Sheet([group], size, caption) for size in ((1200, 400), (300, 400)))
    assert narrow.height < wide.height < 400
    assert wide.widths == [1200]


def test_a_strobe_shows_a_place_once():
    """A robot that comes back after a whole turn is at the same place."""
    once = take({"a": 1.0})
    end, turn = once.truth[2], np.array((0, 0, 2 * np.pi))
    truth = np.array([once.truth[0], once.truth[1], end, end + turn, end + turn / 2])
    whole = Take(ROBOT, once.world, once.t, truth, once.wheel_angles, {"a": truth + np.array((0, 1.0, 0))})
    there = whole.at(whole.t)
    view = _cameras.view("above", [whole], whole.at(whole.t[-1:]), 1.0)
    scene = _scene.standing(whole, there, view, (100, 100))
    assert len(scene.actors) == 2 * 4
