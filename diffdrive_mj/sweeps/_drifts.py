"""How far off the odometry of trials is that were driven together: those that believe and read alike in one go.

A trial's numbers do not depend on which others are reduced with it: its sums run along its own samples, and its
randomness has a stream of its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import gyrodometry
from diffdrive_mj.metrics import Drift, drift, stacked
from diffdrive_mj.odometry import integrate
from diffdrive_mj.recording import Recording
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.measuring import measure
from diffdrive_mj.sweeps.making import Trial
from diffdrive_mj.sweeps.studies import Study

# Samples of trials that are reduced at once: what fits into a processor's own memory is faster.
_SAMPLES = 20_000


def drifts(
    study: Study, trials: Sequence[Trial], recording: Recording[Any, Any]
) -> Iterator[tuple[list[int], Drift | InvalidValue]]:
    """Drifts with one leading dimension, each with the places in `trials` of those that it is of.

    In the place of the drift of a trial whose wheels or turns its sensors cannot read stands why.
    """
    most = max(1, _SAMPLES // len(recording.t))
    for places in _of_one_mind(trials).values():
        for first in range(0, len(places), most):
            yield from _read(study, trials, recording, places[first : first + most])


def _read(
    study: Study, trials: Sequence[Trial], recording: Recording[Any, Any], places: list[int]
) -> Iterator[tuple[list[int], Drift | InvalidValue]]:
    """The drifts of some places; one that cannot be read does not take the others down."""
    try:
        found = _drift(study, [trials[place] for place in places], recording, places)
    except InvalidValue as error:
        if len(places) == 1:
            yield places, error
            return
        for part in (places[: len(places) // 2], places[len(places) // 2 :]):
            yield from _read(study, trials, recording, part)
        return
    yield places, found


def _of_one_mind(trials: Sequence[Trial]) -> dict[Any, list[int]]:
    """The places of trials that believe in one robot, and read their wheels in one way."""
    groups: dict[Any, list[int]] = defaultdict(list)
    for place, trial in enumerate(trials):
        groups[trial.believed, trial.encoder, trial.gyro].append(place)
    return groups


def _drift(study: Study, trials: Sequence[Trial], recording: Recording[Any, Any], places: list[int]) -> Drift:
    """Of trials that believe and read alike (N, T)."""
    believed, encoder = trials[0].believed, trials[0].encoder
    truth, angles = recording.truth[places], recording.wheel_angles[places]
    if encoder is None and trials[0].gyro is None:
        return drift(truth, integrate(angles, believed, study.method, truth[:, 0]))
    if encoder is None or trials[0].gyro is not None or encoder.jitter or encoder.missed_ticks:
        runs = (recording.run(place) for place in places)
        return stacked(_measured(study, trial, run) for run, trial in zip(runs, trials, strict=True))
    return _counted(study, trials, recording.t, angles, truth, encoder)


def _measured(study: Study, trial: Trial, run: Recording[Any, Any]) -> Drift:
    """Of a trial alone, by wheels or by gyro; odometry believes in the gyro as designed, whatever it is like here."""
    drive = measure(run, encoder=trial.encoder, gyro=trial.gyro, seed=_seed(study, trial))
    if study.gyro is None:
        return drive.drift(trial.believed, study.method)
    return gyrodometry.by_gyro(drive, trial.believed, study.gyro, bias=study.gyro.bias).drift


def _counted(study: Study, trials: Sequence[Trial], t: Array, angles: Array, truth: Array, encoder: Encoder) -> Drift:
    """What `measure` and `Drive.drift` make of each trial, where nothing but the counters' phases is random."""
    # The stream of a recording's only run is the first that is spawned for it.
    phases = np.stack([np.random.default_rng(_seed(study, trial)).spawn(1)[0].random(2) for trial in trials])
    readings = encoder.read(t, angles, phase=phases)
    counted = encoder.to_angles(readings.counts)
    first = Drive(readings.t, counted[0], truth[0], t)  # which of the poses count, and when, is the same for all
    kept = np.searchsorted(t, first.clock)
    times = np.union1d(first.t, first.clock)
    at = np.searchsorted(times, first.clock)
    wheels = np.stack([np.stack([np.interp(times, first.t, wheel) for wheel in run.T], axis=-1) for run in counted])
    poses = integrate(wheels, trials[0].believed, study.method)[:, at]
    true = truth[:, kept]
    return drift(true, se2.compose(true[:, :1], se2.between(poses[:, :1], poses)))


def _seed(study: Study, trial: Trial) -> np.random.SeedSequence:
    return np.random.SeedSequence([study.seed, 1, trial.index])
