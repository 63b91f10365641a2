"""An outcome in print: as people read it, as JSON or as Markdown, with the pictures that were drawn."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import tyro

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report.experiment import Report

AsJson: TypeAlias = Annotated[bool, tyro.conf.arg(name="json"), tyro.conf.FlagCreatePairsOff]
AsMarkdown: TypeAlias = Annotated[bool, tyro.conf.arg(name="markdown"), tyro.conf.FlagCreatePairsOff]


def refuse_both(as_json: bool, as_markdown: bool) -> None:
    """Refuse to print in two ways."""
    if as_json and as_markdown:
        raise InvalidValue("--json and --markdown: must be one of them")


def drawn(report: Report, folder: Path) -> list[Path]:
    """Write the pictures of a report, which take the place of those of an earlier one, and say where they are."""
    report.write(folder, command=shlex.join(["diffdrive", *sys.argv[1:]]))
    return [folder / f"{name}.png" for name in report.pictures]


def tell(
    text: str, markdown: str, content: Mapping[str, Any], written: Sequence[Path], as_json: bool, as_markdown: bool
) -> None:
    """Print the outcome in the way that was asked for; pictures are named where Markdown would not show them."""
    if as_json:
        print(json.dumps({**content, "pictures": list(map(str, written))}, indent=1))
    elif as_markdown:
        print(markdown)
    else:
        print(text)
        if written:
            print(f"written: {shlex.join(map(str, written))}")
