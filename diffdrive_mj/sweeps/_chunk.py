"""Running some trials of a study: those that drive alike go together through the batch engine."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.metrics import Drift, drift
from diffdrive_mj.odometry import integrate
from diffdrive_mj.recording import Recording
from diffdrive_mj.sensors.measuring import measure
from diffdrive_mj.sweeps.figures import FIGURES
from diffdrive_mj.sweeps.studies import Study, Trial
from diffdrive_mj.sweeps.trials import Trials


def run(study: Study, first: int, last: int) -> Trials:
    """The trials from `first` to before `last`."""
    trials: list[Trial] = []
    rows: dict[int, tuple[str, str, dict[str, Any]]] = {}
    for index in range(first, last):
        try:
            trials.append(study.trial(index))
        except InvalidValue as error:
            rows[index] = ("refused", str(error), {})
    for alike in _alike(trials):
        rows.update(_driven(study, alike))
    shapes = {name: np.shape(FIGURES[name](_STILL)) for name in study.figures}
    figures = {
        name: np.stack([rows[i][2].get(name, np.full(shape, np.nan)) for i in range(first, last)])
        for name, shape in shapes.items()
    }
    return Trials(
        np.arange(first, last),
        study.drawn(first, last),
        figures,
        np.array([rows[i][0] for i in range(first, last)]),
        np.array([rows[i][1] for i in range(first, last)]),
    )


_STILL = drift(np.zeros((2, 3)), np.zeros((2, 3)))


def _alike(trials: Sequence[Trial]) -> list[list[Trial]]:
    """Groups that one call of the engine can drive: in one world, for one time, on one kind of caster."""
    groups: dict[Any, list[Trial]] = defaultdict(list)
    for trial in trials:
        robot, commands = trial.robot, trial.commands
        groups[trial.world, commands.period, len(commands.wheel_rates), robot.caster.kind, robot.skids].append(trial)
    return list(groups.values())


def _driven(study: Study, trials: Sequence[Trial]) -> dict[int, tuple[str, str, dict[str, Any]]]:
    """Outcome, what happened and the figures of trials that are driven together, by their index."""
    recording = _recorded(study, trials)
    rows = {}
    for trial, run in zip(trials, recording.runs, strict=True):
        fell = run.grip is not None and not run.upright
        why = run.surprises[0] if fell else ""
        off = {} if fell else {name: FIGURES[name](_drift(study, trial, run)) for name in study.figures}
        rows[trial.index] = ("fell" if fell else "ok", why, off)
    return rows


def _rolled(study: Study, trials: Sequence[Trial]) -> Recording[Any, Any]:
    """What wheels that never slip, and turn as they are told, make of the commands."""
    commands = trials[0].commands
    stride = checks.multiple("sampling interval", 1 / study.sample_rate, "command period", commands.period)
    angles = np.stack([trial.commands.wheel_angles for trial in trials])
    truth = np.stack([integrate(turned, trial.robot) for turned, trial in zip(angles, trials, strict=True)])
    return Recording(
        commands.period * np.arange(angles.shape[1], dtype=np.float64)[::stride],
        angles[:, ::stride],
        truth[:, ::stride],
        tuple(trial.robot for trial in trials),
        tuple(trial.commands for trial in trials),
        trials[0].world,
        study.physics,
    )


def _recorded(study: Study, trials: Sequence[Trial]) -> Recording[Any, Any]:
    if study.truth == "kinematics":
        return _rolled(study, trials)
    from diffdrive_mj.physics.simulation import simulate  # loads MuJoCo

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return simulate(
            [trial.robot for trial in trials],
            [trial.commands for trial in trials],
            world=trials[0].world,
            physics=study.physics,
            sample_rate=study.sample_rate,
            on_fall="record",
            threads=1,
        )


def _drift(study: Study, trial: Trial, run: Recording[Any, Any]) -> Drift:
    """How far the trial's odometry is off."""
    if trial.encoder is None:
        return _ideal(run.truth, run.wheel_angles, study, trial)
    seed = np.random.SeedSequence([study.seed, 1, trial.index])
    return measure(run, encoder=trial.encoder, seed=seed).drift(trial.believed, study.method)


def _ideal(truth: Array, wheel_angles: Array, study: Study, trial: Trial) -> Drift:
    return drift(truth, integrate(wheel_angles, trial.believed, study.method, truth[0]))
