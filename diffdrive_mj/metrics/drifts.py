"""Drift: how far an estimate is off along a drive, without aligning anything."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.metrics._pairs import complex_positions, paired


@dataclass(frozen=True, eq=False)
class Drift:
    """How far an estimate is off, along the drive. Leading dimensions are those of the runs.

    Attributes:
        distance: driven, from the truth (...) [m].
        travelled: driven up to each sample (..., T) [m].
        position_error: (..., T) [m].
        heading_error: estimate minus truth on the circle (..., T) [rad], in (-pi, pi].
        warnings: what to know before relying on it, such as a wheel that slipped; printed below the figures.

    Example:
        An estimate that is 20 mm off to the left at the end of 2 m:

        >>> drift = dd.metrics.drift([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)], [(0.0, 0.0, 0.0), (2.0, 0.02, 0.0)])
        >>> print(drift)
        distance driven        2 m
        largest position error 20 mm   1e+04 um/m
        final position error   20 mm   1e+04 um/m
        largest heading error  0 deg
        final heading error    0 deg
        >>> bool(drift.max_position_per_metre < 0.011)  # what a test of odometry asserts
        True
    """

    distance: Array
    travelled: Array
    position_error: Array
    heading_error: Array
    warnings: tuple[str, ...] = ()

    @property
    def max_position(self) -> Array:
        """The largest position error along the drive (...) [m]."""
        return np.asarray(self.position_error.max(axis=-1))[()]

    @property
    def final_position(self) -> Array:
        """The position error at the end (...) [m]."""
        return self.position_error[..., -1]

    @property
    def final_position_rms(self) -> float:
        """Root mean square of the final position errors of all the runs [m]."""
        return float(np.sqrt(np.mean(self.final_position**2)))

    @property
    def max_heading(self) -> Array:
        """The largest size of the heading error along the drive (...) [rad]."""
        return np.asarray(np.abs(self.heading_error).max(axis=-1))[()]

    @property
    def final_heading(self) -> Array:
        """The heading error at the end, signed (...) [rad]."""
        return self.heading_error[..., -1]

    @property
    def max_position_per_metre(self) -> Array:
        """The largest position error over the whole distance (...) [m/m]."""
        return self._per_metre(self.max_position)

    @property
    def final_position_per_metre(self) -> Array:
        """The position error at the end over the whole distance (...) [m/m]."""
        return self._per_metre(self.final_position)

    @property
    def max_heading_per_metre(self) -> Array:
        """The largest size of the heading error over the whole distance (...) [rad/m]."""
        return self._per_metre(self.max_heading)

    @property
    def final_heading_per_metre(self) -> Array:
        """The heading error at the end, signed, over the whole distance (...) [rad/m]."""
        return self._per_metre(self.final_heading)

    def _per_metre(self, error: Array) -> Array:
        # Standing still: no error is no drift, any other error is infinite.
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(error == 0, 0.0, error / self.distance)[()]

    def summary(self) -> str:
        """Put the position errors of all the runs in one line."""
        return (
            f"final position {1e3 * self.final_position_rms:.4g} mm RMS, {1e3 * np.max(self.final_position):.4g} mm "
            f"at most; on the way {1e3 * np.max(self.max_position):.4g} mm at most"
        )

    def __repr__(self) -> str:
        return f"Drift({span(self.distance, 'm')}, position error at most {span(self.max_position, 'mm', 1e3)})"

    def __str__(self) -> str:
        rows = [f"{name:<22} {value}   {per_metre}".rstrip() for name, value, per_metre in self._rows()]
        return "\n".join([*rows, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        return html_table([*self._rows(), *(("warning", warning, "") for warning in self.warnings)])

    def _rows(self) -> list[tuple[str, str, str]]:
        """What it prints: a name, the figure, and the figure per metre."""
        return [
            ("distance driven", span(self.distance, "m"), ""),
            (
                "largest position error",
                span(self.max_position, "mm", 1e3),
                span(self.max_position_per_metre, "um/m", 1e6),
            ),
            (
                "final position error",
                span(self.final_position, "mm", 1e3),
                span(self.final_position_per_metre, "um/m", 1e6),
            ),
            ("largest heading error", span(np.degrees(self.max_heading), "deg"), ""),
            ("final heading error", span(np.degrees(self.final_heading), "deg"), ""),
        ]


def drift(truth: ArrayLike, estimate: ArrayLike) -> Drift:
    """Compare an estimate with the truth, sample by sample, without aligning anything.

    Args:
        truth: (..., T, 3) [m, m, rad].
        estimate: (..., T, 3) [m, m, rad], at the same samples; leading dimensions broadcast.

    Returns:
        The errors along the drive.

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, or values that are not finite.

    Example:
        >>> truth = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, np.pi / 2)]
        >>> estimate = [(0.0, 0.0, 0.0), (1.01, 0.0, 0.0), (1.01, 0.0, 1.55)]
        >>> off = dd.metrics.drift(truth, estimate)
        >>> round(float(off.final_position), 4), round(float(off.final_heading), 4)
        (0.01, -0.0208)
    """
    truth, estimate = paired(truth, estimate)
    along = travelled(truth)
    return Drift(
        distance=along[..., -1],
        travelled=along,
        position_error=np.abs(complex_positions(estimate) - complex_positions(truth)),
        heading_error=se2.wrap_angle(estimate[..., 2] - truth[..., 2]),
    )


def travelled(truth: ArrayLike) -> Array:
    """Compute the distance driven up to each sample, each step counted as the arc through its two poses.

    Args:
        truth: (..., T, 3) [m, m, rad].

    Returns:
        (..., T) [m], zero at the first sample.

    Example:
        A quarter of a circle of radius 1 m, and a turn on the spot:

        >>> dd.metrics.travelled([(0.0, 0.0, 0.0), (1.0, 1.0, np.pi / 2), (1.0, 1.0, 0.0)]).round(4).tolist()
        [0.0, 1.5708, 1.5708]
    """
    poses = checks.array("truth", truth, "T", 3)
    result = np.zeros(poses.shape[:-1])
    if poses.shape[-2] > 1:
        step = np.diff(poses, axis=-2)
        chord = np.hypot(step[..., 0], step[..., 1])
        np.cumsum(chord / se2.sinc(se2.wrap_angle(step[..., 2]) / 2), axis=-1, out=result[..., 1:])
    return result


def stacked(drifts: Iterable[Drift]) -> Drift:
    """Stack the drifts of several drives as the runs of one drift: a new first dimension.

    A drive that is shorter than the longest keeps its last errors until the end.

    Args:
        drifts: at least one, of the same leading dimensions.

    Returns:
        The drift of all the drives, with the warnings of each.

    Raises:
        InvalidType: something other than drifts.
        InvalidValue: none, or leading dimensions that differ.

    Example:
        >>> truth = np.zeros((3, 3))
        >>> off = dd.metrics.stacked(dd.metrics.drift(truth, truth + (error, 0, 0)) for error in (0.003, 0.004))
        >>> off.final_position.tolist(), round(off.final_position_rms, 6)
        ([0.003, 0.004], 0.003536)
    """
    given = checks.instances("drifts", drifts, Drift)
    if len({drift.distance.shape for drift in given}) != 1:
        shapes = ", ".join(str(drift.distance.shape) for drift in given) or "none"
        raise InvalidValue(f"drifts: leading dimensions {shapes}: must be at least one, all alike")
    samples = np.arange(max(drift.travelled.shape[-1] for drift in given))

    def joined(parts: list[Array]) -> Array:
        return np.stack([part[..., np.minimum(samples, part.shape[-1] - 1)] for part in parts])

    return Drift(
        distance=np.stack([drift.distance for drift in given]),
        travelled=joined([drift.travelled for drift in given]),
        position_error=joined([drift.position_error for drift in given]),
        heading_error=joined([drift.heading_error for drift in given]),
        warnings=tuple(warning for drift in given for warning in drift.warnings),
    )
