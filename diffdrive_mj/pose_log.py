"""Poses on a clock: somebody's estimate, or a truth that comes without wheels."""

from __future__ import annotations

from dataclasses import dataclass

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances as covariances
from diffdrive_mj import metrics
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, one_line
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.recording import Recording


@dataclass(frozen=True, eq=False)
class PoseLog:
    """Poses on a clock of their own, as a log has them: an estimate, or the truth.

    Args:
        t: times (T,) [s], increasing; two at least.
        poses: (T, 3) [m, m, rad]; headings may be wrapped.
        name: what messages call it.
        warnings: what to know before relying on it, such as gaps.
        covariance: of x, y and theta at each time (T, 3, 3), as stated by whoever estimated them; None if nobody did.

    Raises:
        InvalidType: not numbers, or a name that is not a string.
        InvalidValue: values that are not finite, times that repeat or go back, shapes that do not fit, a matrix that is
            no covariance.

    Example:
        >>> dd.PoseLog(t=[0.0, 2.0], poses=[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], name="odom")
        PoseLog(odom: 2 poses, 0 to 2 s)
    """

    t: Array
    poses: Array
    name: str = "poses"
    warnings: tuple[str, ...] = ()
    covariance: Array | None = None

    def __repr__(self) -> str:
        return f"PoseLog({self.name}: {len(self.t)} poses, {self.t[0]:.13g} to {self.t[-1]:.13g} s)"

    def __str__(self) -> str:
        return "\n".join([repr(self), *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        rows = [
            ("poses", len(self.t)),
            ("duration", f"{self.t[-1] - self.t[0]:g} s"),
            ("distance", f"{metrics.travelled(self.poses)[-1]:.4g} m"),
            *(("warning", warning) for warning in self.warnings),
        ]
        return html_table(rows, caption=self.name)

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", one_line(checks.string("PoseLog.name", self.name)))
        object.__setattr__(self, "warnings", checks.strings("PoseLog.warnings", self.warnings))
        t = checks.increasing(f"{self.name}: t", self.t)
        poses = checks.array(f"{self.name}: poses", self.poses, "T", 3)
        if poses.shape != (len(t), 3):
            raise InvalidValue(f"{self.name}: poses has shape {poses.shape} and t {len(t)} times: must be (T, 3)")
        # Copies, which whoever made the log cannot change after they were checked.
        own = {"t": t.copy(), "poses": poses.copy()}
        if self.covariance is not None:
            stated = covariances.covariance(f"{self.name}: covariance", self.covariance, 3)
            if stated.shape != (len(t), 3, 3):
                raise InvalidValue(
                    f"{self.name}: covariance has shape {stated.shape} and t {len(t)} times: must be (T, 3, 3)"
                )
            own["covariance"] = stated.copy()
        for field, value in own.items():
            value.flags.writeable = False
            object.__setattr__(self, field, value)


def poses_of(name: str, value: PoseLog | Drive | Recording) -> PoseLog:
    """Take the poses of a log, or the true ones of a drive or a recording.

    Args:
        name: how messages call it.
        value: a pose log, a drive, or a recording of one run.

    Returns:
        The poses on their clock.

    Raises:
        InvalidType: something else.
        InvalidValue: a recording of many runs.

    Example:
        >>> still = dd.Drive([0.0, 1.0, 2.0], np.zeros((3, 2)), np.zeros((2, 3)), [0.0, 2.0], name="lab")
        >>> dd.pose_log.poses_of("truth", still)
        PoseLog(lab: 2 poses, 0 to 2 s)
    """
    checks.string("name", name)
    if isinstance(value, Drive):
        return PoseLog(value.clock, value.truth, value.name, value.warnings)
    if isinstance(value, Recording):
        if isinstance(value.robot, tuple):
            raise InvalidValue(f"{name}: a recording of {len(value.robot)} runs: take one of recording.runs")
        return PoseLog(value.t, value.truth, value.robot.name, value.events)
    if not isinstance(value, PoseLog):
        checks.instance(name, value, PoseLog, Drive, Recording)
    return value
