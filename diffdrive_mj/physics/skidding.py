"""How a robot with skid steer turns: its wheels slide, and the friction under them decides by how much it does.

The wheel at (x_i, y_i), whose tread moves back at the ground speed s of its side, slides over the floor by

    u_i = (v_x - omega y_i - s, v_y + omega x_i)

while the robot's middle moves with (v_x, v_y) and the robot turns with omega. Friction pulls at it by mu N_i against
u_i. In a steady turn these forces carry the mass around it:

    -mu sum N_i u_i / |u_i| = M a,    -mu sum N_i p_i x u_i / |u_i| = M c x a

with the centre of mass c and a = omega x (v + omega x c). The four wheels sink alike, so that the loads N_i are a
linear function of the place; their moments balance the weight and the inertia of what is above the floor.

Slowly (a = 0) neither mu nor speed is left in it: the same turn for every floor. With the centre of mass in the middle
all wheels then slide equally fast, each at right angles to its place seen from the middle, and the moment balance is
the closed form of `Robot.effective_track`. With the weight so far ahead that N_front / N_rear is
sqrt(1 + 4 (wheelbase / b)^2) or more, the front wheels stop sliding: they roll as a differential drive's, and the rear
ones drag behind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import GRAVITY

# Below which share of the wheels' difference of speed friction fades out, from step to step of the solution; a wheel
# that hardly slides would have no direction otherwise.
_FADING = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)


@dataclass(frozen=True)
class SkidTurn:
    """Say how a robot with skid steer turns: as a differential drive of another track, whose axle lies elsewhere.

    ```
    omega = (s_right - s_left) / effective_track
    v_x = (s_left + s_right) / 2 + omega axle_y
    v_y = -omega axle_x
    ```

    of the middle between the wheels, with the ground speeds s = wheel rate x radius. The centres about which the treads
    turn are half an effective track to the left and right of that axle, and the efficiency of the steering is the track
    over the effective track.

    References:
        Mandow et al. 2007, who measure these centres.

    Attributes:
        effective_track: [m].
        axle_x: forward of the middle [m]; the point there moves straight ahead.
        axle_y: to the left of the middle [m].

    Example:
        >>> print(SkidTurn(1.03, 0.0, 0.0))
        effective track 1.0300 m, axle at x = 0.0000 m, y = 0.0000 m
    """

    effective_track: float
    axle_x: float
    axle_y: float

    def __str__(self) -> str:
        """One line."""
        x, y = round(self.axle_x, 4) + 0.0, round(self.axle_y, 4) + 0.0  # no minus zero
        return f"effective track {self.effective_track:.4f} m, axle at x = {x:.4f} m, y = {y:.4f} m"


def skid_turn(robot: Robot, wheel_rates: ArrayLike = (-0.1, 0.1), *, friction: float = 1.0) -> SkidTurn:
    """Work out from the balance of forces how a robot with skid steer turns, without simulating it.

    Args:
        robot: with skid steer.
        wheel_rates: (2,) [rad/s], of the left and the right wheels, which differ; slow ones by default, whose turn does
            not depend on speed and friction.
        friction: coefficient of the floor.

    Returns:
        Its steady turn.

    Raises:
        InvalidValue: a robot without skid steer, wheels that do not turn it, or a turn that friction does not hold
            or that lifts a wheel.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> print(skid_turn(robot))
        effective track 1.0263 m, axle at x = 0.0000 m, y = 0.0000 m
        >>> print(skid_turn(robot.replace(center_of_mass_x=0.1)))
        effective track 0.7358 m, axle at x = 0.2035 m, y = 0.0000 m
    """
    speeds = checks.vector("wheel_rates", wheel_rates, 2) * (robot.left_radius, robot.right_radius)
    mu = checks.positive("friction", friction)
    difference, middle = float(speeds[1] - speeds[0]), float(speeds.mean())
    size = abs(difference)
    places, along = wheel_places(robot), np.array([*speeds, *speeds])
    if not difference:
        raise InvalidValue("wheel_rates: both sides are equally fast, which turns no robot")
    masses, heights, at = _mass_points(robot)
    mass = float(masses.sum())

    def carried(motion: Array) -> tuple[Array, Array, Array]:
        """The middle's velocity (3,), what carries each mass around the turn (6, 2), and the wheels' loads (4,)."""
        velocity = motion * (difference, difference, difference / robot.track_width) + (middle, 0, 0)
        v_x, v_y, omega = velocity
        held = masses[:, None] * omega * np.stack([-v_y - omega * at[:, 0], v_x - omega * at[:, 1]], axis=-1)
        weighed = (masses @ at * GRAVITY - heights @ held) / (mass * GRAVITY)
        return velocity, held, _loads(places, mass, weighed)

    def unbalanced(motion: Array, fading: float) -> Array:
        (v_x, v_y, omega), held, loads = carried(motion)
        slip = np.stack([v_x - omega * places[:, 1] - along, v_y + omega * places[:, 0]], axis=-1) / size
        pull = -mu * loads[:, None] * slip / np.sqrt((slip**2).sum(-1) + fading**2)[:, None]
        moment = _moment(places, pull) - _moment(at, held)
        return np.array([*(pull.sum(axis=0) - held.sum(axis=0)), moment / robot.track_width]) / (mu * mass * GRAVITY)

    found = np.array([0.0, 0.0, robot.track_width / robot.effective_track])
    for fading in _FADING:
        found = least_squares(unbalanced, found, "3-point", args=(fading,), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    _, _, loads = carried(found)
    turn = f"wheel_rates = {checks.vector('wheel_rates', wheel_rates, 2)} rad/s, friction = {mu:g}"
    if np.abs(unbalanced(found, _FADING[-1])).max() > 1e-4:
        raise InvalidValue(f"{turn}: no steady turn of robot {robot.name} balances; turn more slowly")
    if loads.min() <= 0:
        raise InvalidValue(f"{turn}: lifts a wheel of robot {robot.name} off the floor; turn more slowly")
    v_x, v_y, omega = found * (difference, difference, difference / robot.track_width)
    return SkidTurn(difference / omega, -v_y / omega, v_x / omega)


def measured_turn(recording: Recording) -> SkidTurn:
    """Measure how a robot with skid steer has turned, from its wheels' angles beside the true poses.

    The mean over the recording, which should be one steady turn (`Recording.during`).

    Args:
        recording: of one robot.

    Raises:
        InvalidValue: the robot has not turned.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.1, yaw_rate=0.5))
        >>> print(f"{measured_turn(recording).effective_track:.2f} m")
        1.03 m
    """
    checks.instance("recording", recording, Recording)
    robot = checks.instance("recording.robot", recording.robot, Robot)
    rolled = (recording.wheel_angles[-1] - recording.wheel_angles[0]) * (robot.left_radius, robot.right_radius)
    moved = se2.log(se2.between(recording.truth[:-1], recording.truth[1:])).sum(axis=0)
    if abs(moved[2]) < 1e-9:
        raise InvalidValue("recording: the robot has not turned, so that nothing is known of its turns")
    return SkidTurn(
        float((rolled[1] - rolled[0]) / moved[2]),
        float(-moved[1] / moved[2]),
        float((moved[0] - rolled.mean()) / moved[2]),
    )


def skid_acceleration(robot: Robot, friction: float = 1.0) -> float:
    """Return up to which acceleration [m/s^2] no wheel slides and none lifts on a straight line, either way.

    Args:
        robot: with skid steer.
        friction: coefficient of the floor.

    Raises:
        InvalidValue: a robot without skid steer.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> skid_acceleration(robot, friction=0.5)
        4.905
    """
    masses, heights, _ = _mass_points(robot)
    lifts = 2 * _wheelbase(robot) * float(wheel_loads(robot).min() / (masses @ heights))
    return min(checks.positive("friction", friction) * GRAVITY, lifts)


def wheel_places(robot: Robot) -> Array:
    """Return where the wheels touch the floor (4, 2) [m]: front left, front right, rear left, rear right.

    Args:
        robot: with skid steer.

    Raises:
        InvalidValue: a robot without.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> print(wheel_places(robot)[0])
        [0.255 0.285]
    """
    x, y = _wheelbase(robot) / 2, robot.track_width / 2
    return np.array([(x, y), (x, -y), (-x, y), (-x, -y)])


def wheel_loads(robot: Robot) -> Array:
    """Return what the wheels carry at rest (4,) [N], in the order of `wheel_places`.

    Three wheels would do: the four sink alike, so that the load is a linear function of the place.

    Args:
        robot: with skid steer.

    Raises:
        InvalidValue: a robot without.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> bool(np.isclose(wheel_loads(robot).sum(), 9.81 * robot.mass))
        True
    """
    places = wheel_places(robot)
    masses, _, at = _mass_points(robot)
    return _loads(places, float(masses.sum()), masses @ at / masses.sum())


def steepest(robot: Robot, friction: float, uphill: ArrayLike = 0.0) -> Array:
    """Return up to which angle of a slope the robot stands with held wheels (...) [rad]: none lifts, and none slides.

    ```
    tan = min(mu, min over the wheels of N / (M g h d))
    ```

    A slope moves the place where the weight acts downhill, by the height h of the centre of mass times its tangent: the
    friction, in proportion to the loads, acts there too, so that all wheels slide at once. A wheel with the load N on
    the level lifts where the share d, which it loses of that place's way, has used it up.

    Args:
        robot: with skid steer.
        friction: coefficient mu of the floor.
        uphill: (...) [rad], in which direction the floor rises, in the robot's axes.

    Raises:
        InvalidValue: a robot without, or friction that is not positive.

    Example:
        >>> robot = dd.Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> print(f"{np.tan(steepest(robot, 0.5)):.3f}")
        0.500
    """
    uphill, friction = checks.array("uphill", uphill), checks.positive("friction", friction)
    masses, heights, _ = _mass_points(robot)
    places = wheel_places(robot)
    downhill = -np.stack([np.cos(uphill), np.sin(uphill)], axis=-1)
    lost = -GRAVITY * float(masses @ heights) * (downhill / (places**2).sum(axis=0)) @ places.T
    lifts = np.divide(wheel_loads(robot), lost, out=np.full_like(lost, np.inf), where=lost > 0).min(axis=-1)
    angles: Array = np.arctan(np.minimum(friction, lifts))
    return angles


def _loads(places: Array, mass: float, center: Array) -> Array:
    """What the wheels carry (4,) [N] where the mass [kg] acts at a center (2,) [m]."""
    return mass * GRAVITY * (0.25 + places @ (center / (places**2).sum(axis=0)))


def _mass_points(robot: Robot) -> tuple[Array, Array, Array]:
    """Body, payload and the four wheels: masses (6,) [kg], heights (6,) [m], places (6, 2) [m]."""
    load, radii = robot.payload, [robot.left_radius, robot.right_radius] * 2
    masses = np.array([robot.body_mass, load.mass, *[robot.tyres.mass] * 4])
    heights = np.array([robot.center_of_mass_height, load.height, *radii])
    return masses, heights, np.array([(robot.center_of_mass_x, 0.0), (load.x, load.y), *wheel_places(robot)])


def _moment(places: Array, forces: Array) -> float:
    return float((places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]).sum())


def _wheelbase(robot: Robot) -> float:
    checks.instance("robot", robot, Robot)
    if not robot.skids:
        raise InvalidValue(f"robot {robot.name}: has no skid steer; give it one, as in skid_steer={{'wheelbase': 0.5}}")
    return robot.skid_steer.wheelbase
