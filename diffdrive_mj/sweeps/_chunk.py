"""Running some trials of a study: those that drive alike go together through the batch engine.

How a trial ends, and the words for it, are those of a drive of its own: neither the chunk that it is in nor its place
there shows in its row.
"""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue, PhysicsWarning, SimulationDiverged
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.metrics import drift
from diffdrive_mj.odometry import accumulate
from diffdrive_mj.recording import Recording
from diffdrive_mj.sweeps._drifts import drifts
from diffdrive_mj.sweeps.figures import FIGURES
from diffdrive_mj.sweeps.making import Trial
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

_STILL = drift(np.zeros((2, 3)), np.zeros((2, 3)))


def run(study: Study, first: int, last: int) -> Trials:
    """The trials from `first` to before `last`."""
    outcome, why = ["ok"] * (last - first), [""] * (last - first)
    figures = {name: np.full((last - first, *FIGURES[name](_STILL).shape), np.nan) for name in study.figures}
    trials, refused = study.trials_between(first, last)
    for index, error in refused.items():
        outcome[index - first], why[index - first] = "refused", str(error)
    for alike in _alike(trials):
        for some, ended in _driven(study, alike):
            if not isinstance(ended, Recording):
                row = some[0].index - first
                outcome[row] = "diverged" if isinstance(ended, SimulationDiverged) else "refused"
                why[row] = str(ended)
                continue
            fallen = _fallen(ended)
            for place in fallen:
                row = some[place].index - first
                outcome[row], why[row] = "fell", ended.run(place).surprises[0]
            for places, off in drifts(study, some, ended):
                rows = [some[place].index - first for place in places]
                if isinstance(off, InvalidValue):
                    if outcome[rows[0]] == "ok":
                        outcome[rows[0]], why[rows[0]] = "refused", str(off)
                    continue
                for name, kept in figures.items():
                    kept[rows] = FIGURES[name](off)
            for kept in figures.values():
                kept[[some[place].index - first for place in fallen]] = np.nan
    return Trials(np.arange(first, last), study.drawn(first, last), figures, np.array(outcome), np.array(why))


def refuse_rates(study: Study) -> None:
    """Refuse a study none of whose trials could be driven or sampled: better said once than in every row.

    Raises:
        InvalidValue: rates that do not divide each other.
    """
    if study.truth == "physics":
        checks.multiple("sampling interval", 1 / study.sample_rate, "Physics.timestep", study.physics.timestep)


def _alike(trials: Sequence[Trial]) -> list[list[Trial]]:
    """Groups that one call of the engine can drive: in one world, for one time, on one kind of caster."""
    groups: dict[Any, list[Trial]] = defaultdict(list)
    for trial in trials:
        robot, commands = trial.robot, trial.commands
        groups[trial.world, commands.period, len(commands.wheel_rates), robot.caster.kind, robot.skids].append(trial)
    return list(groups.values())


def _driven(
    study: Study, trials: Sequence[Trial]
) -> Iterator[tuple[Sequence[Trial], Recording[Any, Any] | InvalidValue | SimulationDiverged]]:
    """Trials with the recording of their drive; or a single one, with why there is none.

    One that breaks down is taken out, and the others are driven again: what a robot does, it does in any company.
    """
    try:
        recording = _rolled(study, trials) if study.truth == "kinematics" else _simulated(study, trials)
    except (InvalidValue, SimulationDiverged) as error:
        if len(trials) == 1:
            yield trials, error
            return
        broken = set(error.runs) if isinstance(error, SimulationDiverged) else set()
        half = len(trials) // 2
        parts: list[Sequence[Trial]] = [trials[:half], trials[half:]]
        if broken:
            others = [trial for place, trial in enumerate(trials) if place not in broken]
            parts = [*([trials[place]] for place in sorted(broken)), *([others] if others else [])]
        for part in parts:
            yield from _driven(study, part)
        return
    yield trials, recording


def _simulated(study: Study, trials: Sequence[Trial]) -> Recording[Any, Any]:
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


def _rolled(study: Study, trials: Sequence[Trial]) -> Recording[Any, Any]:
    """What wheels that never slip, and turn as they are told, make of the commands."""
    commands = trials[0].commands
    stride = checks.multiple("sampling interval", 1 / study.sample_rate, "command period", commands.period)
    turned = {id(trial.commands): trial.commands.wheel_angles for trial in trials}
    angles = [turned[id(trial.commands)] for trial in trials]
    steps = {key: np.diff(of, axis=0) for key, of in turned.items()}
    truth = accumulate(np.stack([body_twist(steps[id(trial.commands)], trial.robot) for trial in trials]))
    return Recording(
        commands.period * np.arange(truth.shape[1], dtype=np.float64)[::stride],
        np.stack([of[::stride] for of in angles]),
        truth[:, ::stride],
        tuple(trial.robot for trial in trials),
        tuple(trial.commands for trial in trials),
        trials[0].world,
        study.physics,
    )


def _fallen(recording: Recording[Any, Any]) -> list[int]:
    return [] if recording.grip is None else np.flatnonzero(~recording.upright).tolist()
