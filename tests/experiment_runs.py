"""Experiments called with options of a user's own: the right answer, or one clear line."""

from __future__ import annotations

from types import ModuleType

from hypothesis import Phase, settings

from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.report import Report

# Experiments take seconds: a case that fails is not made simpler.
FEW = settings(max_examples=5, phases=(Phase.explicit, Phase.generate))


def answer(script: ModuleType, **options: object) -> Report | str:
    """The report, whose bounds all hold, or the line that refuses the options."""
    try:
        report = script.run(**options)
    except DiffdriveError as error:
        line = str(error)
    else:
        assert report.bounds
        assert broken(report) == []
        return report
    assert len(line.splitlines()) == 1
    return line


def broken(report: Report) -> list[str]:
    """The bounds that do not hold."""
    return [str(bound) for bound in report.bounds if not bound.holds]
