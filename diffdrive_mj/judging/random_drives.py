"""Random robots and what they drive: cases that nobody has chosen.

Wheels of 20 to 250 mm that differ by up to a third, tracks of 80 mm to 1.2 m and masses of 0.3 to 80 kg, evenly over
their powers of ten; the other numbers lie around those that a robot of the size would have. They drive arcs forward and
in reverse, spins, pivots about one wheel, and slaloms, gently or not.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue, PhysicsWarning, RobotFell
from diffdrive_mj.judging.standards import residual
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.parts import Caster, Motor, Tyres
from diffdrive_mj.physics.limits import needed_grip
from diffdrive_mj.physics.model import static_loads
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics

LONGEST = 30.0  # [s]
# Mechanics is sure of a drive's grip if no wheel needs more friction, and no contact carries less of the weight.
MOST_FRICTION, LEAST_LOAD = 0.6, 0.02


@dataclass(frozen=True)
class Case:
    """Pair a robot with its drive.

    Attributes:
        robot: the true robot.
        kind: "arc", "reverse", "spin", "pivot" or "slalom".
        commands: computed for the robot with independent axles that rolls like it.

    Example:
        >>> case = random_cases(1, seed=0)[0]
        >>> case.kind in ("arc", "reverse", "spin", "pivot", "slalom")
        True
    """

    robot: Robot
    kind: str
    commands: Commands

    @property
    def keeps_grip(self) -> bool:
        """Whether mechanics says that the wheels roll and every contact stays on the floor."""
        need, load = needed_grip(self.robot, self.commands)
        return bool((need <= MOST_FRICTION).all() and load >= LEAST_LOAD)


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes:
        keeps_grip: whether mechanics says that it keeps its grip.
        position: largest position error of odometry with the true parameters [ppm of the distance].
        flagged: whether the recording says that a wheel slipped or left the floor, or the robot fell.

    Example:
        >>> Outcome(keeps_grip=True, position=0.02, flagged=False)
        Outcome(keeps_grip=True, position=0.02, flagged=False)
    """

    keeps_grip: bool
    position: float
    flagged: bool


def outcome(case: Case) -> Outcome:
    """Drive a case, and compare odometry with the true parameters with the physics at every time step.

    Every step, since what lower rates lose where the curvature varies between two samples is no fault of the physics.

    Args:
        case: the robot and its drive.

    Returns:
        What came of it.

    Example:
        >>> outcome(random_cases(1, seed=0)[0]).position < 1.0
        True
    """
    physics = Physics()
    try:
        with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
            recording = simulate(case.robot, case.commands, sample_rate=1 / physics.timestep)
    except RobotFell:
        return Outcome(case.keeps_grip, np.inf, flagged=True)
    left = residual(recording, level_twin(case.robot))
    return Outcome(case.keeps_grip, left.position, flagged=bool(recording.events))


def random_cases(count: int, seed: int) -> list[Case]:
    """Draw robots that can stand, and drives of at most half a minute.

    Args:
        count: how many.
        seed: of the randomness; each case has a stream of its own, so that more of them change none.

    Returns:
        The cases.

    Raises:
        InvalidValue, InvalidType: not whole numbers, none, or a negative seed.

    Example:
        >>> [case.kind for case in random_cases(3, seed=1)] == [case.kind for case in random_cases(5, seed=1)[:3]]
        True
    """
    streams = np.random.SeedSequence(checks.whole("seed", seed, least=0)).spawn(checks.whole("count", count))
    return [_case(np.random.default_rng(stream)) for stream in streams]


def _case(rng: np.random.Generator) -> Case:
    while True:
        try:
            robot = random_robot(rng)
            kind, commands = random_drive(rng, robot)
            static_loads(robot)
        except InvalidValue:  # it cannot stand
            continue
        if commands.duration <= LONGEST:
            return Case(robot, kind, commands)


def random_robot(rng: np.random.Generator) -> Robot:
    """Draw a robot; it may be one that cannot stand.

    Args:
        rng: the source of the randomness.

    Returns:
        A robot on independent axles or a rigid one.

    Example:
        >>> 0.02 <= random_robot(np.random.default_rng(0)).left_radius <= 0.25
        True
    """
    left = _log_uniform(rng, 0.02, 0.25)
    right = left * rng.uniform(0.75, 1.33)
    track, mass = _log_uniform(rng, 0.08, 1.2), _log_uniform(rng, 0.3, 80.0)
    radius = (left + right) / 2
    caster_x, wheels = -track * rng.uniform(0.3, 0.7), rng.uniform(0.1, 0.3)
    return Robot(
        name="random",
        left_radius=left,
        right_radius=right,
        track_width=track,
        axle="independent" if rng.random() < 0.5 else "rigid",
        body_mass=mass * (1 - wheels / 2),
        center_of_mass_x=caster_x * rng.uniform(0.15, 0.6),
        center_of_mass_height=radius * rng.uniform(0.5, 1.2),
        tyres=Tyres(width=0.4 * radius, mass=mass * wheels / 4),
        caster=Caster(x=caster_x, radius=0.25 * radius),
        motor=Motor(rotor_inertia=0.2 * mass * radius**2 * rng.uniform(0.2, 1.5)),
    )


def random_drive(rng: np.random.Generator, robot: Robot) -> tuple[str, Commands]:
    """Draw a drive for a robot, from rest to rest.

    Args:
        rng: the source of the randomness.
        robot: the true robot; the commands are computed for its level twin.

    Returns:
        Its kind, "arc", "reverse", "spin", "pivot" or "slalom", and its commands.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> kind, commands = random_drive(np.random.default_rng(2), robot)
        >>> kind, commands.duration > 2.0
        ('slalom', True)
    """
    twin = level_twin(robot)
    kind = str(rng.choice(["arc", "reverse", "spin", "pivot", "slalom"]))
    ramp, duration, side = rng.uniform(0.1, 2.0), rng.uniform(2.0, 6.0), rng.choice([-1.0, 1.0])
    speed, yaw_rate = rng.uniform(0.1, 1.5), rng.uniform(0.3, 3.5)
    if kind in ("arc", "reverse"):
        length, radius = speed * duration, side * twin.track_width * _log_uniform(rng, 0.6, 20.0)
        legs = [[Segment(-length if kind == "reverse" else length, length / radius, duration)]]
    elif kind == "spin":
        legs = [[Segment(0.0, side * yaw_rate * duration, duration)]]
    elif kind == "pivot":
        angle = yaw_rate * duration
        legs = [[Segment(angle * twin.track_width / 2, side * angle, duration)]]
    else:
        radius, angle = twin.track_width * _log_uniform(rng, 1.0, 10.0), rng.uniform(0.3, 1.5)
        bend = radius * angle
        legs = [[Segment(bend, angle, bend / speed)], [Segment(bend, -angle, bend / speed)]] * 2
    return kind, sequence(twin, legs, ramp=ramp)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
