"""A trial's row is the same bits in any company, and says how the trial ended."""

import dataclasses

import numpy as np
import pytest
from sweeping import ROBOT, SHORT, SPREAD, assert_same, eventful, small

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.sweeps import Choice, Maneuver, Normal, Study, Uniform, _chunk, _drifts
from diffdrive_mj.sweeps.trials import joined

EVERY = ("final_position", "final_heading", "max_position", "max_heading", "distance", "position_along")
FAULTY = dd.Encoder(ticks_per_revolution=500, sample_rate=50.0, jitter=0.002, missed_ticks=0.01)
EXACT = dd.Encoder(ticks_per_revolution=500, sample_rate=40.0, latency=0.003)


def in_pieces(study, size):
    return joined([
        _chunk.run(study, first, min(first + size, study.trials)) for first in range(0, study.trials, size)
    ])  # fmt: skip


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"truth": "kinematics"},
        {"encoder": EXACT},
        {"encoder": FAULTY, "truth": "kinematics"},
        {"vary": {**SPREAD, "world.friction": Uniform(low=0.5, high=1.0)}},
        {"vary": {**SPREAD, "believed.track_width": Normal(mean=ROBOT.track_width, sigma=0.002)}},
        {"vary": {**SPREAD, "robot.payload.mass": Uniform(low=0.0, high=3.0)}, "method": "euler"},
    ],
    ids=["physics", "kinematics", "encoder", "faulty encoder", "friction", "belief", "payload"],
)
def test_the_chunk_changes_no_bit(changes, monkeypatch):
    study = small(11, figures=EVERY, **changes)
    whole = in_pieces(study, 11)
    assert whole.ok.all()
    monkeypatch.setattr(_drifts, "_SAMPLES", 200)  # few trials are reduced at once
    for size in (1, 4):
        assert_same(in_pieces(study, size), whole)


def test_trials_that_fall_or_cannot_be_change_no_bit_of_the_others():
    study = eventful()
    whole = in_pieces(study, study.trials)
    assert {"ok", "fell", "refused"} == set(whole.outcome.tolist())
    assert_same(in_pieces(study, 1), whole)
    for outcome, word in (("fell", "fell at"), ("refused", "tips over")):
        rows = whole.outcome == outcome
        assert all(word in why for why in whole.why[rows])
        assert np.isnan(whole.figures["final_position"][rows]).all()
    assert np.isfinite(whole.figures["final_position"][whole.ok]).all()


@pytest.mark.parametrize("jitter", [0.0, 0.001])
@pytest.mark.parametrize("truth", ["physics", "kinematics"])
def test_a_trial_whose_wheels_cannot_be_read_takes_none_down(truth, jitter):
    counter = dd.Encoder(ticks_per_revolution=500, sample_rate=5.0, counter_bits=16, jitter=jitter)
    study = small(12, truth=truth, encoder=counter, vary={**SPREAD, "believed.track_width": Choice(values=(0.4, 0.41))})
    whole = _chunk.run(study, 0, 12)
    assert whole.ok.all()
    # Half of the drives are so fast that the counter jumps by half of its range.
    study = study.replace(
        encoder=dataclasses.replace(counter, ticks_per_revolution=450_000),
        vary={**study.vary, "maneuver.speed": Choice(values=(0.1, 0.5))},
    )
    whole = _chunk.run(study, 0, 12)
    fast = whole.drawn["maneuver.speed"] == 0.5
    assert (whole.outcome == np.where(fast, "refused", "ok")).all()
    assert 0 < fast.sum() < 12
    assert all("read it more often" in why for why in whole.why[fast])
    assert (np.isnan(whole.figures["final_position"]) == fast).all()
    assert_same(in_pieces(study, 1), whole)


def test_a_trial_is_what_simulate_and_measure_make_of_it():
    """Drive by drive, through the package's front door."""
    for encoder in (None, EXACT, FAULTY):
        study = small(4, encoder=encoder, figures=("final_position", "final_heading", "max_position"))
        rows = _chunk.run(study, 0, 4)
        for trial in (study.trial(k) for k in range(4)):
            recording = dd.simulate(trial.robot, trial.commands, physics=study.physics)
            seed = np.random.SeedSequence([study.seed, 1, trial.index])
            drive = recording if encoder is None else dd.sensors.measure(recording, encoder=encoder, seed=seed)
            drift = drive.drift(trial.believed)
            for name, values in rows.figures.items():
                assert values[trial.index] == getattr(drift, name), (encoder, name)


def test_kinematic_truth_rolls_as_the_commands_say():
    """Exact arcs have a closed form: the turn of unequal wheels at equal rates, and the chord to where it leads."""
    study = small(5, truth="kinematics", figures=("final_position", "final_heading", "distance"))
    rows = _chunk.run(study, 0, 5)
    for trial in (study.trial(k) for k in range(5)):
        turned = trial.commands.wheel_angles[-1, 0]
        left, right = trial.robot.left_radius * turned, trial.robot.right_radius * turned
        turn, length = (right - left) / trial.robot.track_width, (left + right) / 2
        chord = length * np.sinc(turn / 2 / np.pi)
        off = abs(chord * np.exp(0.5j * turn) - ROBOT.mean_radius * turned)
        assert rows.figures["final_heading"][trial.index] == pytest.approx(-turn, rel=1e-9)
        assert rows.figures["final_position"][trial.index] == pytest.approx(off, rel=1e-6)
        assert rows.figures["distance"][trial.index] == pytest.approx(length, rel=1e-9)


def too_fast(trial):
    late = 5 if trial.index == 6 else 40
    rates = trial.commands.wheel_rates.copy()
    rates[late:] = 1e9
    return dataclasses.replace(trial, commands=dd.Commands(trial.commands.period, rates))


def with_a_gain(trial):
    return dataclasses.replace(trial, robot=trial.robot.replace(turning_gain=0.01))


@pytest.mark.parametrize(
    ("spoilt", "outcome", "why"),
    [
        (too_fast, "diverged", "robot 0 (matched) diverged at t ="),
        (with_a_gain, "refused", "Robot.turning_gain = 0.01: must be 0 for a robot that drives in physics"),
    ],
)
def test_what_only_the_physics_refuses_takes_out_its_own_trials_alone(spoilt, outcome, why, monkeypatch):
    study, made = small(7), Study.trials_between
    plain = _chunk.run(study, 0, 7)

    def tampered(study, first, last):
        trials, refused = made(study, first, last)
        return [spoilt(trial) if trial.index in (2, 3, 6) else trial for trial in trials], refused

    monkeypatch.setattr(Study, "trials_between", tampered)
    whole = _chunk.run(study, 0, 7)
    assert whole.outcome.tolist() == ["ok", "ok", outcome, outcome, "ok", "ok", outcome]
    assert all(why in of for of in whole.why[~whole.ok])
    for name, values in whole.figures.items():
        assert np.isnan(values[~whole.ok]).all()
        assert np.array_equal(values[whole.ok], plain.figures[name][whole.ok])
    for size in (1, 3):
        assert_same(in_pieces(study, size), whole)


def test_rates_that_fit_no_trial_are_refused_once():
    with pytest.raises(InvalidValue, match="sampling interval"):
        dd.sweep(small(3, sample_rate=300.0))


def test_a_sweep_warns_of_no_trial_that_slips():
    """Its rows say how each trial ended; a warning a trial would drown them."""
    slippery = small(
        2, vary={}, world=dd.World(friction=0.02), maneuver=Maneuver("straight", {**SHORT.options, "ramp": 0.1})
    )
    with pytest.warns(PhysicsWarning):
        dd.simulate(ROBOT, slippery.trial(0).commands, world=slippery.world, physics=slippery.physics)
    assert dd.sweep(slippery).ok.all()
