"""How MuJoCo solves the drive.

The three numbers that decide how clean the physics is count in time steps, so that one choice holds at every
step size; `experiments/physics_floor.py` measures why the defaults are what they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue

WheelShape = Literal["crowned", "cylinder"]
Integrator = Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"]
Cone = Literal["elliptic", "pyramidal"]


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
