"""Guaranteed drift: what no robot within tolerances can exceed, by set membership.

Monte Carlo finds large drifts, and the worst it finds is no bound; nor are the corners of the tolerances. Here boxes of
robots are halved until a bound that is proven for each (`_drift_enclosure`: Taylor's theorem, all rounding counted) is
close to a drift that some robot has.
"""

from __future__ import annotations

import html
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, one_line, shown, table
from diffdrive_mj.commands import Commands
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.estimation._boxes import Maximum, maximum
from diffdrive_mj.estimation._drift_enclosure import DriftOverBoxes
from diffdrive_mj.estimation._reading_errors import by_sampling, by_ticks
from diffdrive_mj.estimation._robot_box import Interval, robot_box
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.tolerances import Tolerances

# How far a bound may lie above a drift that is found: a part of it, and a length [m].
_RELATIVE, _ABSOLUTE = 0.01, 1e-4
# When to stop all the same: boxes, and boxes times pieces of path, a minute or two.
_MOST_BOXES, _MOST_WORK = 20_000, 5e7


@dataclass(frozen=True, eq=False)
class GuaranteedDrift:
    """Holds bounds on the drift that no robot within tolerances exceeds, and prints as a table.

    Each part has an adversary of its own: the robot, the ticks, the rates between samples. By the triangle inequality
    the three together do not exceed the sum.

    Attributes:
        name: of the robot that the odometry believes in.
        anywhere: whether it is the largest drift at any sample, not that at the end.
        by_tolerances: what the robot's numbers add at most (2,) [m, rad].
        by_ticks: what whole ticks add at most (2,) [m, rad].
        by_sampling: what rates that change between samples add at most (2,) [m, rad].
        worst: the robot with the largest drift that was found, without ticks and between samples.
        worst_heading: its heading at the start, less the believed one [rad].
        found: its drift [m]; `by_tolerances` lies at most 1 % or 0.1 mm above, unless a warning says so.
        at_corners: the largest drift of the robots at the corners of the tolerances [m], which is no bound.
        boxes: how many boxes of robots were looked at.
        warnings: what to know before relying on it.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> ahead = dd.maneuvers.straight(robot, distance=1.0)
        >>> drift = dd.guarantee(ahead, robot, dd.Tolerances(radius=0.01, radius_ratio=0.0, track_width=0.01))
        >>> round(drift.found, 6), 0.01 <= drift.position < 0.0102
        (0.01, True)
    """

    name: str
    anywhere: bool
    by_tolerances: Array
    by_ticks: Array
    by_sampling: Array
    worst: Robot
    worst_heading: float
    found: float
    at_corners: float
    boxes: int
    warnings: tuple[str, ...] = ()

    @property
    def position(self) -> float:
        """The bound on the position error [m]: the sum of the parts."""
        return float(self.by_tolerances[0] + self.by_ticks[0] + self.by_sampling[0])

    @property
    def heading(self) -> float:
        """The bound on the heading error [rad]: the sum of the parts."""
        return float(self.by_tolerances[1] + self.by_ticks[1] + self.by_sampling[1])

    def __str__(self) -> str:
        warnings = (f"warning: {warning}" for warning in self.warnings)
        return "\n".join([self._title(), "", table(*self._table()), "", self._found(), *warnings])

    def _repr_html_(self) -> str:
        header, rows = self._table()
        below = "".join(f"<p>{html.escape(text)}</p>" for text in (self._found(), *self.warnings))
        return "\n".join([html_table(rows, header, self._title()), below])

    def _title(self) -> str:
        place = "is anywhere" if self.anywhere else "ends"
        return (
            f"{self.name}: no robot within the tolerances {place} more than {1e3 * self.position:.4g} mm and "
            f"{math.degrees(self.heading):.3g} degrees off"
        )

    def _table(self) -> tuple[list[str], list[list[object]]]:
        parts = {"tolerances": self.by_tolerances, "ticks": self.by_ticks, "sampling": self.by_sampling}
        total = np.array([self.position, self.heading])
        rows = [[name, 1e3 * part[0], math.degrees(part[1])] for name, part in {**parts, "sum": total}.items()]
        return ["what is off", "position [mm]", "heading [deg]"], rows

    def _found(self) -> str:
        left, right, track = (
            1e3 * n for n in (self.worst.left_radius, self.worst.right_radius, self.worst.track_width)
        )
        turned = f", started {math.degrees(self.worst_heading):+.3g} degrees" if self.worst_heading else ""
        return (
            f"Found: {1e3 * self.found:.4g} mm by radii of {left:.5g} and {right:.5g} mm, a track of {track:.5g} mm"
            f"{turned} ({self.boxes} boxes). At the corners at most {1e3 * self.at_corners:.4g} mm."
        )


def guarantee(
    drive: Commands | Recording | Drive | ArrayLike,
    believed: Robot,
    tolerances: Tolerances | None = None,
    *,
    left_radius: Interval | None = None,
    right_radius: Interval | None = None,
    track_width: Interval | None = None,
    heading: float = 0.0,
    ticks: float | None = None,
    acceleration: float | None = None,
    period: float | None = None,
    anywhere: bool = False,
) -> GuaranteedDrift:
    """Bound the drift that arc odometry can have on a drive, if the true robot is anywhere within tolerances.

    The wheels turn as the drive says, exactly. Odometry believes one robot, and the true one is another: it has any
    mean radius, radius ratio and track width within the tolerances, or any radii and track within intervals, and starts
    under any heading within some angle of the believed one. The bound is also that of any belief within them, were this
    robot the true one: the difference is the same.

    - Ticks: odometry's readings are each off by less than one tick since the start, for each wheel, in any pattern.
    - Sampling: between two samples each wheel accelerates and brakes as it likes, by at most `acceleration`.

    Args:
        drive: how the wheels turn: commands, a recording or drive of one robot, or wheel angles (T, 2) [rad].
        believed: the robot that the odometry believes in; its radii and track width are read.
        tolerances: by what parts the true robot may be off; those of the believed robot if not given.
        left_radius: from and to [m], in the place of the tolerances of the radii; with `right_radius`.
        right_radius: from and to [m].
        track_width: from and to [m], in the place of its tolerance.
        heading: by how much the true heading at the start may be off [rad], to either side.
        ticks: of the encoder, a turn of the wheel; no ticks are counted if not given.
        acceleration: of each wheel between samples [rad/s^2]; rates are constant between samples if not given.
        period: between samples of wheel angles that come as an array [s].
        anywhere: bound the largest drift at any sample, not that at the end.

    Returns:
        The bounds, with their parts and the worst robot found.

    Raises:
        InvalidType: not a drive, a robot, tolerances or numbers.
        InvalidValue: tolerances that hold robots that cannot be, intervals from larger to smaller, several runs, a
            robot with a turning gain, no times for an acceleration.

    Example:
        A test that no robot within 0.2 % of its radii and 1 % of its track drifts by more than 40 mm on a small square:

        >>> robot = dd.Robot.load("matched")
        >>> known = dd.Tolerances(radius=0.002, radius_ratio=0.002, track_width=0.01)
        >>> drift = dd.guarantee(dd.maneuvers.square(robot, side=0.5), robot, known, ticks=4096)
        >>> assert drift.position < 0.040
    """
    angles, times = _wheels(drive, period)
    checks.instance("believed", believed, Robot)
    if believed.turning_gain:
        raise InvalidValue(
            f"believed.turning_gain = {believed.turning_gain:g}: must be 0; the bound knows no such gain"
        )
    box = robot_box(believed, tolerances, left_radius, right_radius, track_width, heading)
    checks.boolean("anywhere", anywhere)
    drift = DriftOverBoxes(angles, believed, box, anywhere)
    enough = min(_MOST_BOXES, int(_MOST_WORK / drift.pieces))
    most = maximum(drift.enclose, drift.value, box.faces, relative=_RELATIVE, absolute=_ABSOLUTE, most=enough)
    ticked = (0.0, 0.0)
    if ticks is not None:
        ticked = by_ticks(angles, believed, 2 * math.pi / checks.positive("ticks", ticks), anywhere)
    sampled = 0.0
    if acceleration is not None:
        pushed = checks.not_negative("acceleration", acceleration)
        if times is None:
            raise InvalidValue("acceleration: needs the times of the samples; give period beside wheel angles")
        longest = box.lengths(box.corners)
        sampled = by_sampling(angles, np.diff(times), pushed, longest[:, :2].max(axis=0), longest[:, 2].min())
    return GuaranteedDrift(
        name=one_line(believed.name),
        anywhere=bool(anywhere),
        by_tolerances=np.array([most.upper, drift.heading]),
        by_ticks=np.array(ticked),
        by_sampling=np.array([sampled, 0.0]),
        worst=box.robot(most.where),
        worst_heading=float(most.where[3]),
        found=most.found,
        at_corners=float(drift.value(box.corners).max()),
        boxes=most.boxes,
        warnings=_warnings(most),
    )


def _wheels(drive: Commands | Recording | Drive | ArrayLike, period: float | None) -> tuple[Array, Array | None]:
    """The wheel angles of a drive (T, 2) [rad], and their times (T,) [s] if it has any."""
    if isinstance(drive, (Commands, Recording, Drive)):
        if period is not None:
            raise InvalidType(f"period = {shown(period)}: leave it out; {type(drive).__name__} has its own times")
        angles = drive.wheel_angles
        times: Array = drive.period * np.arange(len(angles), dtype=float) if isinstance(drive, Commands) else drive.t
        if angles.ndim != 2:
            raise InvalidValue("drive = a Recording of several runs: give one of recording.runs")
        return angles, times
    angles = checks.array("drive", drive, "T", 2)
    if angles.ndim != 2:
        raise InvalidValue(f"drive has shape {angles.shape}: must be wheel angles (T, 2) of one run")
    return angles, None if period is None else checks.positive("period", period) * np.arange(len(angles), dtype=float)


def _warnings(most: Maximum) -> tuple[str, ...]:
    """That the bound is loose, if it is."""
    if most.upper <= most.found + max(_RELATIVE * most.found, _ABSOLUTE) * (1 + 1e-9):
        return ()
    return (
        f"the bound holds, but may be loose: {1e3 * most.upper:.4g} mm by tolerances where {1e3 * most.found:.4g} mm "
        f"were found after {most.boxes} boxes; such a drive turns too far for such tolerances",
    )
