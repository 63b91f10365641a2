"""Worker processes on this machine: each runs chunks one after the other, so that Python's part is parallel too.

A thread tends to each process: it hands over a chunk, waits for the trials, and starts another process where this one
has died. A process ends when its input does, and so with its parent, however that ends.
"""

from __future__ import annotations

import io
import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Generator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from diffdrive_mj.errors import InvalidType
from diffdrive_mj.sweeps.failures import SweepFailed
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

Span = tuple[int, int]

# How often a chunk is run whose processes die.
TRIES = 3


def cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run(study: Study, spans: Sequence[Span], workers: int) -> Generator[Trials, None, None]:
    """The trials of each span of indices, as they come.

    Raises:
        SweepFailed: the processes that ran a chunk have died, one after the other.
        InvalidType: a study that no other process can know.
    """
    crew = _Crew(study, spans)
    try:
        crew.start(min(workers, len(spans)))
        for _ in spans:
            outcome = crew.done.get()
            if isinstance(outcome, BaseException):
                raise outcome
            yield outcome
    finally:
        crew.end()


class _Packer(pickle.Pickler):
    """Refuses what another process would look for in vain: a script's own classes and functions."""

    def reducer_override(self, of: Any) -> Any:
        if getattr(of, "__module__", None) == "__main__" and hasattr(of, "__qualname__"):
            raise pickle.PicklingError(f"{of.__qualname__} is of the script itself, and must stand in a module")
        return NotImplemented


def _packed(study: Study) -> bytes:
    content = io.BytesIO()
    try:
        _Packer(content).dump(study)
    except Exception as error:  # whatever an attribute that cannot be pickled raises
        raise InvalidType(f"study: other processes cannot take it ({error}); workers = 1 runs it in this one") from None
    return content.getvalue()


class _Crew:
    """The threads, their processes, what is to be done and what is done."""

    def __init__(self, study: Study, spans: Sequence[Span]) -> None:
        self._study = _packed(study)
        self._todo: queue.SimpleQueue[Span] = queue.SimpleQueue()
        for span in spans:
            self._todo.put(span)
        self.done: queue.SimpleQueue[Trials | BaseException] = queue.SimpleQueue()
        self._lock, self._over = threading.Lock(), False
        self._threads: list[threading.Thread] = []
        self._workers: set[_Worker] = set()

    def start(self, count: int) -> None:
        for _ in range(count):
            thread = threading.Thread(target=self._tend, daemon=True)
            self._threads.append(thread)
            thread.start()

    def end(self) -> None:
        """Leave no process behind, whatever it is doing."""
        with self._lock:
            self._over = True
            for worker in self._workers:
                worker.kill()
        for thread in self._threads:
            thread.join()

    def _tend(self) -> None:
        """Run chunk after chunk in a process, and in another where it dies."""
        worker: _Worker | None = None
        try:
            while True:
                span, died = self._todo.get_nowait(), ""
                for _ in range(TRIES):
                    worker = worker or self._hired()
                    try:
                        self.done.put(worker.ask(span))
                        break
                    except (OSError, EOFError, pickle.UnpicklingError):
                        died = self._dismissed(worker)
                        worker = None
                else:
                    first, last = span
                    raise SweepFailed(
                        f"trials {first} to {last - 1}: {TRIES} processes that ran them have died, the last one {died}"
                    )
        except queue.Empty:  # all is done, or being done
            pass
        except BaseException as error:  # whatever it is, the sweep ends with it
            self.done.put(error)
        finally:
            if worker is not None:
                self._dismissed(worker)

    def _hired(self) -> _Worker:
        with self._lock:
            if self._over:
                raise SweepFailed("the sweep has ended")
            worker = _Worker(self._study)
            self._workers.add(worker)
        return worker

    def _dismissed(self, worker: _Worker) -> str:
        how = worker.end()
        with self._lock:
            self._workers.discard(worker)
        return how


class _Worker:
    """A process that runs chunks of one study."""

    def __init__(self, study: bytes) -> None:
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        package = str(Path(__file__).parents[2])
        environment["PYTHONPATH"] = os.pathsep.join([package, *filter(None, [environment.get("PYTHONPATH")])])
        self._said: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 (closed in `end`)
        self._study: bytes | None = study
        # -P: what lies in the working folder is not imported. A session of its own: Ctrl-C is answered by the parent.
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "diffdrive_mj.sweeps._worker"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, env=environment, start_new_session=True,
        )  # fmt: skip

    def ask(self, span: Span) -> Trials:
        """Have some trials run."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        if self._study is not None:
            pickle.dump(sys.path, self._process.stdin)
            self._process.stdin.write(self._study)
            self._study = None
        pickle.dump(span, self._process.stdin)
        self._process.stdin.flush()
        answer: Any = pickle.load(self._process.stdout)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def end(self) -> str:
        """End it, and say how it had ended by itself."""
        status = self._process.poll()
        if status is None:
            # A process that has closed its output is about to end.
            with suppress(subprocess.TimeoutExpired):
                status = self._process.wait(0.5)
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(OSError):
                pipe.close()
        with self._said:
            self._said.seek(0)
            lines = self._said.read().decode(errors="replace").strip().splitlines()
        said = f" ({lines[-1]})" if lines else ""
        if status is not None and status < 0:
            with suppress(ValueError):
                return f"by {signal.Signals(-status).name}{said}"
        return f"with exit status {status}{said}"
