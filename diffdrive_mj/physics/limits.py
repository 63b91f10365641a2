"""How far a robot can go before it slides or tips: accelerations, drives, slopes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.physics import skidding
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.robot import Robot
from diffdrive_mj.terrain import Slope
from diffdrive_mj.world import World

# A friction with which nothing slides before it tips over.
_STICKY = 1e6


def largest_acceleration(
    robot: Robot,
    world: World = World(),  # noqa: B008
    heading: float = 0.0,
) -> float:
    """Return up to which acceleration [m/s^2] no wheel slides and no contact lifts on a straight line, either way.

    Args:
        robot: the true robot.
        world: its friction, gravity and slope.
        heading: [rad], which matters on a slope.

    Returns:
        0 where the robot cannot even stand.

    Example:
        >>> robot = Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> print(f"{largest_acceleration(robot):.2f} m/s^2")
        4.96 m/s^2
    """
    checks.instance("world", world, World)
    rest, pushed = (
        contact_forces(robot, acceleration=(a, 0.0), world=world, heading=checks.number("heading", heading))
        for a in (0.0, 1.0)
    )
    ways = np.array([[1.0], [-1.0]])
    load, along = ways * (pushed.load - rest.load), ways * (pushed.along - rest.along)  # at a = 1, forward and back
    lifts = np.divide(rest.load, -load, out=np.full_like(load, np.inf), where=load < 0)
    # A wheel slides where (along + a along')^2 + (across / 2)^2 = friction^2 (load + a load')^2.
    have, use = world.friction * rest.load[:2], world.friction * load[:, :2]
    free = have**2 - rest.along**2 - (rest.across / 2) ** 2
    half, square = rest.along * along - have * use, along**2 - use**2
    root = half + np.sqrt(np.maximum(half**2 + square * free, 0.0))
    slides = np.divide(free, root, out=np.full_like(root, np.inf), where=(root > 0) & (half**2 + square * free >= 0))
    return max(0.0, float(min(lifts.min(), slides.min())))


def needed_grip(
    robot: Robot,
    commands: Commands,
    world: World = World(),  # noqa: B008
    heading: float = 0.0,
) -> tuple[Array, float]:
    """Return what a drive asks of the contacts, if the wheels do as they are told.

    Args:
        robot: the true robot.
        commands: to be driven.
        world: its gravity and its slope.
        heading: at the start [rad], which matters on a slope.

    Returns:
        The largest coefficient of friction that each wheel needs (2,), and the smallest load of any contact, as a share
        of the weight.

    Example:
        >>> from diffdrive_mj import maneuvers
        >>> robot = Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> need, least = needed_grip(robot, maneuvers.straight(robot, speed=1.0, distance=3.0))
        >>> bool((need < 0.2).all() and least > 0.1)
        True
    """
    checks.instance("commands", commands, Commands)
    twists = np.pad(body_twist(commands.wheel_rates, robot), ((1, 1), (0, 0)))
    twists[-1] = twists[-2]
    mean, change = (twists[1:] + twists[:-1]) / 2, np.diff(twists, axis=0) / commands.period
    headings = heading + np.cumsum(twists[:-1, 1]) * commands.period
    forces = contact_forces(robot, mean, change, world, headings)
    share = float(forces.load.min() / (world.gravity * robot.mass))
    return np.max(forces.friction_need, axis=0), share


def steepest_slope(
    robot: Robot,
    world: World = World(),  # noqa: B008
    heading: ArrayLike = 0.0,
    friction: ArrayLike | None = None,
) -> Array:
    """Return up to which angle of a slope a robot stands there, its wheels held: no contact lifts and none slides.

    How much of the force across each wheel takes is open, so that they hold if they can share it:

    ```
    |F_y| <= sqrt((mu_l N_l)^2 - F_l^2) + sqrt((mu_r N_r)^2 - F_r^2)
    ```

    with what statics says of the loads N and of the forces F along each wheel.

    Args:
        robot: the true robot.
        world: its friction, and the direction in which its slope rises, x if it has none.
        heading: (...) [rad].
        friction: (..., 2), under the left and the right wheel; the world's without its patches if not given.

    Returns:
        (...) [rad].

    Example:
        Uphill, more of the weight is on the caster, which holds nothing:

        >>> print(steepest_slope(Robot.load("matched"), World(friction=0.5), [0.0, np.pi]))
        [0.2972 0.4359]
    """
    checks.instance("world", world, World)
    heading = checks.array("heading", heading)
    friction = np.full(2, world.friction) if friction is None else checks.array("friction", friction, 2)
    direction = 0.0 if world.slope is None else world.slope.direction
    if robot.skids:
        return skidding.steepest(robot, float(friction.min()), direction - heading)
    level = contact_forces(robot, world=world.replace(slope=None))
    half_way = contact_forces(
        robot, world=world.replace(slope=Slope(angle=math.pi / 4, direction=direction)), heading=heading
    )

    def stands(angle: Array) -> NDArray[np.bool_]:
        # Forces are linear in the components of gravity across the floor and along it.
        along, across = math.sqrt(2) * np.sin(angle), np.cos(angle) - np.sin(angle)
        load = across[..., None] * level.load + along[..., None] * half_way.load
        free = (friction * load[..., :2]) ** 2 - (along[..., None] * half_way.along) ** 2
        shared = np.abs(along * half_way.across) <= np.sqrt(np.maximum(free, 0.0)).sum(axis=-1)
        return (load > 0).all(axis=-1) & (free >= 0).all(axis=-1) & shared

    low, high = np.zeros(heading.shape), np.full(heading.shape, math.pi / 2)
    for _ in range(50):
        middle = (low + high) / 2
        holds = stands(middle)
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return low


def refuse_to_slide(robots: Sequence[Robot], world: World, headings: Array, friction: Array) -> None:
    """Refuse robots that cannot stand on the world's slope.

    Args:
        robots: true robots, N.
        world: with its slope.
        headings: (N,) [rad], at the start.
        friction: (N, 2), under their wheels.

    Raises:
        InvalidValue: one would slide or tip over; the message says how steep the slope may be.

    Example:
        >>> steep = World(friction=0.5, slope={"angle": 0.35})
        >>> refuse_to_slide([Robot.load("matched")], steep, np.array([0.0]), np.array([[0.5, 0.5]]))
        Traceback (most recent call last):
        diffdrive_mj.errors.InvalidValue: World.slope.angle = 0.35 rad: robot matched would slide down with ...
    """
    if world.slope is None or not world.slope.angle:
        return
    angle, around = world.slope.angle, np.linspace(-math.pi, math.pi, 721)
    for robot, heading, under in zip(robots, headings.tolist(), friction, strict=True):
        allowed = float(steepest_slope(robot, world, heading, under))
        if angle <= allowed:
            continue
        sticky = float(steepest_slope(robot, world, heading, np.full(2, _STICKY)))
        slides = angle < sticky  # it would stand if that were all
        most = steepest_slope(robot, world, around, under)
        raise InvalidValue(
            f"World.slope.angle = {angle:g} rad: robot {robot.name} would {'slide down' if slides else 'tip over'} "
            f"with friction {under.min():g} from a start heading of {heading:.4g} rad, where at most {allowed:.4g} rad "
            f"is allowed; {most.max():.4g} rad is at {around[most.argmax()]:.3g} rad: lower the slope, turn the robot "
            f"or {'raise World.friction' if slides else 'lower its centre of mass'}"
        )
