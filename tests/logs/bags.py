"""ROS 2 bags written by rosbags itself, message by message, and WPILib's data logs written byte by byte."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

rosbags = pytest.importorskip("rosbags.rosbag2", reason="needs the extra ros")
typesys = pytest.importorskip("rosbags.typesys")

STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
T = STORE.types
NONE = np.zeros(0)


def header(t=0.0, frame="map"):
    nanoseconds = round(t * 1e9)
    return T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9)), frame)


def pose(x=0.0, y=0.0, theta=0.0, z=0.0, q=None):
    qx, qy, qz, qw = (0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2)) if q is None else q
    point, quaternion = T["geometry_msgs/msg/Point"], T["geometry_msgs/msg/Quaternion"]
    return T["geometry_msgs/msg/Pose"](point(x, y, z), quaternion(qx, qy, qz, qw))


def joints(t, left, right, names=("left_wheel_joint", "right_wheel_joint"), position=None):
    position = np.array([left, right] if position is None else position, dtype=float)
    return (
        "sensor_msgs/msg/JointState",
        t,
        T["sensor_msgs/msg/JointState"](header(t), list(names), position, NONE, NONE),
    )


def stamped(t, *at, **more):
    return "geometry_msgs/msg/PoseStamped", t, T["geometry_msgs/msg/PoseStamped"](header(t), pose(*at, **more))


def with_covariance(t, *at, **more):
    both = T["geometry_msgs/msg/PoseWithCovariance"](pose(*at, **more), np.zeros(36))
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    return kind, t, T[kind](header(t), both)


def odometry(t, *at, **more):
    vector, kind = T["geometry_msgs/msg/Vector3"], "nav_msgs/msg/Odometry"
    twist = T["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0))
    return (
        kind,
        t,
        T[kind](
            header(t, "odom"),
            "base_link",
            T["geometry_msgs/msg/PoseWithCovariance"](pose(*at, **more), np.zeros(36)),
            T["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
        ),
    )


def transforms(t, *each):
    """Of (parent, child, x, y, theta)."""
    found = []
    for parent, child, *at in each:
        p = pose(*at)
        transform = T["geometry_msgs/msg/Transform"](
            T["geometry_msgs/msg/Vector3"](p.position.x, p.position.y, p.position.z), p.orientation
        )
        found.append(T["geometry_msgs/msg/TransformStamped"](header(t, parent), child, transform))
    return "tf2_msgs/msg/TFMessage", t, T["tf2_msgs/msg/TFMessage"](found)


def write(path, topics, storage="mcap", order=None):
    """Write a bag: messages (type, time [s], message) by topic; a folder, or its one file if the path has an ending."""
    path = Path(path)
    folder = path.with_name(f"{path.name}-folder") if path.suffix else path
    plugin = rosbags.StoragePlugin[storage.upper()]
    with rosbags.Writer(folder, version=9, storage_plugin=plugin) as writer:
        for topic, messages in topics.items():
            if isinstance(messages, str):  # a topic without messages
                writer.add_connection(topic, messages, typestore=STORE)
                continue
            connection = writer.add_connection(topic, messages[0][0], typestore=STORE)
            for k, (kind, t, message) in enumerate(messages):
                raw = message if isinstance(message, bytes) else STORE.serialize_cdr(message, kind)
                writer.write(connection, round(1e9 * t) if order is None else order + k, raw)
    if path.suffix:
        next(file for file in folder.iterdir() if file.suffix == path.suffix).rename(path)
    return path


def wpilog(path, entries, values):
    """Write a data log as WPILib specifies it.

    Args:
        path: of the file.
        entries: type of each entry by name.
        values: (name, time [us], value), in their order; a value of bytes is written as it is.
    """
    pack = {"double": "<d", "float": "<f", "int64": "<q", "boolean": "<?", "struct:Pose2d": "<3d"}
    ids = {name: k for k, name in enumerate(entries, 1)}

    def record(entry, stamp, payload):
        # Lengths of the fields less one, in two bits each for the first two, and three for the last.
        return struct.pack("<BIIQ", 0b01111111, entry, len(payload), stamp) + payload

    def text(string):
        return struct.pack("<I", len(string.encode())) + string.encode()

    out = b"WPILOG" + struct.pack("<HI", 0x0100, 0)
    for name, kind in entries.items():
        out += record(0, 0, struct.pack("<BI", 0, ids[name]) + text(name) + text(kind) + text(""))
    for name, stamp, value in values:
        cells = value if isinstance(value, tuple) else (value,)
        out += record(ids[name], stamp, value if isinstance(value, bytes) else struct.pack(pack[entries[name]], *cells))
    Path(path).write_bytes(out)
    return Path(path)
