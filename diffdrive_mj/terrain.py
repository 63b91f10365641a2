"""What a floor can be beside level and smooth: slopes, cables across the way, rough floors."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import SCALES, checked, described, span
from diffdrive_mj.errors import InvalidValue

# A rough floor: plane waves that it is the sum of, points a wavelength, and the most points along a side.
_WAVES, _POINTS, _MOST_POINTS = 64, 16, 2000
# By how much of its height a cable may lie above or below a rough floor, between the ends of a straight piece.
_CLOSE = 0.02
# Below this a cable has no length [m].
_SHORTEST = 1e-6


def _steepness(name: str, value: object) -> float:
    angle = checks.number(name, value)
    if not 0 <= angle < math.pi / 2:
        hint = f"; in degrees? then {math.radians(angle):.4g} rad" if math.pi / 2 <= angle < 90 else ""
        raise InvalidValue(f"{name} = {angle:g} rad: must be from 0 to below pi/2{hint}")
    return angle


@described()
@dataclass(frozen=True, kw_only=True)
class Slope:
    """Describe a floor that rises evenly; the world's x and y axes lie in it.

    Args:
        angle: how steep it is [rad].
        direction: in which it rises, as a heading [rad]; 0 along x.

    Raises:
        InvalidValue: an angle that is negative or not below pi/2, or a number that is not finite.
        InvalidType: not a number.
        UnknownName: a field that a slope does not have.

    Example:
        >>> Slope(angle=0.1, direction=math.pi / 2)  # uphill to the left
        Slope(angle=0.1, direction=1.5707963267948966)
    """

    angle: float = field(metadata=checked(_steepness))
    direction: float = field(default=0.0, metadata=checked(checks.number))


def _ends(name: str, value: Any) -> tuple[float, float]:
    """From and to [m]; one number is both."""
    if not hasattr(value, "__iter__") or getattr(value, "shape", None) == ():
        here = checks.number(name, value)
        return here, here
    begin, end = checks.vector(name, value, 2).tolist()
    return begin, end


def _point(name: str, value: Any) -> tuple[float, float]:
    x, y = checks.vector(name, value, 2).tolist()
    return x, y


@described()
@dataclass(frozen=True, kw_only=True)
class Cable:
    """Describe a cable on the floor, or a threshold: a straight bump with a round top, which follows a rough floor.

    Args:
        x: of one end and of the other [m]; one number where it lies along y.
        y: of one end and of the other [m]; one number where it lies along x.
        height: of its top above the floor [m].
        radius: of its round top [m], at least half the height; by default half of it, a cable that lies on the floor.
            With the whole height it is half sunk, with more a flat threshold.

    Raises:
        InvalidValue: a height or a radius out of its range, or ends that coincide.
        InvalidType: not a number.
        UnknownName: a field that a cable does not have.

    Example:
        >>> Cable(x=1.0, y=(-0.5, 0.5), height=0.005).radius
        0.0025
    """

    x: tuple[float, float] = field(metadata=checked(_ends))
    y: tuple[float, float] = field(metadata=checked(_ends))
    height: float = field(metadata=checked(checks.positive))
    radius: float = field(default=SCALES, metadata=checked(checks.positive))

    def __post_init__(self) -> None:
        if self.radius is None:
            object.__setattr__(self, "radius", self.height / 2)
        if self.radius < self.height / 2:
            raise InvalidValue(
                f"Cable.radius = {self.radius:g} m: must be at least half of the height, {self.height / 2:g} m, or the "
                "cable hangs above the floor"
            )
        if math.hypot(self.x[1] - self.x[0], self.y[1] - self.y[0]) < _SHORTEST:
            raise InvalidValue(f"Cable.x = {self.x[0]:g} m, Cable.y = {self.y[0]:g} m: its ends must lie apart")

    def course(self, rough: RoughFloor | None = None) -> Array:
        """Find where its axis goes: straight on a smooth floor, in straight pieces over a rough one.

        Args:
            rough: on which it lies, to within a few hundredths of its height.

        Returns:
            (n, 3) [m], the ends of the pieces from one end of the cable to the other.

        Example:
            >>> Cable(x=1.0, y=(-0.5, 0.5), height=0.005).course()
            array([[ 1.    , -0.5   ,  0.0025],
                   [ 1.    ,  0.5   ,  0.0025]])
        """
        ends, axis = np.array([self.x, self.y]).T, self.height - self.radius
        if rough is None:
            return np.column_stack([ends, (axis, axis)])
        x, *_ = rough.grid
        share = np.linspace(0, 1, math.ceil(np.hypot(*(ends[1] - ends[0])) / (x[1] - x[0])) + 1)
        places = ends[0] + share[:, None] * (ends[1] - ends[0])
        height, cuts = rough.height_at(places), {0, len(share) - 1}
        while True:  # cut each piece where it is farthest from the floor (Ramer, Douglas and Peucker)
            kept = sorted(cuts)
            off = np.abs(height - np.interp(share, share[kept], height[kept]))
            worst = [a + int(off[a : b + 1].argmax()) for a, b in itertools.pairwise(kept)]
            far = {k for k in worst if off[k] > _CLOSE * self.height}
            if not far:
                return np.column_stack([places, height + axis])[kept]
            cuts |= far


@described()
@dataclass(frozen=True, kw_only=True)
class RoughFloor:
    """Describe a rectangle of uneven floor, made from a seed, around a level circle where robots start.

    ```
    z(x, y) = rms sqrt(2 / n) sum_i cos(2 pi (x cos(a_i) + y sin(a_i)) / wavelength + b_i)
    ```

    with n = 64 random directions a_i and phases b_i: waves of one length that run all ways. The level circle goes over
    into it within a wavelength; along its outermost wavelength it goes down to a smooth floor, which lies as low as its
    deepest hollow or its highest crest is deep or high, whichever is more. A drive that leaves it has that as an event.

    Args:
        x: from and to [m].
        y: from and to [m].
        rms: root mean square of its heights [m], below a tenth of the wavelength; crests are about three times as high.
        wavelength: of its waves [m].
        seed: which decides them; the same seed gives the same floor.
        start: (x, y) of the middle of the level circle [m].
        level: radius of that circle [m]; the contacts of all robots must start in it.

    Raises:
        InvalidValue: a field out of its range, or sides that are too short or too long for the wavelength.
        InvalidType: not a number.
        UnknownName: a field that a rough floor does not have.

    Example:
        >>> floor = RoughFloor(x=(-1.0, 3.0), y=(-1.0, 1.0), rms=0.002, wavelength=0.2, seed=0)
        >>> floor.height_at(((0.0, 0.0), (1.0, 0.0))).round(4)
        array([0.   , 0.002])
    """

    x: tuple[float, float] = field(metadata=checked(span))
    y: tuple[float, float] = field(metadata=checked(span))
    rms: float = field(metadata=checked(checks.positive))
    wavelength: float = field(metadata=checked(checks.positive))
    seed: int = field(default=0, metadata=checked(functools.partial(checks.whole, least=0)))
    start: tuple[float, float] = field(default=(0.0, 0.0), metadata=checked(_point))
    level: float = field(default=0.5, metadata=checked(checks.positive))

    def __post_init__(self) -> None:
        if self.rms >= self.wavelength / 10:
            raise InvalidValue(
                f"RoughFloor.rms = {self.rms:g} m: must be below a tenth of the wavelength, "
                f"{self.wavelength / 10:g} m, or the floor has walls"
            )
        for axis in ("x", "y"):
            low, high = getattr(self, axis)
            waves = (high - low) / self.wavelength
            if not 4 <= waves <= _MOST_POINTS / _POINTS:
                raise InvalidValue(
                    f"RoughFloor.{axis} = ({low:g}, {high:g}): must be 4 to {_MOST_POINTS // _POINTS} wavelengths of "
                    f"{self.wavelength:g} m long, not {waves:.3g}"
                )

    @property
    def depth(self) -> float:
        """How far the smooth floor around it lies below its level circle [m]."""
        return float(-self.grid[2].min())

    @cached_property
    def grid(self) -> tuple[Array, Array, Array]:
        """Its points: x (n,), y (m,) and the heights there (m, n) [m]."""
        x, y = (
            np.linspace(low, high, math.ceil((high - low) / self.wavelength * _POINTS) + 1)
            for low, high in (self.x, self.y)
        )
        directions, phases = np.random.default_rng(self.seed).uniform(0, 2 * np.pi, (2, _WAVES))
        per_metre = 2 * np.pi / self.wavelength
        # A plane wave is the product of what it is along x and along y.
        along = np.exp(1j * (per_metre * np.outer(np.cos(directions), x) + phases[:, None]))
        across = np.exp(1j * per_metre * np.outer(np.sin(directions), y))
        # No matrix product: its bits may depend on the number of threads.
        waves = self.rms * math.sqrt(2 / _WAVES) * np.einsum("ij,ik->jk", across, along).real
        depth = np.abs(waves).max()
        out = np.hypot(x - self.start[0], (y - self.start[1])[:, None]) - self.level
        inside = np.minimum(np.minimum(x - self.x[0], self.x[1] - x), np.minimum(y - self.y[0], self.y[1] - y)[:, None])
        return x, y, (waves * self._eased(out) + depth) * self._eased(inside) - depth

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Tell which of the points lie on it.

        Args:
            points: (..., 2) [m].

        Returns:
            (...).
        """
        points = checks.array("points", points, 2)
        x, y = points[..., 0], points[..., 1]
        return (self.x[0] <= x) & (x <= self.x[1]) & (self.y[0] <= y) & (y <= self.y[1])

    def height_at(self, points: Array) -> Array:
        """Find its height at each of the points, between those of the grid; outside of it that of the smooth floor.

        Args:
            points: (..., 2) [m].

        Returns:
            (...) [m].
        """
        points = checks.array("points", points, 2)
        x, y, z = self.grid
        share = []
        for axis, at in zip((x, y), np.moveaxis(points, -1, 0), strict=True):
            place = np.clip((at - axis[0]) / (axis[1] - axis[0]), 0, len(axis) - 1)
            index = np.minimum(place.astype(np.intp), len(axis) - 2)
            share.append((index, place - index))
        (i, u), (j, v) = share
        near, far = z[j, i] * (1 - u) + z[j, i + 1] * u, z[j + 1, i] * (1 - u) + z[j + 1, i + 1] * u
        between: Array = near * (1 - v) + far * v
        return between

    def _eased(self, distance: Array) -> Array:
        """From 0 to 1 within a wavelength, without a kink at either end."""
        share = np.clip(distance / self.wavelength, 0.0, 1.0)
        eased: Array = share * share * (3 - 2 * share)
        return eased
