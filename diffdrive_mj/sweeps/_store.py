"""A sweep's folder: the study's text, and each chunk of its trials as one whole file.

A chunk's file says what it is of and what made it, and holds the sum of its content, so that nothing is taken for what
it is not: trials of another study, those of another version, whose bits may be others, and half a file.
"""

from __future__ import annotations

import hashlib
import io
import re
import shutil
import time
import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import __version__
from diffdrive_mj._files import as_path, write_whole
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.sweeps.failures import SweepWarning
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

STUDY, CHUNKS = "study.toml", "chunks"
# The first line of a folder's study: it is changed when what a chunk's file holds is.
_MARK = "# The study of a sweep by diffdrive_mj, format 1: it is what the chunks beside it are of."
_DRAWN, _FIGURE = "drawn:", "figure:"
_CURE = "name another folder"
# What a process that was killed while it wrote leaves behind (`_files.made_whole`), and how old it is by then [s].
_HALF, _OLD = re.compile(r"\.(study\.toml|\d{8,}-\d{8,}\.npz)-[0-9a-f]{16}"), 60.0


def made_by() -> str:
    """What decides about the bits of a trial."""
    return f"diffdrive_mj {__version__} with MuJoCo {version('mujoco')}"


def opened(folder: Path, study: Study) -> list[Trials]:
    """Make a study's folder, or continue in it.

    Returns:
        The trials of the study that are there already, each once.

    Raises:
        InvalidValue: another study's folder, one that holds something else, chunks of another version, or a folder that
            cannot be written.
    """
    text = f"{_MARK}\n{study.to_toml()}"
    there = _read_study(folder)
    if there is None:
        _refuse_foreign(folder)
    elif difference := _difference(there, text):
        raise InvalidValue(f"out = {shown(str(folder))}: holds another study, {difference}; {_CURE}")
    _make(folder)
    _tidy(folder)
    parts = _distinct(_chunks(folder, _fingerprint(text), aside=True), study.trials)
    if there is not None and _trials(there) != study.trials:
        for part in parts:
            _refuse_other_draws(folder, study, part)
    if there is None or _trials(there) < study.trials:
        write_whole(folder / STUDY, text)
    _make(folder / CHUNKS)
    return parts


def left(folder: Path) -> list[Trials]:
    """The trials that are in a folder, each once.

    Raises:
        MissingFile: it is no sweep's folder, or no chunk is done.
        InvalidValue: chunks of another version, or of another study.
    """
    text = _read_study(folder)
    if text is None:
        raise MissingFile(f"out = {shown(str(folder))}: no sweep has been kept there")
    parts = _distinct(_chunks(folder, _fingerprint(text), aside=False), _trials(text))
    if not parts:
        raise MissingFile(f"out = {shown(str(folder))}: no chunk of the sweep is done yet")
    return parts


def write(folder: Path, study: Study, trials: Trials) -> None:
    """Write some trials, whole or not at all.

    Raises:
        InvalidValue: the disk is full, or the folder is gone.
    """
    arrays: dict[str, Any] = {
        "made_by": np.array(made_by()),
        "study": np.array(_fingerprint(study.to_toml())),
        "index": trials.index,
        "outcome": trials.outcome,
        "why": trials.why,
        **{_DRAWN + name: values for name, values in trials.drawn.items()},
        **{_FIGURE + name: values for name, values in trials.figures.items()},
    }
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, sum=np.array(_sum(arrays)), **arrays)
    write_whole(folder / CHUNKS / _name(trials.index), content.getvalue())


def _name(index: NDArray[Any]) -> str:
    return f"{int(index[0]):08d}-{int(index[-1]) + 1:08d}.npz"


def _chunks(folder: Path, fingerprint: str, aside: bool) -> Iterable[Trials]:
    """The trials of every chunk that is whole; one that is not is put aside, if it is to be run again."""
    for path in sorted((folder / CHUNKS).glob("[0-9]*-[0-9]*.npz")):
        arrays = _read_chunk(path)
        if arrays is None:
            if aside:
                _put_aside(path)
            again = "its trials are run again, and it is kept as .broken" if aside else "its trials are left out"
            warnings.warn(f"{path}: is not whole, or not what its name says; {again}", SweepWarning, stacklevel=5)
            continue
        if str(arrays["study"]) != fingerprint:
            raise InvalidValue(f"{path}: is a chunk of another study; take it away, or {_CURE}")
        if str(arrays["made_by"]) != made_by():
            raise InvalidValue(
                f"{path}: was made by {arrays['made_by']}, and this is {made_by()}, which may give other bits; go on "
                f"with that version, or {_CURE}"
            )
        yield Trials(
            arrays["index"],
            {name.removeprefix(_DRAWN): values for name, values in arrays.items() if name.startswith(_DRAWN)},
            {name.removeprefix(_FIGURE): values for name, values in arrays.items() if name.startswith(_FIGURE)},
            arrays["outcome"],
            arrays["why"],
        )


def _read_chunk(path: Path) -> dict[str, Any] | None:
    """What a chunk's file holds; None if it is not whole, or another chunk than its name says."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InvalidValue(f"{path}: cannot be read ({error.strerror})") from None
    try:
        with np.load(io.BytesIO(content)) as file:
            arrays = dict(file)
        whole = str(arrays.pop("sum")) == _sum(arrays)
        # Under another chunk's name it would be written over when that one is run.
        return arrays if whole and _name(arrays["index"]) == path.name else None
    except Exception:  # a broken archive raises whatever its first wrong byte leads to
        return None


def _sum(arrays: Mapping[str, Any]) -> str:
    total = hashlib.sha256()
    for name, values in sorted(arrays.items()):
        total.update(f"{name} {values.dtype.str} {values.shape} ".encode())
        total.update(np.ascontiguousarray(values).tobytes())
    return total.hexdigest()


def _distinct(parts: Iterable[Trials], count: int) -> list[Trials]:
    """The trials below a count, each from the first part that has it."""
    taken = np.zeros(count, dtype=bool)
    found = []
    for part in parts:
        new = part.index < count
        new[new] = ~taken[part.index[new]]
        taken[part.index[new]] = True
        if new.any():
            found.append(part if new.all() else _some(part, new))
    return found


def _some(part: Trials, rows: NDArray[np.bool_]) -> Trials:
    return Trials(
        part.index[rows],
        {name: values[rows] for name, values in part.drawn.items()},
        {name: values[rows] for name, values in part.figures.items()},
        part.outcome[rows],
        part.why[rows],
    )


def _refuse_other_draws(folder: Path, study: Study, part: Trials) -> None:
    """Refuse trials whose design is no part of the study's: not every design of fewer trials is one of more."""
    first, last = int(part.index[0]), int(part.index[-1]) + 1
    for name, values in study.drawn(first, last).items():
        wanted, have = values[part.index - first], part.drawn[name]
        # Another machine may round the last bit in another way.
        same = np.allclose(wanted, have, rtol=1e-9, atol=0) if have.dtype.kind == "f" else (wanted == have).all()
        if not same:
            raise InvalidValue(
                f"out = {shown(str(folder))}: holds the study with another number of trials, which in its design are "
                f"others from the first on; {_CURE}"
            )


def _trials(text: str) -> int:
    found = re.search(r"^trials = (\d+)$", text, re.MULTILINE)
    return int(found[1]) if found else 0


def _plain(text: str) -> list[str]:
    """The lines that two studies share of which one continues the other: without how many trials it has."""
    return [line for line in text.splitlines() if line != _MARK and not re.fullmatch(r"trials = \d+", line)]


def _fingerprint(text: str) -> str:
    return hashlib.sha256("\n".join(_plain(text)).encode()).hexdigest()


def _difference(there: str, text: str) -> str:
    """The first line in which two studies differ; empty if one continues the other."""
    before, now = _plain(there), _plain(text)
    for old, new in zip([*before, ""], [*now, ""], strict=False):
        if old != new:
            return f"with {shown(old)} in the place of {shown(new)}"
    return ""


def _read_study(folder: Path) -> str | None:
    """The text of a folder's study; None if there is none that a sweep has left."""
    path = folder / STUDY
    try:
        if not path.is_file():
            return None
        text = path.read_bytes().decode(errors="replace")
    except OSError as error:
        raise InvalidValue(f"{path}: cannot be read ({error.strerror})") from None
    if text.partition("\n")[0] != _MARK:
        raise InvalidValue(f"{path}: was not left by a sweep of this version; {_CURE}")
    return text


def _refuse_foreign(folder: Path) -> None:
    try:
        names = (path.name for path in folder.iterdir()) if folder.exists() else ()
        others = sorted(name for name in names if not _HALF.fullmatch(name))
    except OSError as error:
        raise InvalidValue(f"out = {shown(str(folder))}: cannot be read ({error.strerror})") from None
    if others:
        raise InvalidValue(
            f"out = {shown(str(folder))}: holds something else already, such as {shown(others[0])}; {_CURE}"
        )


def _put_aside(path: Path) -> None:
    try:
        path.replace(path.with_suffix(".broken"))
    except OSError as error:
        raise InvalidValue(f"{path}: is not whole, and cannot be put aside ({error.strerror})") from None


def _tidy(folder: Path) -> None:
    """Take away what killed processes have half written, but nothing that one may be writing just now."""
    for path in (*folder.glob(".*"), *(folder / CHUNKS).glob(".*")):
        if _HALF.fullmatch(path.name):
            with suppress(OSError):
                if time.time() - path.stat().st_mtime > _OLD:
                    shutil.rmtree(path)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidValue(f"{folder}: cannot be written ({error.strerror})") from None


def folder_of(out: object) -> Path:
    """The path of a sweep's folder."""
    return as_path("out", out)
