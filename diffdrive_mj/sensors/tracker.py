"""A tracker of the true pose, such as motion capture: how often and how well it sees which point of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.sensors._sampling import due, poses_between


@dataclass(frozen=True, eq=False)
class Track:
    """What a tracker has written down.

    Attributes:
        t: (M,) [s], the times on the tracker's own clock.
        poses: (..., M, 3) [m, m, rad], of its marker.

    Example:
        >>> dd.Tracker(sample_rate=2.0).read([0.0, 4.0], np.zeros((2, 3)))
        Track(9 poses, 0 to 4 s)
    """

    t: Array
    poses: Array

    def __repr__(self) -> str:
        runs = f"{self.poses.shape[:-2]} runs of " if self.poses.ndim > 2 else ""
        return f"Track({runs}{len(self.t)} poses, {self.t[0]:g} to {self.t[-1]:g} s)"


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """A tracker that follows a marker on the robot; as it stands, it sees every recorded pose perfectly.

    Args:
        sample_rate: [Hz]; None for every recorded pose.
        position_noise: standard deviation of x and of y, independent from pose to pose [m].
        heading_noise: standard deviation of theta, likewise [rad].
        x: of the marker, forward of the axle's midpoint [m]: its lever arm.
        y: of the marker, to the left of it [m].
        angle: of the marker's forward axis, counter-clockwise off the robot's [rad].
        clock_offset: the tracker's time minus the encoder's [s].
        gaps: (start, end) of each time in which it does not see the robot, on the encoder's clock [s].

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is of another type; the message names it.

    Example:
        A marker 50 mm ahead of the axle, on a robot that turns on the spot by a quarter turn:

        >>> tracker = dd.Tracker(x=0.050, sample_rate=1.0)
        >>> tracker.read([0.0, 1.0], [(0.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2)]).poses.round(4).tolist()
        [[0.05, 0.0, 0.0], [0.0, 0.05, 1.5708]]
    """

    sample_rate: float | None = None
    position_noise: float = 0.0
    heading_noise: float = 0.0
    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0
    clock_offset: float = 0.0
    gaps: Sequence[tuple[float, float]] = ()

    def __post_init__(self) -> None:
        if self.sample_rate is not None:
            self._set("sample_rate", checks.positive("Tracker.sample_rate", self.sample_rate))
        for field in ("position_noise", "heading_noise"):
            self._set(field, checks.not_negative(f"Tracker.{field}", getattr(self, field)))
        for field in ("x", "y", "angle", "clock_offset"):
            self._set(field, checks.number(f"Tracker.{field}", getattr(self, field)))
        if not isinstance(self.gaps, (tuple, list)):
            raise InvalidType(f"Tracker.gaps = {shown(self.gaps)}: must be a tuple of (start, end) [s]")
        gaps = []
        for gap in self.gaps:
            start, end = checks.vector("Tracker.gaps", gap, 2).tolist()
            if start >= end:
                raise InvalidValue(f"Tracker.gaps: ({start:g}, {end:g}): must end after they start")
            gaps.append((start, end))
        self._set("gaps", tuple(gaps))

    def _set(self, field: str, value: object) -> None:
        object.__setattr__(self, field, value)

    @property
    def is_random(self) -> bool:
        """Whether it adds noise."""
        return bool(self.position_noise or self.heading_noise)

    def read(self, t: ArrayLike, truth: ArrayLike, rng: np.random.Generator | None = None) -> Track:
        """Follow the marker along a drive, which moves in an arc from each recorded pose to the next.

        Args:
            t: (T,) [s], increasing: the times of the recorded poses.
            truth: (..., T, 3) [m, m, rad], of the axle's midpoint.
            rng: the source of the noise, anew for each run.

        Returns:
            The times, from the first recorded one on, and the marker's poses.

        Raises:
            InvalidValue: shapes that do not fit, times that do not increase, noise without a generator, gaps that
                leave nothing.
            InvalidType: `rng` is no numpy Generator.
        """
        poses = checks.array("truth", truth, "T", 3)
        recorded = checks.increasing("t", checks.vector("t", t, poses.shape[-2]))
        seen = recorded
        if self.sample_rate is not None:
            duration = checks.duration("t", recorded, self.sample_rate)
            seen = recorded[0] + due(duration, self.sample_rate) / self.sample_rate
        for start, end in self.gaps:
            seen = seen[(seen < start) | (seen >= end)]
        if not len(seen):
            raise InvalidValue(f"Tracker.gaps = {self.gaps}: must leave at least one pose")
        marker = se2.compose(poses_between(recorded, poses, seen), (self.x, self.y, self.angle))
        if self.is_random:
            sigma = (self.position_noise, self.position_noise, self.heading_noise)
            marker = marker + sigma * checks.generator("rng", rng).standard_normal(marker.shape)
        return Track(seen + self.clock_offset, marker)
