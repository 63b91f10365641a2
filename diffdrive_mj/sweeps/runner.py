"""Running a study in chunks, each of which is kept as soon as it is done."""

from __future__ import annotations

from pathlib import Path

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import as_path
from diffdrive_mj._progress import progress
from diffdrive_mj.sweeps import _chunk, _store
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials, joined

CHUNK = 64


def sweep(study: Study, out: str | Path | None = None, *, chunk: int = CHUNK) -> Trials:
    """Run the trials of a study.

    Args:
        study: what is driven, and what varies.
        out: the sweep's folder; chunks that are there already are not run again. None keeps nothing.
        chunk: how many trials are run together; it changes no bit of the result.

    Returns:
        All the trials, in their order.

    Raises:
        InvalidType: not a study.
        InvalidValue: a folder that cannot be written.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> dd.sweep(dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=4))
        Trials(4: 4 ok)
    """
    checks.instance("study", study, Study)
    chunk = checks.whole("chunk", chunk)
    folder = None if out is None else as_path("out", out)
    parts = []
    with progress(study.name, study.trials, " trials") as advance:
        for first in range(0, study.trials, chunk):
            last = min(first + chunk, study.trials)
            part = None if folder is None else _store.read_chunk(_store.chunk_path(folder, first, last))
            if part is None:
                part = _chunk.run(study, first, last)
                if folder is not None:
                    _store.write_chunk(folder, part)
            parts.append(part)
            advance(last - first)
    return joined(parts)
