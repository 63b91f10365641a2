"""The path that rolling and sliding make together: what the wheels say, and what the contacts do beside it."""

from __future__ import annotations

from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import integrate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot


def path(recording: Recording[Robot, Any]) -> Array:
    """Compute where a robot has come by rolling and sliding, from its wheel angles and the slip at its contacts.

    With the slips f forward and s to the left of both sides, a step is the arc of

    ```
    forward  v + (f_l + f_r) / 2
    left     (s_l + s_r) / 2
    turn     omega + (f_r - f_l) / b
    ```

    with v and omega by the wheels, for a robot with skid steer as for any other. No true pose but the first enters, so
    that the path agrees with the truth only if the slip is all that odometry does not see: ground that tilts the robot
    moves its axle without a slip.

    Args:
        recording: of one run, with slip.

    Returns:
        (T, 3) [m, m, rad].

    Raises:
        InvalidType: not a recording.
        InvalidValue: a recording of many runs, or one without slip.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> drive = dd.maneuvers.straight(robot, speed=0.5, distance=1.0)
        >>> recording = dd.simulate(robot, drive, sample_rate=500.0, slip=True)
        >>> np.abs(path(recording) - recording.truth).max() < 1e-9
        np.True_
    """
    checks.instance("recording", recording, Recording)
    if isinstance(recording.robot, tuple):
        raise InvalidValue("recording has many runs: must be one, such as recording.runs[0]")
    if recording.slip is None:
        raise InvalidValue("recording.slip is None: simulate(..., slip=True) records it")
    slid = np.diff(recording.slip, axis=0)

    def step(increments: Array, robot: Robot) -> Array:
        motion = np.insert(body_twist(increments, robot), 1, slid[..., 1].mean(axis=-1), axis=-1)
        motion[:, 0] += slid[..., 0].mean(axis=-1)
        motion[:, 2] += (slid[:, 1, 0] - slid[:, 0, 0]) / robot.track_width
        return se2.exp(motion)

    return integrate(recording.wheel_angles, recording.robot, step, recording.truth[0])
