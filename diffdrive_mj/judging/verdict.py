"""The verdict on somebody's odometry: its arithmetic and its drift, drive by drive, with the likely reason."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics
from diffdrive_mj._checks import Array
from diffdrive_mj._progress import progress
from diffdrive_mj._text import html_table, markdown_table, quantity, table
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import CandidateFailed, InvalidType, InvalidValue
from diffdrive_mj.judging.bounds import Bounds
from diffdrive_mj.judging.candidates import Candidate, name_of, poses_of
from diffdrive_mj.judging.causes import distance_between, likely_reasons, reason_of_failure
from diffdrive_mj.judging.tasks import Task, Unit
from diffdrive_mj.robot import Robot


@dataclass(frozen=True, eq=False)
class Row:
    """What came of one drive.

    Attributes:
        task: the drive.
        poses: as answered (T, 3) [m, m, rad]; None if the candidate failed.
        arithmetic: largest distance from exact arc odometry of the same readings [m].
        allowed: of that [m].
        drift: against the truth; None where nobody knows it, or the candidate failed.
        broken: the bounds that do not hold, in words.
        reasons: what explains the poses equally well, in words, the plainest first.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> judge(robot, [Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])]).rows[0].holds
        True
    """

    task: Task
    poses: Array | None
    arithmetic: float
    allowed: float
    drift: metrics.Drift | None
    broken: tuple[str, ...]
    reasons: tuple[str, ...] = ()

    @property
    def reason(self) -> str:
        """The likely one, in words; "" if none is known."""
        return self.reasons[0] if self.reasons else ""

    @property
    def holds(self) -> bool:
        """Whether every bound holds."""
        return not self.broken


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is to be said of an odometry, and prints as a table, the worst drive first.

    Attributes:
        candidate: its name.
        rows: one a drive, as they were driven.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> print(judge(robot, [Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])]))
        robot: holds on 1 of 1 drives
        drive  arithmetic  drift  heading
        ---------------------------------
        ahead       exact
    """

    candidate: str
    rows: tuple[Row, ...]

    def __post_init__(self) -> None:
        refuted = _refuted([row for row in self.rows if not row.holds])
        rows = [replace(row, reasons=tuple(r for r in row.reasons if _kind(r) not in refuted)) for row in self.rows]
        # Where several reasons are as good on one drive, that which explains more of the others comes first.
        said = Counter(kind for row in rows for kind in set(map(_kind, row.reasons)))
        rows = [replace(row, reasons=tuple(sorted(row.reasons, key=lambda r: -said[_kind(r)]))) for row in rows]
        object.__setattr__(self, "rows", tuple(rows))

    @property
    def reason(self) -> str:
        """What explains most of the drives that do not hold, in words; "" if nothing known explains a quarter."""
        said = [row.reason for row in self.rows if not row.holds]
        kinds = Counter(map(_kind, filter(None, said)))
        first = max(filter(None, said), key=lambda reason: kinds[_kind(reason)], default="")
        return first if kinds[_kind(first)] >= len(said) / 4 else ""

    @property
    def holds(self) -> bool:
        """Whether every bound holds on every drive."""
        return all(row.holds for row in self.rows)

    def __str__(self) -> str:
        kept = sum(row.holds for row in self.rows)
        lines = [f"{self.candidate}: holds on {kept} of {len(self.rows)} drives"]
        lines.append(table(_HEADER, [_cells(row) for row in self.ranked]))
        lines += [f"{row.task.name}: {'; '.join(row.broken)}{_because(row)}" for row in self.ranked if row.broken]
        return "\n".join(lines)

    def markdown(self) -> str:
        """A heading and a table, as for a comment on a pull request.

        Example:
            >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
            >>> print(judge(robot, [Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])]).markdown())
            ### robot: holds on 1 of 1 drives
            <BLANKLINE>
            | drive | arithmetic | drift | heading | broken |
            | --- | --- | --- | --- | --- |
            | ahead | exact |  |  |  |
        """
        title, _, _ = str(self).partition("\n")
        return f"### {title}\n\n{markdown_table((*_HEADER, 'broken'), self._rows)}"

    def _repr_html_(self) -> str:
        return html_table(self._rows, (*_HEADER, "broken"), caption=self.candidate)

    @property
    def _rows(self) -> list[tuple[str, ...]]:
        return [(*_cells(row), "; ".join(row.broken) + _because(row)) for row in self.ranked]

    @property
    def ranked(self) -> list[Row]:
        """The rows, the worst first: failures, then the drives whose bounds are exceeded most."""

        def badness(row: Row) -> tuple[bool, float]:
            off = 0.0 if row.drift is None else float(row.drift.max_position)
            return (not row.holds, max(row.arithmetic / row.allowed, off))

        return sorted(self.rows, key=badness, reverse=True)


_HEADER = ("drive", "arithmetic", "drift", "heading")


def _cells(row: Row) -> tuple[str, str, str, str]:
    exact = row.arithmetic < row.allowed / 100
    arithmetic = "none" if row.poses is None else "exact" if exact else quantity(row.arithmetic, "m")
    if row.drift is None:
        return row.task.name, arithmetic, "", ""
    position, heading = float(row.drift.max_position), float(row.drift.max_heading)
    return row.task.name, arithmetic, quantity(position, "m"), f"{np.degrees(heading):.3g} deg"


def _kind(reason: str) -> str:
    """A reason without the numbers in it, which depend on the drive, and without the order of two."""
    return "; and ".join(sorted(re.sub(r"\d[\w.+-]*", "", reason).split("; and ")))


def _refuted(rows: list[Row]) -> set[str]:
    """The kinds of reasons that other drives gainsay, of those with a number that has been fitted to the answers.

    A factor, a fixed period or another point of the robot shows on nearly all drives; the first two are the same on
    all of them, but for a factor that is told as a track width. What a factor is known for, as a radius that is
    missing, may go by the robot, and is let be.
    """
    numbers: dict[str, list[list[float]]] = {}
    for row in rows:
        for reason in row.reasons:
            found = [float(number) for number in _FITTED.findall(reason)]
            if found and "(" not in reason.replace("(a track width", ""):
                numbers.setdefault(_kind(reason), []).append(found)
    return {
        kind
        for kind, found in numbers.items()
        if len(found) <= len(rows) / 2 or (not _BY_ROBOT.search(kind) and not _alike(np.array(found)))
    }


_FITTED = re.compile(r"\S+(?= times the right )|(?<=a fixed period of )\S+|(?<=of a point )\S+")
_BY_ROBOT = re.compile("a track width of|of a point")


def _alike(found: Array) -> bool:
    """Whether the numbers of some drives (N, K) are the same; of a factor near one, what it is more than one."""
    return bool(np.allclose(found, found[0], rtol=0.01) and np.allclose(found - 1, found[0] - 1, rtol=0.2, atol=0.0))


def _because(row: Row) -> str:
    return f"; {row.reason}" if row.reason else ""


def judge(
    candidate: Candidate,
    drives: Iterable[Task | Drive],
    *,
    robot: Robot | None = None,
    position: float | None = None,
    heading: float | None = None,
    position_per_metre: float | None = None,
    unit: Unit = "rad",
    seconds: float = 10.0,
) -> Verdict:
    """Judge an odometry: is its arithmetic right, and how far does it drift?

    Without bounds the arithmetic decides: within 1e-9 m per metre that a wheel rolls of exact arc odometry on the same
    readings. With bounds the drift against the truth does, which right odometry has too.

    Args:
        candidate: a Robot; a function from wheel angles (T, 2) [rad], times (T,) [s] and the robot to poses (T, 3); a
            class that takes the robot, or its numbers by name, with `update((left, right), t)`; or a program's command
            line, a list of strings. What takes a `start` is told it.
        drives: tasks, or drives of a robot, simulated or real.
        robot: what the odometry is told of the robot of drives.
        position: largest position error along a drive [m].
        heading: largest heading error along a drive [rad].
        position_per_metre: largest position error over the distance driven [m/m].
        unit: of a program's readings.
        seconds: that a program may take for a drive.

    Returns:
        The verdict.

    Raises:
        InvalidType: no candidate, no drives, or drives without a robot.
        InvalidValue: a bound that is not positive, or no drive.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
        >>> t = np.arange(0.0, 5.0, 0.1)
        >>> task = Task("bend", robot, t, np.stack([5 * t, 6 * t], axis=-1))
        >>> def mine(wheel_angles, t, robot):
        ...     return dd.odometry.integrate(wheel_angles, robot, "euler")
        >>> judge(mine, [task]).rows[0].reason
        'steps are taken along the heading before them (Euler): use the exact arc'
    """
    bounds = Bounds(position=position, heading=heading, position_per_metre=position_per_metre)
    checks.positive("seconds", seconds)
    tasks = [_task(drive, robot) for drive in checks.several("drives", drives)]
    if not tasks:
        raise InvalidValue("drives: must hold at least one")
    name, rows = name_of(candidate), []
    with progress(f"judging {name}", len(tasks), " drives") as advance:
        for task in tasks:
            rows.append(_row(candidate, task, bounds, unit, seconds))
            advance(1)
    return Verdict(name, tuple(rows))


def _task(drive: Task | Drive, robot: Robot | None) -> Task:
    if isinstance(drive, Task):
        return drive
    if robot is None:
        raise InvalidType("robot = None: must say what the odometry is told of the robot of the drives")
    return Task.of(drive, robot)


def _row(candidate: Candidate, task: Task, bounds: Bounds, unit: Unit, seconds: float) -> Row:
    asked = task.as_read(unit)
    allowed = asked.allowed
    try:
        poses = poses_of(candidate, asked, unit=unit, seconds=seconds)
    except CandidateFailed as failure:
        reason = reason_of_failure(asked, failure.reading)
        return Row(task, None, np.inf, allowed, None, (failure.args[2],), (reason,) if reason else ())
    off = distance_between(asked, poses, asked.expected)
    drift = None if task.truth is None else metrics.drift(task.truth, poses)
    if bounds and drift is not None:
        broken = bounds.broken(drift)
    else:
        broken = (f"arithmetic off by {quantity(off, 'm')}, more than {quantity(allowed, 'm')}",) * (off > allowed)
    return Row(task, poses, off, allowed, drift, broken, likely_reasons(asked, poses) if off > allowed else ())
