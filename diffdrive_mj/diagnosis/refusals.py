"""What makes a calibration worthless: drives that are mixed up or given twice, and outcomes that are not a robot's.

A calibration method collects reasons; `refuse` raises on the first, or returns them all as warnings.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.diagnosis.drives import mix_up
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import CalibrationRefused
from diffdrive_mj.metrics import Drift
from diffdrive_mj.robot import Robot

# No radius and no track is believed wrong by a larger factor.
_PLAUSIBLE = 1.3
# Nor does any tyre have a larger turning gain.
_LARGEST_GAIN = 0.3
# Odometry is worse than before if its final errors rise by this factor, and by so many residuals.
_RISE, _RESIDUALS = 1.2, 3.0


def refuse(reasons: Iterable[str], *, anyway: bool) -> tuple[str, ...]:
    """Raise for the first of some reasons.

    Args:
        reasons: against a calibration.
        anyway: accept it all the same.

    Returns:
        The reasons, to be given as warnings.

    Raises:
        CalibrationRefused: there is a reason, and it is not accepted.

    Example:
        >>> refuse(["the wheels look swapped"], anyway=True)
        ('the wheels look swapped',)
        >>> refuse(["the wheels look swapped"], anyway=False)
        Traceback (most recent call last):
        diffdrive_mj.errors.CalibrationRefused: the wheels look swapped; anyway=True accepts it
    """
    anyway, found = checks.boolean("anyway", anyway), []
    for reason in checks.several("reasons", reasons):
        if not anyway:
            raise CalibrationRefused(reason)
        found.append(reason)
    return tuple(found)


def mixed_up(drives: Sequence[Drive], believed: Robot, *, headings: bool = True) -> Iterator[str]:
    """Name the drives whose columns or units look mixed up, with the field of `logs.Columns` that cures it.

    Args:
        drives: to be calibrated on.
        believed: the nominal robot.
        headings: whether the true headings are read.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> t = np.arange(0, 10, 0.1)
        >>> wheel_angles = np.stack([2 * t, 6 * t], axis=-1)
        >>> truth = dd.odometry.integrate(wheel_angles, robot)
        >>> [*mixed_up([dd.Drive(t, wheel_angles * [-1, 1], truth, name="lab")], robot)]
        ['lab: the left wheel looks reversed: try reverse_left']
    """
    for drive in drives:
        if odd := mix_up(drive, believed, headings=headings):
            yield f"{drive.name}: {odd}"


def repeated(drives: Sequence[Drive]) -> Iterator[str]:
    """Name drives that are the same log, under whatever name and starting at whatever time.

    Args:
        drives: to be calibrated on.

    Example:
        >>> drive = dd.Drive([0.0, 1.0], [(0, 0), (10, 10)], [(0, 0, 0), (1, 0, 0)], name="a")
        >>> later = dd.Drive([5.0, 6.0], drive.wheel_angles, drive.truth, name="b")
        >>> [*repeated([drive, later])]
        ['a and b are the same log: one drive does not count as two']
    """
    for one, other in itertools.combinations(drives, 2):
        if _same(one, other):
            same = one.name == other.name
            which = f"{one.name} is given twice" if same else f"{one.name} and {other.name} are the same log"
            yield f"{which}: one drive does not count as two"


def implausible(believed: Robot, calibrated: Robot) -> Iterator[str]:
    """Name parameters that are too far from what was believed to be a robot that was merely measured badly.

    Args:
        believed: the nominal robot.
        calibrated: the outcome.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> [*implausible(robot, robot.replace(track_width=0.6))]
        ['track_width comes out at 0.6 m, 1.5 times the believed 0.4 m: ...']
    """
    for name in ("left_radius", "right_radius", "track_width"):
        before, after = getattr(believed, name), getattr(calibrated, name)
        if not 1 / _PLAUSIBLE <= after / before <= _PLAUSIBLE:
            yield (
                f"{name} comes out at {after:.4g} m, {after / before:.3g} times the believed {before:.4g} m: check the "
                "units (wheel_unit, ticks_per_revolution, position_unit, angle_unit) and measure the robot, or drive "
                "straight lines and turns, if all of them are right"
            )
    if abs(calibrated.turning_gain) > _LARGEST_GAIN:
        yield (
            f"the turning gain comes out at {calibrated.turning_gain:.3g}, which no tyre has: calibrate without it "
            "(turning_gain = False), or drive turns of different radii"
        )


def worse(before: Drift, after: Drift, residual: float) -> Iterator[str]:
    """Say that odometry ends further off than before.

    Args:
        before: drifts of the believed robot.
        after: drifts of the calibrated robot.
        residual: standard deviation of the true positions [m].

    Example:
        >>> truth = np.zeros((2, 3))
        >>> near, far = (dd.metrics.drift(truth, truth + (error, 0, 0)) for error in (0.01, 0.05))
        >>> [*worse(near, far, 0.001)]
        ['odometry ends 50 mm off (RMS) with the calibrated robot and 10 mm with the believed one: ...']
        >>> [*worse(far, near, 0.001)]
        []
    """
    old, new = before.final_position_rms, after.final_position_rms
    if new > _RISE * old + _RESIDUALS * residual:
        yield (
            f"odometry ends {1e3 * new:.3g} mm off (RMS) with the calibrated robot and {1e3 * old:.3g} mm with the "
            "believed one: keep that, or try start = truth where the first true pose is as good as any"
        )


def _same(one: Drive, other: Drive) -> bool:
    return all(
        a.shape == b.shape and np.array_equal(a, b)
        for a, b in (
            (one.wheel_angles, other.wheel_angles),
            (one.truth, other.truth),
            (one.clock - one.clock[0], other.clock - other.clock[0]),
        )
    )
