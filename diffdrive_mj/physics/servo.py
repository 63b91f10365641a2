"""The wheel servos: motor and speed controller, with gains that give unequal wheels one time constant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.physics.mechanics import contact_forces, gravity
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


@dataclass(frozen=True)
class ServoGains:
    """Hold what the motor and controller of one wheel do.

    ```
    torque = feedforward * command - damping * rate + integral * (commanded angle - angle)
    ```

    Attributes:
        armature: the rotor's inertia, reflected to the wheel [kg m^2].
        feedforward: of the commanded rate [N m s/rad].
        damping: of the rate [N m s/rad].
        integral: of the commanded angle minus the angle [N m/rad].

    Example:
        >>> ServoGains(armature=0.01, feedforward=1.0, damping=2.0, integral=30.0).damping
        2.0
    """

    armature: float
    feedforward: float
    damping: float
    integral: float


def servo_gains(robot: Robot, physics: Physics, radius: float) -> ServoGains:
    """Return the gains of the servo of one wheel.

    With the bandwidth w and the inertia J that the wheel drives, its own, its rotor's and half of the robot's mass,

    ```
    damping = 2 w J,  integral = w^2 J,  feedforward = w J
    ```

    so that the wheel follows as w / (s + w): with the time constant 1 / w, without overshoot, and onto the commanded
    rate. "P" has no integral part and feeds the whole command forward: it falls behind by the load's torque over the
    damping. So does "voltage", whose damping is the motor's own, stall torque over no-load speed. With gains and
    inertias in proportion to the radius squared, both wheels follow the ground speed that they are told alike, and a
    compensated robot speeds up along its line.

    Args:
        robot: its servo, motor, masses and wheel radii.
        physics: its time step, which limits the damping (`Physics.servo_stiffness`).
        radius: of the wheel [m].

    Example:
        >>> robot = Robot.load("matched")
        >>> gains = servo_gains(robot, Physics(), robot.left_radius)
        >>> print(f"{gains.damping:.2f} N m s/rad, {gains.integral:.2f} N m/rad")
        2.07 N m s/rad, 31.05 N m/rad
    """
    checks.instance("robot", robot, Robot)
    checks.instance("physics", physics, Physics)
    radius = checks.positive("radius", radius)
    matched = robot.servo.gains == "matched"
    scale = (radius / robot.mean_radius) ** 2 if matched else 1.0
    reference = robot.mean_radius if matched else min(robot.left_radius, robot.right_radius)
    free_inertia = robot.tyres.mass * reference**2 / 2 + robot.motor.rotor_inertia
    driven_inertia = free_inertia + robot.mass * reference**2 / 2
    stiffest = physics.servo_stiffness * free_inertia / physics.timestep
    damping = min(2 * robot.servo.bandwidth * driven_inertia, stiffest)
    if robot.servo.law == "voltage":
        assert robot.motor.stall_torque is not None  # `Robot` has seen to it
        assert robot.motor.no_load_speed is not None
        back_emf = robot.motor.stall_torque / robot.motor.no_load_speed
        return ServoGains(robot.motor.rotor_inertia * scale, back_emf, back_emf, 0.0)
    if robot.servo.law == "P":
        return ServoGains(robot.motor.rotor_inertia * scale, damping * scale, damping * scale, 0.0)
    integral = damping**2 / (4 * driven_inertia)
    return ServoGains(robot.motor.rotor_inertia * scale, damping / 2 * scale, damping * scale, integral * scale)


def wound_up(robot: Robot, physics: Physics, world: World, heading: float) -> Array:
    """Return by how much the commanded angles lead the wheels of a robot that stands on a slope (2,) [rad].

    ```
    lead = F r / integral
    ```

    with the force F along each wheel that statics asks for, and the radius r; zero for a servo without an integral
    part, which creeps.

    Args:
        robot: the true robot.
        physics: as for `servo_gains`.
        world: its gravity and its slope.
        heading: of the robot [rad].

    Example:
        >>> print(wound_up(Robot.load("matched"), Physics(), World(slope={"angle": 0.1}), 0.0))
        [0.0073 0.0073]
    """
    at = resting_tilt(robot)
    if robot.skids:  # which shares it equally between its sides
        along = -robot.mass / 2 * (gravity(world)[:2] @ (np.cos(heading), np.sin(heading)))
    else:
        along = contact_forces(robot, world=world, heading=heading).along
    torques = along * np.array([at.left_radius, at.right_radius])
    gains = np.array(
        [servo_gains(robot, physics, radius).integral for radius in (robot.left_radius, robot.right_radius)]
    ) * (1.0, robot.motor.gain_ratio)
    return np.divide(torques, gains, out=np.zeros(2), where=gains > 0)
