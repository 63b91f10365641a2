"""Running a study in chunks, each of which is kept as soon as it is done: here, in processes, or on a cluster."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._progress import progress
from diffdrive_mj._text import one_line
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sweeps import _chunk, _cluster, _store, _workers
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials, joined

# How many trials are run together where nobody says.
CHUNK = 16


def sweep(
    study: Study,
    out: str | Path | None = None,
    *,
    chunk: int = CHUNK,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Trials:
    """Run the trials of a study.

    Trial i is the same bits whatever the chunk, the workers and the order, and whether or not the sweep was stopped and
    went on. A robot that falls, an engine that diverges, a robot that cannot be are rows that say so.

    Args:
        study: what is driven, and what varies.
        out: the sweep's folder, in which each chunk is kept as soon as it is done; trials that are there already, be it
            those of a study of fewer, are not run again. None keeps nothing.
        chunk: how many trials are run together, and stand in one file.
        workers: processes on this machine; None for one a core, 1 for none but this.
        scheduler: the address of a Dask scheduler, such as "tcp://10.0.0.1:8786", whose workers run the chunks.

    Returns:
        All the trials, in their order.

    Raises:
        InvalidType: not a study.
        InvalidValue: a folder of another study or version, or that cannot be written; both workers and a scheduler;
            rates that do not divide each other.
        SweepFailed: a chunk whose processes die again and again, or a scheduler that cannot be reached.
        MissingExtra: a scheduler, and Dask is not installed.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> dd.sweep(dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=4))
        Trials(4: 4 ok)
    """
    checks.instance("study", study, Study)
    chunk = checks.whole("chunk", chunk)
    workers = None if workers is None else checks.whole("workers", workers)
    if scheduler is not None:
        checks.string("scheduler", scheduler)
        if workers is not None:
            raise InvalidValue(f"workers = {workers}, scheduler = {scheduler!r}: only one of them can be given")
    _chunk.refuse_rates(study)
    folder = None if out is None else _store.folder_of(out)
    parts = [] if folder is None else _store.opened(folder, study)
    spans = _missing(parts, study.trials, chunk)
    missing = sum(last - first for first, last in spans)
    with (
        progress(one_line(study.name), missing, " trials") as advance,
        closing(_run(study, spans, workers, scheduler)) as done,
    ):
        for part in done:
            if folder is not None:
                _store.write(folder, study, part)
            parts.append(part)
            advance(len(part))
    return joined(parts)


def load(out: str | Path) -> Trials:
    """Read the trials that a sweep has left in its folder, without running any.

    Args:
        out: the folder; that of a sweep that still runs, or was stopped, has some of the trials.

    Returns:
        The trials that are there, in their order.

    Raises:
        MissingFile: no sweep's folder, or one without a chunk.
        InvalidValue: chunks of another version, or of another study.

    Example:
        >>> load("nowhere")
        Traceback (most recent call last):
        diffdrive_mj.errors.MissingFile: out = 'nowhere': no sweep has been kept there
    """
    return joined(_store.left(_store.folder_of(out)))


def _missing(parts: Sequence[Trials], count: int, chunk: int) -> list[_workers.Span]:
    """Spans of the indices below a count that are in no part, each of a chunk at most."""
    missing = np.ones(count, dtype=bool)
    for part in parts:
        missing[part.index] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]])))
    return [
        (first, min(first + chunk, end))
        for begin, end in edges.reshape(-1, 2).tolist()
        for first in range(begin, end, chunk)
    ]


def _run(
    study: Study, spans: Sequence[_workers.Span], workers: int | None, scheduler: str | None
) -> Generator[Trials, None, None]:
    """The trials of each span, as they come."""
    if scheduler is not None:
        yield from _cluster.run(study, spans, scheduler)
        return
    workers = min(_workers.cores() if workers is None else workers, len(spans))
    if workers > 1:
        yield from _workers.run(study, spans, workers)
        return
    for span in spans:
        yield _chunk.run(study, *span)
