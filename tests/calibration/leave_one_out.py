"""Which start to advise: the real robot fitted on ten recordings, and judged on the eleventh; the same for each.

    python tests/calibration/leave_one_out.py

needs OptiOdom's recordings (DIFFDRIVE_OPTIODOM) and some minutes. For each recording left out and each start it prints
the root mean square of the final position errors [mm], of odometry that starts at the first true pose, and of odometry
that starts there with the heading that fits the drive best. Measured, in this order, as geometric means:

    estimated   13.6    9.6     best on the circles of 0.375 m (4.2 against 6.2 and 5.4)
    position    14.7    9.6     best of the first two on squares and lines (squares 17.4 to 26.6 against 20.4 to 29.9)
    truth       13.9    9.3     best on the large square and the free drives

so that no start is better in general, "truth" included: there is no reason to advise one by the residuals.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from real_data import optiodom_recordings

import diffdrive_mj as dd
from diffdrive_mj.calibration._problem import Problem, Start
from diffdrive_mj.estimation.derivatives import parameters_of


def final_errors(drives: list[dd.Drive], robot: dd.Robot, start: Start) -> float:
    """Root mean square of the final position errors of odometry, its start estimated as far as a start says [m]."""
    problem = Problem(drives, robot, start=start, clock_offset=False, headings=False)
    ends = [terms.gap[-1, :2] for terms in problem.terms(parameters_of(robot))]
    return float(np.sqrt(np.mean(np.sum(np.square(ends), axis=1))))


def thinned(drive: dd.Drive, every: int = 5) -> dd.Drive:
    return replace(drive, truth=drive.truth[::every], truth_t=drive.clock[::every])


def main() -> None:
    recordings = {folder.name: dd.logs.read_optiodom(folder) for folder in optiodom_recordings()}
    nominal = dd.logs.optiodom_robot(optiodom_recordings()[0])
    starts = get_args(Start)
    print(f"{'left out':14s}" + "".join(f"{start + how:>22s}" for start in starts for how in ("", ", heading free")))
    scores = {start: [] for start in starts}
    for name, drives in recordings.items():
        others = [thinned(drive) for other, group in recordings.items() if other != name for drive in group]
        for start in starts:
            robot = dd.calibration.least_squares(others, nominal, start=start, turning_gain=False).calibrated
            scores[start].append([final_errors(drives, robot, judged) for judged in ("truth", "position")])
        cells = "".join(f"{1e3 * value:22.2f}" for start in starts for value in scores[start][-1])
        print(f"{name:14s}{cells}", flush=True)
    means = [np.exp(np.mean(np.log(scores[start]), axis=0)) for start in starts]
    print(f"{'geometric mean':14s}" + "".join(f"{1e3 * value:22.2f}" for pair in means for value in pair))


if __name__ == "__main__":
    main()
