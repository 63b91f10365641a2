"""Drives that the report page replays: where a robot was, and where its odometry believed it to be."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import DiffdriveError, InvalidType, InvalidValue
from diffdrive_mj.recording import Recording
from diffdrive_mj.report._thinning import kept
from diffdrive_mj.robot import Robot

FILE = "replays.json"
# Of the samples of one drive, and of its beliefs.
MOST, MOST_BELIEFS = 400, 20
# Between samples a path may be off by this part of its extent, a heading by this much [rad], and an error by this part
# of the largest.
_PATH, _HEADING, _ERROR = 1e-4, 5e-3, 5e-3


@dataclass(frozen=True, eq=False)
class Replay:
    """Holds a drive for the report page, which replays it with a time slider.

    Args:
        title: what is driven, in a few words.
        t: (T,) [s], increasing.
        truth: (T, 3) [m, m, rad], the true poses; theta continuous, as in the beliefs.
        beliefs: by name, (T, 3) [m, m, rad] each: where an odometry believes the robot to be at the same times.
        robot: the true robot, whose outline is drawn.
        believed: by the same names the robots that are believed; the true one where none is given.

    Raises:
        InvalidType: not numbers, or not robots.
        InvalidValue: shapes that do not fit, values that are not finite, times that do not increase, no belief, more
            than 20 of them, or a believed robot without a belief.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> path = dd.odometry.integrate([(0, 0), (9, 10), (18, 20)], robot)
        >>> wrong = dd.odometry.integrate([(0, 0), (9, 10), (18, 20)], robot.replace(track_width=0.42))
        >>> dd.report.Replay("A bend", [0.0, 1.0, 2.0], path, {"track too wide": wrong}, robot)
        Replay('A bend': 3 samples, 2 s, track too wide)
    """

    title: str
    t: Array
    truth: Array
    beliefs: Mapping[str, Array]
    robot: Robot
    believed: Mapping[str, Robot] = field(default_factory=dict)

    def __post_init__(self) -> None:
        title = checks.string("Replay.title", self.title)
        t = checks.increasing(f"{title}: t", self.t)
        beliefs, believed = _named("beliefs", self.beliefs), _named("believed", self.believed)
        if not 0 < len(beliefs) <= MOST_BELIEFS:
            raise InvalidValue(f"{title}: {len(beliefs)} beliefs: must be 1 to {MOST_BELIEFS}")
        if strangers := sorted(believed.keys() - beliefs.keys()):
            raise InvalidValue(f"{title}: believed[{strangers[0]!r}] has no path in beliefs")
        checks.instance("Replay.robot", self.robot, Robot)
        robots = {name: checks.instance(f"believed[{name!r}]", robot, Robot) for name, robot in believed.items()}
        paths = {name: _poses(f"{title}: {name}", path, len(t)) for name, path in beliefs.items()}
        own = {"t": t.copy(), "truth": _poses(f"{title}: truth", self.truth, len(t)), "beliefs": paths}
        for name, value in {**own, "believed": robots}.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"Replay({self.title!r}: {len(self.t)} samples, {self.t[-1] - self.t[0]:g} s, {', '.join(self.beliefs)})"

    @classmethod
    def of(
        cls, title: str, driven: Recording[Any, Any] | Drive, believed: Mapping[str, Robot], robot: Robot | None = None
    ) -> Replay:
        """Make a replay of a recording or a drive, and of what some robots make of its wheel angles.

        Args:
            title: what is driven, in a few words.
            driven: a recording of one robot, or a drive.
            believed: robots by name.
            robot: the true one; that of the recording by default, and the first believed one of a drive.

        Returns:
            The replay, thinned to the samples that can be seen.

        Raises:
            InvalidType: neither a recording nor a drive, or not robots.
            InvalidValue: a recording of several robots, or no believed robot.

        Example:
            >>> robot = dd.Robot.load("mismatched")
            >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
            >>> dd.report.Replay.of("A metre", recording, {"equal wheels": dd.Robot.load("matched")})
            Replay('A metre': ... samples, 3.5 s, equal wheels)
        """
        checks.instance("driven", driven, Recording, Drive)
        robots = _named("believed", believed)
        for name, one in robots.items():
            checks.instance(f"believed[{name!r}]", one, Robot)
        if not robots:
            raise InvalidValue("believed is empty: must name a robot at least")
        if isinstance(driven, Recording):
            if isinstance(driven.robot, tuple):
                raise InvalidValue("driven is a recording of several robots: must be of one; recording.runs has each")
            t, true = driven.t, driven.robot
        else:
            t, true = driven.clock, next(iter(robots.values()))
        paths = {name: driven.odometry(one) for name, one in robots.items()}
        # A tracker's headings may be wrapped.
        return cls(title, t, se2.unwrapped(driven.truth), paths, true if robot is None else robot, robots).thinned()

    def errors(self, name: str) -> metrics.Drift:
        """Compute how far off a belief is along the drive.

        Args:
            name: of the belief.

        Returns:
            The errors at every sample.

        Raises:
            UnknownName: no belief of this name.

        Example:
            >>> still = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
            >>> beside = [(0.0, 0.0, 0.0), (0.3, 0.4, 0.0)]
            >>> made = dd.report.Replay("At rest", [0.0, 1.0], still, {"drifts": beside}, dd.Robot.load("matched"))
            >>> made.errors("drifts").final_position.item()
            0.5
        """
        return metrics.drift(self.truth, checks.one_of("belief", name, self.beliefs))

    def thinned(self, most: int = MOST) -> Replay:
        """Leave out the samples that nobody would miss: lines between the others pass them by less than is seen.

        Args:
            most: so many samples at most.

        Returns:
            A replay with the first and the last sample and those between that matter.

        Raises:
            InvalidValue: fewer than two samples.

        Example:
            >>> t = np.linspace(0.0, 1.0, 1001)
            >>> line = np.stack([t, 0 * t, 0 * t], axis=-1)
            >>> dd.report.Replay("A line", t, line, {"too short": 0.99 * line}, dd.Robot.load("matched")).thinned()
            Replay('A line': 2 samples, 1 s, too short)
        """
        curves, tolerances = [], []
        extent = max(float(np.ptp(path[:, :2], axis=0).max()) for path in (self.truth, *self.beliefs.values()))
        for path in (self.truth, *self.beliefs.values()):
            curves += [*path[:, :2].T, path[:, 2]]
            tolerances += [_PATH * extent] * 2 + [_HEADING]
        for drift in map(self.errors, self.beliefs):
            off, turned = drift.position_error, drift.heading_error
            # A heading error jumps at half a turn, where its sine and cosine do not.
            curves += [off, np.sin(turned), np.cos(turned)]
            tolerances += [_ERROR * float(off.max()), *[_ERROR * float(np.abs(turned).max())] * 2]
        # Where nothing moves or nothing is off, nothing differs.
        limits = np.maximum(tolerances, 1e-15)
        chosen = kept(self.t, np.array(curves), limits, checks.whole("most", most, least=2))
        paths = {name: path[chosen] for name, path in self.beliefs.items()}
        return Replay(self.title, self.t[chosen], self.truth[chosen], paths, self.robot, self.believed)


def _named(name: str, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise InvalidType(f"{name}: must be a mapping by name")
    return {checks.string(f"a name of {name}", key): item for key, item in value.items()}


def _poses(name: str, value: ArrayLike, samples: int) -> Array:
    poses = checks.array(name, value, 3)
    if poses.shape != (samples, 3):
        raise InvalidValue(f"{name} has shape {poses.shape}: must be ({samples}, 3), as t has {samples} times")
    return poses.copy()


def to_json(replays: Iterable[Replay]) -> str:
    """Write replays as the text of a file, thinned, every number in full.

    Args:
        replays: of one experiment.

    Example:
        >>> print(to_json([]), end="")
        {"replays": []}
    """
    return json.dumps({"replays": [_content(replay.thinned()) for replay in replays]}) + "\n"


def _content(replay: Replay) -> dict[str, Any]:
    return {
        "title": replay.title,
        "t": replay.t.tolist(),
        "truth": replay.truth.tolist(),
        "beliefs": {name: path.tolist() for name, path in replay.beliefs.items()},
        "robot": _sizes(replay.robot),
        "believed": {name: _sizes(robot) for name, robot in replay.believed.items()},
    }


def _sizes(robot: Robot) -> dict[str, Any]:
    """What of a robot is drawn."""
    return {
        **{name: getattr(robot, name) for name in ("left_radius", "right_radius", "track_width")},
        "tyres": {"width": robot.tyres.width},
        "caster": {"x": robot.caster.x, "radius": robot.caster.radius},
    }


def from_json(text: str) -> list[Replay]:
    """Read replays from the text of a file.

    Args:
        text: as `to_json` writes it.

    Raises:
        InvalidValue: not such a text, or values that a replay does not take.
        InvalidType: values of other kinds than a replay takes.

    Example:
        >>> from_json('{"replays": []}')
        []
    """
    try:
        items = json.loads(text)["replays"]
        read = [(item, _robot(item["robot"]), _named("believed", item["believed"])) for item in items]
        return [
            Replay(
                item["title"],
                item["t"],
                item["truth"],
                item["beliefs"],
                robot,
                {name: _robot(sizes) for name, sizes in robots.items()},
            )
            for item, robot, robots in read
        ]
    except DiffdriveError:
        raise
    except (json.JSONDecodeError, RecursionError):
        raise InvalidValue("half written, or no JSON") from None
    except (ValueError, TypeError, KeyError):
        raise InvalidValue("not a file of replays") from None


def _robot(sizes: dict[str, Any]) -> Robot:
    return Robot(**_named("robot", sizes))
