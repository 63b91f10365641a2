"""What every calibration method returns: the robot that the drives support, how sure it is, and what it is worth."""

from __future__ import annotations

import typing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table
from diffdrive_mj.metrics import Drift
from diffdrive_mj.robot import Robot

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    # What is calibrated: a robot, or its passive wheels.
    Subject = TypeVar("Subject", default=Robot)
else:
    Subject = typing.TypeVar("Subject")


@dataclass(frozen=True, eq=False)
class Calibration(Generic[Subject]):
    """Holds the outcome of a calibration, and prints as a short report.

    Attributes:
        method: its name.
        believed: the robot that went in, or its passive wheels.
        calibrated: the one that came out.
        parameters: names of what was estimated: fields of the robot, or what the method sees of them ("radius_ratio").
        values: of the parameters (P,).
        covariance: of the parameters (P, P); NaN where the method or the data cannot say.
        residuals: what was left unexplained (N,), in the method's own unit.
        before: drift of the believed robot on the drives that were used, one run a drive.
        after: drift of the calibrated robot on the same drives.
        condition: condition number of the scaled problem; large where the path cannot show a parameter.
        warnings: what to know before relying on it.
        details: further figures of the method, by name.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
        >>> found = dd.calibration.Calibration(
        ...     method="ruler",
        ...     believed=robot,
        ...     calibrated=robot.replace(track_width=0.41),
        ...     parameters=("track_width",),
        ...     values=np.array([0.41]),
        ...     covariance=np.array([[1e-6]]),
        ...     residuals=np.zeros(1),
        ... )
        >>> print(found)
        calibration by ruler
          track_width    0.41 +- 0.001
        >>> found.std
        array([0.001])
    """

    method: str
    believed: Subject
    calibrated: Subject
    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    before: Drift | None = None
    after: Drift | None = None
    condition: float = float("nan")
    warnings: tuple[str, ...] = ()
    details: dict[str, float] = field(default_factory=dict)

    @property
    def std(self) -> Array:
        """Standard deviations of the parameters (P,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Correlations of the parameters (P, P)."""
        return self.covariance / np.outer(self.std, self.std)

    def __str__(self) -> str:
        lines = [f"calibration by {self.method}"]
        lines += [
            f"  {name:14s} {value:.7g} +- {std:.2g}"
            for name, value, std in zip(self.parameters, self.values, self.std, strict=True)
        ]
        for label, drift in (("before", self.before), ("after", self.after)):
            if drift is not None:
                lines.append(f"  {label:6s} {drift.summary()}")
        lines += [f"  {name} = {value:.6g}" for name, value in self.details.items()]
        lines += [f"  warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        drifts = (("before", self.before), ("after", self.after))
        rows = [
            *(
                (n, f"{v:.7g}", f"± {std:.2g}")
                for n, v, std in zip(self.parameters, self.values, self.std, strict=True)
            ),
            *((label, drift.summary(), "") for label, drift in drifts if drift is not None),
            *((name, f"{value:.6g}", "") for name, value in self.details.items()),
            *(("warning", warning, "") for warning in self.warnings),
        ]
        return html_table(rows, caption=f"calibration by {self.method}")
