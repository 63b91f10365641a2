"""Processes on this machine: killed, interrupted or orphaned, no row is lost or doubled, and every bit is the same."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from sweeping import assert_same, eventful, small

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName
from diffdrive_mj.sweeps import _chunk, _workers
from diffdrive_mj.sweeps.failures import SweepFailed

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="reads what processes there are from /proc"
)

SCRIPT = """
import sys
import diffdrive_mj as dd
from test_workers import long
dd.sweep(long(int(sys.argv[2])), sys.argv[1], chunk=2, workers=2)
"""


def long(trials):
    """Drives long enough to be killed in the midst of a chunk."""
    return small(trials, maneuver=dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 12.0}))


def children(parent):
    """The processes that run chunks for a process."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = path.read_text().rpartition(")")[2].split()
            command = path.with_name("cmdline").read_bytes()
            if int(fields[1]) == parent and b"diffdrive_mj.sweeps._worker" in command and fields[0] != "Z":
                found.append(int(path.parent.name))
    return found


def gone(pid):
    with suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    return True


def eventually(true, seconds=60.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it has not come true"
        time.sleep(0.01)


def start(out, trials):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(out), str(trials)], env=environment, stderr=subprocess.PIPE
    )


def kept(out):
    return len(list((out / "chunks").glob("*.npz"))) if (out / "chunks").exists() else 0


def test_processes_give_the_same_bits_as_none():
    for study in (eventful(), small(9, truth="kinematics", encoder=dd.Encoder(ticks_per_revolution=100))):
        assert_same(dd.sweep(study, chunk=2, workers=2), dd.sweep(study, workers=1))
    assert not children(os.getpid())


def test_a_small_study_starts_no_process(monkeypatch):
    monkeypatch.setattr(_workers, "run", lambda *_: pytest.fail("one chunk needs no process"))
    assert dd.sweep(small(4)).ok.all()


def killed_workers(out, trials, rng, most):
    """Run a sweep whose worker processes are killed at random moments, all in all at most so many."""
    over, count = threading.Event(), [0]

    def kill():
        while not over.wait(rng.uniform(0.05, 0.4)) and count[0] < most:
            if workers := children(os.getpid()):
                os.kill(int(rng.choice(workers)), signal.SIGKILL)
                count[0] += 1

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        return dd.sweep(long(trials), out, chunk=2, workers=2), count[0]
    finally:
        over.set()
        killer.join()


@pytest.mark.parametrize(
    ("trials", "moments"), [(24, 3), pytest.param(120, 10, marks=pytest.mark.slow)], ids=["three", "ten"]
)
def test_workers_that_are_killed_lose_and_double_nothing(tmp_path, trials, moments, monkeypatch):
    monkeypatch.setattr(_workers, "TRIES", moments + 1)  # a chunk may be hit by all of them
    found, count = killed_workers(tmp_path / "out", trials, np.random.default_rng(0), moments)
    assert count == moments
    assert_same(found, dd.sweep(long(trials), workers=1))
    assert_same(dd.sweeps.load(tmp_path / "out"), found)
    assert not children(os.getpid())


@pytest.mark.parametrize(
    ("trials", "moments"), [(24, 2), pytest.param(240, 10, marks=pytest.mark.slow)], ids=["two", "ten"]
)
def test_a_sweep_that_is_killed_goes_on_and_leaves_no_process(tmp_path, trials, moments):
    """The whole of it, at random moments from the first import to the last chunk; the last start is left alone."""
    rng, out, chunks = np.random.default_rng(1), tmp_path / "out", trials // 2
    for moment in range(moments):
        process = start(out, trials)
        try:
            # As many chunks more than there are as leaves some for each of the moments, or a random time before.
            wanted = kept(out) + int(rng.integers(0, chunks // (2 * moments)))
            eventually(lambda least=wanted, one=process: kept(out) > least or one.poll() is not None)
            time.sleep(rng.uniform(0, 0.05))
            workers = children(process.pid)
        finally:
            process.kill()
            process.communicate()
        assert process.returncode == -signal.SIGKILL, f"it was over before moment {moment}"
        eventually(lambda orphans=workers: all(gone(pid) for pid in orphans))
    assert 0 < kept(out) < chunks
    found = dd.sweep(long(trials), out, chunk=3, workers=2)
    assert_same(found, dd.sweep(long(trials), workers=1))
    assert_same(dd.sweeps.load(out), found)


def test_an_interrupt_keeps_what_is_done_and_leaves_no_process(tmp_path):
    process = start(tmp_path / "out", 400)
    try:
        eventually(lambda: kept(tmp_path / "out") > 1)
        workers = children(process.pid)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1].decode()
    finally:
        process.kill()
    assert workers
    assert said.rstrip().endswith("KeyboardInterrupt")  # Python's own; nothing of a worker or a thread
    # It may come while Python handles an exception of its own, such as that of a file that is not there.
    assert said.count("Traceback") == 1 + said.count("During handling of the above exception"), said
    eventually(lambda: all(gone(pid) for pid in workers))
    assert len(dd.sweeps.load(tmp_path / "out")) == 2 * kept(tmp_path / "out") >= 4


def test_a_chunk_on_which_every_worker_dies_is_named_in_one_line(tmp_path, monkeypatch):
    ask = _workers._Worker.ask

    def dying(worker, span):
        if span == (2, 4):
            worker.kill()
        return ask(worker, span)

    monkeypatch.setattr(_workers._Worker, "ask", dying)
    with pytest.raises(
        SweepFailed, match=r"trials 2 to 3: 3 processes that ran them have died, the last one by SIGKILL$"
    ):
        dd.sweep(small(8), tmp_path / "out", chunk=2, workers=2)
    assert not children(os.getpid())
    monkeypatch.undo()
    assert_same(dd.sweep(small(8), tmp_path / "out"), dd.sweep(small(8)))


def test_what_a_worker_raises_is_raised_here():
    """A fault of the package's own is no row."""
    study = small(8, truth="kinematics")
    object.__setattr__(study, "method", "nonsense")
    with pytest.raises(UnknownName, match="nonsense"):
        dd.sweep(study, chunk=2, workers=2)
    assert not children(os.getpid())


def test_a_worker_that_cannot_start_says_why(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(SweepFailed, match=r"3 processes that ran them have died, the last one with exit status 1"):
        dd.sweep(small(8), chunk=2, workers=2)


OWN = """
import diffdrive_mj as dd
from sweeping import small
class Own(dd.sweeps.Normal): pass
study = small(4, truth="kinematics", vary={"robot.track_width": Own(mean=0.4, sigma=0.001)})
print(dd.sweep(study, workers=1).ok.all())
try:
    dd.sweep(study, chunk=2, workers=2)
except dd.DiffdriveError as error:
    print(error)
"""


def test_what_only_a_script_knows_is_refused_in_one_line():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    said = subprocess.run([sys.executable, "-c", OWN], env=environment, capture_output=True, text=True, check=True)
    assert said.stdout.splitlines() == [
        "True",
        "study: other processes cannot take it (Own is of the script itself, and must stand in a module); workers = 1 "
        "runs it in this one",
    ]

    class Local(dd.sweeps.Normal):
        pass

    study = small(4, truth="kinematics", vary={"robot.track_width": Local(mean=0.4, sigma=0.001)})
    with pytest.raises(InvalidType, match=r"^study: other processes cannot take it \(.*Local.*\); workers = 1 runs"):
        dd.sweep(study, chunk=2, workers=2)


def test_workers_and_a_scheduler_exclude_each_other():
    with pytest.raises(InvalidValue, match=re.escape("workers = 2, scheduler = 'tcp://127.0.0.1:1': only one")):
        dd.sweep(small(2), workers=2, scheduler="tcp://127.0.0.1:1")
    with pytest.raises(InvalidValue, match="workers"):
        dd.sweep(small(2), workers=0)


def test_chunks_are_what_a_worker_runs():
    assert_same(_chunk.run(small(4), 1, 3), next(_workers.run(small(4), [(1, 3)], 1)))
