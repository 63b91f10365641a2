"""Drift bounds in tests: an assertion that says which bound is broken, why, and where the picture is."""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

from diffdrive_mj.drive import Drive
from diffdrive_mj.judging.candidates import Candidate
from diffdrive_mj.judging.tasks import Task, Unit
from diffdrive_mj.judging.verdict import Verdict, judge
from diffdrive_mj.robot import Robot

# The environment's name for the folder of pictures.
PICTURES = "DIFFDRIVE_PICTURES"


def assert_drift(
    drive: Task | Drive,
    candidate: Candidate,
    *,
    robot: Robot | None = None,
    position: float | None = None,
    heading: float | None = None,
    position_per_metre: float | None = None,
    unit: Unit = "rad",
    seconds: float = 10.0,
) -> None:
    """Assert that an odometry drifts no further than bounds say; without bounds, that its arithmetic is exact.

    Args:
        drive: of the fixture `simulated_drive`, a case of the conformance suite, or a drive of a robot's log.
        candidate: whose odometry; what `judge` takes.
        robot: what the odometry is told of the robot of a log.
        position: largest position error along the drive [m].
        heading: largest heading error along the drive [rad].
        position_per_metre: largest position error over the distance driven [m/m].
        unit: of a program's readings.
        seconds: that a program may take.

    Raises:
        AssertionError: a bound is broken; it says by how much, the likely reason, and where a picture is. That is in
            the folder named by DIFFDRIVE_PICTURES or pytest's --diffdrive-pictures, or else a temporary one.
        InvalidType: no candidate, no drive, or a drive without a robot.
        InvalidValue: a bound that is not positive.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> ahead = dd.Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])
        >>> dd.testing.assert_drift(ahead, robot)
        >>> dd.testing.assert_drift(ahead, robot.replace(left_radius=0.2, right_radius=0.2))
        Traceback (most recent call last):
        ...
        AssertionError: robot: holds on 0 of 1 drives
        ...
        ahead: arithmetic off by 1.00 m, more than 1.00 nm
        picture: ...ahead.png
    """
    __tracebackhide__ = True
    verdict = judge(
        candidate, [drive], robot=robot, position=position, heading=heading, position_per_metre=position_per_metre,
        unit=unit, seconds=seconds,
    )  # fmt: skip
    if not verdict.holds:
        raise AssertionError("\n".join([str(verdict), *(f"picture: {path}" for path in _pictures(verdict))]))


def _pictures(verdict: Verdict) -> list[Path]:
    """Draw what broke; each into a file of its own. Of what answered nothing there is no picture."""
    from diffdrive_mj.report.verdicts import reported

    report = reported(verdict)
    if not report.pictures:
        return []
    named = os.environ.get(PICTURES)
    # Of a parametrised test each case has a folder.
    test = re.sub(r"[^\w.-]+", "_", os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0])
    folder = Path(named, test) if named else Path(tempfile.mkdtemp(prefix="diffdrive-"))
    report.write(folder)
    return [folder / f"{name}.png" for name in report.pictures]
