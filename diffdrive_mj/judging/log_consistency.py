"""NEES of logs: the covariance that an estimator wrote beside its poses, against the truth on a clock of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.consistency import Consistency, nees
from diffdrive_mj.pose_log import PoseLog, poses_of
from diffdrive_mj.recording import Recording
from diffdrive_mj.sensors._sampling import poses_between


def nees_of_logs(
    truths: Sequence[PoseLog | Drive | Recording],
    estimates: Sequence[PoseLog],
    *,
    samples: int = 100,
    confidence: float = 0.95,
) -> Consistency:
    """Compare the covariances in the logs of some drives with the errors, each seen from where the drive began.

    An estimate is in a frame of its own, and is turned and moved onto the truth at the first time that both logs have:
    the covariances are those of a robot that knows where it starts. They are taken as they are, at some of the poses of
    each estimate, evenly; the truth is interpolated on the arcs between its poses.

    Args:
        truths: where the robot was, a log a drive.
        estimates: where it was believed to be, likewise, with covariances, such as `logs.read_poses` reads of a bag.
        samples: so many poses of each drive, at most.
        confidence: with which honest covariances of normal errors are found to be honest, at least.

    Returns:
        The squares of the drives, whose samples are at the same parts of each.

    Raises:
        InvalidType: not logs.
        InvalidValue: no logs or not as many of both, a log without covariances, fewer than two poses within the truth's
            times, or an error where none is stated.

    Example:
        >>> truth = dd.PoseLog([0.0, 1.0, 2.0], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
        >>> stated = 1e-4 * np.eye(3) * np.arange(3.0)[:, None, None]
        >>> odom = dd.PoseLog([0.0, 1.0, 2.0], [(0.0, 0.0, 0.0), (1.02, 0.0, 0.0), (2.03, 0.0, 0.0)], covariance=stated)
        >>> print(nees_of_logs([truth], [odom]).verdict)
        honest: NEES / 3 is 1.42, within 0.0446 to 3.62
    """
    true = [poses_of(f"truths[{k}]", one) for k, one in enumerate(checks.several("truths", truths))]
    told = checks.instances("estimates", estimates, PoseLog)
    most = checks.whole("samples", samples, least=2)
    if len(true) != len(told) or not true:
        raise InvalidValue(f"truths has {len(true)} logs and estimates {len(told)}: must be as many, and at least one")
    within = [_within(one, other) for one, other in zip(true, told, strict=True)]
    count = min(most, *(len(some) for some in within))
    rows = [_row(one, other, some, count) for one, other, some in zip(true, told, within, strict=True)]
    at, mean, covariance = (np.array(part) for part in zip(*rows, strict=True))
    return nees(at, mean, covariance, confidence=confidence)


def _within(true: PoseLog, estimate: PoseLog) -> NDArray[np.intp]:
    """Which poses of an estimate lie within the times of the truth, by their indices."""
    if estimate.covariance is None:
        raise InvalidValue(f"{estimate.name}: has poses without a covariance: must say how far they may be off")
    found = np.flatnonzero((estimate.t >= true.t[0]) & (estimate.t <= true.t[-1]))
    if len(found) < 2:
        raise InvalidValue(f"{estimate.name}: fewer than two poses lie within the times of {true.name}")
    return found


def _row(true: PoseLog, estimate: PoseLog, within: NDArray[np.intp], count: int) -> tuple[Array, Array, Array]:
    """Truth (count, 3), estimate moved onto it, and its covariances turned with it."""
    some = within[np.linspace(0, len(within) - 1, count).round().astype(int)]
    at = poses_between(true.t, true.poses, estimate.t[some])
    believed = estimate.poses[some]
    turn = float(at[0, 2] - believed[0, 2])
    c, s = np.cos(turn), np.sin(turn)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert estimate.covariance is not None
    return at, se2.compose(at[0], se2.between(believed[0], believed)), turned @ estimate.covariance[some] @ turned.T
