"""The page's physics against Python's: the same drives in MuJoCo's WebAssembly build and in `simulate`."""

import dataclasses
import json
import sys

import numpy as np
import pytest
from helpers import ROOT
from needs import run_node

import diffdrive_mj as dd
from diffdrive_mj.grip import LARGEST_USE
from diffdrive_mj.play.drives import MANEUVERS, plan
from diffdrive_mj.play.setting import Setting

sys.path.insert(0, str(ROOT / "benchmarks"))
from play import CLOSE, ROBOTS, random_plans, samples, simulated


@pytest.fixture(scope="module")
def both():
    """Twenty random drives: what was planned, Python's recording, the page's answer."""
    plans = random_plans(20, seed=2026)
    answers = json.loads(run_node("poses.mjs", given=json.dumps([planned.as_json() for planned in plans])))
    return [(planned, simulated(planned), answer) for planned, answer in zip(plans, answers, strict=True)]


def test_the_true_poses_are_those_of_python(both):
    for planned, recording, answer in both:
        page = samples(answer)
        fell = answer["grip"]["fall"] is not None
        assert len(page) == len(recording.t) or fell
        assert fell == (not recording.upright), planned.setting
        assert np.abs(page[:, 0] - recording.t[: len(page)]).max() < 1e-9
        assert np.abs(page[:, 1:4] - recording.truth[: len(page)]).max() < CLOSE, planned.setting
        assert np.abs(page[:, 4:6] - recording.wheel_angles[: len(page)]).max() < CLOSE, planned.setting


def test_the_drives_are_of_every_kind(both):
    slid = [bool((recording.friction_use > LARGEST_USE).any()) for _, recording, _ in both]
    assert 3 <= sum(slid) <= 17
    assert {planned.setting.maneuver for planned, _, _ in both} == set(MANEUVERS)
    assert len({planned.setting.robot for planned, _, _ in both}) >= 5
    assert all(np.hypot(*recording.truth[-1, :2]) + abs(recording.truth[-1, 2]) > 0.01 for _, recording, _ in both)


def test_the_beliefs_are_those_of_python(both):
    for planned, recording, answer in both:
        page, encoder = samples(answer), planned.encoder
        angles = recording.wheel_angles
        if encoder is not None:
            angles = encoder.to_angles(encoder.read(recording.t, angles).counts)
        believed = dd.odometry.integrate(angles, planned.believed)
        assert np.abs(page[:, 6:] - believed[: len(page)]).max() < CLOSE, planned.setting


def test_the_grip_is_that_of_python(both):
    for planned, recording, answer in both:
        if recording.upright:
            assert np.abs(np.array(answer["grip"]["use"]) - recording.friction_use).max() < 1e-6, planned.setting
            slid = [time is not None for time in answer["grip"]["slip"]]
            assert slid == list(recording.friction_use > LARGEST_USE), planned.setting
            assert (answer["grip"]["lift"] is not None) == bool(recording.lift)


def test_it_is_faster_than_real_time(both):
    """Five times at least; some 100 times on an idle machine, which this one need not be."""
    spans = [answer["time"] for _, _, answer in both]
    spent = [answer["time"] / answer["faster"] for _, _, answer in both]
    assert sum(spans) > 5 * sum(spent)


def test_another_model_is_refused(both):
    """A field that differs by more than six digits, or has another size, is named."""
    given = both[0][0].as_json()
    for field, change in (("body_mass", lambda v: [*v[:-1], v[-1] * 1.01]), ("geom_pos", lambda v: v[:-1])):
        bad = {**given, "model": {**given["model"], "numbers": {**given["model"]["numbers"]}}}
        bad["model"]["numbers"][field] = change(bad["model"]["numbers"][field])
        with pytest.raises(AssertionError, match=rf"{field}.*another MuJoCo\?"):
            run_node("poses.mjs", given=json.dumps([bad]))


def test_a_fall_ends_the_drive_when_it_does_in_python():
    planned = plan(Setting.of(ROBOTS["turtlebot3_burger"]), ROBOTS)
    harsh = dd.maneuvers.straight(planned.true, speed=1.0, distance=1.0, ramp=0.2)
    planned = dataclasses.replace(planned, commands=harsh)
    (answer,) = json.loads(run_node("poses.mjs", given=json.dumps([planned.as_json()])))
    assert answer["grip"]["fall"] == pytest.approx(float(simulated(planned).grip.fall_time), abs=1e-9)
    assert answer["time"] < harsh.duration
