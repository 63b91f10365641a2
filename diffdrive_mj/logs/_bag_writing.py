"""ROS 2 bags written: the wheels as a JointState, poses as a PoseStamped, or with their covariance as an Odometry."""

from __future__ import annotations

import heapq
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._covariances import in_space
from diffdrive_mj._extras import extra
from diffdrive_mj._files import made_whole
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs._bag import JOINTS, check_ending
from diffdrive_mj.logs._format import Contents, Save
from diffdrive_mj.logs._planar import spatial
from diffdrive_mj.logs.topics import Topics
from diffdrive_mj.pose_log import PoseLog

Message = tuple[int, str, Any]
_POSE, _ODOMETRY = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"
# The seconds of a stamp have 31 bits.
_LATEST = 2**31


def save(storage: Literal["mcap", "sqlite3"], folder: bool) -> Save:
    """What writes bags of a storage, in a folder with its metadata or as the file alone."""

    def write(path: Path, contents: Contents, options: Topics | None) -> None:
        check_ending(path)
        with extra("ros", "rosbags", f"{path}: a ROS 2 bag"):
            from rosbags.rosbag2 import StoragePlugin, Writer
            from rosbags.typesys import Stores, get_typestore
        messages = _Messages(path, contents, options, get_typestore(Stores.LATEST))
        with made_whole(path, folder=folder) as new:
            bag = new if folder else new.with_name("bag")
            with _disk(path), Writer(bag, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
                topics = {
                    topic: writer.add_connection(topic, kind, typestore=messages.store)
                    for topic, kind in messages.kinds.items()
                }
                for stamp, topic, message in messages:
                    kind = messages.kinds[topic]
                    writer.write(topics[topic], stamp, messages.store.serialize_cdr(message, kind))
            if not folder:
                next(file for file in bag.iterdir() if file.suffix != ".yaml").replace(new)

    return write


@contextmanager
def _disk(path: Path) -> Iterator[None]:
    """Errors of a database, such as a full disk, in one line."""
    try:
        yield
    except sqlite3.Error as error:
        raise InvalidValue(f"{path}: cannot be written ({error})") from None


class _Messages:
    """The messages that a log becomes, in the order of their stamps."""

    def __init__(self, path: Path, contents: Contents, options: Topics | None, store: Any) -> None:
        self.store = store
        self.kinds: dict[str, str] = {}
        self._of: list[Iterator[Message]] = []
        name = {field: getattr(options, field, None) for field in (
            "wheels", "left", "right", "poses", "frame", "child_frame"
        )}  # fmt: skip
        if contents.wheels is not None:
            topic = name["wheels"] or "/joint_states"
            joints = [name["left"] or "left_wheel_joint", name["right"] or "right_wheel_joint"]
            self.kinds[topic] = JOINTS
            stamps = _stamps(contents.wheels.t, path)
            self._of.append(self._wheels(topic, stamps, contents.wheels.angles, joints))
        if contents.poses is not None:
            log = contents.poses
            stated = log.covariance is not None
            topic = name["poses"] or ("/ground_truth" if contents.wheels else "/odom" if stated else "/pose")
            if topic in self.kinds:
                raise InvalidValue(f"Topics.wheels and Topics.poses are both {topic!r}: must differ")
            self.kinds[topic] = _ODOMETRY if stated else _POSE
            stamps = _stamps(log.t, path)
            if stated:
                frames = name["frame"] or "odom", name["child_frame"] or "base_link"
                self._of.append(self._odometry(topic, stamps, log, frames))
            else:
                self._of.append(self._poses(topic, stamps, log.poses, name["frame"] or "map"))

    def __iter__(self) -> Iterator[Message]:
        return heapq.merge(*self._of, key=lambda message: message[0])

    def _header(self, stamp: int, frame: str) -> Any:
        types = self.store.types
        time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 1_000_000_000))
        return types["std_msgs/msg/Header"](time, frame)

    def _wheels(self, topic: str, stamps: NDArray[np.int64], angles: Array, joints: list[str]) -> Iterator[Message]:
        message, none = self.store.types[JOINTS], np.zeros(0)
        for stamp, both in zip(stamps.tolist(), angles, strict=True):
            yield stamp, topic, message(self._header(stamp, ""), joints, both, none, none)

    def _poses(self, topic: str, stamps: NDArray[np.int64], poses: Array, frame: str) -> Iterator[Message]:
        stamped = self.store.types[_POSE]
        for stamp, row in zip(stamps.tolist(), spatial(poses).tolist(), strict=True):
            yield stamp, topic, stamped(self._header(stamp, frame), self._pose(row))

    def _pose(self, row: list[float]) -> Any:
        types = self.store.types
        point, quaternion = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
        return types["geometry_msgs/msg/Pose"](point(*row[:3]), quaternion(*row[3:]))

    def _odometry(
        self, topic: str, stamps: NDArray[np.int64], log: PoseLog, frames: tuple[str, str]
    ) -> Iterator[Message]:
        """Poses with their covariance, and the twists between them; the twists' covariance is not known: zero."""
        types = self.store.types
        vector, twist = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Twist"]
        posed, moved = types["geometry_msgs/msg/PoseWithCovariance"], types["geometry_msgs/msg/TwistWithCovariance"]
        assert log.covariance is not None
        stated = in_space(log.covariance)
        poses = se2.unwrapped(log.poses)
        speeds = se2.log(se2.between(poses[:-1], poses[1:])) / np.diff(log.t)[:, None]
        rows = zip(stamps.tolist(), spatial(log.poses).tolist(), stated, [speeds[0], *speeds], strict=True)
        for stamp, row, covariance, (x, y, turn) in rows:
            yield (
                stamp,
                topic,
                types[_ODOMETRY](
                    self._header(stamp, frames[0]),
                    frames[1],
                    posed(self._pose(row), covariance),
                    moved(twist(vector(float(x), float(y), 0.0), vector(0.0, 0.0, float(turn))), np.zeros(36)),
                ),
            )


def _stamps(t: Array, path: Path) -> NDArray[np.int64]:
    """Times (T,) [s] in whole nanoseconds.

    Raises:
        InvalidValue: times that have no stamp, or that share one.
    """
    if t[0] < 0 or t[-1] >= _LATEST:
        raise InvalidValue(f"{path}: times from {t[0]:.10g} to {t[-1]:.10g} s: a bag's stamps are from 0 to 2^31 s")
    stamps = np.rint(t * 1e9).astype(np.int64)
    close = np.flatnonzero(np.diff(stamps) <= 0)
    if close.size:
        k = int(close[0])
        raise InvalidValue(f"{path}: {t[k]:.17g} and {t[k + 1]:.17g} s are one stamp in whole nanoseconds")
    return stamps
