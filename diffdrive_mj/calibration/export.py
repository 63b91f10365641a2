"""A calibrated robot in the configuration format of other stacks.

Each target gets the numbers with which its own formulas, fed the same wheels, give the calibrated robot's motion.
None of them knows a turning gain: calibrate without one.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

from diffdrive_mj._checks import instance, member
from diffdrive_mj._text import yaml_number
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot

Target = Literal["ros2", "wpilib", "duckietown", "toml"]
# What only the testbed's own format can hold.
WITHOUT_GAIN: tuple[Target, ...] = ("ros2", "wpilib", "duckietown")


def ros2(nominal: Robot, calibrated: Robot) -> dict[str, float]:
    """Compute the parameters of ros2_controllers' diff_drive_controller.

    It computes with multiplier * wheel_radius for each side and with multiplier * wheel_separation.

    Args:
        nominal: the robot that the controller is configured with: its track width, and the mean of its radii.
        calibrated: the robot that a calibration found.

    Returns:
        The parameters by name [m, 1].

    Raises:
        InvalidType: not robots.
        InvalidValue: a turning gain.

    References:
        ros-controls/ros2_controllers, diff_drive_controller/src/diff_drive_controller.cpp and odometry.cpp.

    Example:
        >>> nominal = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> dd.export.ros2(nominal, nominal.replace(track_width=0.41))["wheel_separation_multiplier"]
        1.025
    """
    _check("ros2", nominal, calibrated)
    return {
        "wheel_separation": nominal.track_width,
        "wheel_radius": nominal.mean_radius,
        "wheel_separation_multiplier": calibrated.track_width / nominal.track_width,
        "left_wheel_radius_multiplier": calibrated.left_radius / nominal.mean_radius,
        "right_wheel_radius_multiplier": calibrated.right_radius / nominal.mean_radius,
    }


def wpilib(nominal: Robot, calibrated: Robot) -> dict[str, float]:
    """Compute the constants of a WPILib drivetrain: the track, and how far each side rolls.

    DifferentialDriveKinematics takes the track width; the encoders' distances come from Encoder.setDistancePerPulse,
    or from a motor controller's rotations times the distance per rotation: 2 pi r, over the ticks of a revolution.

    Args:
        nominal: not used; every target takes both robots.
        calibrated: the robot that a calibration found.

    Returns:
        The constants by name [m].

    Raises:
        InvalidType: not robots.
        InvalidValue: a turning gain.

    References:
        wpilibsuite/allwpilib, wpimath/src/main/native/include/frc/kinematics/DifferentialDriveKinematics.h and
        wpilibc/src/main/native/include/frc/Encoder.h.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> round(dd.export.wpilib(robot, robot)["left_metres_per_rotation"], 4)
        0.6283
    """
    _check("wpilib", nominal, calibrated)
    left, right = (2 * math.pi * radius for radius in (calibrated.left_radius, calibrated.right_radius))
    return {
        "track_width": calibrated.track_width,
        "left_metres_per_rotation": left,
        "right_metres_per_rotation": right,
        "left_distance_per_pulse": left / calibrated.encoder.ticks_per_wheel_turn,
        "right_distance_per_pulse": right / calibrated.encoder.ticks_per_wheel_turn,
    }


def duckietown(nominal: Robot, calibrated: Robot) -> dict[str, float]:
    """Compute the parameters of Duckietown's kinematics node.

    It turns a twist into duty cycles u_r and u_l of motors that turn k u,

    ```
    u_r = (gain + trim) / k (v + omega b / 2) / R        u_l = (gain - trim) / k (v - omega b / 2) / R
    ```

    Wheels of the radii r_r and r_l do what was asked for with

    ```
    gain = R / 2 (1 / r_r + 1 / r_l)    trim = R / 2 (1 / r_r - 1 / r_l)    trim / gain = (r_l - r_r) / (r_l + r_r)
    ```

    A positive trim drives the right wheel harder: the right wheel is the smaller one.

    Args:
        nominal: the robot that the node is configured with: its radius R, the mean of both.
        calibrated: the robot that a calibration found.

    Returns:
        The parameters by name: baseline and radius [m], gain and trim [1].

    Raises:
        InvalidType: not robots.
        InvalidValue: a turning gain.

    References:
        duckietown/dt-car-interface, packages/dagu_car/src/kinematics_node.py.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
        >>> words = dd.export.duckietown(robot, robot)
        >>> round(words["trim"] / words["gain"], 5)
        0.04712
    """
    _check("duckietown", nominal, calibrated)
    half = nominal.mean_radius / 2
    return {
        "baseline": calibrated.track_width,
        "radius": nominal.mean_radius,
        "gain": half * (1 / calibrated.right_radius + 1 / calibrated.left_radius),
        "trim": half * (1 / calibrated.right_radius - 1 / calibrated.left_radius),
    }


def text(target: Target, nominal: Robot, calibrated: Robot) -> str:
    """Write the calibrated robot as the target's files have it.

    Args:
        target: "ros2", "wpilib", "duckietown" or "toml", the testbed's own.
        nominal: the robot that the target is configured with.
        calibrated: the robot that a calibration found.

    Returns:
        YAML, Java or TOML, of whole lines.

    Raises:
        UnknownName: another target.
        InvalidType: not robots.
        InvalidValue: a turning gain, which only "toml" can hold.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> print(dd.export.text("duckietown", robot, robot), end="")
        baseline: 0.4
        radius: 0.1
        gain: 1.0
        trim: 0.0
        k: 27.0
        limit: 1.0
    """
    member("export target", target, get_args(Target))
    if target == "ros2":
        lines = [f"    {name}: {yaml_number(value)}" for name, value in ros2(nominal, calibrated).items()]
        head = ["diff_drive_controller:  # your controller's name", "  ros__parameters:"]
        return "\n".join([*head, *lines]) + "\n"
    if target == "wpilib":
        unit = {"track_width": "m"}
        return "".join(
            f"public static final double k{name.title().replace('_', '')} = {value!r};  // {unit.get(name, 'm each')}\n"
            for name, value in wpilib(nominal, calibrated).items()
        )
    if target == "duckietown":
        # A parameter missing from the file becomes None in the node: k and limit are its own defaults.
        values = duckietown(nominal, calibrated) | {"k": 27.0, "limit": 1.0}
        return "".join(f"{name}: {yaml_number(value)}\n" for name, value in values.items())
    return instance("calibrated", calibrated, Robot).to_toml()


def _check(target: Target, nominal: Robot, calibrated: Robot) -> None:
    instance("nominal", nominal, Robot)
    if gain := instance("calibrated", calibrated, Robot).turning_gain:
        raise InvalidValue(f"Robot.turning_gain = {gain:g}: {target} has none; calibrate without it")
