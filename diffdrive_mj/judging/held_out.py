"""How good a calibration is on drives that it has not seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.metrics import Drift, stacked
from diffdrive_mj.robot import Robot

Recordings = Mapping[str, Sequence[Drive]]


def drift_on(drives: Sequence[Drive], robot: Robot) -> Drift:
    """Compute the drift of a robot's odometry on drives, one run a drive.

    Args:
        drives: of the robot, one at least.
        robot: the believed robot.

    Raises:
        InvalidType: not drives.
        InvalidValue: no drive.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.Drive([0.0, 1.0], [(0, 0), (10, 10)], [(0, 0, 0), (1.01, 0, 0)])
        >>> drift_on([drive, drive], robot).final_position.round(4).tolist()
        [0.01, 0.01]
    """
    return stacked(drive.drift(robot) for drive in checked_drives(drives))


def fitted_on(recordings: Recordings, fit: Callable[[list[Drive]], Robot], *names: str) -> Robot:
    """Fit a robot on the drives of some recordings together.

    Args:
        recordings: by name, several drives each.
        fit: from drives to the calibrated robot.
        names: of the recordings.

    Example:
        >>> still = dd.Drive([0.0, 1.0], np.zeros((2, 2)), np.zeros((2, 3)))
        >>> sizes = lambda drives: dd.Robot.load("matched").replace(name=f"of {len(drives)} drives")
        >>> fitted_on({"a": [still], "b": [still], "c": [still]}, sizes, "a", "c").name
        'of 2 drives'
    """
    return fit([drive for name in names for drive in recordings[name]])


def unseen(recordings: Recordings, fit: Callable[[list[Drive]], Robot]) -> dict[str, Drift]:
    """Fit a robot on all recordings but one, and judge it on that one, for each of them in turn.

    Args:
        recordings: by name, several drives each; two recordings at least.
        fit: from drives to the calibrated robot.

    Returns:
        The drift on each recording of the robot fitted on the others.

    Raises:
        InvalidValue: fewer than two recordings.

    Example:
        >>> still = dd.Drive([0.0, 1.0], np.zeros((2, 2)), np.zeros((2, 3)))
        >>> unseen({"a": [still], "b": [still]}, lambda drives: dd.Robot.load("matched"))["a"].final_position_rms
        0.0
    """
    if len(recordings) < 2:
        raise InvalidValue(f"recordings: has {len(recordings)}: must be at least two, so that one can be left out")
    return {
        name: drift_on(recordings[name], fitted_on(recordings, fit, *(other for other in recordings if other != name)))
        for name in recordings
    }
