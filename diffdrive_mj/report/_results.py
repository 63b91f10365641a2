"""What a folder of results holds, read without trusting it: whatever is missing or broken is a note, not an error."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from diffdrive_mj._resources import EXPERIMENTS
from diffdrive_mj._text import one_line
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.report import replays
from diffdrive_mj.report.experiment import Bound
from diffdrive_mj.report.replays import Replay

LIST = "metrics.json"
# A larger file is none of an experiment's [bytes].
_LARGEST = 50_000_000


@dataclass
class Result:
    """One experiment's results, as far as they can be read.

    Attributes:
        name: of its folder.
        question: that it asked; "" where that is not known, as with all texts.
        finding: its answer.
        table: as printed.
        bounds: that could be read.
        pictures: files that are there.
        replays: that could be read.
        command: that runs it again.
        options: by name, as text.
        versions: by package.
        date: of the run, ISO 8601.
        notes: what is missing or cannot be read, a line each.
    """

    name: str
    question: str = ""
    finding: str = ""
    table: str = ""
    bounds: list[Bound] = field(default_factory=list)
    pictures: list[Path] = field(default_factory=list)
    replays: list[Replay] = field(default_factory=list)
    command: str = ""
    options: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    date: str = ""
    notes: list[str] = field(default_factory=list)

    @property
    def broken(self) -> list[Bound]:
        """The bounds that do not hold."""
        return [bound for bound in self.bounds if not bound.holds]


def read_results(folder: Path) -> list[Result]:
    """The results in a folder's folders, by name; those of the folder itself if it holds some.

    Raises:
        OSError: the folder cannot be read.
    """
    found = []
    for place in [folder, *sorted(folder.iterdir())]:
        try:
            if place.is_dir() and _is_result(place, of_its_own=place == folder):
                found.append(_read(place))
        except OSError as error:  # a locked folder, a link to itself
            found.append(Result(clean(place.name), notes=[f"cannot be read ({error.strerror})"]))
    return found


def _is_result(place: Path, of_its_own: bool) -> bool:
    """Whether an experiment has left something: its list, its replays, or at least the folder of its name."""
    left = any((place / name).exists() for name in (LIST, replays.FILE))
    return left or (not of_its_own and (EXPERIMENTS / f"{place.name}.py").is_file())


def _read(place: Path) -> Result:
    result = Result(clean(place.resolve().name if place.name in ("", "..") else place.name))
    again = "run the experiment again"
    if not (place / LIST).is_file():
        result.notes.append(f"{LIST} is missing: {again}")
        return result
    try:
        content = _json(place / LIST)
    except (OSError, ValueError, RecursionError) as error:
        reason = error.strerror if isinstance(error, OSError) else "half written, or no JSON"
        result.notes.append(f"{LIST} cannot be read ({reason}): {again}")
        return result
    if not isinstance(content, Mapping) or not {"question", "finding", "bounds"} <= content.keys():
        result.notes.append(f"{LIST} was not written by an experiment: it has no question, finding and bounds")
        return result
    for name in ("question", "finding", "table"):
        setattr(result, name, _text(content, name, result))
    _read_bounds(content["bounds"], result)
    _read_provenance(content.get("provenance"), result)
    _read_pictures(place, content.get("pictures", []), result)
    if "replays" in content:
        _read_replays(place / replays.FILE, result)
    return result


def _json(path: Path) -> Any:
    if path.stat().st_size > _LARGEST:
        raise ValueError("too large")
    return json.loads(path.read_text(encoding="utf-8"))


def _text(content: Mapping[str, Any], name: str, result: Result) -> str:
    value = content.get(name, "")
    if not isinstance(value, str):
        result.notes.append(f"{LIST}: {name} is not a text")
        return ""
    return clean(value)


def clean(text: str) -> str:
    """A text whose lines stay, and in which whatever else cannot be printed is shown by its number."""
    return "\n".join(map(one_line, text.expandtabs(4).split("\n")))


def _read_bounds(content: Any, result: Result) -> None:
    """Whether they hold is computed again from the figures, and not believed."""
    if not isinstance(content, list):
        result.notes.append(f"{LIST}: bounds is not a list")
        return
    unreadable = 0
    for item in content:
        try:
            value, limit = (float("nan") if item[key] is None else float(item[key]) for key in ("value", "limit"))
            name, unit = clean(item["name"]), clean(item.get("unit", ""))
            result.bounds.append(Bound(name, value, limit, unit, item.get("at_least") is True))
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
            unreadable += 1
    if unreadable:
        result.notes.append(f"{LIST}: {unreadable} of {len(content)} bounds cannot be read")


def _read_provenance(content: Any, result: Result) -> None:
    if content is None:
        result.notes.append(
            "written by an older version: the command, the versions and the date are not recorded; run it again"
        )
        return
    if not isinstance(content, Mapping):
        result.notes.append(f"{LIST}: provenance cannot be read")
        return
    result.command, result.date = (_text(content, name, result) for name in ("command", "date"))
    result.options, result.versions = (_texts(content.get(name)) for name in ("options", "versions"))


def _texts(content: Any) -> dict[str, str]:
    return {clean(str(k)): clean(str(v)) for k, v in content.items()} if isinstance(content, Mapping) else {}


def _read_pictures(place: Path, names: Any, result: Result) -> None:
    if not isinstance(names, list):
        result.notes.append(f"{LIST}: pictures is not a list")
        return
    for name in dict.fromkeys(map(str, names)):
        # Nothing outside the folder is looked at, whatever the list says.
        if Path(name).name != name or "\0" in name or not name.endswith(".png"):
            result.notes.append(f"{LIST}: a picture's name cannot be used")
        elif not os.path.isfile(place / name):  # where Path.is_file is an error if the name is too long
            result.notes.append(f"{clean(name)} is missing")
        else:
            result.pictures.append(place / name)


def _read_replays(path: Path, result: Result) -> None:
    try:
        if path.stat().st_size > _LARGEST:
            raise ValueError("too large")
        result.replays = replays.from_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        result.notes.append(f"{path.name} is missing")
    except (OSError, ValueError, DiffdriveError) as error:
        reason = error if isinstance(error, DiffdriveError) else getattr(error, "strerror", None) or "half written"
        result.notes.append(f"{path.name} cannot be read ({clean(str(reason))})")
