"""The program that answers for a shared library: what it tells it, and how its wheels count."""

import ctypes
import io
import math
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.judging import _library
from diffdrive_mj.judging._library import NUMBERS, Wheel, answers
from diffdrive_mj.judging.tasks import Task

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.08, track_width=0.37, encoder={"ticks_per_revolution": 500, "gear": 2})
TASK = Task("two", ROBOT, [1.5, 2.0], [(0.0, 0.0), (3.0, -4.0)], start=(2.0, -1.0, 0.5))


class Library(SimpleNamespace):
    """Keeps what it is told, and answers with what it reads."""

    def __init__(self):
        told, read = [], []

        def start(robot):
            told.append({name: getattr(robot._obj, name) for name in NUMBERS})

        def update(t, left, right, pose):
            read.append((t, left, right))
            pose[0], pose[1], pose[2] = t, left, 1 / 3

        super().__init__(start=start, update=update, told=told, read=read)


@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_a_library_is_told_the_robot_and_gets_radians(unit):
    library = Library()
    lines = [*answers(library, [*TASK.lines(unit), "\n"])]
    x, y, theta = TASK.start
    assert library.told == [
        {"left_radius": 0.1, "right_radius": 0.08, "track_width": 0.37, "ticks_per_revolution": 1000.0, "x": x, "y": y,
         "theta": theta}
    ]  # fmt: skip
    tick = 2 * math.pi / 1000
    assert np.array(library.read) == pytest.approx(np.array([(1.5, 0, 0), (2.0, 3.0, -4.0)]), abs=tick)
    assert [float(cell) for cell in lines[1].split(",")] == [2.0, library.read[1][1], 1 / 3]
    assert len(lines) == 2


@given(
    st.sampled_from(["16", "32"]),
    st.lists(st.integers(-20_000, 20_000), min_size=1, max_size=30),
    st.integers(-(10**6), 10**6),
)
def test_counters_are_unwrapped(bits, steps, first):
    true = first + np.concatenate([[0], np.cumsum(steps)])
    half = 2 ** (int(bits) - 1)
    shown = [(int(count) + half) % (2 * half) - half for count in true.tolist()]
    wheel = Wheel(0.5, bits)
    angles = [wheel.angle(float(count)) for count in shown]
    assert np.diff(angles) == pytest.approx(0.5 * np.array(steps))
    assert angles[0] == 0.5 * shown[0]


def test_what_is_no_number_is_passed_on_and_changes_nothing():
    wheel = Wheel(2.0, "16")
    assert [wheel.angle(count) for count in (32_767.0, -32_768.0)] == [65_534.0, 65_536.0]
    assert math.isnan(wheel.angle(math.nan))
    assert wheel.angle(-32_767.0) == 65_538.0
    plain = Wheel(2.0, None)
    assert [plain.angle(count) for count in (40_000.0, -40_000.0)] == [80_000.0, -80_000.0]


def test_before_it_is_told_anything_readings_are_radians():
    library = Library()
    assert [*answers(library, ["0.5,1.25,-2.0\n"])] == [f"0.5,1.25,{1 / 3}"]
    assert (library.told, library.read) == ([], [(0.5, 1.25, -2.0)])


class Kept(io.StringIO):
    """What is written and closed can still be read."""

    def close(self):
        self.said = self.getvalue()
        super().close()


def test_the_program_answers_its_input(monkeypatch):
    out = Kept()
    monkeypatch.setattr(_library, "_alone", lambda: out)
    monkeypatch.setattr(ctypes, "CDLL", {"./mine.so": Library()}.__getitem__)
    monkeypatch.setattr("sys.stdin", io.StringIO("0.5,1.25,0\n\n0.75,2.5,0\n"))
    _library.main("./mine.so")
    assert out.said == f"0.5,1.25,{1 / 3}\n0.75,2.5,{1 / 3}\n"


@pytest.mark.parametrize("missing", ["start", "update"])
def test_a_library_without_its_functions_is_refused_before_it_reads(monkeypatch, missing):
    library = Library()
    delattr(library, missing)
    monkeypatch.setattr(_library, "_alone", Kept)
    monkeypatch.setattr(ctypes, "CDLL", lambda path: library)
    with pytest.raises(SystemExit, match=f"mine.so: has no function {missing}"):
        _library.main("mine.so")


def test_it_runs_as_a_program_with_the_path_of_the_library():
    command = [sys.executable, "-m", "diffdrive_mj.judging._library", "./nowhere.so"]
    done = subprocess.run(command, input="", capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert "nowhere.so" in done.stderr
    assert "Traceback" not in done.stderr
