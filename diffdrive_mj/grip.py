"""How robots held on to the floor on a drive: what wheel odometry cannot see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from diffdrive_mj._checks import Array

# The share of its friction above which a wheel is said to slip.
LARGEST_USE = 0.95
# Below this a slide is not worth a word [m].
_SHORTEST_SLIDE = 1e-3
# The share of the largest command above which a wheel is said to fall short of its command.
LARGEST_SHORTFALL = 0.05


@dataclass(frozen=True, eq=False)
class Grip:
    """How the wheels held on, and whether the robots stayed up.

    Attributes:
        friction_use: (..., 2), largest share of the friction that the left and the right wheel used.
        friction_time: (..., 2) [s], when that was.
        lift_time: (...) [s], when a wheel or the caster first left the floor; nan if none did.
        fall_time: (...) [s], when the robot fell; nan if it did not.
        stuck_time: (...) [s], from when on it stayed, for a second, within a tenth of the way over which its wheels
            were told to move; nan if it never did.
        edge_time: (...) [s], when it left the rough floor; nan if it did not.
        grounded_time: (...) [s], when its chassis first touched what lies on the floor; nan if it did not.
        slide: (..., 2) [m], how far each wheel slid while it used all of its friction or carried nothing; None where
            nobody has looked.
        shortfall: (..., 2), by how much each wheel was slower than commanded at most while its motor gave all it had,
            as a share of the largest command so far; None where no motor has a limit.
        shortfall_time: (..., 2) [s], when that was.

    Example:
        >>> held = Grip(np.array([0.2, 0.97]), np.array([1.0, 1.2]), np.array(np.nan), np.array(np.nan))
        >>> held.events(["my_robot"])
        ('my_robot: the right wheel used 97 % of its friction at 1.2 s',)
    """

    friction_use: Array
    friction_time: Array
    lift_time: Array
    fall_time: Array
    stuck_time: Array | None = None
    edge_time: Array | None = None
    grounded_time: Array | None = None
    slide: Array | None = None
    shortfall: Array | None = None
    shortfall_time: Array | None = None

    def of(self, run: int) -> Grip:
        """That of one run."""
        values: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        return Grip(**{name: value[run] for name, value in values.items() if value is not None})

    def events(self, names: Sequence[str], skids: Sequence[bool] = ()) -> tuple[str, ...]:
        """Falls, robots that got stuck or left the rough floor, lifts, slip and motors at their limits, a line each.

        Args:
            names: of the runs' robots.
            skids: which of them have skid steer, one each; their slip is what is expected, and `skids` has it.
        """
        use, when = self.friction_use.reshape(-1, 2), self.friction_time.reshape(-1, 2)
        times = (self.lift_time, self.fall_time, self.stuck_time, self.edge_time, self.grounded_time)
        lift, fall, stuck, edge, grounded = (
            np.full(len(use), np.nan) if time is None else time.reshape(-1) for time in times
        )
        slides = np.zeros_like(use) if self.slide is None else self.slide.reshape(-1, 2)
        found: list[str] = []
        for run, name in enumerate(names):
            if not np.isnan(fall[run]):
                found.append(f"{name} fell at {fall[run]:.4g} s")
            if not np.isnan(stuck[run]):
                found.append(f"{name} got stuck at {stuck[run]:.4g} s")
            if not np.isnan(grounded[run]):
                found.append(f"{name}: its chassis touched the ground at {grounded[run]:.4g} s")
            if not np.isnan(edge[run]):
                found.append(f"{name} left the rough floor at {edge[run]:.4g} s")
            for side, wheel in enumerate(("left", "right")):
                if use[run, side] > LARGEST_USE and not any(skids[run : run + 1]):
                    share, time = 100 * use[run, side], when[run, side]
                    slid = f", and slid {slides[run, side]:.3g} m" if slides[run, side] > _SHORTEST_SLIDE else ""
                    found.append(f"{name}: the {wheel} wheel used {share:.0f} % of its friction at {time:.4g} s{slid}")
            if not np.isnan(lift[run]):
                found.append(f"{name}: a wheel or the caster was off the floor at {lift[run]:.4g} s")
            found += self._motors_at_their_limits(run, name)
        return tuple(found)

    def _motors_at_their_limits(self, run: int, name: str) -> list[str]:
        if self.shortfall is None or self.shortfall_time is None:
            return []
        short, when = self.shortfall.reshape(-1, 2)[run], self.shortfall_time.reshape(-1, 2)[run]
        return [
            f"{name}: the {wheel} motor gave all it has at {when[side]:.4g} s, {100 * short[side]:.0f} % too slow"
            for side, wheel in enumerate(("left", "right"))
            if short[side] > LARGEST_SHORTFALL
        ]

    def skids(self, names: Sequence[str], skids: Sequence[bool]) -> tuple[str, ...]:
        """Robots with skid steer whose wheels slid, a line each.

        Args:
            names: of the runs' robots.
            skids: which of them have skid steer, one each.
        """
        slid = np.flatnonzero((self.friction_use.reshape(-1, 2) > LARGEST_USE).any(axis=-1))
        return tuple(
            f"{names[run]}: its wheels slid, as those of skid steer do in turns: odometry needs its effective track"
            for run in slid.tolist()
            if skids[run]
        )
