"""What a film shows: a recorded drive, and where each odometry believed the robot to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import one_line, shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.physics.mechanics import body_box, box_lift
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World

# More are hard to keep apart by their colours.
MOST_GHOSTS = 5
# Between true poses the robot is drawn on a straight line, which is no drive where they are this far apart [s].
_SPARSE = 1.0
Belief = Robot | ArrayLike
Believed = Robot | list[Robot] | tuple[Robot, ...] | Mapping[str, Belief]


@dataclass(frozen=True, eq=False)
class Take:
    """A drive with its ghosts, at the recorded times or at those of a film's frames.

    Attributes:
        robot: the true robot.
        world: as simulated.
        t: (T,) [s].
        truth: (T, 3) [m, m, rad], headings not wrapped.
        wheel_angles: (T, 2) [rad].
        ghosts: where each odometry believed the robot to be, by name: (T, 3) [m, m, rad].
        stance: (T, 5), the height of the axle's midpoint [m] and the body's attitude as a quaternion, w first; None
            where that was not recorded.
        fork: (T,) [rad], how far a swivel caster's fork has turned since the start, if that is known.
    """

    robot: Robot
    world: World
    t: Array
    truth: Array
    wheel_angles: Array
    ghosts: dict[str, Array]
    stance: Array | None = None
    fork: Array | None = None

    @classmethod
    def of(cls, recording: Recording | Drive, believed: Believed) -> Take:
        """The whole drive, refused where it is none that can be shown."""
        if isinstance(recording, Drive):
            return cls._measured(recording, believed)
        checks.instance("recording", recording, Recording, Drive)
        if isinstance(recording.robot, tuple):
            raise InvalidValue(
                f"recording has {len(recording.robot)} runs: a film shows one, such as recording.runs[0], "
                "or several beside each other, {'one': recording.runs[0], 'other': recording.runs[1]}"
            )
        samples = len(np.atleast_1d(recording.t))
        if samples < 2:
            raise InvalidValue(f"recording has {samples} sample{'s' * (samples != 1)}: a film needs two or more")
        t = checks.increasing("recording.t", recording.t)
        truth = checks.array("recording.truth", recording.truth, len(t), 3)
        angles = checks.array("recording.wheel_angles", recording.wheel_angles, len(t), 2)
        ghosts = _ghosts(_named(recording.robot, believed), recording.odometry, len(t))
        seen = recording.caster_angle
        fork = None if seen is None else seen - recording.robot.caster.angle
        return cls(recording.robot, recording.world, t, truth, angles, ghosts, _stance(recording), fork)

    @classmethod
    def _measured(cls, drive: Drive, believed: Believed) -> Take:
        """A drive of a log, at its true poses; its robot looks like the first that is believed."""
        apart = float(np.median(np.diff(drive.clock)))
        if apart > _SPARSE:
            raise InvalidValue(
                f"{drive.name}: true poses are {apart:.3g} s apart: a film needs them at least every {_SPARSE:g} s"
            )
        named = _named(None, believed)
        truth = se2.unwrapped(drive.truth)
        ghosts = _ghosts(named, drive.odometry, len(truth))
        robot = next((belief for belief in named.values() if isinstance(belief, Robot)), None)
        if robot is None:
            raise InvalidValue(
                f"believed: must name a Robot too, since {drive.name} does not say what its robot looks like"
            )
        return cls(robot, World(), drive.clock, truth, drive.angles_at(drive.clock), ghosts)

    def at(self, times: Array) -> Take:
        """The same drive between its samples."""

        def between(values: Array) -> Array:
            return np.stack([np.interp(times, self.t, column) for column in values.T], axis=-1)

        ghosts = {name: between(poses) for name, poses in self.ghosts.items()}
        stance = None if self.stance is None else between(self.stance)
        fork = None if self.fork is None else np.interp(times, self.t, self.fork)
        wheels = between(self.wheel_angles)
        return Take(self.robot, self.world, times, between(self.truth), wheels, ghosts, stance, fork)

    def moved(self, x: float, y: float) -> Take:
        """The same drive elsewhere on the floor; its world stays where it is."""
        by = np.array([x, y, 0.0])
        ghosts = {name: poses + by for name, poses in self.ghosts.items()}
        return replace(self, truth=self.truth + by, ghosts=ghosts)

    @property
    def apart(self) -> dict[str, Array]:
        """How far each ghost is from the robot (T,) [m]."""
        return {name: np.hypot(*(poses - self.truth)[:, :2].T) for name, poses in self.ghosts.items()}

    @property
    def travelled(self) -> Array:
        """How far the robot has driven (T,) [m]."""
        return metrics.travelled(self.truth)

    @property
    def speed_ratio(self) -> float | None:
        """Left rate / right rate, if it is the same along the whole drive."""
        left, right = (self.wheel_angles - self.wheel_angles[0]).T
        total = float(right @ right)
        if total == 0:
            return None
        ratio = float(left @ right) / total
        largest = float(max(np.abs(left).max(), np.abs(right).max()))
        return ratio if np.abs(left - ratio * right).max() <= 2e-3 * largest else None

    @property
    def size(self) -> float:
        """How large the robot is, from its middle to whatever is farthest out [m]."""
        robot = self.robot
        long = abs(robot.caster.x) + robot.caster.radius
        if robot.skids:
            long = robot.skid_steer.wheelbase / 2 + robot.mean_radius
        return float(np.hypot(max(long, robot.mean_radius), robot.track_width / 2 + robot.tyres.width))

    @property
    def height(self) -> float:
        """How high the robot is, its nose included [m]."""
        thickness = float(body_box(self.robot)[2])
        return self.robot.mean_radius + box_lift(self.robot) + 0.53 * thickness


def _stance(recording: Recording) -> Array | None:
    if recording.height is None or recording.attitude is None:
        return None
    # A quaternion and its negative are one attitude: the nearer one goes on, so that what is between them is too.
    turned = recording.attitude.copy()
    flips = np.where(np.einsum("tk,tk->t", turned[1:], turned[:-1]) < 0, -1.0, 1.0)
    turned[1:] *= np.cumprod(flips)[:, None]
    return np.concatenate([recording.height[:, None], turned], axis=-1)


def _ghosts(named: dict[str, Belief], odometry: Callable[[Robot], Array], samples: int) -> dict[str, Array]:
    """The poses of each belief by its name."""
    if not named:
        raise InvalidValue("believed is empty: must name at least one belief")
    if len(named) > MOST_GHOSTS:
        raise InvalidValue(f"believed has {len(named)} beliefs: at most {MOST_GHOSTS} can be distinguished in a film")
    return {
        name: odometry(belief) if isinstance(belief, Robot) else _given(name, belief, samples)
        for name, belief in named.items()
    }


def _named(true: Robot | None, believed: Believed) -> dict[str, Belief]:
    if isinstance(believed, Robot):
        return {
            "odometry"
            if true is None or believed.name == true.name
            else f"odometry ({one_line(believed.name)})": believed
        }
    if isinstance(believed, Mapping):
        return {one_line(checks.string("name of a belief", name)): belief for name, belief in believed.items()}
    if not isinstance(believed, list | tuple):
        raise InvalidType(
            f"believed = {shown(believed)}: must be a Robot, a list of them, or a mapping from names to robots or poses"
        )
    robots = checks.instances("believed", believed, Robot)
    names = [one_line(robot.name) for robot in robots]
    alone = [names.count(name) == 1 for name in names]
    return {name if once else f"{name} {k + 1}": robots[k] for k, (name, once) in enumerate(zip(names, alone))}  # noqa: B905


def _given(name: str, poses: ArrayLike, samples: int) -> Array:
    if isinstance(poses, str):
        checks.instance(f"believed[{name!r}]", poses, Robot)  # refuses it with its cure
    return se2.unwrapped(checks.array(f"believed[{name!r}]", poses, samples, 3))
