"""A sweep's folder: the study, and each chunk of its trials as one whole file."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from diffdrive_mj._files import write_whole
from diffdrive_mj.sweeps.trials import Trials

_DRAWN, _FIGURE = "drawn:", "figure:"


def chunk_path(folder: Path, first: int, last: int) -> Path:
    """The file of the trials from `first` to before `last`."""
    return folder / "chunks" / f"{first:08d}-{last:08d}.npz"


def write_chunk(folder: Path, trials: Trials) -> None:
    """Write some trials, whole or not at all."""
    content = io.BytesIO()
    arrays: dict[str, Any] = {
        "index": trials.index,
        "outcome": trials.outcome,
        "why": trials.why,
        **{_DRAWN + name: values for name, values in trials.drawn.items()},
        **{_FIGURE + name: values for name, values in trials.figures.items()},
    }
    np.savez(content, **arrays)
    path = chunk_path(folder, int(trials.index[0]), int(trials.index[-1]) + 1)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content.getvalue())


def read_chunk(path: Path) -> Trials | None:
    """The trials of a chunk's file; None if it is not whole."""
    try:
        with np.load(path) as file:
            arrays = dict(file)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
    return Trials(
        arrays["index"],
        {name.removeprefix(_DRAWN): values for name, values in arrays.items() if name.startswith(_DRAWN)},
        {name.removeprefix(_FIGURE): values for name, values in arrays.items() if name.startswith(_FIGURE)},
        arrays["outcome"],
        arrays["why"],
    )
