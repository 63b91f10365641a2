"""Rates that a gyro has written down, simulated or real, and the turns that they stand for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import one_line
from diffdrive_mj.errors import InvalidValue

# A reading that comes later than this many usual intervals after the one before does not stand for all of the time.
_GAP = 3.0
# Times that are equal up to rounding [s].
_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class GyroLog:
    """Yaw rates on a clock: each reading is the mean rate since the reading before.

    The first reading's interval is taken to be as long as the second's. An IMU's instantaneous, filtered rates are
    close to such means where they are read faster than the robot's rate changes.

    Args:
        t: times of the readings (S,) [s], increasing, two at least.
        rates: (..., S) [rad/s], counter-clockwise.
        saturated: (..., S), which readings are at the gyro's range, so that the rate may have been larger; none where
            it is left out.
        name: what messages call it.

    Raises:
        InvalidType: not numbers; `saturated` not of bools.
        InvalidValue: values that are not finite, times that repeat or go back, shapes that do not fit.

    Example:
        A turn at 0.5 rad/s, seen by wheels at other times than the gyro's:

        >>> log = dd.GyroLog(t=[0.5, 1.0, 1.5, 2.0], rates=[0.5, 0.5, 0.5, 0.5])
        >>> turns, seen = log.turns([0.0, 0.8, 1.9])
        >>> print(turns, seen)
        [0.4  0.55] [ True  True]
    """

    t: Array
    rates: Array
    saturated: NDArray[np.bool_] | None = None
    name: str = "gyro"

    def __repr__(self) -> str:
        runs = f"{self.rates.shape[:-1]} runs of " if self.rates.ndim > 1 else ""
        lost = np.count_nonzero(self.at_range)
        held = f", {lost} of {self.at_range.size} saturated" if lost else ""
        return f"GyroLog({self.name}: {runs}{len(self.t)} rates, {self.t[0]:g} to {self.t[-1]:g} s{held})"

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", one_line(checks.string("GyroLog.name", self.name)))
        t = checks.increasing(f"{self.name}: t", self.t)
        rates = checks.array(f"{self.name}: rates", self.rates, "S")
        if rates.shape[-1] != len(t):
            raise InvalidValue(f"{self.name}: rates has {rates.shape[-1]} readings and t {len(t)}: must be as many")
        if self.saturated is None:
            lost = np.zeros(rates.shape, dtype=np.bool_)
        else:
            lost = checks.flags(f"{self.name}: saturated", self.saturated, len(t))
            checks.broadcast(rates=rates, saturated=lost)
            lost = np.broadcast_to(lost, rates.shape)
        # Copies, which whoever made the log cannot change after they were checked.
        for field, value in (("t", t.copy()), ("rates", rates.copy()), ("saturated", lost.copy())):
            value.flags.writeable = False
            object.__setattr__(self, field, value)

    @property
    def at_range(self) -> NDArray[np.bool_]:
        """Which readings are saturated (..., S)."""
        return cast("NDArray[np.bool_]", self.saturated)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before relying on it: readings at the gyro's range, and gaps."""
        lost, gaps = int(np.count_nonzero(self.at_range)), int(np.count_nonzero(self._gaps))
        said = []
        if lost:
            said.append(f"{self.name}: {lost} of {self.at_range.size} readings are at its range; it turned faster")
        if gaps:
            said.append(f"{self.name}: {gaps} gap{'s' * (gaps > 1)} between its readings")
        return tuple(said)

    @property
    def longest(self) -> float:
        """The longest time that a reading stands for, gaps aside [s]."""
        return float(np.diff(self._edges)[~self._gaps].max())

    @property
    def _edges(self) -> Array:
        """The times between which the readings are means (S + 1,)."""
        return np.concatenate([[2 * self.t[0] - self.t[1]], self.t])

    @property
    def _gaps(self) -> NDArray[np.bool_]:
        """Which readings stand for less than the time since the one before (S,)."""
        intervals = np.diff(self._edges)
        return np.asarray(intervals > _GAP * np.median(intervals))

    def turns(self, times: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
        """Compute by how much the gyro turned between given times.

        ```
        turn = integral of the rate, which is constant from each reading's predecessor to itself
        ```

        Args:
            times: (T,) [s], increasing, such as an encoder's.

        Returns:
            The turns (..., T - 1) [rad], and whether the gyro saw the whole of each (..., T - 1): not where it had not
            begun or had ended, in a gap, or where a reading is saturated.

        Raises:
            InvalidType: not numbers.
            InvalidValue: times that do not increase.
        """
        at, edges = checks.increasing("times", times), self._edges
        inside = np.clip(at, edges[0], edges[-1])
        blind = self.at_range | self._gaps
        # Angle turned, and time in which it was blind, since the first edge; both change evenly between the edges.
        angle, lost = (
            _since_first(edges, values * np.diff(edges), inside) for values in (self.rates, blind.astype(np.float64))
        )
        covered = (at[:-1] >= edges[0] - _SLACK) & (at[1:] <= edges[-1] + _SLACK)
        return np.diff(angle, axis=-1), covered & (np.diff(lost, axis=-1) <= _SLACK)


def _since_first(edges: Array, steps: Array, times: Array) -> Array:
    """Sums of steps (..., S) between edges (S + 1,) at times (T,), evenly in between."""
    sums = np.concatenate([np.zeros_like(steps[..., :1]), np.cumsum(steps, axis=-1)], axis=-1)
    before = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, len(edges) - 2)
    part = (times - edges[before]) / (edges[before + 1] - edges[before])
    return sums[..., before] + part * steps[..., before]
