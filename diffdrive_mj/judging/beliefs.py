"""What a wrong belief makes of a path: the law that odometry with wrong parameters follows on any drive."""

from __future__ import annotations

from numpy.typing import ArrayLike

from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array
from diffdrive_mj.kinematics import belief_matrix
from diffdrive_mj.odometry import accumulate
from diffdrive_mj.robot import Robot


def believed_path(path: ArrayLike, believed: Robot, true: Robot) -> Array:
    """Predict the path that a robot with a wrong belief takes a true path for.

    ```
    p'_(k+1) = p'_k exp(M log(p_k^-1 p_(k+1)))
    ```

    with the belief matrix M: the wheels roll, and both robots see them turn alike. With the robots exchanged it is the
    true path of a robot that believes to follow a given one.

    Args:
        path: (..., T, 3) [m, m, rad], sampled finely enough that each step is an arc.
        believed: the robot that the odometry computes with.
        true: the robot that drives.

    Returns:
        (..., T, 3) [m, m, rad], from the same first pose.

    Raises:
        InvalidValue: poses of another shape, or values that are not finite.

    Example:
        A straight metre, driven by a robot whose left wheel is larger than the odometry believes:

        >>> true = dd.Robot(left_radius=0.101, right_radius=0.100, track_width=0.400)
        >>> believed_path([(0, 0, 0), (1, 0, 0)], true.replace(left_radius=0.100), true)[-1].round(4)
        array([0.9949, 0.0123, 0.0248])
    """
    poses = array("path", path, "T", 3)
    steps = se2.log(se2.between(poses[..., :-1, :], poses[..., 1:, :]))[..., [0, 2]]
    return accumulate(steps @ belief_matrix(believed, true).T, start=poses[..., 0, :])
