"""Cases: what they tell whom, and tolerances that any right arc keeps."""

import dataclasses
import math

import numpy as np
import pytest
from helpers import exact_arc, refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, robots

import diffdrive_mj as dd
from diffdrive_mj.judging import cases
from diffdrive_mj.judging.candidates import poses_of
from diffdrive_mj.judging.cases import exact_case
from diffdrive_mj.judging.causes import distance_between
from diffdrive_mj.judging.exact import exact_poses
from diffdrive_mj.parts import WheelEncoder

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4, encoder=WheelEncoder(gear=0.5))
T = np.arange(6.0)
TICKS = np.array([(32000, 0), (32760, -900), (-32000, -1700), (-31000, -2500), (-30000, -3600), (-29000, -4400)])


def ticks_case():
    return exact_case("ticks", "A wrap.", ROBOT, T, TICKS, (1.0, 2.0, 3.0), unit="ticks", counter_bits=16)


class Teller:
    """Says what it was told."""

    def __init__(self, header):
        self.header = header

    def update(self, wheels, t):
        Teller.told = self.header
        Teller.wheels.append(wheels)
        return 0.0, 0.0, 0.0


def test_who_asks_for_the_header_reads_what_a_program_reads():
    Teller.wheels = []
    poses_of(Teller, ticks_case())
    assert Teller.wheels == [tuple(row) for row in TICKS.tolist()]
    assert all(isinstance(wheel, int) for row in Teller.wheels for wheel in row)
    header = dict(pair.split("=") for pair in ticks_case().header("rad").split()[3:])
    assert {name: str(value) for name, value in Teller.told.items()} == header
    assert (header["unit"], header["counter_bits"], header["ticks_per_revolution"]) == ("ticks", "16", "2048.0")


def test_a_function_that_asks_for_the_header_gets_all_readings_at_once():
    def mine(readings, t, header):
        assert readings.tolist() == TICKS.tolist()
        assert t.tolist() == T.tolist()
        return np.tile((header["x"], header["y"], header["theta"]), (len(t), 1))

    assert poses_of(mine, ticks_case()).tolist() == [[1.0, 2.0, 3.0]] * 6


def test_others_read_radians_that_count_on_through_wraps():
    angles = ticks_case().wheel_angles
    assert angles[:, 0] * 2048 / (2 * math.pi) == pytest.approx([0, 760, 1536, 2536, 3536, 4536])
    assert angles[0].tolist() == [0.0, 0.0]


def test_plain_tasks_tell_a_header_too():
    task = dd.Task("plain", ROBOT, T, np.zeros((6, 2)))
    Teller.wheels = []
    poses_of(Teller, task, unit="ticks")
    assert Teller.told["unit"] == "ticks"
    assert "tolerance" not in Teller.told


def test_a_task_holds_the_pose_as_a_case_does():
    task = dd.Task("twice", ROBOT, [0.0, 1.0, 1.0, 2.0], [(0, 0), (1, 1), (5, 5), (2, 2)])
    assert task.expected[2].tolist() == task.expected[1].tolist()
    assert task.expected[3].tolist() == dd.odometry.integrate([(0, 0), (1, 1), (2, 2)], ROBOT)[-1].tolist()
    assert task.rolled == pytest.approx(2 * 0.0955)


arcs = st.lists(st.tuples(numbers(-3.0, 3.0), numbers(-3.0, 3.0)), min_size=2, max_size=12)


@given(robots, arcs, numbers(-100, 100), numbers(-100, 100), numbers(-3, 3))
def test_right_arcs_of_every_form_keep_the_tolerance(robot, steps, x, y, theta):
    """The chord; metres before differences; headings that wrap; the circle's radius above 1.5e-8 rad."""
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    case = exact_case("any", "", robot, np.arange(len(angles)), angles, (x, y, theta))

    def off(answers):
        return distance_between(case, np.array(answers), case.poses)

    assert off(case.odometry(robot)) <= case.tolerance / 2
    metres = angles * (robot.left_radius, robot.right_radius)
    pose, wrapped, answers, others = (x, y, theta), (x, y, theta), [(x, y, theta)], [(x, y, theta)]
    for left, right in np.diff(metres, axis=0).tolist():
        distance, turn = (left + right) / 2, (right - left) / robot.track_width
        if abs(turn) < 1.5e-8:
            pose = (pose[0] + distance * math.cos(pose[2]), pose[1] + distance * math.sin(pose[2]), pose[2] + turn)
        else:
            after, radius = pose[2] + turn, distance / turn
            pose = (
                pose[0] + radius * (math.sin(after) - math.sin(pose[2])),
                pose[1] - radius * (math.cos(after) - math.cos(pose[2])),
                after,
            )
        answers.append(pose)
        chord = distance * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
        along = wrapped[2] + turn / 2
        wrapped = (
            wrapped[0] + chord * math.cos(along), wrapped[1] + chord * math.sin(along),
            math.remainder(wrapped[2] + turn, 2 * math.pi),
        )  # fmt: skip
        others.append(wrapped)
    assert off(answers) <= case.tolerance
    assert off(others) <= case.tolerance


@given(robots, st.tuples(numbers(-3.0, 3.0), numbers(-3.0, 3.0)))
def test_one_step_is_the_exact_arc(robot, step):
    x, y, theta = exact_poses([(0.0, 0.0), step], robot, (0.0, 0.0, 0.0))[-1]
    left, right = step[0] * robot.left_radius, step[1] * robot.right_radius
    turn = (right - left) / robot.track_width
    assert theta == pytest.approx(turn, rel=1e-12, abs=1e-15)
    assert (x, y) == pytest.approx(exact_arc((left + right) / 2, 0.0, turn), rel=1e-11, abs=1e-14)


def test_ticks_are_turned_with_all_the_digits_of_pi():
    """A turn of a wheel of 1 m is 2 pi, and not what float64 makes of it times one."""
    robot = dd.Robot(left_radius=1.0, right_radius=1.0, track_width=1.0, encoder=WheelEncoder(ticks_per_revolution=3))
    (_, (x, _, _)) = exact_poses([(0, 0), (10**15, 10**15)], robot, (0.0, 0.0, 0.0), in_ticks=True)
    assert x == 2094395102393195.5  # 2 pi 1e15 / 3 = 2094395102393195.49...


def test_what_is_no_case():
    with refused(ValueError, "no reading has a time and both wheels"):
        exact_case("none", "", ROBOT, [0.0, 1.0], np.full((2, 2), np.nan), (0, 0, 0))
    with refused(ValueError, "start has shape (2,)"):
        exact_case("short", "", ROBOT, T, TICKS, (0, 0))
    with refused(ValueError, "tolerance = 0"):
        exact_case("none", "", ROBOT, T, TICKS, (0, 0, 0), tolerance=0)
    with refused(ValueError, "poses has shape (2, 3)"):
        exact_case("few", "", ROBOT, T, TICKS, (0, 0, 0), poses=np.zeros((2, 3)))
    with refused(ValueError, "no reading has a time and both wheels"):
        dataclasses.replace(ticks_case(), readings=np.full((6, 2), np.nan))


@pytest.mark.parametrize(("heading", "largest"), [(-7.0, 7.0), (1.0, 2 * math.pi)])
def test_the_tolerance_is_the_formula_of_the_documentation(monkeypatch, heading, largest):
    """Two steps whose numbers are exact: one turns by 2^-27 rad, the other by a little more than one, clockwise."""
    monkeypatch.setattr(cases, "_rounded_up", lambda value: value)
    robot = dd.Robot(left_radius=0.5, right_radius=0.25, track_width=0.5)
    little, u = 2.0**-27, 2.0**-53
    angles = np.array([(0.0, 0.0), (1.0, 2.0 + 2 * little), (3.0, 4.0)])
    poses = np.array([(0.0, 1.0, 0.0), (-3.0, 1.0, heading), (2.0, 2.0, 0.5)])
    n, big_x, big_w, big_d, b = 2, 3.0, 8 * 0.5, (0.5 + little / 2) + 1.0, 0.5
    turns = (little, 1.0 + little)
    ways = (0.5 + little / 4, 0.75 - little / 4)
    off_heading = u * (n * largest + 4 * big_w / b + 8 * sum(turns))
    off_arcs = ways[0] * turns[0] / 2 + ways[1] * 2 * u / turns[1]
    expected = 2 * (u * (n * big_x + 4 * big_w + 8 * big_d) + off_heading * (big_d + b / 2) + off_arcs)
    # The small turn counts a million times as much as roundings do.
    assert cases._tolerance(angles, 8.0, poses, robot) == pytest.approx(expected, rel=1e-14, abs=0)


def test_tolerances_have_two_digits_and_are_rounded_up():
    values = [1.234e-12, 9.91e-9, 4.5001e-3, 1.2]
    assert [cases._rounded_up(value) for value in values] == [1.3e-12, 1.0e-8, 4.6e-3, 1.2]


def test_readings_of_narrow_integers_are_the_numbers_that_they_are():
    wheels = np.array([(200, 0), (10, 250), (100, 3)], dtype=np.uint8)
    narrow, wide = (exact_case("any", "", ROBOT, T[:3], read, (0, 0, 0)) for read in (wheels, wheels.astype(float)))
    assert narrow.tolerance == wide.tolerance
    assert narrow.poses.tolist() == wide.poses.tolist()
