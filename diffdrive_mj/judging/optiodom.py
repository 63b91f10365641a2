"""A real robot: what calibrations on some of OptiOdom's recordings leave on these, and on others that they never saw.

Drives start at their first true pose, and positions alone decide: the headings of the markers jitter by 9 mrad.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from diffdrive_mj._files import folder_with
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.attribution import Attribution, attribute
from diffdrive_mj.judging.held_out import drift_on, fitted_on, unseen
from diffdrive_mj.logs.optiodom import read_optiodom
from diffdrive_mj.metrics import Drift
from diffdrive_mj.robot import Robot

CIRCLES, SQUARE_A, SQUARE_B, LARGE, FREE = "circles", "square a", "square b", "large square", "free"
# Circles and small squares were driven within three days, the others half a year later and more.
SAME_DAYS = (CIRCLES, SQUARE_A, SQUARE_B)
FOLDERS: Mapping[str, str] = MappingProxyType(
    {
        CIRCLES: "circular/250620202104",
        SQUARE_A: "square/230620202042",
        SQUARE_B: "square/230620202317",
        LARGE: "square/231220200040",
        FREE: "free/030120210001",
    }
)
NOMINAL, ON_CIRCLES, ON_SAME_DAYS = "nominal", "fitted on the circles", "on circles and small squares"
UNSEEN, UNSEEN_GAIN = "fitted on all the others", "the same, with the turning gain"
UNSEEN_DAYS, UNSEEN_DAYS_GAIN = "fitted on the others of the same days", "these, with the turning gain"


def read_recordings(folder: str | Path) -> dict[str, list[Drive]]:
    """Read the recordings that are judged here.

    Args:
        folder: of the data set.

    Returns:
        The drives, by recording.

    Raises:
        MissingFile: the folder is not there, or lacks a recording.
        InvalidValue: files that are not as they should be.

    Example:
        >>> read_recordings("nowhere")
        Traceback (most recent call last):
        diffdrive_mj.errors.MissingFile: data = 'nowhere': nowhere is not a folder
    """
    root = folder_with("data", folder, FOLDERS.values())
    return {name: read_optiodom(root / place) for name, place in FOLDERS.items()}


def fit(drives: Sequence[Drive]) -> Robot:
    """Calibrate the robot's radii and track on some drives.

    Args:
        drives: of the robot.

    Example:
        >>> robot = dd.Robot.load("optiodom")
        >>> recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot, radius=0.3), sample_rate=20.0)
        >>> print(f"{fit([dd.sensors.measure(recording)]).left_radius:.4f} m")
        0.0420 m
    """
    return _fit(drives, turning_gain=False)


def fit_with_gain(drives: Sequence[Drive]) -> Robot:
    """Calibrate the robot's radii, track and turning gain on some drives.

    Args:
        drives: of the robot.

    Example:
        >>> robot = dd.Robot.load("optiodom")
        >>> recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot, radius=0.3), sample_rate=20.0)
        >>> abs(fit_with_gain([dd.sensors.measure(recording)]).turning_gain) < 0.01
        True
    """
    return _fit(drives, turning_gain=True)


def _fit(drives: Sequence[Drive], *, turning_gain: bool) -> Robot:
    nominal = Robot.load("optiodom")
    return least_squares(drives, nominal, start="truth", headings=False, turning_gain=turning_gain).calibrated


def drifts(recordings: Mapping[str, Sequence[Drive]]) -> dict[str, dict[str, Drift]]:
    """Fit on some recordings and judge on each.

    Args:
        recordings: as `read_recordings` reads them.

    Returns:
        The drifts by fit and by recording; of fits on the other recordings only those that they have not seen.

    Example:
        >>> from diffdrive_mj.judging.accuracy import mixed_drive
        >>> robot = dd.Robot.load("optiodom")
        >>> recording = dd.simulate(robot, mixed_drive(robot), sample_rate=5.0)
        >>> tracker = dd.Tracker(position_noise=1e-3)
        >>> measured = {
        ...     name: [dd.sensors.measure(recording, tracker=tracker, seed=k)] for k, name in enumerate(FOLDERS)
        ... }
        >>> judged = drifts(measured)
        >>> sorted(judged[NOMINAL]) == sorted(FOLDERS)
        True
    """
    robots = {
        NOMINAL: Robot.load("optiodom"),
        ON_CIRCLES: fitted_on(recordings, fit, CIRCLES),
        ON_SAME_DAYS: fitted_on(recordings, fit, *SAME_DAYS),
    }
    same_days = {name: recordings[name] for name in SAME_DAYS}
    return {
        **{label: {name: drift_on(of, robot) for name, of in recordings.items()} for label, robot in robots.items()},
        UNSEEN: unseen(recordings, fit),
        UNSEEN_GAIN: unseen(recordings, fit_with_gain),
        UNSEEN_DAYS: unseen(same_days, fit),
        UNSEEN_DAYS_GAIN: unseen(same_days, fit_with_gain),
    }


def explained(recordings: Mapping[str, Sequence[Drive]]) -> dict[str, list[Attribution]]:
    """Split the final error of the nominal robot's odometry; the reference is fitted on all the other recordings.

    Args:
        recordings: as `read_recordings` reads them.

    Returns:
        The attributions of each recording's drives.

    Example:
        >>> from diffdrive_mj.judging.accuracy import mixed_drive
        >>> robot = dd.Robot.load("optiodom").replace(track_width=0.202)
        >>> drive = dd.sensors.measure(dd.simulate(robot, mixed_drive(robot), sample_rate=5.0))
        >>> explained({"a": [drive], "b": [drive]})["a"][0].causes[0]
        'track width'
    """
    nominal, found = Robot.load("optiodom"), {}
    for name, drives in recordings.items():
        reference = fitted_on(recordings, fit, *(other for other in recordings if other != name))
        found[name] = [attribute(drive, nominal, true=reference) for drive in drives]
    return found
