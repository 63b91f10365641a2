"""The same chunks as tasks of a Dask scheduler, whose workers may be on other machines.

Workers keep nothing: a chunk's trials are gathered once, by whoever runs the sweep, who alone writes files. Only some
chunks are in flight at a time, so that the scheduler's memory does not grow with the study.
"""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from diffdrive_mj._extras import extra
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.sweeps import _chunk
from diffdrive_mj.sweeps._store import made_by
from diffdrive_mj.sweeps.failures import SweepFailed
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

# How long a scheduler may take to answer, and its first worker to come [s].
PATIENCE = 10.0
# Chunks in flight for each thread of the workers: one that runs, and one that waits.
_AHEAD = 2


def run(study: Study, spans: Sequence[tuple[int, int]], scheduler: str) -> Generator[Trials, None, None]:
    """The trials of each span of indices, as they come.

    Raises:
        SweepFailed: no scheduler there, no workers, workers of another version, or a chunk on which workers die.
        MissingExtra: Dask is not installed.
    """
    if not spans:
        return
    with extra("cluster", "distributed", f"scheduler = {scheduler!r}"):
        from distributed import Client, as_completed
    completed: Any = as_completed
    with _quiet(), _connected(Client, scheduler) as client:
        threads = _threads(client, scheduler)
        todo = iter(spans)
        spans_of: dict[str, tuple[int, int]] = {}

        def submit() -> Any:
            span = next(todo, None)
            if span is None:
                return None
            future = client.submit(task, study, *span, pure=False)
            spans_of[future.key] = span
            return future

        flight = completed(
            [future for _ in range(_AHEAD * threads) if (future := submit()) is not None], loop=client.loop
        )
        for future in flight:
            made, trials = _result(future, spans_of.pop(future.key), scheduler)
            if made != made_by():
                raise SweepFailed(
                    f"scheduler {scheduler}: a worker runs {made}, and this is {made_by()}: make them one"
                )
            if (following := submit()) is not None:
                flight.add(following)
            yield trials


def task(study: Study, first: int, last: int) -> tuple[str, Trials]:
    """What a worker does: it says what it is, and runs some trials."""
    return made_by(), _chunk.run(study, first, last)


def _result(future: Any, span: tuple[int, int], scheduler: str) -> tuple[str, Trials]:
    from distributed import CancelledError
    from distributed.scheduler import KilledWorker

    first, last = span
    try:
        made, trials = future.result()
    except DiffdriveError:
        raise
    except KilledWorker as error:
        died = getattr(error, "allowed_failures", None)
        times = "" if died is None else f" {died + 1}"
        raise SweepFailed(
            f"trials {first} to {last - 1}:{times} workers that ran them have died; the workers' logs say of what"
        ) from None
    except CancelledError:
        raise SweepFailed(f"scheduler = {scheduler!r}: is gone; the same command goes on with another one") from None
    except Exception as error:  # whatever a worker lacks
        raise SweepFailed(
            f"trials {first} to {last - 1}: a worker failed ({type(error).__name__}: {error}); workers need "
            f"{made_by()}, as here"
        ) from None
    finally:
        future.release()
    return made, trials


@contextmanager
def _connected(client: Any, scheduler: str) -> Iterator[Any]:
    connected = client.__new__(client)
    try:
        connected.__init__(scheduler, timeout=PATIENCE, set_as_default=False)
    except Exception as error:  # of an address that is none Dask says whatever it stumbles over
        # Left half made, it would close itself when garbage is collected, and hold up whoever connects just then.
        with suppress(Exception):
            connected.close(timeout=1)
        with suppress(Exception):
            connected._loop_runner.stop()  # the thread that a client which has failed leaves running
        reason = "; ".join(str(error).split("\n")[:1]) or type(error).__name__
        raise SweepFailed(f"scheduler = {scheduler!r}: cannot be reached ({reason})") from None
    try:
        yield connected
    finally:
        connected.close(timeout=PATIENCE)


def _threads(client: Any, scheduler: str) -> int:
    """How many chunks the workers run at a time."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except OSError:
        raise SweepFailed(f"scheduler = {scheduler!r}: has no workers; start some with dask worker") from None
    return max(1, sum(client.nthreads().values()))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Dask from reporting what is an error of ours, or no error at all."""
    names = ["distributed", *(name for name in logging.root.manager.loggerDict if name.startswith("distributed."))]
    before = {name: logging.getLogger(name).level for name in names}
    try:
        for name in names:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)
