"""What in a ROS 2 bag is what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue

Stamps = Literal["header", "bag"]


@dataclass(frozen=True, kw_only=True)
class Topics:
    """Says what in a ROS 2 bag is what. Where a name is not given, the only candidate is taken.

    When a log is written, these are the names that it gets: by default /joint_states with left_wheel_joint and
    right_wheel_joint, and poses in the frame "map" on /ground_truth, or on /pose if there are no wheels. Poses with a
    covariance are a nav_msgs/Odometry: on /odom, from the frame "odom" to the child frame "base_link".

    Args:
        wheels: topic of the wheels, sensor_msgs/JointState, whose positions are the wheel angles [rad].
        left: joint of the left wheel; by default the one with "left" in its name, and if there are several, "wheel".
        right: joint of the right wheel, likewise.
        poses: topic of the poses: nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped, or
            tf2_msgs/TFMessage.
        frame: parent of the transforms, such as "odom" or "map".
        child_frame: their child, such as "base_link"; between the two may be others.
        reverse_left: count the left wheel's turning with the other sign.
        reverse_right: count the right wheel's turning with the other sign.
        stamps: whose times count, the "header" of each message (the bag's if they are all zero) or the "bag", which has
            those at which messages were written.

    Raises:
        InvalidType: a name that is not a string.
        UnknownName: stamps of another kind.
        InvalidValue: an empty name.

    Example:
        >>> dd.logs.Topics(wheels="/joint_states", frame="map", child_frame="base_link").stamps
        'header'
    """

    wheels: str | None = None
    left: str | None = None
    right: str | None = None
    poses: str | None = None
    frame: str | None = None
    child_frame: str | None = None
    reverse_left: bool = False
    reverse_right: bool = False
    stamps: Stamps = "header"

    def __post_init__(self) -> None:
        for field in ("wheels", "left", "right", "poses", "frame", "child_frame"):
            value = getattr(self, field)
            if value is not None and not checks.string(f"Topics.{field}", value):
                raise InvalidValue(f"Topics.{field} = '': must name something, or not be given")
        for field in ("reverse_left", "reverse_right"):
            checks.boolean(f"Topics.{field}", getattr(self, field))
        checks.member("Topics.stamps", self.stamps, get_args(Stamps))
        for one, other in (("left", "right"), ("frame", "child_frame")):
            if getattr(self, one) is not None and getattr(self, one) == getattr(self, other):
                raise InvalidValue(f"Topics.{one} and Topics.{other} are both {getattr(self, one)!r}: must differ")
