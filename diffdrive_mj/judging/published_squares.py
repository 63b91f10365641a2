"""UMBmark on a real robot: the figures that OptiOdom's authors publish of their squares, and the same found again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from types import MappingProxyType

from diffdrive_mj.calibration.squares import umbmark
from diffdrive_mj.judging.optiodom import FOLDERS, LARGE, SQUARE_A, SQUARE_B
from diffdrive_mj.logs.optiodom import optiodom_robot, read_optiodom


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
        >>> SquareFigures(201.46, 83.95, 84.05, before=33.26, after=7.17).digits_off(PUBLISHED[SQUARE_A][0])
        1.0
    """

    track_width: float
    right_diameter: float
    left_diameter: float
    before: float
    after: float

    def digits_off(self, other: SquareFigures) -> float:
        """How far the two differ at most, in hundredths of a millimetre: the last digit that is published."""
        return round(max(abs(a - b) for a, b in zip(astuple(self), astuple(other), strict=True)) / 0.01, 6)


# By recording: the figures of Sousa et al. 2022, and the side of the squares [m].
PUBLISHED: Mapping[str, tuple[SquareFigures, float]] = MappingProxyType(
    {
        SQUARE_A: (SquareFigures(201.46, 83.95, 84.05, 33.26, 7.16), 0.75),
        SQUARE_B: (SquareFigures(201.22, 83.95, 84.05, 33.46, 7.43), 0.75),
        LARGE: (SquareFigures(201.70, 83.98, 84.02, 113.89, 37.81), 1.70),
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
        MissingFile: no such folder, or a file that is missing in it.
        InvalidValue: files that are not as they should be.

    References:
        Sousa et al. 2022.

    Example:
        >>> from pathlib import Path
        >>> umbmark_figures(Path("nowhere"), SQUARE_A)
        Traceback (most recent call last):
        diffdrive_mj.errors.MissingFile: nowhere/square/230620202042: ...
    """
    place, side = folder / FOLDERS[recording], PUBLISHED[recording][1]
    drives, nominal = read_optiodom(place), optiodom_robot(place)
    robot = umbmark(drives, nominal, side=side, update="published", forms="x", rounds=1).calibrated
    ends = [max(float(drive.drift(one).final_position) for drive in drives) for one in (nominal, robot)]
    lengths = (robot.track_width, 2 * robot.right_radius, 2 * robot.left_radius, *ends)
    return SquareFigures(*(1e3 * length for length in lengths))
