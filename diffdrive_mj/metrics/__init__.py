"""Judging an estimated path against the true one.

`drift` compares the poses as they are, from a common start: what a robot feels. `ate` (absolute trajectory
error) may align first; `rpe` (relative pose error) compares stretches of equal length or duration, paired
by the truth. Headings are compared on the circle.
"""

from diffdrive_mj.metrics.drifts import Drift as Drift
from diffdrive_mj.metrics.drifts import drift as drift
from diffdrive_mj.metrics.drifts import stacked as stacked
from diffdrive_mj.metrics.drifts import travelled as travelled
from diffdrive_mj.metrics.trajectories import ALIGNMENTS as ALIGNMENTS
from diffdrive_mj.metrics.trajectories import ErrorStatistics as ErrorStatistics
from diffdrive_mj.metrics.trajectories import ate as ate
from diffdrive_mj.metrics.trajectories import rpe as rpe
