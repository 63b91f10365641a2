"""Direct-current motors: a limited torque, back-EMF, and unequal gains.

With the voltage u as a share of the supply's, a motor of stall torque S and no-load speed w_0 gives S (u - rate / w_0).
The servo asks for the voltage that gives the torque of its law, and |u| is at most 1. As MuJoCo has it: the actuators
of a joint add up to S u, which the joint limits to S, and back-EMF is a damping of the joint, S / w_0.
"""

from __future__ import annotations

from dataclasses import dataclass

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


@dataclass(frozen=True)
class DrivenWheel:
    """Say what drives one wheel: the torque that is asked for, before it is limited.

    ```
    torque = feedforward * command - damping * rate + integral * (commanded angle - angle)
    ```

    The motor then gives it within its limit, less back_emf * rate.

    Attributes:
        feedforward: of the commanded rate [N m s/rad].
        damping: of the rate, apart from back-EMF [N m s/rad].
        integral: of the commanded angle minus the angle [N m/rad].
        limit: the stall torque [N m]; infinite without one.
        back_emf: [N m s/rad].

    Example:
        >>> DrivenWheel(feedforward=1.0, damping=2.0, integral=30.0, limit=0.5, back_emf=0.01).limit
        0.5
    """

    feedforward: float
    damping: float
    integral: float
    limit: float
    back_emf: float


def driven_wheel(model: mujoco.MjModel, side: str) -> DrivenWheel:
    """Read from a model what drives a wheel.

    Args:
        model: of a robot.
        side: "left" or "right".

    Example:
        >>> from diffdrive_mj.physics.model import compile_model
        >>> driven_wheel(compile_model(Robot.load("ct_bot")), "left").limit
        inf
    """
    speed, spring, joint = model.actuator(f"{side}_servo"), model.actuator(f"{side}_integral"), model.joint(side)
    dof = int(joint.dofadr[0])
    limited = bool(model.jnt_actfrclimited[joint.id])
    return DrivenWheel(
        feedforward=float(speed.gainprm[0]),
        damping=-float(speed.biasprm[2]),
        integral=float(spring.gainprm[0]),
        limit=float(model.jnt_actfrcrange[joint.id, 1]) if limited else float("inf"),
        back_emf=float(model.dof_damping[dof]),
    )


def top_speed(robot: Robot, load: float = 0.0) -> float:
    """Return how fast a wheel turns at most against a torque [rad/s].

    ```
    w = w_0 (1 - load / S)
    ```

    with the motor's no-load speed w_0 and stall torque S.

    Args:
        robot: its motor.
        load: [N m], such as rolling resistance.

    Returns:
        Infinite for a motor without a no-load speed.

    Raises:
        InvalidValue: a load that is negative or not below the stall torque.

    Example:
        >>> robot = Robot.load("matched").replace(motor={"stall_torque": 1.5, "no_load_speed": 20.0})
        >>> top_speed(robot, load=0.15)
        18.0
    """
    motor, load = checks.instance("robot", robot, Robot).motor, checks.not_negative("load", load)
    if motor.stall_torque is not None and load >= motor.stall_torque:
        raise InvalidValue(f"load = {load:g} N m: must be below the stall torque, {motor.stall_torque:g} N m")
    if motor.stall_torque is None or motor.no_load_speed is None:
        return float("inf")
    return motor.no_load_speed * (1 - load / motor.stall_torque)


def drive(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Put motors between the servos and the wheels.

    Args:
        spec: a robot's model with ideal motors, which is changed.
        robot: its motor.
        world: is not read.
        physics: its time step.

    Raises:
        InvalidValue: back-EMF that is too stiff for the time step.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> robot = Robot.load("matched").replace(motor={"stall_torque": 1.5})
        >>> print(model_spec(robot).joint("left").actfrcrange)
        [-1.5  1.5]
    """
    motor = robot.motor
    for side, gain in (("left", 1.0), ("right", motor.gain_ratio)):
        joint, speed, spring = spec.joint(side), spec.actuator(f"{side}_servo"), spec.actuator(f"{side}_integral")
        if motor.stall_torque is not None:
            joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.actfrcrange = (-motor.stall_torque, motor.stall_torque)
            if motor.no_load_speed is not None:
                back_emf = motor.stall_torque / motor.no_load_speed
                _refuse_stiff(robot, physics, back_emf, float(spec.body(f"{side}_wheel").inertia[1]) + joint.armature)
                joint.damping = (back_emf, 0, 0)
                speed.biasprm[2] += back_emf  # what the servo adds to its voltage, so that the law's torque comes out
                # Or Euler's step takes damping implicitly, after the contacts have been solved.
                spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
        if gain != 1:
            for actuator in (speed, spring):
                actuator.gainprm[0] *= gain
                actuator.biasprm[1] *= gain
                actuator.biasprm[2] *= gain


def _refuse_stiff(robot: Robot, physics: Physics, back_emf: float, inertia: float) -> None:
    """A free wheel that back-EMF would turn back within a step swings for ever."""
    longest = inertia / back_emf
    if physics.timestep > longest:
        raise InvalidValue(
            f"robot {robot.name}: Motor.stall_torque / no_load_speed = {back_emf:.3g} N m s/rad brakes its free wheel "
            f"within {longest:.2g} s: Physics.timestep must be at most that, or Motor.rotor_inertia larger"
        )
