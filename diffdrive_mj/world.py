"""What surrounds the robot: the floor and its disturbances, and how the physics is solved.

The three numbers that decide how clean the physics is count in time steps, so that one choice holds at every
step size; `experiments/physics_floor.py` measures why the defaults are what they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import checks
from diffdrive_mj.checks import Array
from diffdrive_mj.errors import InvalidType, InvalidValue

WheelShape = Literal["crowned", "cylinder"]
Integrator = Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"]
Cone = Literal["elliptic", "pyramidal"]


@dataclass(frozen=True, kw_only=True)
class Push:
    """A force on the body's centre of mass for some time, as an acceleration of the whole robot.

    Args:
        start, duration: [s].
        acceleration: (x, y, z) in the world's axes [m/s^2], times the robot's mass.
    """

    start: float
    duration: float
    acceleration: tuple[float, float, float]

    def __post_init__(self) -> None:
        checks.not_negative("Push.start", self.start)
        checks.positive("Push.duration", self.duration)
        x, y, z = checks.vector("Push.acceleration", self.acceleration, 3).tolist()
        object.__setattr__(self, "acceleration", (x, y, z))


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A rectangle of floor with a friction of its own.

    Args:
        x, y: from and to [m].
        friction: coefficient of sliding friction.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    friction: float

    def __post_init__(self) -> None:
        for axis in ("x", "y"):
            low, high = checks.array(f"Patch.{axis}", getattr(self, axis), 2).tolist()
            if low >= high:
                raise InvalidValue(f"Patch.{axis} = ({low:g}, {high:g}): must go from a smaller to a larger number")
            object.__setattr__(self, axis, (low, high))
        checks.positive("Patch.friction", self.friction)

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Which of the points (..., 2) [m] lie on it."""
        (left, right), (near, far) = self.x, self.y
        x, y = points[..., 0], points[..., 1]
        return (left <= x) & (x < right) & (near <= y) & (y < far)

    def distance(self, points: Array) -> Array:
        """How far each of the points (..., 2) is from its border at least (...) [m]."""
        gaps = [np.abs(points[..., axis] - edge) for axis, edges in enumerate((self.x, self.y)) for edge in edges]
        outside = [
            np.maximum(np.maximum(low - points[..., axis], points[..., axis] - high), 0.0)
            for axis, (low, high) in enumerate((self.x, self.y))
        ]
        away = np.hypot(*outside)
        return np.where(away > 0, away, np.min(gaps, axis=0))


@dataclass(frozen=True, kw_only=True)
class World:
    """The floor and what happens on it; the default is ideal.

    Args:
        friction: coefficient of sliding friction between wheels and floor.
        patches: where the floor's friction is another one; of two that overlap the later counts.
        pushes: on the robot.
    """

    friction: float = 1.0
    patches: tuple[Patch, ...] = ()
    pushes: tuple[Push, ...] = ()

    def __post_init__(self) -> None:
        checks.positive("World.friction", self.friction)
        for field, kind in (("patches", Patch), ("pushes", Push)):
            items = getattr(self, field)
            if not isinstance(items, (tuple, list)) or not all(isinstance(item, kind) for item in items):
                raise InvalidType(f"World.{field} = {items!r}: must be a tuple of {kind.__name__}")
            object.__setattr__(self, field, tuple(items))

    def friction_at(self, points: Array) -> Array:
        """The coefficient of friction under each of the points (..., 2) [m]."""
        result = np.full(points.shape[:-1], self.friction)
        for patch in self.patches:
            result[patch.holds(points)] = patch.friction
        return result


@dataclass(frozen=True, kw_only=True)
class Physics:
    """How MuJoCo solves the drive.

    Args:
        timestep: [s].
        integrator: implicit ones let servo-driven wheels slip while they accelerate.
        wheel_shape: "crowned", an ellipsoid that touches the floor in one point, so that the track is what the
            robot says, or "cylinder", whose contact jumps between its edges.
        cone: of friction; friction_damping needs "elliptic".
        contact_time: time constant of the contacts [time steps], at least 2.
        contact_impedance: how hard a contact is, when just touching and when deep, each below 1; a wheel
            sinks in proportion to 1 - impedance.
        friction_damping: what part of a wheel's slip is taken out in a step; the rest of a turn's
            lateral creep is v omega dt (1/2 - 1/friction_damping), but a slip dies out as
            (1 - friction_damping)^n, never at 2. Worlds in which wheels slide want 1, see `sliding`.
            None leaves it to MuJoCo, which derives it from contact_time.
        servo_stiffness: what part of a free wheel's speed error its servo may take out in a step, at most; stable
            below 2 in theory, 1.5 in practice.
        tolerance: of the solver.
        settle_time: standing still before time zero, until the robot rests on its contacts [s].
    """

    timestep: float = 0.002
    integrator: Integrator = "Euler"
    wheel_shape: WheelShape = "crowned"
    cone: Cone = "elliptic"
    contact_time: float = 2.0
    contact_impedance: tuple[float, float] = (0.9999, 0.9999)
    friction_damping: float | None = 1.995
    servo_stiffness: float = 0.5
    tolerance: float = 1e-10
    settle_time: float = 0.3

    def __post_init__(self) -> None:
        checks.positive("Physics.timestep", self.timestep)
        checks.member("Physics.integrator", self.integrator, ("Euler", "RK4", "implicit", "implicitfast", "discrete"))
        checks.member("Physics.wheel_shape", self.wheel_shape, ("crowned", "cylinder"))
        checks.member("Physics.cone", self.cone, ("elliptic", "pyramidal"))
        if checks.number("Physics.contact_time", self.contact_time) < 2:
            raise InvalidValue(f"Physics.contact_time = {self.contact_time:g} time steps: must be at least 2")
        low, high = checks.vector("Physics.contact_impedance", self.contact_impedance, 2).tolist()
        if not 0 < low <= high < 1:
            raise InvalidValue(f"Physics.contact_impedance = ({low:g}, {high:g}): must be 0 < touching <= deep < 1")
        object.__setattr__(self, "contact_impedance", (low, high))
        if self.friction_damping is not None:
            damping = checks.positive("Physics.friction_damping", self.friction_damping)
            if damping >= 2:
                raise InvalidValue(
                    f"Physics.friction_damping = {damping:g}: must be below 2, where slip never dies out"
                )
        stiffness = checks.positive("Physics.servo_stiffness", self.servo_stiffness)
        if stiffness > 1.5:
            raise InvalidValue(
                f"Physics.servo_stiffness = {stiffness:g}: must be at most 1.5, or a free wheel diverges"
            )
        checks.positive("Physics.tolerance", self.tolerance)
        checks.not_negative("Physics.settle_time", self.settle_time)

    @classmethod
    def sliding(cls) -> Physics:
        """For worlds in which wheels slide: friction acts as Coulomb's within 2 %, at 270 ppm of creep in turns."""
        return cls(friction_damping=1.0)

    @classmethod
    def careless(cls) -> Physics:
        """What a model gets that leaves every choice to habit: cylinders, default contacts, `implicitfast`."""
        return cls(
            integrator="implicitfast",
            wheel_shape="cylinder",
            cone="pyramidal",
            contact_time=10.0,
            contact_impedance=(0.9, 0.95),
            friction_damping=None,
            tolerance=1e-8,
        )
