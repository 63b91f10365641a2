"""`diffdrive evaluate`: how far an estimate is off the truth, and whether bounds hold."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from diffdrive_mj import logs
from diffdrive_mj.cli._left_out import Name, Number
from diffdrive_mj.cli._outcome import AsJson, AsMarkdown, drawn, refuse_both, tell
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.bounds import Bounds
from diffdrive_mj.judging.evaluation import Evaluation, evaluate
from diffdrive_mj.metrics.trajectories import Alignment
from diffdrive_mj.pose_log import PoseLog

_COLUMNS = ("time", "x", "y", "theta")


def command(
    estimate: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="ESTIMATE", help_behavior_hint="(required)")],
    /,
    truth: Annotated[Path, tyro.conf.arg(metavar="TRUTH")],
    topic: Name = None,
    truth_topic: Name = None,
    columns: Name = None,
    truth_columns: Name = None,
    align: Alignment = "origin",
    stretch: float = 1.0,
    offset: float = 0.0,
    position: Number = None,
    heading: Number = None,
    position_per_metre: Number = None,
    output: Path = Path("results"),
    pictures: bool = True,
    as_json: AsJson = False,
    as_markdown: AsMarkdown = False,
) -> None:
    """Evaluate an estimate: how far it drifts from the truth, each on a clock of its own.

      diffdrive evaluate odom.mcap --truth mocap.tum --topic /odom --position 0.05

    Logs are CSV, TUM, .mcap, .db3, rosbag2 folders or .wpilog. The path is drawn, coloured by the error.

    Exit status: 0 if every bound holds, 1 if one is broken, 2 for bad input, of which one line on stderr says what is
    wrong.

    Args:
        estimate: its log.
        truth: its log.
        topic: of the estimate in a bag; the only one with poses if not given.
        truth_topic: of the truth in a bag.
        columns: of the estimate in a CSV file, names or numbers: time,x,y,theta.
        truth_columns: of the truth in a CSV file.
        align: for the absolute error: origin lays the first poses over each other, se2 fits the positions, none leaves
            the estimate where it is.
        stretch: of the relative error [m].
        offset: added to the estimate's times [s].
        position: largest position error [m].
        heading: largest heading error [rad].
        position_per_metre: largest position error over the distance driven [m/m].
        output: folder in which that of the picture, evaluate, is made.
        pictures: whether to draw it.
        as_json: print JSON, in metres and radians.
        as_markdown: print Markdown, as for a comment on a pull request.

    Raises:
        DiffdriveError: bad input.
        SystemExit: 1 where a bound is broken.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["evaluate", "odom.tum", "--truth", "mocap.tum"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    refuse_both(as_json, as_markdown)
    bounds = Bounds(position=position, heading=heading, position_per_metre=position_per_metre)
    believed, true = _read(estimate, "", topic, columns), _read(truth, "truth_", truth_topic, truth_columns)
    found = evaluate(true, believed, align=align, stretch=stretch, offset=offset)
    broken = list(bounds.broken(found.drift))
    written = _drawn(found, bounds, output / "evaluate") if pictures else []
    text, markdown = "\n".join([str(found), *broken]), "\n\n".join([found.markdown(), *broken])
    tell(text, markdown, _content(found, broken), written, as_json, as_markdown)
    sys.exit(1 if broken else 0)


def _read(path: Path, prefix: str, topic: str | None, columns: str | None) -> PoseLog:
    """The poses in a log, with what its options say of it."""
    flag = f"--{prefix.replace('_', '-')}"
    if topic is not None and columns is not None:
        raise InvalidValue(f"{flag}topic is for bags and {flag}columns for CSV files: must be one of them")
    if topic is not None:
        return logs.read_poses(path, logs.Topics(poses=topic))
    if columns is None:
        return logs.read_poses(path)
    names = columns.split(",")
    if len(names) != len(_COLUMNS):
        raise InvalidValue(f"{flag}columns {columns}: must be four, {','.join(_COLUMNS)}")
    chosen = {field: int(name) if name.isdecimal() else name for field, name in zip(_COLUMNS, names, strict=True)}
    return logs.read_poses(path, logs.Columns(**chosen))  # type: ignore[arg-type]


def _drawn(found: Evaluation, bounds: Bounds, folder: Path) -> list[Path]:
    from diffdrive_mj.report.verdicts import evaluated

    return drawn(evaluated(found, bounds), folder)


def _content(found: Evaluation, broken: list[str]) -> dict[str, Any]:
    drift = found.drift
    return {
        "estimate": found.name,
        "poses": len(found.t),
        "distance_m": float(drift.distance),
        "max_position_error_m": float(drift.max_position),
        "final_position_error_m": float(drift.final_position),
        "max_position_error_per_metre": float(drift.max_position_per_metre),
        "max_heading_error_rad": float(drift.max_heading),
        "final_heading_error_rad": float(drift.final_heading),
        "ate_rmse_m": float(found.ate.rmse),
        "ate_align": found.align,
        "rpe_rmse_m": None if found.rpe is None else float(found.rpe.rmse),
        "rpe_stretch_m": found.stretch,
        "warnings": list(found.warnings),
        "holds": not broken,
        "broken": broken,
    }
