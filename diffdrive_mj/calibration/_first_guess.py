"""First guesses of a robot's parameters, from which a refinement starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.calibration._start import Start
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import parameters_of, trajectory
from diffdrive_mj.robot import Robot

# A guess further from the believed robot than this, relative, is not used.
_FARTHEST = 0.6


def linear_fit(drives: Sequence[Drive], believed: Robot) -> Array:
    """The linear fit, which needs no belief; the believed robot where the drives do not show enough for it.

    The heading is linear in the wheel angles, theta = J_l phi_l + J_r phi_r with J_l = -r_l / b and J_r = r_r / b; with
    J_l and J_r known the path is linear in the track b (Antonelli et al. 2005, Censi et al. 2013). The angles are those
    since the start of a drive: of single steps a coarse encoder shows little but its ticks.
    """
    angles, headings = [], []
    for drive in drives:
        wheels = drive.angles_at(drive.clock)
        seen = se2.wrap_angle(np.diff(drive.truth[:, 2]))
        guess = np.diff(drive.odometry(believed)[:, 2])
        # Sparse truth cannot count the turns: odometry does, where it is off by less than half of one.
        turns = guess + se2.wrap_angle(seen - guess) if np.abs(guess).max() > 1.5 else seen
        heading = np.concatenate([[0.0], np.cumsum(turns)])
        angles.append(wheels - wheels.mean(axis=0))
        headings.append(heading - heading.mean())
    (j_left, j_right), _, rank, _ = np.linalg.lstsq(np.concatenate(angles), np.concatenate(headings), rcond=1e-9)
    if rank < 2 or j_left >= 0 or j_right <= 0:
        return parameters_of(believed)
    along, across = 0.0, 0.0
    for drive in drives:
        # In units of the track: the robot of radii -J_l b and J_r b has the same path, b times as large.
        path = trajectory(drive, (-j_left, j_right, 1.0, 0.0), count=3).poses
        turned = np.angle(np.mean(np.exp(1j * (drive.truth[:, 2] - path[:, 2]))))
        at = se2.rotate(path[:, :2] - path[:, :2].mean(axis=0), turned)
        true = drive.truth[:, :2] - drive.truth[:, :2].mean(axis=0)
        along += float((at * true).sum())
        across += float((at * at).sum())
    track = along / across if across > 0 else believed.track_width
    if track <= 0 or not np.isfinite(track):
        return parameters_of(believed)
    guess = np.array([-j_left * track, j_right * track, track, believed.turning_gain])
    far = np.abs(guess[:3] / parameters_of(believed)[:3] - 1).max() > _FARTHEST
    return parameters_of(believed) if far else guess


def continued(drives: Sequence[Drive], believed: Robot, start: Start) -> Array:
    """A first guess from positions alone: longer and longer beginnings of the drives, so that none is far off."""
    guess = parameters_of(believed)
    for share in (0.1, 0.2, 0.4, 0.7):
        beginnings = [
            replace(drive, truth=drive.truth[:count], truth_t=drive.clock[:count])
            for drive in drives
            for count in [max(2, round(share * len(drive.truth)))]
        ]
        if 2 * sum(len(drive.truth) for drive in beginnings) > 3 + 3 * len(drives):
            problem = Problem(beginnings, believed, start=start, clock_offset=False, headings=False)
            guess[:3] = problem.solve(guess[:3])
    return guess
