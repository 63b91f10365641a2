"""Covariances as ROS 2 takes them: in the messages of an odometry, and as parameters of those that publish and fuse it.

Poses and twists in space have six numbers, x, y, z, roll, pitch and yaw, and their covariances 36, row by row. Of a
robot on a floor z, roll and pitch are not measured and not in doubt either: their variances are small, and not zero.
Large ones ("ignore this") make consumers that invert the whole matrix lose their digits; what is not to be fused is
left out by the configuration of the filter.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances as covariances
from diffdrive_mj._checks import Array
from diffdrive_mj._covariances import UNSEEN
from diffdrive_mj._text import html_table, shown, yaml_number
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._of_wheels import variances
from diffdrive_mj.estimation.moments import covariance as moments_along
from diffdrive_mj.estimation.wheel_noise import WheelNoise
from diffdrive_mj.robot import Robot

# Below this robot_localization puts another number in the place of a variance.
LEAST = 1e-9
# What robot_localization's own process noise is for the two speeds of a robot [m^2/s^3, rad^2/s^3].
_SPEEDS = (0.025, 0.02)
_PARTS = ("x", "y", "yaw")
# Names of topics, absolute, relative and private (~).
_TOPIC = re.compile(r"~?/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def pose_message(covariance: ArrayLike, unseen: float = UNSEEN) -> Array:
    """Lay out the covariance of a pose as `pose.covariance` of nav_msgs/Odometry has it.

    Args:
        covariance: of x, y and theta in the odometry's frame (..., 3, 3).
        unseen: the variance of z, roll and pitch [m^2, rad^2].

    Returns:
        (..., 36), row by row, in the order x, y, z, roll, pitch, yaw.

    Raises:
        InvalidType: not numbers.
        InvalidValue: a matrix that is no covariance, or a variance that is not positive.

    References:
        ros2/common_interfaces, geometry_msgs/msg/PoseWithCovariance.msg; cra-ros-pkg/robot_localization,
        src/ros_filter.cpp (forceTwoD), whose variance of what a floor holds is the default here.

    Example:
        >>> whole = pose_message(np.diag([0.01, 0.02, 0.03]))
        >>> whole[[0, 7, 35]].tolist(), whole[14].item()
        ([0.01, 0.02, 0.03], 1e-06)
    """
    stated = covariances.covariance("covariance", covariance, 3)
    return covariances.in_space(stated, checks.positive("unseen", unseen))


def twist_message(
    wheel_rates: ArrayLike, robot: Robot, noise: WheelNoise, interval: float, unseen: float = UNSEEN
) -> Array:
    """Compute the covariance of a twist as `twist.covariance` of nav_msgs/Odometry has it.

    ```
    var v = (k_l^2 |v_l| + k_r^2 |v_r|) / (4 h)    var omega = (k_l^2 |v_l| + k_r^2 |v_r|) / (b^2 h)
    cov(v, omega) = (k_r^2 |v_r| - k_l^2 |v_l|) / (2 b h)
    ```

    with the speeds v_l and v_r at which the wheels roll. It grows with the rate: of shorter intervals h the twists are
    noisier, and their sum is as uncertain.

    Args:
        wheel_rates: (..., 2) [rad/s], over the interval.
        robot: with radii and track width.
        noise: of the wheels.
        interval: h, between two messages [s].
        unseen: the variance of what is not measured: sideways, up, roll, pitch [m^2/s^2, rad^2/s^2].

    Returns:
        (..., 36), row by row, in the robot's own axes. No variance is below 1e-9: filters replace zeros.

    Raises:
        InvalidType: not numbers, a robot, noise.
        InvalidValue: numbers out of range, or a turning gain, which the formula does not know.

    References:
        Chong and Kleeman 1997; cra-ros-pkg/robot_localization, src/ekf.cpp (correct).

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> whole = twist_message((5.0, 5.0), robot, dd.WheelNoise(left=0.002, right=0.002), interval=0.02)
        >>> whole[[0, 35]].round(7).tolist()
        [5e-05, 0.00125]
    """
    rates = checks.array("wheel_rates", wheel_rates, 2)
    checks.instance("robot", robot, Robot)
    checks.instance("noise", noise, WheelNoise)
    if robot.turning_gain:
        raise InvalidValue(f"Robot.turning_gain = {robot.turning_gain:g}: ROS 2 has none; calibrate without it")
    step, held = checks.positive("interval", interval), checks.positive("unseen", unseen)
    of_speeds = np.square([noise.left, noise.right]) * np.abs(rates * (robot.left_radius, robot.right_radius)) / step
    var_speed, both, var_yaw_rate = variances(of_speeds[..., 0], of_speeds[..., 1], robot.track_width)
    stated = np.zeros((*rates.shape[:-1], 3, 3))
    stated[..., 0, 0], stated[..., 1, 1], stated[..., 2, 2] = var_speed + LEAST, held, var_yaw_rate + LEAST
    stated[..., 0, 2] = stated[..., 2, 0] = both
    return covariances.in_space(stated, held)


@dataclass(frozen=True, eq=False)
class Diagonals:
    """Holds the constant variances that fit a drive best, and prints as parameters of diff_drive_controller.

    Attributes:
        pose: of x, y, z, roll, pitch, yaw (6,) [m^2, rad^2].
        twist: likewise (6,) [m^2/s^2, rad^2/s^2].
        at_end: by which factor the variances of x, y and yaw at the end of the drive are larger than these (3,).

    Example:
        >>> print(Diagonals(np.full(6, 1e-3), np.full(6, 1e-4), at_end=np.array([2.0, 4.0, 2.0])))
        diff_drive_controller:  # your controller's name
          ros__parameters:
            # A compromise: at the end of the drive the variance of x is 2 times this, of y 4, of yaw 2.
            pose_covariance_diagonal: [0.001, 0.001, 0.001, 0.001, 0.001, 0.001]
            twist_covariance_diagonal: [0.0001, 0.0001, 0.0001, 0.0001, 0.0001, 0.0001]
    """

    pose: Array
    twist: Array
    at_end: Array

    def __str__(self) -> str:
        (first, *others), times = _PARTS, self.at_end.tolist()
        off = [
            f"{first} is {times[0]:.3g} times this",
            *(f"of {p} {t:.3g}" for p, t in zip(others, times[1:], strict=True)),
        ]
        return "\n".join(
            [
                "diff_drive_controller:  # your controller's name",
                "  ros__parameters:",
                f"    # A compromise: at the end of the drive the variance of {', '.join(off)}.",
                f"    pose_covariance_diagonal: {_list(self.pose)}",
                f"    twist_covariance_diagonal: {_list(self.twist)}",
            ]
        )

    def _repr_html_(self) -> str:
        rows = [("pose_covariance_diagonal", _list(self.pose)), ("twist_covariance_diagonal", _list(self.twist))]
        return html_table(rows, caption="diff_drive_controller")


def diagonals(
    t: ArrayLike, wheel_angles: ArrayLike, robot: Robot, noise: WheelNoise, *, publish_rate: float = 50.0
) -> Diagonals:
    """Compute the constant diagonals of diff_drive_controller that fit a drive best.

    Of all normal distributions with a constant diagonal D the one nearest to those along the drive has their mean
    variances:

    ```
    D = mean of diag C(t) over the time of the drive
    ```

    which is too much at the beginning, too little at the end, and has no correlations. Where a filter may choose, it
    fuses the twist, whose variance does not grow.

    Args:
        t: times of the samples (T,) [s].
        wheel_angles: (T, 2) [rad], of a drive as the robot usually makes it between two fixes.
        robot: with radii and track width.
        noise: of the wheels.
        publish_rate: at which the controller publishes [Hz].

    Returns:
        The diagonals, and how far they are off at the end.

    Raises:
        InvalidType: not numbers, a robot, noise.
        InvalidValue: shapes that do not fit, times that go back, wheels without noise or that never turn.

    References:
        ros-controls/ros2_controllers, diff_drive_controller/src/diff_drive_controller_parameter.yaml.

    Example:
        Along 10 m straight the variance of y grows with the cube of the way:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> t = np.linspace(0.0, 20.0, 401)
        >>> found = diagonals(t, np.stack([5 * t, 5 * t], axis=-1), robot, dd.WheelNoise(left=0.002, right=0.002))
        >>> found.at_end.round(2).tolist()
        [2.12, 4.0, 2.0]
    """
    times, rate = checks.increasing("t", t), checks.positive("publish_rate", publish_rate)
    angles = checks.array("wheel_angles", wheel_angles, "T", 2)
    if angles.shape != (len(times), 2):
        raise InvalidValue(f"wheel_angles has shape {angles.shape} and t {len(times)} times: must be (T, 2)")
    stated = moments_along(angles, robot, noise=noise).covariance
    along = np.diagonal(stated, axis1=-2, axis2=-1)
    if not np.all(along[-1] > 0):
        raise InvalidValue("noise: leaves no doubt of the end of the drive: must be positive, and the wheels must turn")
    steps = np.diff(times)[:, None]
    mean = np.sum((along[1:] + along[:-1]) / 2 * steps, axis=0) / np.sum(steps)
    rates = np.diff(angles, axis=0) / steps
    twist = twist_message(rates, robot, noise, 1 / rate).reshape(-1, 6, 6)
    pose = pose_message(np.diag(mean)).reshape(6, 6)
    fastest = np.average(np.diagonal(twist, axis1=-2, axis2=-1), axis=0, weights=steps[:, 0])
    return Diagonals(np.diag(pose).copy(), fastest, along[-1] / mean)


def robot_localization(topic: str = "/odom", *, rate: float = 30.0) -> str:
    r"""Write the configuration with which robot_localization takes the covariances from the messages of an odometry.

    It has no parameter for the covariance of a measurement: that is in the message. Fused are the speeds forward and
    sideways (zero, with a small variance) and the yaw rate, whose covariance `twist_message` states; poses that drift
    are not absolute measurements. The process noise of x, y and yaw is next to none, since their growth follows from
    that of the twist. Its default, 0.05 m^2/s, is that of a wheel noise of 0.45 m / sqrt(m) at 0.5 m/s, and drowns what
    the messages say.

    Args:
        topic: of the odometry.
        rate: of the filter [Hz].

    Returns:
        YAML, of whole lines.

    Raises:
        InvalidType: not a string, not a number.
        InvalidValue: a rate that is not positive, a topic that is no name.

    References:
        cra-ros-pkg/robot_localization, params/ekf.yaml, doc/preparing_sensor_data.rst, src/ekf.cpp.

    Example:
        >>> print("\n".join(robot_localization("/wheels/odom").splitlines()[:6]))
        ekf_filter_node:
          ros__parameters:
            frequency: 30.0
            two_d_mode: true
            world_frame: odom
            odom0: /wheels/odom
    """
    name, hertz = checks.string("topic", topic), checks.positive("rate", rate)
    if not _TOPIC.fullmatch(name):
        raise InvalidValue(f"topic = {shown(topic)}: must be a ROS 2 name, such as /odom: letters, digits, _ and /")
    noise = [LEAST] * 15
    noise[6], noise[11] = _SPEEDS
    fused = [["false"] * 3, ["false"] * 3, ["true", "true", "false"], ["false", "false", "true"], ["false"] * 3]
    indent = ",\n" + " " * 19
    matrix = ",\n      ".join(", ".join(yaml_number(value) for value in row) for row in np.diag(noise).tolist())
    return "\n".join(
        [
            "ekf_filter_node:",
            "  ros__parameters:",
            f"    frequency: {yaml_number(hertz)}",
            "    two_d_mode: true",
            "    world_frame: odom",
            f"    odom0: {name}",
            "    # x, y, z; roll, pitch, yaw; their speeds; accelerations.",
            f"    odom0_config: [{indent.join(', '.join(row) for row in fused)}]",
            "    odom0_differential: false",
            "    odom0_relative: false",
            "    # By the second, in the same order.",
            f"    process_noise_covariance: [\n      {matrix}]",
            "",
        ]
    )


def _list(values: Array) -> str:
    return f"[{', '.join(yaml_number(float(f'{value:.4g}')) for value in values)}]"
