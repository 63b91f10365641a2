"""A real robot with public recordings: what its authors publish of it, and what calibrations find on its logs.

It is the robot of the OptiOdom data set (Sousa et al. 2022): wheel ticks beside motion capture, whose marker headings
jitter by 9 mrad, which positions do not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from types import MappingProxyType

from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.calibration.squares import umbmark
from diffdrive_mj.drive import Drive
from diffdrive_mj.logs import optiodom_robot, read_optiodom
from diffdrive_mj.metrics import Drift, stacked
from diffdrive_mj.robot import Robot

# The circles and the small squares were driven within three days, the others half a year later and more.
CIRCLES, SMALL_SQUARES = "circular/250620202104", ("square/230620202042", "square/230620202317")
LARGE_SQUARE, FREE = "square/231220200040", "free/030120210001"
RECORDINGS = (CIRCLES, *SMALL_SQUARES, LARGE_SQUARE, FREE)


@dataclass(frozen=True)
class SquareFigures:
    """What is said of a recording of squares.

    Attributes:
        track_width: by UMBmark [mm].
        right_diameter: by UMBmark [mm].
        left_diameter: by UMBmark [mm].
        before: largest final position error of the nominal robot [mm].
        after: of the calibrated one [mm].

    Example:
        >>> SquareFigures(201.46, 83.95, 84.05, before=33.26, after=7.16).digits_off(PUBLISHED[SMALL_SQUARES[0]][0])
        0.0
    """

    track_width: float
    right_diameter: float
    left_diameter: float
    before: float
    after: float

    def digits_off(self, other: SquareFigures) -> float:
        """How far the two differ at most, in hundredths of a millimetre: the last digit that is published."""
        return max(abs(a - b) for a, b in zip(astuple(self), astuple(other), strict=True)) / 0.01


# By recording: the figures of the paper, and the side of the squares [m].
PUBLISHED: Mapping[str, tuple[SquareFigures, float]] = MappingProxyType(
    {
        SMALL_SQUARES[0]: (SquareFigures(201.46, 83.95, 84.05, 33.26, 7.16), 0.75),
        SMALL_SQUARES[1]: (SquareFigures(201.22, 83.95, 84.05, 33.46, 7.43), 0.75),
        LARGE_SQUARE: (SquareFigures(201.70, 83.98, 84.02, 113.89, 37.81), 1.70),
    }
)


def umbmark_figures(folder: Path, recording: str) -> SquareFigures:
    """Calibrate on squares of the real robot as its authors do: by x alone, in one round, with the published update.

    Args:
        folder: of the data set.
        recording: one of `PUBLISHED`.

    Returns:
        The figures that they give.

    Raises:
        MissingFile, InvalidValue: as in `logs.read_optiodom`.

    Example:
        >>> umbmark_figures(Path("no/such/folder"), LARGE_SQUARE)
        Traceback (most recent call last):
        diffdrive_mj.errors.MissingFile: ...
    """
    drives, nominal = read_optiodom(folder / recording), optiodom_robot(folder / recording)
    side = PUBLISHED[recording][1]
    robot = umbmark(drives, nominal, side=side, update="published", forms="x", rounds=1).calibrated
    ends = [max(float(drive.drift(one).final_position) for drive in drives) for one in (nominal, robot)]
    lengths = (robot.track_width, 2 * robot.right_radius, 2 * robot.left_radius, *ends)
    return SquareFigures(*(1e3 * length for length in lengths))


@dataclass(frozen=True)
class RealRobot:
    """The drives of the real robot.

    Attributes:
        drives: by recording.

    Example:
        >>> RealRobot.read(Path("no/such/folder"))
        Traceback (most recent call last):
        diffdrive_mj.errors.MissingFile: ...
    """

    drives: Mapping[str, list[Drive]]

    @classmethod
    def read(cls, folder: Path) -> RealRobot:
        """Read `RECORDINGS` from the folder of the data set."""
        return cls({name: read_optiodom(folder / name) for name in RECORDINGS})

    def fitted(self, *recordings: str, turning_gain: bool = False) -> Robot:
        """Fit the robot to some recordings: drives start at their first true pose, and positions decide."""
        drives = [drive for name in recordings for drive in self.drives[name]]
        nominal = Robot.load("optiodom")
        return least_squares(drives, nominal, start="truth", headings=False, turning_gain=turning_gain).calibrated

    def drift(self, recording: str, robot: Robot) -> Drift:
        """How far off a robot's odometry is on a recording, one run a drive."""
        return stacked(drive.drift(robot) for drive in self.drives[recording])
