"""Where a robot is and how surely, the place as a complex number; and such moments put behind an uncertain start."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from diffdrive_mj._checks import Array


class Spread(NamedTuple):
    """The mean and the covariance of a pose: arrays, or single numbers.

    Attributes:
        place: its mean [m].
        heading: its mean [rad].
        square: E P^2 [m^2], P the place's deviation from its mean.
        spread: E |P|^2 [m^2].
        with_heading: the covariance of place and heading [m rad].
        variance: of the heading [rad^2].
    """

    place: Any
    heading: Any
    square: Any
    spread: Any
    with_heading: Any
    variance: Any

    @classmethod
    def of(cls, pose: Array, covariance: Array) -> Spread:
        """From poses (..., 3) and their covariances (..., 3, 3)."""
        xx, xy, yy = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
        return cls(
            pose[..., 0] + 1j * pose[..., 1],
            pose[..., 2],
            xx - yy + 2j * xy,
            xx + yy,
            covariance[..., 0, 2] + 1j * covariance[..., 1, 2],
            covariance[..., 2, 2],
        )

    def write(self, mean: Array, covariance: Array) -> None:
        """Write the mean (..., 3) and the covariance (..., 3, 3)."""
        mean[..., 0], mean[..., 1], mean[..., 2] = self.place.real, self.place.imag, self.heading
        along, across = self.square.real, self.square.imag / 2
        covariance[..., 0, 0], covariance[..., 1, 1] = (self.spread + along) / 2, (self.spread - along) / 2
        covariance[..., 0, 1] = covariance[..., 1, 0] = across
        covariance[..., 0, 2] = covariance[..., 2, 0] = self.with_heading.real
        covariance[..., 1, 2] = covariance[..., 2, 1] = self.with_heading.imag
        covariance[..., 2, 2] = self.variance


def behind(start: Spread, seen: Spread) -> Spread:
    """The pose p_0 + e^(i theta_0) p whose p and theta are `seen` from a Gaussian start.

    With e = E e^(i theta_0), the start's deviation P_0 goes with the heading as
    E P_0 e^(i theta_0) = i cov(P_0, theta_0) e.
    """
    e = np.exp(1j * start.heading - start.variance / 2)
    less = np.expm1(-start.variance)
    moved = e * seen.place
    return Spread(
        start.place + moved,
        start.heading + seen.heading,
        start.square + 2j * start.with_heading * moved + e**2 * (seen.square + less * (seen.square + seen.place**2)),
        start.spread + 2 * (1j * start.with_heading.conjugate() * moved).real + seen.spread - less * size(seen.place),
        start.with_heading + 1j * start.variance * moved + e * seen.with_heading,
        start.variance + seen.variance,
    )


def behind_to_first_order(start: Spread, seen: Spread) -> Spread:
    """The same, linear in the deviation of the start."""
    e = np.exp(1j * start.heading)
    moved = e * seen.place
    lever = 1j * moved
    return Spread(
        start.place + moved,
        start.heading + seen.heading,
        start.square + 2 * start.with_heading * lever + lever**2 * start.variance + e**2 * seen.square,
        start.spread + 2 * (start.with_heading.conjugate() * lever).real + size(lever) * start.variance + seen.spread,
        start.with_heading + lever * start.variance + e * seen.with_heading,
        start.variance + seen.variance,
    )


def size(z: Any) -> Any:
    """|z|^2."""
    return z.real * z.real + z.imag * z.imag
