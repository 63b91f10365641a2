"""How MuJoCo solves the drive.

The numbers that decide how clean the physics is count in time steps, so that one choice holds at every step size;
`experiments/physics_floor.py` measures why the defaults are what they are, and `docs/physics.md` explains them.
"""

from __future__ import annotations

from dataclasses import InitVar, dataclass
from typing import Any, Literal

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.world import GRAVITY

Integrator = Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"]
Cone = Literal["elliptic", "pyramidal"]
Truth = Literal["midpoint", "engine"]

# Coarser steps do not simulate a wheeled robot; a servo's and a contact's time constants are milliseconds.
COARSEST_STEP = 0.05
# Up to here the standard maneuvers stay within 1 ppm; beyond, the error grows with the square of the step.
FINE_STEP = 0.005
FLOOR_AT_FINE_STEP = 0.5


@dataclass(frozen=True, kw_only=True)
class Physics:
    """Choose how MuJoCo solves a drive.

    Args:
        timestep: [s], at most 0.05.
        integrator: implicit ones let servo-driven wheels slip while they accelerate.
        cone: of friction; friction_damping needs "elliptic".
        contact_stiffness: what part of its penetration a contact takes out in a step, at most 1.
        contact_damping: what part of the speed of approach it takes out in a step, at most 1; with 1 a wheel that lands
            rebounds with at most contact_stiffness of its speed.
        contact_impedance: how hard a contact is, when just touching and when deep, each below 1; a wheel sinks in
            proportion to 1 - impedance.
        balanced_contacts: whether each contact starts to act above the floor by what it sinks under the robot's weight,
            so that a wheel at rest just touches, rolls at its own radius, and a drive starts from rest without a kick.
        friction_impedance: how much harder a contact is along the floor than across it (MuJoCo's impratio); the slip
            that a force leaves falls with it.
        friction_damping: what part of a wheel's slip is taken out in a step: slip dies out as (1 - friction_damping)^n,
            at once for 1, never for 2. None leaves it to MuJoCo, which derives it from contact_damping.
        truth: how the true pose follows from the engine's steps. "midpoint" turns each step's displacement into the
            mean of the headings before and after it, "engine" records the engine's own pose, which Euler's rule moves
            along the heading before the step. "midpoint" needs the integrator "Euler" and a friction_damping.
        servo_stiffness: what part of a free wheel's speed error its servo may take out in a step, at most; stable
            below 2 in theory, 1.5 in practice.
        tolerance: of the solver.
        settle_time: standing still before time zero, until the robot rests on its contacts [s]; balanced contacts need
            none.

    Raises:
        InvalidValue, InvalidType, UnknownName: a field is out of its range; the message names it.

    Example:
        >>> Physics(timestep=0.001).friction_damping
        1.0
    """

    timestep: float = 0.002
    integrator: Integrator = "Euler"
    cone: Cone = "elliptic"
    contact_stiffness: float = 0.5
    contact_damping: float = 1.0
    contact_impedance: tuple[float, float] = (0.9999, 0.9999)
    balanced_contacts: bool = True
    friction_impedance: float = 10.0
    friction_damping: float | None = 1.0
    truth: Truth = "midpoint"
    servo_stiffness: float = 0.5
    tolerance: float = 1e-10
    settle_time: float = 0.0
    wheel_shape: InitVar[Any] = None  # a former field

    def __post_init__(self, wheel_shape: Any) -> None:
        if wheel_shape is not None:
            raise InvalidType(
                f"Physics(wheel_shape={shown(wheel_shape)}) is now the robot's, "
                f"Robot(tyres=Tyres(shape={shown(wheel_shape)}))"
            )
        if checks.positive("Physics.timestep", self.timestep) > COARSEST_STEP:
            raise InvalidValue(f"Physics.timestep = {self.timestep:g} s: must be at most {COARSEST_STEP:g} s")
        checks.member("Physics.integrator", self.integrator, ("Euler", "RK4", "implicit", "implicitfast", "discrete"))
        checks.member("Physics.cone", self.cone, ("elliptic", "pyramidal"))
        checks.member("Physics.truth", self.truth, ("midpoint", "engine"))
        for field in ("contact_stiffness", "contact_damping"):
            if checks.positive(f"Physics.{field}", getattr(self, field)) > 1:
                raise InvalidValue(f"Physics.{field} = {getattr(self, field):g}: must be at most 1, or contacts bounce")
        low, high = checks.vector("Physics.contact_impedance", self.contact_impedance, 2).tolist()
        if not 0 < low <= high < 1:
            raise InvalidValue(f"Physics.contact_impedance = ({low:g}, {high:g}): must be 0 < touching <= deep < 1")
        object.__setattr__(self, "contact_impedance", (low, high))
        checks.boolean("Physics.balanced_contacts", self.balanced_contacts)
        checks.positive("Physics.friction_impedance", self.friction_impedance)
        self._check_damping()
        stiffness = checks.positive("Physics.servo_stiffness", self.servo_stiffness)
        if stiffness > 1.5:
            raise InvalidValue(
                f"Physics.servo_stiffness = {stiffness:g}: must be at most 1.5, or a free wheel diverges"
            )
        checks.positive("Physics.tolerance", self.tolerance)
        checks.not_negative("Physics.settle_time", self.settle_time)

    def _check_damping(self) -> None:
        if self.friction_damping is not None:
            damping = checks.positive("Physics.friction_damping", self.friction_damping)
            if damping >= 2:
                raise InvalidValue(
                    f"Physics.friction_damping = {damping:g}: must be below 2, where slip never dies out"
                )
        if self.truth == "midpoint" and (self.integrator != "Euler" or self.friction_damping is None):
            raise InvalidValue(
                f"Physics.truth = 'midpoint' with integrator = {self.integrator!r} and friction_damping = "
                f"{self.friction_damping}: needs 'Euler' and a number; truth='engine' takes any"
            )

    @property
    def coarse(self) -> str:
        """What steps that are too coarse for the promised floor cost, in words; empty for fine ones."""
        if self.timestep <= FINE_STEP:
            return ""
        floor = FLOOR_AT_FINE_STEP * (self.timestep / FINE_STEP) ** 2
        return (
            f"Physics.timestep = {self.timestep:g} s is coarse: expect {floor:.2g} ppm of the distance from physics "
            f"alone, against 1 ppm up to {FINE_STEP:g} s"
        )

    @property
    def slip_limit(self) -> float:
        """How fast a wheel may slide on a floor of friction 1 before its own friction throws it up [m/s].

        It is (1 - contact_impedance) 9.81 m/s^2 timestep / friction_damping. Friction is solved as a convex problem, in
        which a wheel that slides is to rise by friction x the slip that is to be taken out; up to here it only leans
        less on its contact's spring.
        """
        damping = self.contact_damping if self.friction_damping is None else self.friction_damping
        return (1 - self.contact_impedance[0]) * GRAVITY * self.timestep / damping

    @classmethod
    def fast(cls) -> Physics:
        """Steps of 5 ms: more than twice as fast, within 0.5 ppm of the distance on the standard maneuvers.

        Example:
            >>> Physics.fast().timestep
            0.005
        """
        return cls(timestep=0.005)

    @classmethod
    def sliding(cls) -> Physics:
        """For worlds in which wheels slide for long: a sliding wheel is not thrown up by its own friction cone.

        The price is creep in turns, to the outside by 9.5 times the angle of a step, which leaves 0.1 to 0.8 % of the
        distance on arcs, so that no one setting serves both.

        Example:
            >>> Physics.sliding().friction_damping
            0.1
        """
        return cls(
            contact_stiffness=1 / 9,
            contact_damping=2 / 3,
            friction_impedance=1.0,
            friction_damping=0.1,
            truth="engine",
        )

    @classmethod
    def skidding(cls, timestep: float = 0.002) -> Physics:
        """For robots with skid steer, whose wheels slide in every turn: contacts soft enough to keep them on the floor.

        Friction has its whole size from 1 mm/s of slip on, at every time step, and a wheel stays on the floor up to
        `slip_limit`. The price is a force that follows the direction of a slip 6 ms late.

        Args:
            timestep: [s]; from 5 ms on a start or a stop already makes the wheels slide.

        Example:
            >>> Physics.skidding(0.001).slip_limit
            2.0
        """
        softness = 0.97
        return cls(
            timestep=timestep,
            contact_stiffness=0.06,
            contact_damping=0.4,
            contact_impedance=(1 - softness, 1 - softness),
            friction_impedance=2000.0,
            friction_damping=softness * GRAVITY * timestep / 2.0,
            truth="engine",
        )

    @classmethod
    def mujoco_defaults(cls) -> Physics:
        """What a model gets that leaves every choice to habit: default contacts, `implicitfast`.

        Such a model's wheels are cylinders too: `Tyres(shape="cylinder")`.

        Example:
            >>> Physics.mujoco_defaults().integrator
            'implicitfast'
        """
        return cls(
            integrator="implicitfast",
            cone="pyramidal",
            contact_stiffness=0.01,
            contact_damping=0.2,
            contact_impedance=(0.9, 0.95),
            balanced_contacts=False,
            friction_impedance=1.0,
            friction_damping=None,
            truth="engine",
            tolerance=1e-8,
            settle_time=0.3,
        )
