"""Drives and poses from ROS 2 bags: rosbag2 folders, `.mcap` and `.db3`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj._text import listed
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.logs import _bag, _clocks
from diffdrive_mj.logs._bag import Stamped
from diffdrive_mj.logs._bag_writing import save
from diffdrive_mj.logs._format import Contents, Format, Wheels
from diffdrive_mj.logs._frames import Edge, Pair, chain, composed
from diffdrive_mj.logs._joints import Joints
from diffdrive_mj.logs._planar import planar
from diffdrive_mj.logs.topics import Topics
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot

Handler = Callable[[Any, int, int], None]


def _load(path: Path, options: Topics | None, robot: Robot | None, wheels: bool, poses: bool) -> Contents:
    names = options or Topics()
    joints: Joints | None = None
    seen: Stamped | _Transforms | None = None
    handlers: dict[str, Handler] = {}
    with _bag.opened(path) as reader:
        there = _bag.topics(reader)
        if wheels:
            topic = _topic("wheels", names.wheels, there, (_bag.JOINTS,), path)
            joints = Joints(f"{path}, {topic}", names.left, names.right, names.stamps)
            handlers[topic] = joints.add
        if poses:
            kinds = _bag.POSES if (names.frame, names.child_frame) == (None, None) else (_bag.TRANSFORMS,)
            topic = _topic("poses", names.poses, there, kinds, path)
            if there[topic] == _bag.TRANSFORMS:
                seen = _Transforms(path, names)
                handlers |= {name: seen.handler(name) for name in _transforms(topic, there)}
            else:
                seen = Stamped(f"{path}, {topic}", 7, names.stamps)
                handlers[topic] = _keep_poses(seen)
        _bag.deliver(path, reader, handlers)
    return Contents(
        None if joints is None else _wheels(joints, names),
        None if seen is None else seen.log() if isinstance(seen, _Transforms) else _log(seen, path),
    )


def _log(seen: Stamped, path: Path) -> PoseLog:
    t, poses, warnings = _clocked(seen)
    return PoseLog(t, poses, str(path), warnings)


def _topic(field: str, name: str | None, there: dict[str, str], kinds: tuple[str, ...], path: Path) -> str:
    """The topic that was named, or the only one of some types."""
    fit = [topic for topic, kind in there.items() if kind in kinds and not topic.endswith("tf_static")]
    wanted = listed([kind.replace("/msg/", "/") for kind in kinds])
    if name is not None:
        if name not in there:
            raise UnknownName(f"topic of {path}", name, there)
        if there[name] not in kinds:
            raise InvalidValue(f"{path}: {name} has {there[name].replace('/msg/', '/')}: must have {wanted}")
        return name
    if not fit:
        has = listed([f"{topic} ({kind.replace('/msg/', '/')})" for topic, kind in there.items()]) or "no messages"
        raise InvalidValue(f"{path}: no topic has {wanted}: there is {has}")
    if len(fit) > 1:
        raise InvalidValue(f"{path}: {listed(fit)} may have the {field}: name one, as in Topics({field}={fit[0]!r})")
    return fit[0]


def _transforms(topic: str, there: dict[str, str]) -> list[str]:
    """A topic of transforms, and the static ones."""
    static = [name for name, kind in there.items() if kind == _bag.TRANSFORMS and name.endswith("tf_static")]
    return list(dict.fromkeys([topic, *static]))


def _keep_poses(seen: Stamped) -> Handler:
    def handler(message: Any, stamp: int, number: int) -> None:
        pose = message.pose
        pose = getattr(pose, "pose", pose)  # one with a covariance has the pose in it
        seen.add(message.header.stamp, stamp, number, _seven(pose.position, pose.orientation))

    return handler


def _seven(p: Any, q: Any) -> tuple[float, ...]:
    return p.x, p.y, p.z, q.x, q.y, q.z, q.w


class _Transforms:
    """The transforms between frames, each pair of frames by itself."""

    def __init__(self, path: Path, names: Topics) -> None:
        self.path, self.names = path, names
        self.pairs: dict[Pair, Stamped] = {}
        self.static: dict[Pair, bool] = {}

    def handler(self, topic: str) -> Handler:
        """What keeps the messages of a topic."""
        static = topic.endswith("tf_static")

        def handler(message: Any, stamp: int, number: int) -> None:
            for each in message.transforms:
                pair = (each.header.frame_id, each.child_frame_id)
                if pair not in self.pairs:
                    self.pairs[pair] = Stamped(f"{self.path}, {topic}, {pair[0]} -> {pair[1]}", 7, self.names.stamps)
                    self.static[pair] = static
                numbers = _seven(each.transform.translation, each.transform.rotation)
                self.pairs[pair].add(each.header.stamp, stamp, number, numbers)

        return handler

    def log(self) -> PoseLog:
        """The poses of the child frame in the parent."""
        edges: list[Edge] = []
        warnings: list[str] = []
        for pair in chain(self.static, self.names.frame, self.names.child_frame, self.path):
            if self.static[pair]:
                # The last one counts: a static transform is published again where it was wrong.
                seen = self.pairs[pair].last()
                poses, said = planar(seen.label, seen.values(), seen.at)
                edges.append(Edge(np.zeros(1), poses))
            else:
                t, poses, said = _clocked(self.pairs[pair], least=1)
                edges.append(Edge(t, poses))
            warnings += said
        t, poses = composed(edges, self.path)
        return PoseLog(t, poses, str(self.path), tuple(warnings))


def _clocked(seen: Stamped, least: int = 2) -> tuple[Array, Array, tuple[str, ...]]:
    """Times, poses in the plane, and what to know of both."""
    t, said = seen.times()
    poses, lost = planar(seen.label, seen.values(), seen.at)
    t, poses, gaps = _clocks.settled(seen.label, t, poses, seen.at, least)
    return t, poses, (*said, *gaps, *lost)


def _wheels(joints: Joints, names: Topics) -> Wheels:
    seen = joints.seen()
    t, said = seen.times()
    angles = seen.values()
    finite = np.isfinite(angles).all(axis=1)
    if not finite.all():
        raise InvalidValue(f"{seen.at(int(np.argmin(finite)))}: a wheel's position is not finite")
    t, angles, gaps = _clocks.settled(seen.label, t, angles, seen.at)
    signs = np.where([names.reverse_left, names.reverse_right], -1.0, 1.0)
    return Wheels(t, angles * signs, (*said, *gaps))


def _is_folder(path: Path, head: bytes) -> bool:
    return path.is_dir() and (path / "metadata.yaml").exists()


FOLDER = Format(
    name="a rosbag2 folder", endings=("",), options=Topics, looks=_is_folder, load=_load, save=save("mcap", True)
)
MCAP = Format(
    name="an MCAP file",
    endings=(".mcap",),
    options=Topics,
    looks=lambda path, head: head.startswith(b"\x89MCAP0\r\n"),
    load=_load,
    save=save("mcap", False),
)
SQLITE = Format(
    name="a rosbag2 database",
    endings=(".db3",),
    options=Topics,
    looks=lambda path, head: head.startswith(b"SQLite format 3\0"),
    load=_load,
    save=save("sqlite3", False),
)
