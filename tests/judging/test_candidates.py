"""Candidates: each kind solves a task, and whatever goes wrong is named with the drive, the line and what was said."""

import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import ROOT, refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.errors import CandidateFailed
from diffdrive_mj.judging.candidates import _first_not_finite, name_of, poses_of
from diffdrive_mj.judging.suite import cases
from diffdrive_mj.judging.tasks import Task

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4, name="mine")
T = np.arange(0.0, 4.0, 0.05)
TASK = Task("bend", ROBOT, T, np.stack([6 * T + np.sin(T), 5 * T], axis=-1), start=(3.0, -2.0, 1.0))

HEADER = """
struct robot { double left_radius, right_radius, track_width, ticks_per_revolution, x, y, theta; };
"""
PROGRAM = (ROOT / "examples" / "odometry.py").read_text()


def python(code):
    return [sys.executable, "-c", code]


class Streamed:
    """Odometry as it runs on a robot."""

    def __init__(self, robot, start):
        self.odometer = dd.odometry.Odometer(robot, start=start)

    def update(self, wheels, t):
        return tuple(self.odometer.update(wheels))


class Numbers:
    """The same by the robot's numbers; it begins at the origin."""

    def __init__(self, left_radius, right_radius, track_width):
        self.odometer = dd.odometry.Odometer(dd.Robot(left_radius=left_radius, right_radius=right_radius,
                                                      track_width=track_width))  # fmt: skip

    def update(self, wheels, t):
        return self.odometer.update(wheels)


def at_once(wheel_angles, t, robot):
    """A function that begins at the origin."""
    return dd.odometry.integrate(wheel_angles, robot)


def from_start(wheel_angles, t, robot, *, start):
    return dd.odometry.integrate(wheel_angles, robot, start=start)


CANDIDATES = {
    "a robot": ROBOT, "a class": Streamed, "a class of numbers": Numbers, "a function": at_once,
    "a function with a start": from_start, "a program": python(PROGRAM),
}  # fmt: skip


@pytest.mark.parametrize("kind", CANDIDATES)
def test_every_kind_of_candidate_gives_the_same_poses(kind):
    assert poses_of(CANDIDATES[kind], TASK) == pytest.approx(TASK.expected, abs=1e-12)


def test_a_program_may_read_ticks():
    task = TASK.in_ticks()
    assert poses_of(python(PROGRAM), task, unit="ticks") == pytest.approx(task.expected, abs=1e-12)
    tick = 2 * np.pi / TASK.ticks_per_revolution
    assert np.abs(task.wheel_angles - TASK.wheel_angles).max() <= tick / 2 + 1e-12
    assert task.counts.dtype.kind == "i"


def test_a_program_is_told_the_numbers_of_the_robot_in_full():
    header, first, *_ = TASK.lines("rad")
    assert header == (
        "# diffdrive 1 unit=rad left_radius=0.1 right_radius=0.091 track_width=0.4 ticks_per_revolution=4096.0 x=3.0 "
        "y=-2.0 theta=1.0"
    )
    assert first == "0.0,0.0,0.0"


@given(numbers(-100, 100), numbers(-1e5, 1e5))
def test_readings_reach_a_program_with_all_their_bits(t, angle):
    task = Task("one", ROBOT, [t, t + 1.0], [(angle, -angle), (0.0, 1 / 3)])
    rows = [[float(cell) for cell in line.split(",")] for line in list(task.lines("rad"))[1:]]
    assert np.array_equal(rows, np.column_stack([task.t, task.wheel_angles]))


COUNT = len(T)
FAILING = {
    "print('1,2,3')": f"answered 1 lines: must be {COUNT}",
    f"for _ in range({COUNT + 3}): print('1,2,3')": f"answered {COUNT + 3} lines: must be {COUNT}",
    f"for _ in range({COUNT}): print('1,2')": "answered '1,2' to line 1: must be x,y,theta",
    f"for _ in range({COUNT}): print('1 2 3')": "answered '1 2 3' to line 1",
    f"for k in range({COUNT}): print('nan,0,0' if k == 7 else '0,0,0')": "answered 'nan,0,0' to line 8",
    f"for k in range({COUNT}): print('inf,0,0' if k == 7 else '0,0,0')": "answered 'inf,0,0' to line 8",
    f"for k in range({COUNT}): print('0,0,x' if k == 9 else '0,0,0')": "answered '0,0,x' to line 10",
    "import sys; sys.stdout.buffer.write(bytes([200, 10]) * 80)": "to line 1: must be x,y,theta",
    "import sys; print('0,0,0'); print('no track', file=sys.stderr); sys.exit(3)":
        f"ended with exit status 3 after 1 of {COUNT} answers; it said: no track",
    "raise ZeroDivisionError('nothing to divide by')": "it said: ZeroDivisionError: nothing to divide by",
    "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)": "was ended by signal 11 after 0",
    "while True: print('1,2,3')": f"answered more than {COUNT} lines, without an end",
    "import time; time.sleep(60)": f"did not end within 0.5 s of its input, after 0 of {COUNT} answers",
    "import sys; print('0,0,0', flush=True); sys.stdin.read(); __import__('time').sleep(60)":
        f"did not end within 0.5 s of its input, after 1 of {COUNT} answers",
    "import sys, os; os.close(1); __import__('time').sleep(60)": "did not end within 0.5 s",
    f"for k in range({COUNT}): print('0,1e300,0' if k == 3 else '0,0,0')": "answered '0,1e300,0' to line 4",
    f"for k in range({COUNT + 1}): print('0,0,0' if k else 'x,y,theta')":
        f"answered {COUNT + 1} lines, line 1 of them 'x,y,theta': must be {COUNT}",
    "import subprocess, sys; sys.stdin.read(); subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])":
        "ended, and what it has started did not within 0.5 s, and keeps its output open",
    "import sys; sys.stderr.buffer.write(b'\\xff is no text'); sys.exit(1)": "it said: \ufffd is no text",
    "import sys; sys.stderr.write('x' * 10**6 + '\\nlast \\x1b[31m'); sys.exit(1)": "it said: last \\x1b[31m",
}  # fmt: skip


@pytest.mark.parametrize("code", FAILING)
def test_a_program_that_fails_is_named_with_what_it_did(code):
    command = python(code)
    begin = time.perf_counter()
    with pytest.raises(CandidateFailed) as failed:
        poses_of(command, TASK, seconds=0.5 if "sleep" in code else 20.0)
    assert time.perf_counter() - begin < 15
    text = str(failed.value)
    assert FAILING[code] in text
    assert text.startswith(f"{name_of(command)}, bend: ")
    assert len(text.splitlines()) == 1


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The example in C as a shared library."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler (cc)")
    return built(tmp_path_factory.mktemp("library"), (ROOT / "examples" / "library.c").read_text())


def built(folder, source):
    (folder / "library.c").write_text(source)
    path = folder / "libodometry.so"
    strict = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "examples")
    subprocess.run(["cc", *strict, "-shared", "-fPIC", "-o", path, folder / "library.c", "-lm"], check=True)
    return path


def test_a_shared_library_is_called_as_its_header_says(library):
    for path in (library, str(library)):
        assert poses_of(path, TASK) == pytest.approx(TASK.expected, abs=1e-12)
        assert name_of(path) == str(library)
    task = TASK.in_ticks()
    assert poses_of(library, task, unit="ticks") == pytest.approx(task.expected, abs=1e-12)
    # Counters are unwrapped for it; what it makes of readings that are none is its own business.
    held = {"repeated", "missing", "zero_dt", "reversed_time", "nan", "nan_first"}
    verdict = dd.judge(library, [case for case in cases() if case.name not in held])
    assert verdict.holds, str(verdict)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (("void update(", "void updated("), "has no function update; in C++ it is declared extern"),
        (("x = given->x,", "x = *(volatile double *)0, x = given->x,"), "was ended by signal 11"),
        (("started = 0;", "for (;;) { } started = 0;"), "did not end within 0.5 s"),
    ],
)
def test_a_library_that_fails_is_named(tmp_path, library, wrong, said):
    source = (ROOT / "examples" / "library.c").read_text().replace('#include "odometry.h"', HEADER)
    path = built(tmp_path, source.replace(*wrong).replace("-Werror", ""))
    with pytest.raises(CandidateFailed) as failed:
        poses_of(path, TASK, seconds=0.5 if "0.5" in said else 20.0)
    assert str(failed.value).startswith(f"{path}, bend: ")
    assert said in str(failed.value)


def test_what_a_library_prints_is_no_answer(tmp_path, library):
    source = (ROOT / "examples" / "library.c").read_text()
    source = source.replace("#include <math.h>", "#include <math.h>\n#include <stdio.h>")
    path = built(tmp_path, source.replace("(void)t;", 'printf("at %f s\\n", t);'))
    assert poses_of(path, TASK) == pytest.approx(TASK.expected, abs=1e-12)


def test_a_library_that_ends_its_program_has_answered_until_then(tmp_path, library):
    source = (ROOT / "examples" / "library.c").read_text()
    source = source.replace("#include <math.h>", "#include <math.h>\n#include <stdlib.h>")
    path = built(tmp_path, source.replace("(void)t;", "if (t > 1) exit(0);"))
    with pytest.raises(CandidateFailed, match=f"answered 21 lines: must be {COUNT}"):
        poses_of(path, TASK)


def test_a_library_may_have_a_version_in_its_name(tmp_path, library):
    path = shutil.copy(library, tmp_path / "libodometry.so.1.2")
    assert poses_of(Path(path), TASK) == pytest.approx(TASK.expected, abs=1e-12)


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler (c++)")
def test_the_header_serves_a_library_in_cplusplus(tmp_path):
    (tmp_path / "library.cpp").write_text((ROOT / "examples" / "library.c").read_text())
    path = tmp_path / "libodometry.so"
    strict = ("-O2", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "examples")
    subprocess.run(["c++", *strict, "-shared", "-fPIC", "-o", path, tmp_path / "library.cpp"], check=True)
    assert poses_of(path, TASK) == pytest.approx(TASK.expected, abs=1e-12)


def test_the_time_a_program_may_take_has_no_end():
    assert poses_of(python(PROGRAM), TASK, seconds=1e30) == pytest.approx(TASK.expected, abs=1e-12)


def test_a_program_that_has_answered_may_take_its_time_to_end():
    ends = "\nimport os, time; sys.stdout.flush(); os.close(1); time.sleep(1.5)"
    assert poses_of(python(PROGRAM + ends), TASK, seconds=20.0) == pytest.approx(TASK.expected, abs=1e-12)


def test_a_library_that_is_none(tmp_path):
    (tmp_path / "mine.so").write_text("no library")
    for path, said in ((tmp_path / "mine.so", "file too short"), (tmp_path / "nowhere.so", "No such file")):
        with pytest.raises(CandidateFailed, match=said):
            poses_of(path, TASK)


def test_a_program_that_cannot_be_started():
    with refused(RuntimeError, "./nowhere, bend: cannot be started (No such file or directory)"):
        poses_of(["./nowhere"], TASK)


def test_comments_and_empty_lines_are_no_answers():
    code = f"print('# ready\\n')\nfor _ in range({COUNT}): print('1,2,3')"
    assert (poses_of(python(code), TASK) == (1, 2, 3)).all()


def test_nothing_is_left_of_a_program_that_hangs(tmp_path):
    """Neither it nor what it has started, nor a thread of ours."""
    before = threading.active_count()
    code = (
        f"import os, subprocess, sys, time\n"
        f"child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])\n"
        f"open({str(tmp_path / 'pids')!r}, 'w').write(f'{{os.getpid()}} {{child.pid}}')\n"
        f"time.sleep(60)"
    )
    with pytest.raises(CandidateFailed, match="did not end"):
        poses_of(python(code), TASK, seconds=2.0)
    own, _ = (tmp_path / "pids").read_text().split()
    assert not Path(f"/proc/{own}").exists()  # not even in the table of processes
    for pid in (tmp_path / "pids").read_text().split():
        for _ in range(100):
            if not _runs(int(pid)):
                break
            time.sleep(0.02)
        assert not _runs(int(pid))
    assert threading.active_count() == before


def _runs(pid):
    try:
        return " Z " not in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.parametrize(
    ("candidate", "said"),
    [
        (lambda wheels, t, robot: wheels, "answered no poses"),
        (lambda wheels, t, robot: None, "no poses"),
        (lambda wheels, t, robot: np.full((len(t), 3), np.nan), "no poses"),
        (lambda wheels, t, robot: np.zeros((len(t) - 1, 3)), "no poses"),
        (lambda wheels, t, robot: np.zeros((2, len(t), 3)), f"no poses: the answer has shape (2, {COUNT}, 3)"),
        (lambda wheels, t, robot: 1 / 0, "raised ZeroDivisionError: division by zero"),
        (lambda wheels, t, robot: 1 / 0, "division by zero (test_candidates.py, line "),
        (lambda wheels: wheels, "raised TypeError"),
        (type("Two", (), {"__init__": lambda self, robot: int("a\nb")}), "raised ValueError: invalid literal"),
        (type("Ends", (), {"__init__": lambda self, robot: sys.exit()}), "raised SystemExit"),
        (type("Silent", (), {"__init__": lambda self, robot: None}), "raised AttributeError"),
        (type("Short", (), {"__init__": lambda self, robot: None, "update": lambda self, w, t: (1, 2)}), "no poses"),
    ],
)
def test_a_function_or_a_class_that_fails_is_named(candidate, said):
    with pytest.raises(CandidateFailed) as failed:
        poses_of(candidate, TASK)
    assert str(failed.value).startswith(f"{name_of(candidate)}, bend: ")
    assert said in str(failed.value)
    assert len(str(failed.value).splitlines()) == 1


@pytest.mark.parametrize("nobody", [None, 3, "./mine", [], [1], ["mine", None]])
def test_what_is_no_candidate(nobody):
    for ask in (name_of, lambda candidate: poses_of(candidate, TASK), lambda candidate: dd.judge(candidate, [TASK])):
        with refused(TypeError, "candidate", "must be a Robot, a function, a class, a shared library, or a program"):
            ask(nobody)


def test_names():
    assert name_of(["python", "-c", "1\n2"]) == "python -c '1\\n2'"  # a title has one line
    assert [name_of(of) for of in (ROBOT, Streamed, at_once, ["a b", "-c"])] == [
        "mine",
        "Streamed",
        "at_once",
        "'a b' -c",
    ]


@given(st.integers(2, 30), numbers(0.0, 1.0))
def test_a_drive_becomes_a_task_where_both_clocks_run(count, late):
    """The truth on a clock of its own; a constant twist, so that interpolation is exact."""
    t = np.arange(60) * 0.1
    angles = np.stack([5 * t, 6 * t], axis=-1)
    clock = late + np.linspace(0.0, 4.5, count)
    exact = dd.odometry.integrate(np.stack([5 * clock, 6 * clock], axis=-1), ROBOT, start=(1.0, 2.0, 3.0))
    task = Task.of(dd.Drive(t, angles, exact, clock, name="log"), ROBOT)
    assert task.name == "log"
    assert late - 1e-9 <= task.t[0] < late + 0.1 + 1e-9
    assert late + 4.4 - 1e-9 <= task.t[-1] <= late + 4.5 + 1e-9
    assert np.array_equal(task.start, task.truth[0])
    if count > 12:  # at most a third of a turn from one true pose to the next
        assert task.expected == pytest.approx(task.truth, abs=1e-9)


def test_a_drive_whose_truth_lies_between_two_readings_is_no_task():
    drive = dd.Drive([0.0, 1.0, 2.0], np.zeros((3, 2)), np.zeros((2, 3)), [0.2, 0.8], name="log")
    with refused(ValueError, "log", "fewer than two readings"):
        Task.of(drive, ROBOT)


def test_two_readings_within_the_truth_are_enough():
    drive = dd.Drive([0.0, 1.0, 2.0, 3.0], np.zeros((4, 2)), np.zeros((2, 3)), [0.5, 2.5], name="log")
    assert Task.of(drive, ROBOT).t.tolist() == [1.0, 2.0]


def test_bad_tasks_are_refused():
    still = ([0.0, 1.0], np.zeros((2, 2)))
    for bad, said in (
        (lambda: Task(3, ROBOT, *still), "Task.name = 3: must be a string"),
        (lambda: Task("a", "ct_bot", *still), "robot = 'ct_bot'"),
        (lambda: Task.of(TASK, ROBOT), "drive = "),
    ):
        with refused(TypeError, said):
            bad()
    for bad, said in (
        (lambda: Task("a", ROBOT, [0.0, 1.0, 2.0], np.zeros((2, 2))), "wheel_angles"),
        (lambda: Task("a", ROBOT, *still, start=(0, 0)), "start"),
        (lambda: Task("a", ROBOT, *still, truth=np.zeros((3, 3))), "truth"),
        (lambda: Task("a", ROBOT, *still, start=(0, 0, np.nan)), "start"),
        (lambda: TASK.header("degrees"), "unknown unit 'degrees'"),
    ):
        with refused(ValueError, said):
            bad()


@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_a_function_that_takes_the_header_is_told_what_a_program_is(unit):
    told = {}

    def mine(readings, t, header):
        told.update(header=header, readings=readings, t=t)
        return TASK.expected

    assert np.array_equal(poses_of(mine, TASK, unit=unit), TASK.expected)
    assert told["header"] == TASK.told(unit)
    assert told["readings"].tolist() == TASK.read(unit)
    assert told["t"].tolist() == T.tolist()


@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_a_class_that_takes_the_header_is_told_what_a_program_is(unit):
    told = []

    class Mine:
        def __init__(self, header):
            told.append(header)

        def update(self, wheels, t):
            told.append((*wheels, t))
            return (0.0, 0.0, 0.0)

    poses_of(Mine, TASK, unit=unit)
    assert told == [TASK.told(unit), *((*wheels, t) for wheels, t in zip(TASK.read(unit), T.tolist(), strict=True))]


@pytest.mark.parametrize(
    ("answer", "first"),
    [
        ([(0, 0, 0), (0, np.nan, 0), (np.inf, 0, 0)], 1),
        ([(0, 0, 0), (1, 2, 3)], None),
        ([(np.nan, 0, 0)], 0),
        (np.full((2, 2, 3), np.nan), None),
        ([np.nan, 0, 0], None),
        (np.nan, None),
        ("no poses", None),
        (None, None),
    ],
)
def test_the_first_answer_that_is_no_number_is_found(answer, first):
    assert _first_not_finite(answer) == first
