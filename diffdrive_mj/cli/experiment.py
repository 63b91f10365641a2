"""`diffdrive experiment`: one question about odometry, asked and answered."""

from __future__ import annotations

import ast
import runpy
import sys
from pathlib import Path

from diffdrive_mj._resources import EXPERIMENTS
from diffdrive_mj.errors import UnknownName

_HELP = """\
usage: diffdrive experiment [NAME [options]]

Run an experiment: it prints a table, writes its pictures and metrics.json into results/NAME, and ends with status 1
when a bound is broken. For example

  diffdrive experiment mismatched_radii --distance 5

experiments:
{experiments}

Each says more with --help, as in diffdrive experiment mismatched_radii --help."""


def command(*arguments: str) -> None:
    """Run an experiment by its name; without one, list the experiments and what they ask.

    Args:
        arguments: the name, then the experiment's own options.

    Raises:
        UnknownName: no such experiment.
        SystemExit: 0 when every bound holds, 1 when one is broken, 2 for bad input.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["experiment", "integrator"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    if not arguments or arguments[0] in ("-h", "--help"):
        print(_HELP.format(experiments=_listed()))
        return
    name, *options = arguments
    if name not in scripts():
        raise UnknownName("experiment", name, scripts())
    script = str(scripts()[name])
    # A script reads its options from the command line, as if it had been started by itself.
    own, sys.argv = sys.argv, [script, *options]
    try:
        runpy.run_path(script, run_name="__main__")
    finally:
        sys.argv = own


def scripts() -> dict[str, Path]:
    """List the experiments, each with its file.

    Example:
        >>> "umbmark" in scripts()
        True
    """
    return {script.stem: script for script in sorted(EXPERIMENTS.glob("*.py"))}


def _listed() -> str:
    """The experiments with the questions at the head of their files."""
    width = max(map(len, scripts()), default=0)
    questions = {
        name: (ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or "").split("\n\n")[0]
        for name, script in scripts().items()
    }
    return "\n".join(f"  {name:<{width}}  {' '.join(question.split())}" for name, question in questions.items())
