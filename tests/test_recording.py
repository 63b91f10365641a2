"""A recording, its runs and what odometry makes of it; no physics: truth is planted."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd

TRUE = dd.Robot(left_radius=0.1, right_radius=0.09, track_width=0.4)
EQUAL = TRUE.replace(right_radius=0.1)
RATES = np.array([[1.0, 1.2], [0.8, -0.3], [0.0, 0.0]])


def planted(robots, start=(1.0, -2.0, 0.5)):
    """What an ideal physics would record of wheels at constant rates; a leading axis for more than one robot."""
    t = np.arange(50) * 0.02
    angles = t[:, None] * RATES[: len(robots), None, :]
    truth = np.stack([dd.odometry.integrate(a, robot, start=start) for a, robot in zip(angles, robots, strict=True)])
    commands = tuple(dd.Commands(1.0, rates[None]) for rates in RATES[: len(robots)])
    flow = angles * 2
    if len(robots) == 1:
        return dd.Recording(t, angles[0], truth[0], robots[0], commands[0], dd.World(), dd.Physics(), flow[0])
    return dd.Recording(t, angles, truth, tuple(robots), commands, dd.World(), dd.Physics(), flow)


def test_odometry_starts_at_the_first_true_pose():
    recording = planted([TRUE])
    np.testing.assert_allclose(recording.odometry(TRUE), recording.truth, atol=1e-12)
    np.testing.assert_array_equal(recording.odometry(EQUAL, "euler")[0], recording.truth[0])


def test_drift_grows_as_the_two_constant_twists_part():
    """Both the truth and the belief are arcs from one pose: the error has a closed form in the group."""
    recording = planted([TRUE])
    turned = np.insert(dd.kinematics.body_twist(recording.wheel_angles[-1], [TRUE, EQUAL][1]), 1, 0.0)
    true = np.insert(dd.kinematics.body_twist(recording.wheel_angles[-1], TRUE), 1, 0.0)
    gap = dd.se2.exp(turned)[:2] - dd.se2.exp(true)[:2]
    drift = recording.drift(EQUAL)
    assert drift.final_position == pytest.approx(np.hypot(*gap))
    assert drift.final_heading == pytest.approx(turned[2] - true[2])
    assert drift.position_error.shape == recording.t.shape


def test_runs_are_recordings_of_their_own():
    robots = [TRUE, EQUAL, TRUE.replace(track_width=0.5)]
    recording = planted(robots)
    assert [run.robot for run in recording.runs] == robots
    for k, run in enumerate(recording.runs):
        np.testing.assert_array_equal(run.t, recording.t)
        np.testing.assert_array_equal(run.truth, recording.truth[k])
        np.testing.assert_array_equal(run.flow, recording.flow[k])
        np.testing.assert_array_equal(run.commands.wheel_rates, RATES[k : k + 1])
        assert run.drift(robots[k]).max_position < 1e-12
        assert run.runs == (run,)
    drift = recording.drift(TRUE)
    assert drift.distance.shape == (3,)
    assert drift.max_position[0] < 1e-12 < drift.max_position[1]


def test_a_part_of_the_drive_has_both_its_ends():
    recording = planted([TRUE, EQUAL])
    part = recording.during(0.2, 0.6)  # recorded times such as 29 * 0.02 are off by rounding
    np.testing.assert_array_equal(part.t, recording.t[10:31])
    for field in ("wheel_angles", "truth", "flow"):
        np.testing.assert_array_equal(getattr(part, field), getattr(recording, field)[:, 10:31])
    assert part.drift(TRUE).max_position[0] < 1e-12
    with refused(ValueError, "start = 2 s, end = 3 s: no sample there; recorded are 0 to 0.98 s"):
        recording.during(2.0, 3.0)
    with refused(TypeError, "end"):
        recording.during(0.0, None)


def test_a_recording_of_two_samples_has_a_lower_rate_too():
    two = planted([TRUE]).during(0.0, 0.02)
    assert len(two.t) == 2
    assert two.at_rate(25.0).t.tolist() == [0.0]
    one = two.during(0.0, 0.0)
    assert one.at_rate(25.0) is one
