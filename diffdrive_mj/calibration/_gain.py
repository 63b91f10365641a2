"""Whether drives show a turning gain: a robot that turns further on the spot than on a bend, by more than its track.

The gain c scales a turn by 1 + c s, s being the share of turning in what the wheels do. Where s is the same in all
turns, on squares alone or on circles of one radius, c cannot be separated from the track: any small disturbance then
makes a gain that is not there, and a track that is as wrong.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._fit import Fit, refine
from diffdrive_mj.calibration._problem import Problem

# How much of what a gain does to the poses no other parameter can do, at least. Measured: 0.00 to 0.02 on squares,
# figures of eight and slaloms, 0.05 to 0.09 on circles of one radius by a real robot, 0.12 to 0.7 on mixed drives.
SEPARATED = 0.1
# How improbable a gain of one sign must be by chance: that of four standard deviations.
_CHANCE = float(stats.norm.sf(4.0))
# A smaller gain is not worth a parameter, and a larger one is not a property of tyres.
_SMALLEST, _LARGEST = 1e-3, 0.2


def separated(problem: Problem, parameters: Array) -> float:
    """What part of a gain's influence on the poses is its own, from 0 to 1."""
    problem = problem.on(problem.drives)
    problem.shown = None
    jacobian = problem.jacobian(parameters)[:-4]
    information = jacobian.T @ jacobian
    others, gain = information[:3, :3], information[:3, 3]
    own = information[3, 3] - gain @ np.linalg.lstsq(others, gain, rcond=None)[0]
    return float(np.sqrt(max(own, 0.0) / information[3, 3])) if information[3, 3] > 0 else 0.0


def with_gain(fit: Fit) -> Fit:
    """The fit with a turning gain too, if the drives show one; the fit as it is otherwise."""
    if separated(fit.problem, fit.parameters) < SEPARATED:
        return fit
    problem = fit.problem.on(fit.problem.drives)  # whose scales and weights become those of the fit with a gain
    richer = refine(problem, fit.parameters, 4)
    limit = by_chance(float(richer.std[3]), float(richer.by_ticks[3, 3]), richer.uncertainty.parts)
    bias = abs(float(problem.sampling_bias(richer.free)[3]))
    shown = max(_SMALLEST, limit, 2 * bias) < abs(float(richer.free[3])) < _LARGEST
    return richer if shown else fit


def by_chance(std: float, by_ticks: float, parts: int) -> float:
    """How large a gain may come out by chance, where its deviation is std.

    The scatter of a few parts (0: known exactly) is itself uncertain; what ticks do, a variance of by_ticks, is not.
    """
    normal = float(stats.norm.isf(_CHANCE))
    student = float(stats.t.isf(_CHANCE, parts - 1)) if parts else normal
    return float(np.hypot(student * np.sqrt(max(std**2 - by_ticks, 0.0)), normal * np.sqrt(by_ticks)))
