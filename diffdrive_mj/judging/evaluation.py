"""An estimate against the truth, each on its own clock: drift per metre, absolute and relative errors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import a, html_table, markdown_table, quantity
from diffdrive_mj.diagnosis.estimates import odd_poses
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.logs._clocks import in_gaps
from diffdrive_mj.metrics.trajectories import Alignment
from diffdrive_mj.pose_log import PoseLog, poses_of
from diffdrive_mj.recording import Recording
from diffdrive_mj.sensors._sampling import poses_between

# Times that are equal up to rounding [s].
_SLACK = 1e-9
# Of a log's poses: what may lie outside the other's times without a word.
_OUTSIDE = 0.2


@dataclass(frozen=True, eq=False)
class Evaluation:
    """How far an estimate is off.

    Attributes:
        name: of the estimate.
        t: the times at which the two were compared (N,) [s], on the truth's clock.
        truth: (N, 3) [m, m, rad].
        estimate: (N, 3) [m, m, rad], moved so that the first poses agree, unless it was to be left where it is.
        drift: of it.
        align: how the absolute error was aligned.
        ate: the absolute trajectory error.
        stretch: the length of the relative error's stretches [m].
        rpe: the relative pose error; None where the drive is shorter than a stretch.
        warnings: what to know before relying on it.

    Example:
        >>> truth = dd.PoseLog([0.0, 1.0, 2.0], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
        >>> odom = dd.PoseLog([0.0, 2.0], [(0.0, 0.0, 0.0), (2.01, 0.0, 0.0)], name="odom")
        >>> print(dd.evaluate(truth, odom))
        odom: 2 poses compared
        distance driven        2 m
        largest position error 10 mm   5000 um/m
        final position error   10 mm   5000 um/m
        largest heading error  0 deg
        final heading error    0 deg
        ATE, aligned by origin  rmse 7.07 mm  max 10.0 mm
        RPE over 1 m            rmse 10.0 mm  max 10.0 mm
    """

    name: str
    t: Array
    truth: Array
    estimate: Array
    drift: metrics.Drift
    align: Alignment
    ate: metrics.ErrorStatistics
    stretch: float
    rpe: metrics.ErrorStatistics | None
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Evaluation({self.name}: {len(self.t)} poses, {self.drift!r})"

    def __str__(self) -> str:
        rows = self._rows()
        width = max(len(name) for name, _ in rows)
        return "\n".join(
            [
                f"{self.name}: {len(self.t)} poses compared",
                str(self.drift),
                *(f"{name:<{width}}  {value}" for name, value in rows),
                *(f"warning: {warning}" for warning in self.warnings),
            ]
        )

    def markdown(self) -> str:
        r"""A heading and a table, as for a comment on a pull request.

        Example:
            >>> truth = dd.PoseLog([0.0, 1.0], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
            >>> print(dd.evaluate(truth, truth).markdown().partition("\n")[0])
            ### poses: 2 poses compared
        """
        rows = [(name, " ".join(" ".join(cells).split())) for name, *cells in (*self.drift._rows(), *self._rows())]
        parts = [f"### {self.name}: {len(self.t)} poses compared", markdown_table(("", ""), rows)]
        return "\n\n".join([*parts, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        return self.drift._repr_html_() + html_table(
            [*self._rows(), *(("warning", warning) for warning in self.warnings)], caption=self.name
        )

    def _rows(self) -> list[tuple[str, str]]:
        return [
            (f"ATE, aligned by {self.align}" if self.align != "none" else "ATE, not aligned", _errors(self.ate)),
            (f"RPE over {self.stretch:g} m", "the drive is shorter" if self.rpe is None else _errors(self.rpe)),
        ]


def evaluate(
    truth: PoseLog | Drive | Recording,
    estimate: PoseLog,
    *,
    align: Alignment = "origin",
    stretch: float = 1.0,
    offset: float = 0.0,
) -> Evaluation:
    """Compare an estimate with the truth, each on its own clock.

    They are compared where their times overlap, at those of whichever has fewer poses there (the truth's, if they have
    as many). The other is interpolated on the arcs through its poses, and nowhere inside its gaps.

    The absolute error is that of evo: `evo_ape` on the same poses finds the same numbers, with `--align_origin` for
    "origin" and `--align` for "se2". The relative error differs from `evo_rpe` by the pairs of poses that it compares.
    Here a stretch starts at every pose and ends at the first that is at least `stretch` further along the truth, by
    arcs. By default evo measures along the estimate, whose scale is what is in question, by chords, and starts a pair
    where the last one ended, so that there are few; with `--all_pairs --pairs_from_reference` it takes the pose that is
    nearest to the distance, within a tolerance, where this takes the first beyond it.

    Args:
        truth: where the robot was.
        estimate: where it was believed to be; in a frame and from a start of its own.
        align: how the estimate is moved before the absolute error is taken: "origin" moves the first poses onto each
            other, "se2" fits the positions, "none" leaves it. Drift is a matter of a common start, and is taken after
            "origin" unless this is "none".
        stretch: length of the relative error's stretches [m].
        offset: added to the estimate's times [s], where the clocks are apart.

    Returns:
        Drift, absolute and relative errors; in the warnings what looks wrong with the logs, such as clocks that are
        apart.

    Raises:
        InvalidType: not logs, not numbers.
        UnknownName: the alignment.
        InvalidValue: clocks that have fewer than two times in common, or numbers out of range.

    References:
        Sturm, Engelhard, Endres, Burgard, Cremers 2012, A benchmark for the evaluation of RGB-D SLAM systems.

    Example:
        An estimate at 10 Hz whose distances are 1 % too long, and which started elsewhere, against a truth at 25 Hz:

        >>> t, s = np.arange(0.0, 10.0, 0.04), np.arange(0.0, 10.0, 0.1)
        >>> truth = dd.PoseLog(t, np.stack([0.5 * t, 0 * t, 0 * t], axis=-1))
        >>> odom = dd.PoseLog(s, np.stack([3 + 0 * s, 0.505 * s, 0 * s + np.pi / 2], axis=-1))
        >>> found = dd.evaluate(truth, odom)
        >>> round(found.drift.final_position_per_metre.item(), 6), round(found.rpe.mean.item(), 6)
        (0.01, 0.01)
    """
    true = poses_of("truth", truth)
    if not isinstance(estimate, PoseLog):
        raise InvalidType(f"estimate = {a(type(estimate).__name__)}: must be a PoseLog(t, poses)")
    checks.member("alignment", align, metrics.ALIGNMENTS)
    length = checks.positive("stretch", stretch)
    shift = checks.number("offset", offset)
    t, left_out = _common(true, estimate, shift)
    at = _at(true, t)
    believed = _at(estimate, t - shift)
    moved = believed if align == "none" else se2.compose(at[0], se2.between(believed[0], believed))
    drift = metrics.drift(at, moved)
    warnings = tuple(f"{log.name}: {warning}" for log in (true, estimate) for warning in log.warnings)
    warnings += (*_outside(true, estimate.t + shift), *_outside(estimate, true.t - shift))
    if left_out:
        warnings += (f"{left_out} poses lie in gaps of the other log, and were not compared",)
    warnings += odd_poses(t, at, believed, (true.name, estimate.name), shift)
    return Evaluation(
        estimate.name,
        t,
        at,
        moved,
        replace(drift, warnings=()),
        align,
        metrics.ate(at, believed, align),
        length,
        metrics.rpe(at, moved, distance=length) if drift.distance >= length else None,
        warnings,
    )


def _common(true: PoseLog, estimate: PoseLog, offset: float) -> tuple[Array, int]:
    """The times at which two logs are compared, on the truth's clock, and how many were left out for gaps."""
    clocks = [true.t, estimate.t + offset]
    first, last = max(clock[0] for clock in clocks) - _SLACK, min(clock[-1] for clock in clocks) + _SLACK
    shared = [clock[(clock >= first) & (clock <= last)] for clock in clocks]
    fewer = min((0, 1), key=lambda k: len(shared[k]) if len(shared[k]) > 1 else np.inf)
    gaps = in_gaps(clocks[1 - fewer], shared[fewer])
    t = shared[fewer][~gaps]
    if len(t) < 2 <= len(shared[fewer]):
        other = (true, estimate)[1 - fewer].name
        raise InvalidValue(
            f"{len(shared[fewer]) - len(t)} of {len(shared[fewer])} poses lie in gaps of {other}: at least two must not"
        )
    if len(t) < 2:
        raise InvalidValue(
            f"{estimate.name} spans {clocks[1][0]:.10g} to {clocks[1][-1]:.10g} s and the truth {true.t[0]:.10g} to "
            f"{true.t[-1]:.10g} s: at least two poses must lie within both; offset = "
            f"{true.t[0] - estimate.t[0]:.10g} would let them begin together"
        )
    return t, int(np.count_nonzero(gaps))


def _outside(log: PoseLog, other: Array) -> tuple[str, ...]:
    """What of a log lies outside the times of the other, given on its clock, if that is much."""
    outside = int(np.count_nonzero((log.t < other[0] - _SLACK) | (log.t > other[-1] + _SLACK)))
    many = outside > _OUTSIDE * len(log.t)
    return (f"{outside} of {len(log.t)} poses of {log.name} lie outside the times of the other",) if many else ()


def _at(log: PoseLog, t: Array) -> Array:
    """The poses of a log at times within its own, up to rounding."""
    return log.poses if np.array_equal(log.t, t) else poses_between(log.t, log.poses, t)


def _errors(errors: metrics.ErrorStatistics) -> str:
    return f"rmse {quantity(float(errors.rmse), 'm')}  max {quantity(float(errors.max), 'm')}"
