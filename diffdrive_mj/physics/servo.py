"""The wheel servos: motor and speed controller, with gains that give unequal wheels one time constant."""

from __future__ import annotations

from dataclasses import dataclass

from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics


@dataclass(frozen=True)
class ServoGains:
    """The motor and controller of one wheel: torque = proportional * rate error + integral * angle error.

    Attributes:
        armature: the rotor's inertia, reflected to the wheel [kg m^2].
        proportional: [N m s/rad].
        integral: [N m/rad].
    """

    armature: float
    proportional: float
    integral: float


def servo_gains(robot: Robot, physics: Physics, radius: float) -> ServoGains:
    """The servo of a wheel of some radius.

    p = 2 w J, i = w^2 J: critically damped at the bandwidth w, J being the inertia that the wheel drives, its own, its
    rotor's and half of the robot's mass. With gains and inertias in proportion to the radius squared, both wheels
    follow the ground speed that they are told alike, and a compensated robot speeds up along its line.
    """
    matched = robot.servo.gains == "matched"
    scale = (radius / robot.mean_radius) ** 2 if matched else 1.0
    reference = robot.mean_radius if matched else min(robot.left_radius, robot.right_radius)
    free_inertia = robot.tyres.mass * reference**2 / 2 + robot.motor.rotor_inertia
    driven_inertia = free_inertia + robot.mass * reference**2 / 2
    stiffest = physics.servo_stiffness * free_inertia / physics.timestep
    proportional = min(2 * robot.servo.bandwidth * driven_inertia, stiffest)
    integral = proportional**2 / (4 * driven_inertia) if robot.servo.law == "PI" else 0.0
    return ServoGains(robot.motor.rotor_inertia * scale, proportional * scale, integral * scale)
