"""Drives and poses from ROS 2 bags: rosbag2 folders, `.mcap` and `.db3`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from diffdrive_mj._covariances import in_plane
from diffdrive_mj._text import listed
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.logs import _bag, _clocks
from diffdrive_mj.logs._bag import Handler, Stamped
from diffdrive_mj.logs._bag_writing import save
from diffdrive_mj.logs._format import Contents, Format, Wheels
from diffdrive_mj.logs._frames import Transforms
from diffdrive_mj.logs._joints import Joints
from diffdrive_mj.logs._wheels import wrapped
from diffdrive_mj.logs.topics import Topics
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot


def _load(path: Path, options: Topics | None, robot: Robot | None, wheels: bool, poses: bool) -> Contents:
    names = options or Topics()
    handlers: dict[str, Handler] = {}
    joints: Joints | None = None
    posed: _Posed | None = None
    with _bag.opened(path) as reader:
        there = _bag.topics(reader)
        if wheels:
            topic = _topic("wheels", names.wheels, there, (_bag.JOINTS,), path)
            joints = Joints(path, topic, names.left, names.right, names.stamps)
            handlers[topic] = joints.add
        if poses:
            kinds = _bag.POSES if (names.frame, names.child_frame) == (None, None) else (_bag.TRANSFORMS,)
            topic = _topic("poses", names.poses, there, kinds, path)
            if there[topic] == _bag.TRANSFORMS:
                posed = transforms = Transforms(path, names.frame, names.child_frame, names.stamps)
                handlers |= {each: transforms.handler(each, _is_static(each)) for each in _with_static(topic, there)}
            else:
                posed = single = _Single(path, topic, names.stamps, there[topic] in _bag.STATED)
                handlers[topic] = single.add
        lost = _bag.deliver(path, reader, handlers)
    return Contents(
        None if joints is None else _wheels(joints, names, lost if posed is None else ()),
        None if posed is None else _log(posed, lost, taken=wheels and names.poses is names.child_frame is None),
    )


class _Posed(Protocol):
    """What has kept poses, and of what, once there is a log of them."""

    what: str

    def log(self) -> PoseLog: ...


class _Single:
    """Keeps the poses of a topic whose messages have one each, and their covariances if they have these too."""

    def __init__(self, path: Path, topic: str, stamps: str, stated: bool) -> None:
        self.what, self._stated = topic, stated
        self._seen = Stamped(path, topic, 16 if stated else 7, stamps)

    def add(self, message: Any, stamp: int, number: int) -> None:
        pose = message.pose.pose if self._stated else message.pose
        numbers = _bag.seven(pose.position, pose.orientation)
        if self._stated:
            numbers += (*in_plane(np.asarray(message.pose.covariance, dtype=np.float64)).ravel().tolist(),)
        self._seen.add(message.header.stamp, stamp, number, numbers)

    def log(self) -> PoseLog:
        t, values, warnings = self._seen.poses()
        log = PoseLog(t, values[:, :3], str(self._seen.path), warnings)
        covariance = values[:, 3:].reshape(-1, 3, 3)
        # All of it zero is what a message has when nobody has stated any.
        if not self._stated or not covariance.any():
            return log
        try:
            return replace(log, covariance=covariance)
        except InvalidValue as error:
            why = str(error).removeprefix(f"{log.name}: ")
            return replace(log, warnings=(*warnings, f"{self.what}: its covariance was left out ({why})"))


def _topic(field: str, name: str | None, there: dict[str, str], kinds: tuple[str, ...], path: Path) -> str:
    """The topic that was named, or the only one of some types."""
    fit = [topic for topic, kind in there.items() if kind in kinds and not _is_static(topic)]
    wanted = listed([kind.replace("/msg/", "/") for kind in kinds])
    if name is not None:
        if name not in there:
            raise UnknownName(f"topic of {path}", name, there)
        if there[name] not in kinds:
            raise InvalidValue(f"{path}: {name} has {there[name].replace('/msg/', '/')}: must have {wanted}")
        return name
    if not fit:
        has = listed([f"{topic} ({kind.replace('/msg/', '/')})" for topic, kind in there.items()])
        raise InvalidValue(f"{path}: no topic has {wanted}: there {f'is {has}' if has else 'are no messages'}")
    if len(fit) > 1:
        raise InvalidValue(f"{path}: {listed(fit)} may have the {field}: name one, as in Topics({field}={fit[0]!r})")
    return fit[0]


def _is_static(topic: str) -> bool:
    return topic.endswith("tf_static")


def _with_static(topic: str, there: dict[str, str]) -> list[str]:
    """A topic of transforms, and those of the static ones."""
    static = [name for name, kind in there.items() if kind == _bag.TRANSFORMS and _is_static(name)]
    return list(dict.fromkeys([topic, *static]))


def _log(posed: _Posed, lost: tuple[str, ...], taken: bool) -> PoseLog:
    """The poses that were kept; `taken` are those of a truth that nobody has named."""
    log = posed.log()
    if taken and "odom" in posed.what.lower():
        # Judged against itself, every odometry is right.
        lost += (f"{posed.what} was taken for the truth, and by its name is an odometry",)
    return replace(log, warnings=(*lost, *log.warnings))


def _wheels(joints: Joints, names: Topics, lost: tuple[str, ...]) -> Wheels:
    seen = joints.seen()
    t, said = seen.times()
    angles = seen.values()
    finite = np.isfinite(angles).all(axis=1)
    if not finite.all():
        raise InvalidValue(f"{seen.at(int(np.argmin(finite)))}: a wheel's position is not finite")
    t, angles, gaps = _clocks.settled(seen.label, seen.what, t, angles, seen.at)
    signs = np.where([names.reverse_left, names.reverse_right], -1.0, 1.0)
    return Wheels(t, angles * signs, (*lost, *said, *gaps, *wrapped(angles.T, "radians")))


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
