"""The pages as programs: their commands and their Python, run in order in a folder of their own, their output compared.

What a page's fences mean:

| fence | is |
| --- | --- |
| `sh` | commands, run in a fresh shell each |
| `python` | Python, run in one scope a page |
| none, right after one of these | what that printed, numbers to 1e-5 of themselves |
| `sh not-run` | commands that cannot run here; NOT_RUN in test_pages.py says why |
| `text`, `toml`, `yaml`, `c` | something to look at; TOML must be a robot |

`python tests/pages.py docs/tutorial.md` writes what is printed now into a page.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from helpers import ROOT

RUN, SHOWN = ("sh", "python"), ("text", "toml", "yaml", "c", "sh not-run")
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
FENCE = re.compile(r"^(`{3,})([^\n`]*)\n(.*?)^\1$", re.MULTILINE | re.DOTALL)
# What a code host shows as code too, and FENCE does not find.
HIDDEN = re.compile(r"^ *(?:`{3}|~{3}|<pre|<code)|(?<=\n\n) {4,}\S", re.MULTILINE)


# What some blocks need: what finds it, and how such a block reads.
NEEDED = {
    "cc": (lambda: shutil.which("cc"), r"^cc |\./(odometry|suite|library)"),
    "rosbags": (lambda: find_spec("rosbags"), r"\.mcap\b"),
    "dask": (lambda: find_spec("distributed"), r"^dask |results/cluster"),
}


@dataclass
class Block:
    """A fenced block of a page; `output` is the block right after it, if that says what it prints."""

    kind: str
    text: str
    line: int
    output: str | None = None
    place: tuple[int, int] = (0, 0)  # of the output in the page


def every_page() -> list[Path]:
    """The pages that a reader can come to."""
    folders = (ROOT / "experiments", ROOT / "models", *(ROOT / "docs").glob("[!_]*/"))
    pages = {page for folder in folders for page in folder.glob("*.md")} | {*ROOT.glob("*.md")}
    return sorted(pages | {*(ROOT / "docs").glob("*.md")})


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(text: str) -> list[Block]:
    """The blocks of a page; raises if one is of no kind that is known, or hidden, and so would be skipped."""
    found: list[Block] = []
    end = None
    outside = FENCE.sub(lambda match: re.sub(r"[^\n]+", "-", match[0]), text)  # with the same lines
    if hidden := HIDDEN.search(outside):
        line = outside[: hidden.start()].count("\n") + 1
        raise ValueError(
            f"line {line}: code that is no block: must be fenced by ``` at the line's beginning, and closed"
        )
    for match in FENCE.finditer(text):
        kind, inside, line = match[2].strip(), match[3], text[: match.start()].count("\n") + 1
        if re.search(rf"^ *{match[1]}", inside, re.MULTILINE):
            raise ValueError(f"line {line}: a block with a fence inside: is it closed by {match[1]} alone?")
        if kind in (*RUN, *SHOWN):
            found.append(Block(kind, inside, line))
        elif (
            kind == ""
            and found
            and found[-1].kind in RUN
            and end is not None
            and text[end : match.start()].strip() == ""
        ):
            found[-1].output, found[-1].place = inside, match.span(3)
        else:
            raise ValueError(f"line {line}: a block of the kind {kind!r}: must be one of {RUN + SHOWN}, or an output")
        end = match.end()
    return found


class Reader:
    """Somebody who follows a page word by word, in an empty folder."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.scope: dict[str, object] = {"__name__": "page"}
        self.shell = {
            "PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin",
            "HOME": str(folder),
            "PYTHONPATH": str(ROOT),
            "OPENBLAS_NUM_THREADS": "1",
        }
        (folder / "examples").symlink_to(ROOT / "examples")

    def follow(self, block: Block) -> str:
        """Run a block; what it prints."""
        return self._commands(block.text) if block.kind == "sh" else self._python(block.text)

    def _commands(self, text: str) -> str:
        command = ["bash", "-ec", text]
        done = subprocess.run(command, cwd=self.folder, env=self.shell, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, ""), f"{text}\n{done.stdout}{done.stderr}"
        return done.stdout

    def _python(self, text: str) -> str:
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(text, "page", "exec"), self.scope)
                for value in [value for value in self.scope.values() if getattr(value, "__module__", "") == "page"]:
                    for examples in doctest.DocTestFinder().find(value, value.__name__, globs=dict(self.scope)):
                        assert doctest.DocTestRunner().run(examples).failed == 0
        finally:
            os.chdir(before)
        return printed.getvalue()


def follow(text: str, folder: Path) -> set[str]:
    """Run a page's blocks and compare what they print; returns what is missing here, whose blocks were left out."""
    reader, missing = Reader(folder), set()
    for block in blocks(text):
        if block.kind not in RUN:
            continue
        needed = {name for name, (_, reads) in NEEDED.items() if re.search(reads, block.text, re.MULTILINE)}
        lacking = {name for name in needed if not NEEDED[name][0]()}
        missing |= lacking
        if not lacking:
            printed = reader.follow(block)
            if block.output is not None:
                compare(printed, block.output)
    return missing


def compare(printed: str, said: str) -> None:
    """Words are the same, and numbers but for their last digits, in which processors differ."""
    assert re.sub(NUMBER, "#", printed) == re.sub(NUMBER, "#", said), f"printed:\n{printed}\nsaid:\n{said}"
    there, here = ([float(number) for number in re.findall(NUMBER, text)] for text in (printed, said))
    np.testing.assert_allclose(there, here, rtol=1e-5, err_msg=f"printed:\n{printed}\nsaid:\n{said}")


def rewrite(page: Path) -> None:
    """Put what is printed now into a page."""
    text = page.read_text()
    with tempfile.TemporaryDirectory() as folder:
        reader, printed = Reader(Path(folder)), []
        for block in blocks(text):
            if block.kind in RUN:
                said = reader.follow(block)
                printed += [(block.place, said)] if block.output is not None else []
    for (start, end), said in reversed(printed):
        text = text[:start] + said + text[end:]
    page.write_text(text)


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        rewrite(Path(argument))
