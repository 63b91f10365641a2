"""A ROS 2 bag: what is in it, and its messages, each error in one line."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj._extras import extra
from diffdrive_mj._progress import progress
from diffdrive_mj.errors import DiffdriveError, InvalidValue
from diffdrive_mj.logs import _clocks
from diffdrive_mj.logs._planar import planar

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

JOINTS = "sensor_msgs/msg/JointState"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
POSES = (
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    TRANSFORMS,
)
# Those that have a covariance beside the pose.
STATED = ("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseWithCovarianceStamped")
# What a message is given to: the message, the bag's stamp [ns], and which of its topic's messages it is, from 1.
Handler = Callable[[Any, int, int], None]
# How many messages are between two looks at the progress.
_STEP = 4096


class Stamped:
    """What messages of a topic said, one after the other, in little memory: stamps [ns], and numbers of one width.

    Args:
        path: of the bag.
        what: in it the messages say something of, such as the topic.
        width: how many numbers a message has.
        stamps: which count, "header" or "bag".
    """

    def __init__(self, path: Path, what: str, width: int, stamps: str = "header") -> None:
        self.path, self.what = path, what
        self._width, self._by_bag = width, stamps == "bag"
        # The bag's stamps until one of the headers is not zero, the headers' from there on.
        self._stamps, self._zero = array("q"), not self._by_bag
        self._numbers, self._message = array("d"), array("I")

    def __len__(self) -> int:
        return len(self._message)

    def add(self, stamp: Any, bag: int, message: int, numbers: Iterable[float]) -> None:
        """Keep what a message said, and which of the topic's messages it was, from 1."""
        header = stamp.sec * 1_000_000_000 + stamp.nanosec
        if self._zero and header:
            self._zero = False
            self._stamps = array("q", [0]) * len(self._stamps)
        self._stamps.append(bag if self._zero or self._by_bag else header)
        self._message.append(message)
        self._numbers.extend(numbers)

    @property
    def label(self) -> str:
        """How messages of ours call them."""
        return f"{self.path}, {self.what}"

    def at(self, k: int) -> str:
        """How messages of ours call a message of theirs."""
        return f"{self.label}, message {self._message[k]}"

    def values(self) -> Array:
        """The numbers (N, width)."""
        return np.frombuffer(self._numbers).reshape(-1, self._width)

    def poses(self, least: int = 2) -> tuple[Array, Array, tuple[str, ...]]:
        """Times (N,) [s], poses in the plane (N, 3) and what else there is beside them (N, 3 + more), and what to know.

        The numbers, of which those of `seven` come first, are let go.

        Raises:
            InvalidValue: a pose that is not on a floor, a clock that goes back, or fewer poses than the least.
        """
        t, said = self.times()
        numbers = self.values()
        poses, lost = planar(self.what, numbers[:, :7], self.at)
        values = np.concatenate([poses, numbers[:, 7:]], axis=1) if self._width > 7 else poses
        self._numbers = array("d")
        t, values, gaps = _clocks.settled(self.label, self.what, t, values, self.at, least)
        return t, values, (*said, *gaps, *lost)

    def last(self) -> Stamped:
        """The last message alone, whose time is of no account."""
        result = Stamped(self.path, self.what, self._width)
        result._stamps, result._message = self._stamps[-1:], self._message[-1:]
        result._numbers, result._zero = self._numbers[-self._width :], False
        return result

    def times(self) -> tuple[Array, tuple[str, ...]]:
        """The times (N,) [s], and what to know of them."""
        t = np.frombuffer(self._stamps, dtype=np.int64) / 1e9
        zero = f"{self.what}: the headers' stamps are all zero, those of the bag were taken"
        return t, (zero,) if self._zero else ()


def seven(position: Any, orientation: Any) -> tuple[float, ...]:
    """The numbers of a pose in space."""
    p, q = position, orientation
    return p.x, p.y, p.z, q.x, q.y, q.z, q.w


def check_ending(path: Path) -> None:
    """Refuse an ending in capitals, by which rosbags does not know a bag's file.

    Raises:
        InvalidValue: it is.
    """
    if path.suffix != path.suffix.lower() and not path.is_dir():
        raise InvalidValue(f"{path}: the ending of a bag must be in small letters, {path.suffix.lower()}")


@contextmanager
def opened(path: Path) -> Iterator[Reader]:
    """Open a bag.

    Raises:
        MissingExtra: rosbags is not installed.
        InvalidValue: it cannot be read.
    """
    check_ending(path)
    with extra("ros", "rosbags", f"{path}: a ROS 2 bag"):
        from rosbags.rosbag2 import Reader, ReaderError
    try:
        with Reader(path) as reader:
            yield reader
    except DiffdriveError:
        raise
    except Exception as error:  # whatever the parsers of four formats make of a file that is cut short or damaged
        # What a library says on purpose; what a parser stumbled over, such as a length beyond memory, helps nobody.
        said = str(error).partition("\n")[0].strip(" .") if isinstance(error, (ReaderError, OSError)) else "damaged"
        cure = "; `mcap recover` mends a file that was cut short" if path.suffix.lower() == ".mcap" else ""
        raise InvalidValue(f"{path}: cannot be read as a ROS 2 bag ({said}){cure}") from None


def topics(reader: Reader) -> dict[str, str]:
    """The types of the topics that have messages, by name."""
    return {connection.topic: connection.msgtype for connection in reader.connections if connection.msgcount}


def deliver(path: Path, reader: Reader, handlers: dict[str, Handler]) -> tuple[str, ...]:
    """Give every message of some topics to its handler.

    Returns:
        What to know of it: messages that the bag should have, and that could not be read.

    Raises:
        InvalidValue: a message that is not of its type, or none of a topic.
    """
    with extra("ros", "rosbags", f"{path}: a ROS 2 bag"):
        from rosbags.typesys import Stores, get_typestore
    deserialize = get_typestore(Stores.LATEST).deserialize_cdr
    connections = [connection for connection in reader.connections if connection.topic in handlers]
    numbers = dict.fromkeys(handlers, 0)
    with progress(f"reading {path.name}", sum(c.msgcount for c in connections), "messages") as advance:
        for k, (connection, stamp, raw) in enumerate(reader.messages(connections), 1):
            topic = connection.topic
            numbers[topic] = number = numbers[topic] + 1
            try:
                message = deserialize(raw, connection.msgtype)
            except Exception:  # as above
                raise InvalidValue(
                    f"{path}, {topic}, message {number}: its {len(raw)} bytes are no {connection.msgtype}"
                ) from None
            handlers[topic](message, stamp, number)
            if k % _STEP == 0:
                advance(_STEP)
    lost = []
    for topic, number in numbers.items():
        expected = sum(connection.msgcount for connection in connections if connection.topic == topic)
        if not number:
            raise InvalidValue(f"{path}, {topic}: none of its {expected} messages can be read: the bag is damaged")
        if number < expected:
            lost.append(f"{topic}: {number} of its {expected} messages can be read: the bag is damaged")
    return tuple(lost)
