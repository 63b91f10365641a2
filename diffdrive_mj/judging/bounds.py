"""Bounds on drift, and which of them are broken."""

from __future__ import annotations

from dataclasses import dataclass, fields

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import quantity
from diffdrive_mj.metrics import Drift

# Their units and names.
_WORDS = {
    "position": ("m", "position"),
    "heading": ("rad", "heading"),
    "position_per_metre": ("m", "position per metre"),
}


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """State how far an estimate may drift along a drive; what is not given is not bounded.

    Args:
        position: largest position error [m].
        heading: largest heading error [rad].
        position_per_metre: largest position error over the distance driven [m/m].

    Raises:
        InvalidValue: a bound that is not positive.
        InvalidType: not a number.

    Example:
        >>> drift = dd.metrics.drift([(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1.02, 0, 0)])
        >>> Bounds(position=0.01, heading=0.1).broken(drift)
        ('position off by 20.0 mm, more than 10.0 mm',)
    """

    position: float | None = None
    heading: float | None = None
    position_per_metre: float | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            if (value := getattr(self, field.name)) is not None:
                object.__setattr__(self, field.name, checks.positive(field.name, value))

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) is not None for field in fields(self))

    def broken(self, drift: Drift) -> tuple[str, ...]:
        """Say which bounds a drift breaks, and by how much.

        Args:
            drift: of one run.

        Returns:
            A line each.
        """
        return tuple(
            f"{words} off by {quantity(value, unit)}, more than {quantity(limit, unit)}"
            for words, unit, value, limit in self.figures(drift)
            if not value <= limit
        )

    def figures(self, drift: Drift) -> tuple[tuple[str, str, float, float], ...]:
        """List what is bounded.

        Args:
            drift: of one run.

        Returns:
            For each bound what it is of, its unit, the figure and the limit.

        Example:
            >>> drift = dd.metrics.drift([(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1.5, 0, 0)])
            >>> Bounds(position=0.25).figures(drift)
            (('position', 'm', 0.5, 0.25),)
        """
        found = {
            "position": float(drift.max_position),
            "heading": float(drift.max_heading),
            "position_per_metre": float(drift.max_position) / max(float(drift.distance), 1e-12),
        }
        limits = {name: getattr(self, name) for name in found}
        return tuple(
            (words, unit, found[name], limits[name])
            for name, (unit, words) in _WORDS.items()
            if limits[name] is not None
        )
