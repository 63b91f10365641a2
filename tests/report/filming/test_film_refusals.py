"""What films refuse, each in one line and before anything is drawn; and the death of the process that draws."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.report.filming import _renderer, _sheet

ROBOT = dd.Robot.load("matched")
T = np.linspace(0, 4, 101)
TRUTH = np.stack([T, 0 * T, 0 * T], axis=-1)
DRIVEN = dd.Recording(
    T, np.stack([10 * T, 10 * T], axis=-1), TRUTH, ROBOT, dd.Commands(1.0, np.zeros((1, 2))), dd.World(), dd.Physics()
)


def film(path="film.webp", **options):
    return lambda: dd.film(DRIVEN, ROBOT, path, **options)


def strobe(path="strobe.png", **options):
    return lambda: dd.strobe(DRIVEN, ROBOT, path, **options)


REFUSED = {
    "camera": (film(camera="aboev"), KeyError, ("unknown camera 'aboev'", "did you mean 'above'?")),
    "camera of a strobe": (strobe(camera="follow"), KeyError, ("unknown camera", "above, oblique")),
    "ending": (film("film.gif"), KeyError, ("'.gif'", ".mp4, .png, .webp")),
    "no ending": (film("film"), KeyError, ("unknown ending of a film ''",)),
    "ending of a strobe": (strobe("strobe.mp4"), KeyError, ("'.mp4'", ".png, .webp")),
    "folder that is not there": (film("nowhere/film.webp"), ValueError, ("cannot be written",)),
    "a folder": (film("taken.webp"), ValueError, ("taken.webp", "is a folder")),
    "no path": (film(""), ValueError, ("must name a file",)),
    "path of another kind": (film(3), TypeError, ("must be a path",)),
    "size of zero": (film(size=(0, 480)), ValueError, ("size[0] = 0", "at least 96")),
    "size too large": (film(size=(5000, 100)), ValueError, ("5000 x 100", "at most 4096 x 4096")),
    "size that is a number": (film(size=640), TypeError, ("size = 640", "(width, height)")),
    "size in words": (film(size=("640", "480")), TypeError, ("size[0] = '640'",)),
    "rate of zero": (film(fps=0), ValueError, ("fps = 0",)),
    "rate too high": (film(fps=1000), ValueError, ("between 0.1 and 120",)),
    "speed of zero": (film(speed=0), ValueError, ("speed = 0",)),
    "speed that leaves one frame": (film(speed=1e4), ValueError, ("a single frame", "at most 100")),
    "size that leaves no room": (film(size=(96, 96), camera="both"), ValueError, ("size = 96 x 96", "32 x 32")),
    "more frames than anyone sees": (film(speed=1e-4), ValueError, ("1e+06 frames", "20000", "larger speed")),
    "time before the drive": (film("a.png", time=-1), ValueError, ("time = -1 s", "0 to 4 s")),
    "time after the drive": (film("a.png", time=5), ValueError, ("time = 5 s", "0 to 4 s")),
    "time of a film": (film(time=1.0), ValueError, ("time = 1.0", ".png")),
    "times: one": (strobe(times=1), ValueError, ("times = 1", "at least 2")),
    "times: too many": (strobe(times=100), ValueError, ("times = 100", "at most 24")),
    "times outside": (strobe(times=[0.0, 9.0]), ValueError, ("9 s", "0 to 4 s")),
    "times that are words": (strobe(times="six"), TypeError, ("times",)),
    "too many drives": (lambda: dd.film(dict.fromkeys("abcde", DRIVEN), ROBOT, "a.webp"), ValueError, ("5 drives",)),
    "no drives": (lambda: dd.film({}, ROBOT, "a.webp"), ValueError, ("0 drives",)),
}  # fmt: skip


@pytest.mark.parametrize(("call", "builtin", "words"), REFUSED.values(), ids=REFUSED)
def test_one_line_and_nothing_is_drawn_or_written(call, builtin, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("taken.webp").mkdir()
    monkeypatch.setattr(_renderer, "_start", lambda said: pytest.fail("it is drawn"))
    with refused(builtin, *words):
        call()
    assert [path.name for path in tmp_path.iterdir()] == ["taken.webp"]


def nothing_left(folder):
    return not list(folder.iterdir())


@pytest.fixture
def started(monkeypatch):
    """The processes that draw."""
    found, start = [], _renderer._start

    def noting(said):
        found.append(start(said))
        return found[-1]

    monkeypatch.setattr(_renderer, "_start", noting)
    return found


def test_no_opengl_is_one_line(tmp_path, monkeypatch, started):
    monkeypatch.setenv("MUJOCO_GL", "rubbish")
    with refused(RuntimeError, "OpenGL cannot be used", "MUJOCO_GL=rubbish"):
        dd.film(DRIVEN, ROBOT, tmp_path / "film.webp")
    assert nothing_left(tmp_path)
    assert [process.poll() is None for process in started] == [False]


@pytest.mark.parametrize(
    "code", ["import time; time.sleep(99)", "import sys, time; sys.stdin.buffer.read(); time.sleep(99)"]
)
def test_a_driver_that_hangs_is_one_line(tmp_path, monkeypatch, code):
    """Whether it reads its job or not."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    process = subprocess.Popen([sys.executable, "-c", code], **pipes)
    monkeypatch.setattr(_renderer, "_start", lambda said: process)
    monkeypatch.setattr(_renderer, "_LONGEST", 0.5)
    with refused(RuntimeError, "sent nothing for 0.5 s", "MUJOCO_GL"):
        dd.film(DRIVEN, ROBOT, tmp_path / "film.webp", fps=100)
    assert nothing_left(tmp_path)
    assert process.returncode is not None


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("ending", ["webp", "mp4"])
def test_a_process_that_is_killed_is_one_line(tmp_path, monkeypatch, started, ending):
    frame = _sheet.Sheet.frame

    def killing(self, panels, k):
        if k == 1:
            os.kill(started[0].pid, signal.SIGKILL)
        return frame(self, panels, k)

    monkeypatch.setattr(_sheet.Sheet, "frame", killing)
    with refused(RuntimeError, "ended by SIGKILL"):
        dd.film(DRIVEN, ROBOT, tmp_path / f"film.{ending}", size=(160, 120))
    assert nothing_left(tmp_path)


@pytest.mark.usefixtures("opengl")
def test_an_earlier_film_stays_where_a_new_one_fails(tmp_path, monkeypatch):
    path = tmp_path / "film.webp"
    path.write_bytes(b"earlier")
    monkeypatch.setattr(_sheet.Sheet, "frame", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        dd.film(DRIVEN, ROBOT, path, size=(160, 120))
    assert path.read_bytes() == b"earlier"


def processes():
    """The processes that draw films, by their number."""
    found = {}
    for path in Path("/proc").glob("[0-9]*"):
        try:
            status = (path / "stat").read_text().rpartition(")")[2].split()
            if b"filming._child" in (path / "cmdline").read_bytes() and status[0] != "Z":
                found[int(path.name)] = int(status[1])
        except OSError:
            continue
    return found


def eventually(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


@pytest.mark.usefixtures("opengl")
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc to look for processes in")
@pytest.mark.parametrize(("sent", "status"), [("SIGTERM", 143), ("SIGINT", 130), ("SIGKILL", -9)])
def test_a_program_that_is_ended_leaves_nothing_behind(tmp_path, sent, status):
    command = [sys.executable, "-m", "diffdrive_mj", "film", "ct_bot", "--output", "film.webp", "--fps", "100"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as program:
        assert eventually(lambda: any(path.stat().st_size > 0 for path in tmp_path.rglob("film.webp")))
        (drawing,) = [child for child, parent in processes().items() if parent == program.pid]
        program.send_signal(getattr(signal, sent))
        assert program.wait(20) == status
        assert eventually(lambda: drawing not in processes())
    assert sent == "SIGKILL" or nothing_left(tmp_path)
