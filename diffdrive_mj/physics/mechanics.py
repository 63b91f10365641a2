"""The forces on the contacts of a rigid robot that rolls: what each wheel carries, and what it needs of its friction.

With the mass M at c = (c_x, c_y, h), the axle's midpoint moving with (v, omega) and accelerating with (a, alpha), and
what falls freely accelerating with g, in the robot's axes:

    F_x = M (a - omega^2 c_x - alpha c_y - g_x)          along, both wheels together
    F_y = M (v omega + alpha c_x - omega^2 c_y - g_y)    to the left, both wheels together

The yaw moment about c decides how F_x is shared; the pitch and roll moments, with the wheels' spin, decide what each of
the three contacts carries. F_y is shared equally, since both wheels are held by one axle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World

_MASS_PER_VOLUME_OF_A_BODY = 350.0


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Hold what the floor does to a robot.

    Attributes:
        load: (..., 3) [N], carried by the left wheel, the right wheel and the caster.
        along: (..., 2) [N], on the left and the right wheel, forward.
        across: (...) [N], on both wheels together, to the left.

    Example:
        >>> print(ContactForces(np.array([10.0, 20.0, 5.0]), np.array([2.0, 3.0]), np.array(0.0)).friction_need)
        [0.2  0.15]
    """

    load: Array
    along: Array
    across: Array

    @property
    def pull(self) -> Array:
        """Size of the tangential force on each wheel (..., 2) [N], which share the force across."""
        return np.hypot(self.along, self.across[..., None] / 2)

    @property
    def friction_need(self) -> Array:
        """The coefficient of friction that each wheel needs (..., 2); infinite where it carries nothing."""
        load = self.load[..., :2]
        return np.divide(self.pull, load, out=np.full_like(self.pull, np.inf), where=load > 0)


def body_box(robot: Robot) -> Array:
    """Return length, width and height [m] of the box that stands for the body, from axle to caster.

    Args:
        robot: whose sizes and body mass decide.

    Example:
        >>> print(body_box(Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)))
        [0.2955 0.34   0.1138]
    """
    checks.instance("robot", robot, Robot)
    length = robot.mean_radius + (robot.skid_steer.wheelbase if robot.skids else abs(robot.caster.x))
    width = max(robot.track_width - 1.5 * robot.tyres.width, robot.track_width / 2)
    height = min(robot.body_mass / (_MASS_PER_VOLUME_OF_A_BODY * length * width), length)
    return np.array([length, width, height])


def box_lift(robot: Robot) -> float:
    """Return how far the middle of that box is above the axle [m]: enough to keep it well above the floor.

    Args:
        robot: whose sizes and body mass decide.

    Example:
        >>> box_lift(Robot(left_radius=0.1, right_radius=0.1, track_width=0.4))
        0.03
    """
    thickness = float(body_box(robot)[2])
    return max(0.3 * robot.mean_radius, thickness / 2 - 0.8 * robot.mean_radius)


def box_inertia(mass: float, box: Array) -> Array:
    """Return the principal moments of inertia (3,) [kg m^2] of a uniform box.

    ```
    I_x = m / 12 (b^2 + c^2)
    ```

    and likewise about the other axes.

    Args:
        mass: m [kg].
        box: (3,) [m], its sides a, b, c.

    Example:
        >>> print(box_inertia(12.0, np.array([1.0, 2.0, 3.0])))
        [13. 10.  5.]
    """
    squared = checks.array("box", box, 3) ** 2
    return checks.not_negative("mass", mass) / 12 * (squared.sum() - squared)


def gravity(world: World) -> Array:
    """Return the acceleration of what falls freely, in the world's axes, two of which lie in the floor (3,) [m/s^2].

    ```
    g (-sin(a) cos(d), -sin(a) sin(d), -cos(a))
    ```

    with the slope's angle a and the direction d in which it rises.

    Args:
        world: its gravity and its slope.

    Example:
        >>> print(gravity(World()))
        [ 0.    0.   -9.81]
    """
    checks.instance("world", world, World)
    angle, direction = (0.0, 0.0) if world.slope is None else (world.slope.angle, world.slope.direction)
    along = -np.sin(angle) * np.array([np.cos(direction), np.sin(direction)])
    return world.gravity * np.array([*(along + 0.0), -np.cos(angle)])


def contact_forces(
    robot: Robot,
    twist: ArrayLike = (0.0, 0.0),
    acceleration: ArrayLike = (0.0, 0.0),
    world: World = World(),  # noqa: B008
    heading: ArrayLike = 0.0,
) -> ContactForces:
    """Return the forces on the contacts of a robot whose wheels roll.

    Args:
        robot: the true robot.
        twist: (..., 2) [m/s, rad/s], of the axle's midpoint.
        acceleration: (..., 2) [m/s^2, rad/s^2], its rate of change.
        world: its gravity and its slope.
        heading: (...) [rad], which matters on a slope.

    Returns:
        The forces; at rest those of the weight alone.

    Example:
        >>> robot = Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> load = contact_forces(robot).load
        >>> bool(np.isclose(load[0], load[1]) and (load > 0).all())
        True
    """
    if checks.instance("robot", robot, Robot).skids:
        raise InvalidValue(
            f"robot {robot.name}: has skid steer, whose wheels do not roll: it takes no rolling resistance, soft tyres "
            "or drives that must roll; physics.skidding has its forces"
        )
    twist, acceleration = checks.array("twist", twist, 2), checks.array("acceleration", acceleration, 2)
    heading = checks.array("heading", heading)
    checks.broadcast(twist=twist[..., 0], acceleration=acceleration[..., 0], heading=heading)
    g_x, g_y, g_z = gravity(world)
    cos, sin = np.cos(heading), np.sin(heading)
    v, omega = twist[..., 0], twist[..., 1]
    a, alpha = acceleration[..., 0], acceleration[..., 1]
    masses, places = _mass_points(robot)
    mass = masses.sum()
    center = masses @ places / mass
    c_x, c_y, h = center
    x, y, z = (places - center).T
    yaw_inertia = masses @ (x**2 + y**2) + box_inertia(robot.body_mass, body_box(robot))[2]
    yaw_inertia += 2 * robot.tyres.mass * robot.tyres.width**2 / 12
    yaw_inertia += robot.tyres.mass * (robot.left_radius**2 + robot.right_radius**2) / 4
    xz, yz = masses @ (x * z), masses @ (y * z)

    at = resting_tilt(robot)
    half = at.track_width / 2
    along = mass * (a - omega**2 * c_x - alpha * c_y - (cos * g_x + sin * g_y))
    across = mass * (v * omega + alpha * c_x - omega**2 * c_y - (cos * g_y - sin * g_x))
    # I alpha = -c_x F_y - (half - c_y) F_l + (half + c_y) F_r
    right = (yaw_inertia * alpha + c_x * across + (half - c_y) * along) / (2 * half)
    left = along - right

    radii = np.array([at.left_radius, at.right_radius])
    rolling = np.stack([v - omega * half, v + omega * half], axis=-1) / radii
    speeding = np.stack([a - alpha * half, a + alpha * half], axis=-1) / radii
    spin = robot.tyres.mass * np.array([robot.left_radius, robot.right_radius]) ** 2 / 2
    # Moments about the centre of mass, of the loads alone: roll, pitch, and the weight that they add up to.
    roll = -omega * (rolling @ spin) - alpha * xz + omega**2 * yz - h * across
    pitch = -h * along - speeding @ spin + alpha * yz + omega**2 * xz
    weight = np.broadcast_to(-mass * g_z, roll.shape)
    caster_x, caster_y = caster_contact(robot)
    lever = np.array(
        [
            [half - c_y, -half - c_y, caster_y - c_y],
            [-c_x, -c_x, caster_x - c_x],
            [1.0, 1.0, 1.0],
        ]
    )
    load = np.linalg.solve(lever, np.stack(np.broadcast_arrays(roll, pitch, weight), axis=-1)[..., None])[..., 0]
    return ContactForces(load, np.stack(np.broadcast_arrays(left, right), axis=-1), across)


def resting_loads(robot: Robot, world: World = World()) -> Array:  # noqa: B008
    """Return what the left wheel, the right wheel and the caster carry at rest (3,) [N], on a world's floor.

    Args:
        robot: the true robot, its axle's tilt included.
        world: its gravity; on a slope the mean over all headings, which is what gravity across the floor makes of it.

    Raises:
        InvalidType: not a robot, or not a world.

    Example:
        >>> print(resting_loads(Robot.load("matched"), World(gravity=1.62)))
        [2.754 2.754 1.944]
    """
    if checks.instance("world", world, World).slope is not None:
        world = world.replace(gravity=-float(gravity(world)[2]), slope=None)
    return contact_forces(robot, world=world).load


def _mass_points(robot: Robot) -> tuple[Array, Array]:
    """Body, payload and wheels as masses (n,) [kg] at places (n, 3) [m] from the axle's midpoint on the floor."""
    at = resting_tilt(robot)
    c, s = np.cos(at.roll), np.sin(at.roll)
    height = at.height + at.offset * np.tan(at.roll)
    middle = at.offset / c
    rigid = robot.axle == "rigid"
    hubs = [
        (0.0, side * robot.track_width / 2 - middle, 0.0 if rigid else radius - height)
        for side, radius in ((1, robot.left_radius), (-1, robot.right_radius))
    ]
    load = robot.payload
    masses = np.array([robot.body_mass, load.mass, robot.tyres.mass, robot.tyres.mass])
    body = (robot.center_of_mass_x, 0.0, robot.center_of_mass_height - height)
    x, y, z = np.array([body, (load.x, load.y, load.height - height), *hubs]).T
    return masses, np.stack([x, y * c - z * s, y * s + z * c + height], axis=-1)


def fork_trail(robot: Robot) -> float:
    """Return how far behind its fork's axis a swivel caster touches the floor [m]; zero for a ball.

    Args:
        robot: its caster.

    Example:
        >>> round(fork_trail(Robot.load("matched").replace(caster={"kind": "swivel", "radius": 0.025})), 12)
        0.02
    """
    caster = robot.caster
    if caster.kind == "ball":
        return 0.0
    return 0.8 * caster.radius if caster.trail is None else caster.trail


def caster_contact(robot: Robot) -> tuple[float, float]:
    """Return where the caster touches the floor at the start, forward and left of the axle's midpoint [m].

    Args:
        robot: its caster and axle.

    Example:
        >>> caster_contact(Robot.load("matched"))
        (-0.2, 0.0)
    """
    at, trail = resting_tilt(robot), fork_trail(robot)
    height = at.height + at.offset * math.tan(at.roll)
    x, y = robot.caster.x - trail * math.cos(robot.caster.angle), -trail * math.sin(robot.caster.angle)
    z = (robot.caster.radius - height - y * math.sin(at.roll)) / math.cos(at.roll)
    return x, float(y * math.cos(at.roll) - z * math.sin(at.roll))
