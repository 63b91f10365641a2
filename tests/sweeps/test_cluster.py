"""Chunks as tasks of a real Dask scheduler with two workers on loopback, one of which is killed on the way."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from sweeping import assert_same, eventful, small
from test_workers import eventually, kept, long

import diffdrive_mj as dd
from diffdrive_mj.errors import MissingExtra, UnknownName
from diffdrive_mj.sweeps import _cluster
from diffdrive_mj.sweeps.failures import SweepFailed

KilledWorker = pytest.importorskip("distributed.scheduler").KilledWorker


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def running(folder, *arguments, **environment):
    """A program of Dask's, whose report goes into a file."""
    paths = [str(Path(dd.__file__).parents[1]), str(Path(__file__).parent), str(Path(__file__).parents[1])]
    everything = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "OPENBLAS_NUM_THREADS": "1", **environment}
    with (folder / f"{arguments[0]}-{time.monotonic_ns()}.log").open("w") as report:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{arguments[0]}", *arguments[1:], "--no-dashboard"],
            stdout=report, stderr=report, env=everything, cwd=folder,
        )  # fmt: skip
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def worker(folder, address, **environment):
    own = ("--no-nanny", "--nthreads", "1", "--host", "127.0.0.1", "--local-directory", str(folder))
    return running(folder, "worker", address, *own, **environment)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("dask")


@pytest.fixture(scope="module")
def scheduler(folder):
    port = free_port()
    with running(folder, "scheduler", "--host", "127.0.0.1", "--port", str(port)) as process:

        def listens():
            assert process.poll() is None
            with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
                return True

        eventually(listens, 60.0)
        yield f"tcp://127.0.0.1:{port}"


def test_a_worker_that_is_killed_in_mid_sweep_loses_and_doubles_nothing(scheduler, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(_cluster, "PATIENCE", 60.0)
    study, out, write = long(16), tmp_path / "out", dd.sweeps.runner._store.write
    with worker(folder, scheduler) as first, worker(folder, scheduler) as second:
        monkeypatch.setattr(_cluster, "_threads", lambda client, _: (client.wait_for_workers(2, timeout=60), 2)[1])

        def kill_one(*chunk):
            write(*chunk)
            if kept(out) == 3:
                first.send_signal(signal.SIGKILL)

        monkeypatch.setattr(dd.sweeps.runner._store, "write", kill_one)
        found = dd.sweep(study, out, chunk=2, scheduler=scheduler)
        assert first.wait(5) == -signal.SIGKILL
        assert second.poll() is None
        assert_same(found, dd.sweep(study, workers=1))
        assert_same(dd.sweeps.load(out), found)
        # The rest of what a cluster may meet, on the worker that is left.
        monkeypatch.undo()
        assert_same(dd.sweep(eventful(), chunk=5, scheduler=scheduler), dd.sweep(eventful(), workers=1))
        broken = small(4, truth="kinematics")
        object.__setattr__(broken, "method", "nonsense")
        with pytest.raises(UnknownName, match="nonsense"):
            dd.sweep(broken, scheduler=scheduler)
        monkeypatch.setattr(_cluster, "made_by", lambda: "diffdrive_mj 9.9 with MuJoCo 5.0")
        with pytest.raises(
            SweepFailed, match=r"a worker runs diffdrive_mj .*, and this is diffdrive_mj 9\.9 with MuJoCo"
        ):
            dd.sweep(small(4), scheduler=scheduler)


def test_a_scheduler_without_workers_is_one_line(scheduler, monkeypatch):
    monkeypatch.setattr(_cluster, "PATIENCE", 1.0)
    with pytest.raises(SweepFailed, match=rf"scheduler = '{scheduler}': has no workers; start some") as caught:
        dd.sweep(small(4), scheduler=scheduler)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "address", ["tcp://127.0.0.1:{port}", "nonsense://here", "tcp://no.such.host.invalid:8786", "tcp://", ""]
)
def test_a_scheduler_that_cannot_be_reached_is_one_line_that_names_it(address, monkeypatch):
    monkeypatch.setattr(_cluster, "PATIENCE", 1.0)
    address = address.format(port=free_port())
    with pytest.raises((SweepFailed, ValueError), match=r"scheduler = ") as caught:
        dd.sweep(small(4), scheduler=address)
    assert address in str(caught.value)
    assert "\n" not in str(caught.value)
    assert all(thread.name != "IO loop" for thread in threading.enumerate())


def test_a_chunk_on_which_workers_die_is_named_in_one_line():
    class Future:
        def result(self):
            raise KilledWorker("task-1", None, 3)

        def release(self):
            pass

    with pytest.raises(SweepFailed, match=r"^trials 4 to 7: 4 workers that ran them have died; the workers' logs"):
        _cluster._result(Future(), (4, 8), "tcp://127.0.0.1:1")


def test_without_dask_it_says_which_extra_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtra, match=r"needs distributed: pip install 'diffdrive_mj\[cluster\]'"):
        dd.sweep(small(4), scheduler="tcp://127.0.0.1:1")


def test_a_scheduler_that_dies_is_one_line_and_what_is_done_stays(folder, tmp_path, monkeypatch):
    port, out, write = free_port(), tmp_path / "out", dd.sweeps.runner._store.write
    address = f"tcp://127.0.0.1:{port}"
    with running(folder, "scheduler", "--host", "127.0.0.1", "--port", str(port)) as process, worker(folder, address):
        monkeypatch.setattr(_cluster, "PATIENCE", 60.0)

        def kill_it(*chunk):
            write(*chunk)
            process.kill()
            monkeypatch.setattr(_cluster, "PATIENCE", 1.0)

        monkeypatch.setattr(dd.sweeps.runner._store, "write", kill_it)
        with pytest.raises(SweepFailed, match=rf"scheduler = '{address}': is gone; the same") as caught:
            dd.sweep(long(8), out, chunk=2, scheduler=address)
    assert "\n" not in str(caught.value)
    assert kept(out) >= 1
