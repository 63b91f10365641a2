"""Odometry with a gyro: the filter against all of its noise at once and against chance, the rest by closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import refused
from scipy import stats

import diffdrive_mj as dd
from diffdrive_mj.estimation import heading

ROBOT = dd.Robot.load("matched")


def drive_of(rates, still, dt=0.1, *, runs=1, gyro, seed=0):
    """Turns that a gyro reads (runs, S) of a robot that turns at some rates (S,), and its true heading (S + 1,)."""
    t = dt * np.arange(len(rates) + 1)
    truth = np.zeros((runs, len(t), 3))
    truth[..., 1:, 2] = np.cumsum(np.where(still, 0.0, rates) * dt)
    log = gyro.read(t, truth, np.random.default_rng(seed))
    return log.rates * dt, truth[0, :, 2]


def stops(count, period=60, standing=20):
    """Which of some steps a robot stands on: it begins each period with a rest."""
    return np.arange(count) % period < standing


@pytest.mark.parametrize("bias_sigma", [0.02, 1.0])
def test_the_filter_is_the_conditional_distribution(bias_sigma):
    """All noise of all readings as one Gaussian, conditioned on what the gyro read while the robot stood."""
    count, dt, n, k = 70, 0.3, 2e-3, 4e-3
    still, gyro = stops(count, 25, 8), dd.Gyro(sample_rate=1 / dt, angle_random_walk=n, bias_random_walk=k)
    turns, _ = drive_of(np.full(count, 0.4), still, dt, gyro=gyro, seed=4)
    found = heading.filtered(turns[0], dt, still, gyro, bias_sigma=bias_sigma)
    # Independent normal numbers: the bias at first, each step's walk, its bridge, its white noise.
    first, walk, bridge, white = np.eye(1 + 3 * count)[:1], *np.eye(1 + 3 * count)[1:].reshape(3, count, -1)
    bias = bias_sigma * first + k * math.sqrt(dt) * np.cumsum(walk, axis=0)
    mean = bias - k * math.sqrt(dt) * walk / 2 + k * math.sqrt(dt / 12) * bridge
    noise = mean + n / math.sqrt(dt) * white
    lost = -dt * np.cumsum(np.where(still, 0.0, 1.0)[:, None] * noise, axis=0)
    for end in (8, 24, 33, 70):
        seen, wanted = noise[:end][still[:end]], np.stack([lost[end - 1], bias[end - 1]])
        gain = wanted @ seen.T @ np.linalg.inv(seen @ seen.T)
        expected = gain @ (turns[0, :end][still[:end]] / dt) + (turns[0, :end][~still[:end]].sum(), 0)
        sigma = np.sqrt(np.diag(wanted @ wanted.T - gain @ seen @ wanted.T))
        assert (found.heading[end], found.bias[end]) == pytest.approx(expected, abs=1e-8)
        assert (found.sigma[end], found.bias_sigma[end]) == pytest.approx(sigma, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("grade", ["mpu6050", "bmi088", "adis16495"])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_stated_sigma_is_the_scatter(grade, seed):
    """NEES of the heading over 400 runs, after 8 stops and 8 drives, within its 99.9 % interval."""
    gyro = dd.Gyro.load(grade, sample_rate=10.0, scale_error=0.0, resolution=0.0)
    still = stops(480)
    turns, truth = drive_of(np.full(480, 0.3), still, runs=400, gyro=gyro, seed=seed)
    found = heading.filtered(turns, 0.1, still, gyro)
    low, high = stats.chi2.ppf([5e-4, 1 - 5e-4], 400) / 400
    for end in (60, 200, 479, 480):
        error = found.heading[:, end] - truth[end]
        assert low < np.mean((error / found.sigma[:, end]) ** 2) < high


def test_a_scale_error_is_in_the_sigma():
    scales = np.random.default_rng(5).normal(0, 0.02, 400)
    still = stops(120)
    errors, sigmas = [], []
    for seed, scale in enumerate(scales):
        gyro = dd.Gyro(sample_rate=10.0, angle_random_walk=1e-3, scale_error=scale)
        turns, truth = drive_of(np.full(120, 0.5), still, gyro=gyro, seed=seed)
        found = heading.filtered(turns[0], 0.1, still, replace(gyro, scale_error=0.0), scale_sigma=0.02)
        errors.append(found.heading[-1] - truth[-1])
        sigmas.append(found.sigma[-1])
    low, high = stats.chi2.ppf([5e-4, 1 - 5e-4], 400) / 400
    assert low < np.mean((np.array(errors) / sigmas) ** 2) < high


def test_a_bias_that_is_not_known_is_stated():
    """Without a stop the heading's sigma grows as that of the bias times the time."""
    found = heading.filtered(np.zeros(50), 0.1, np.zeros(50, dtype=bool), dd.Gyro(), bias_sigma=0.2)
    assert found.sigma == pytest.approx(0.2 * 0.1 * np.arange(51))


def test_a_robot_that_is_turned_while_its_wheels_stand_does_not_teach_a_bias():
    still = np.ones(200, dtype=bool)
    gyro = dd.Gyro(sample_rate=10.0, angle_random_walk=1e-4, bias=0.05)
    rates = np.where((np.arange(200) >= 100) & (np.arange(200) < 120), 0.3, 0.0)
    turns, truth = drive_of(rates, ~still, gyro=gyro)
    found = heading.filtered(turns[0], 0.1, still, gyro)
    assert found.standing.tolist() == (rates == 0).tolist()
    assert found.bias[-1] == pytest.approx(0.05, abs=1e-4)
    assert found.heading[-1] == pytest.approx(truth[-1], abs=1e-3)


def test_a_batch_is_each_of_its_runs():
    gyro, still = dd.Gyro.load("mpu6050", sample_rate=10.0), np.stack([stops(90), stops(90, 30, 5)])
    turns = np.random.default_rng(0).normal(0, 0.01, (2, 90))
    together = heading.filtered(turns, 0.1, still, gyro)
    for run in range(2):
        alone = heading.filtered(turns[run], 0.1, still[run], gyro)
        for field in ("heading", "sigma", "bias", "bias_sigma", "standing"):
            assert np.array_equal(getattr(alone, field), getattr(together, field)[run])


def test_a_robot_stands_where_both_wheels_have_for_some_time():
    """A coarse encoder's last tick comes before the wheel has stopped: time is left out on both sides."""
    t = np.arange(0.0, 3.01, 0.05)
    phi = np.clip(t - 1.0, 0, 1)
    for wheels in ((phi, phi), (phi, 0 * phi), (0 * phi, -phi)):
        found = heading.standing(t, np.stack(wheels, axis=-1), settle=0.4, lead=0.2)
        middle = (t[1:] + t[:-1]) / 2
        assert np.array_equal(found, (middle < 0.8) | (middle > 2.4))
    assert heading.standing(t, np.zeros((len(t), 2))).all()


def test_the_switch_takes_the_gyro_only_where_the_two_differ():
    """Borenstein and Feng's rule at its threshold, and what it leaves of a drift below it: nothing."""
    rng = np.random.default_rng(0)
    wheels, slips = rng.normal(0, 0.1, 500), rng.random(500) < 0.1
    gyro = wheels + 0.9 * 0.05 * 0.1 * rng.choice([-1, 1], 500) + np.where(slips, 0.2, 0.0)
    turns, believed = heading.switched(wheels, gyro, 0.1, threshold=0.05)
    assert np.array_equal(believed, slips)
    assert np.array_equal(turns, np.where(slips, gyro, wheels))


def measured(
    maneuver="square", world=None, physics=None, gyro=None, encoder=None, seed=0, sample_rate=100.0, **options
):
    """A drive that begins with two seconds of rest."""
    go = getattr(dd.maneuvers, maneuver)(ROBOT, **options)
    waits = dd.Commands(go.period, np.concatenate([np.zeros((200, 2)), go.wheel_rates]))
    recording = dd.simulate(
        ROBOT, waits, world=world or dd.World(), physics=physics or dd.Physics(), sample_rate=sample_rate
    )
    return dd.sensors.measure(recording, encoder=encoder, gyro=gyro or dd.Gyro(), seed=seed)


def methods(drive, gyro=None):
    return {
        "by_gyro": dd.gyrodometry.by_gyro(drive, ROBOT),
        "switched": dd.gyrodometry.switched(drive, ROBOT, threshold=0.01),
        "filtered": dd.gyrodometry.filtered(drive, ROBOT, gyro or dd.Gyro()),
    }


def test_on_an_ideal_floor_an_ideal_gyro_is_as_good_as_the_wheels():
    drive = measured(side=1.0)
    for estimate in methods(drive).values():
        assert float(estimate.drift.max_position_per_metre) < 1e-6


@pytest.mark.filterwarnings("ignore::diffdrive_mj.errors.PhysicsWarning")
def test_an_ideal_gyro_keeps_the_heading_where_one_wheel_slips():
    ice = dd.World(patches=(dd.Patch(x=(0.1, 0.3), y=(0.0, 1.0), friction=0.02),))
    drive = measured("straight", world=ice, physics=dd.Physics.sliding(), distance=1.0, speed=0.5, ramp=0.5)
    assert float(drive.drift(ROBOT).max_heading) > np.radians(1)
    found = methods(drive)
    for name in ("by_gyro", "filtered"):
        # Standing it takes what the physics creeps by for the bias: a millionth of a degree a second.
        assert float(found[name].drift.max_heading) < np.radians(1e-4)
    assert float(found["switched"].drift.max_heading) < np.radians(0.3)
    assert 0 < found["switched"].by_gyro.mean() < 0.5


def test_clocks_of_their_own():
    """Encoder, gyro and tracker at rates that have nothing in common: what is left is their interpolation."""
    robot = ROBOT
    recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot, radius=0.5), sample_rate=500.0)
    gyro, tracker = dd.Gyro(sample_rate=83.0, bias=0.02), dd.Tracker(sample_rate=17.0)
    encoder = dd.Encoder(ticks_per_revolution=1e6, sample_rate=61.0)
    drive = dd.sensors.measure(recording, encoder=encoder, gyro=gyro, tracker=tracker, seed=0)
    estimate = dd.gyrodometry.by_gyro(drive, robot, bias=0.02)
    assert estimate.poses.shape == drive.truth.shape
    assert float(estimate.drift.max_position) < 1e-4
    assert float(estimate.drift.max_heading) < 1e-3
    # The gyro's last reading may come before the encoder's.
    assert all("did not see 1 of" in warning for warning in estimate.warnings)


def test_sigma_and_bias_are_those_at_the_true_poses():
    """A tracker that sees the second half of a drive alone."""
    go = dd.maneuvers.square(ROBOT, side=0.5)
    recording = dd.simulate(ROBOT, go, sample_rate=100.0)
    gyro = dd.Gyro(bias=0.1, angle_random_walk=1e-3)
    half = dd.Tracker(sample_rate=7.0, gaps=((0.0, float(recording.t[-1] / 2)),))
    drive = dd.sensors.measure(recording, gyro=gyro, tracker=half, seed=0)
    estimate = dd.gyrodometry.filtered(drive, ROBOT, gyro, bias_sigma=0.01)
    whole = dd.gyrodometry.filtered(
        replace(drive, truth=recording.truth, truth_t=recording.t), ROBOT, gyro, bias_sigma=0.01
    )
    assert estimate.sigma.shape == estimate.bias.shape == (len(drive.clock),)
    assert estimate.sigma == pytest.approx(np.interp(drive.clock, recording.t, whole.sigma))
    assert estimate.bias == pytest.approx(np.interp(drive.clock, recording.t, whole.bias))


def test_a_saturated_gyro_is_said_and_left_to_the_wheels():
    drive = measured("spin", turns=1.0, yaw_rate=2.0, gyro=dd.Gyro(range=1.0))
    assert any("at its range" in warning for warning in drive.warnings)
    for estimate in methods(drive).values():
        assert any("did not see" in warning for warning in estimate.warnings)
        assert any("at its range" in warning for warning in estimate.drift.warnings)
        assert float(estimate.drift.max_heading) < 1e-4


def test_the_bias_of_the_first_rest_is_taken_out():
    drive = measured(side=1.0, gyro=dd.Gyro(bias=0.3))
    for estimate in methods(drive).values():
        assert estimate.bias[1:] == pytest.approx(0.3, abs=1e-6)
        assert float(estimate.drift.max_heading) < 1e-4


def test_a_scale_error_and_a_tilt_that_are_known_are_taken_out():
    gyro = dd.Gyro(bias=0.2, scale_error=0.05, roll=0.3, pitch=-0.2)
    drive = measured("spin", turns=2.0, gyro=gyro)
    scale = dd.gyrodometry.scale_error(drive)
    assert scale == pytest.approx(1.05 * math.cos(0.3) * math.cos(0.2) - 1, abs=1e-6)
    wrapped = replace(drive, truth=np.column_stack([drive.truth[:, :2], dd.se2.wrap_angle(drive.truth[:, 2])]))
    ends = replace(drive, truth=drive.truth[[0, -1]], truth_t=drive.clock[[0, -1]])
    for same in (wrapped, ends):
        assert dd.gyrodometry.scale_error(same) == pytest.approx(scale, abs=1e-9)
    for believed in (gyro, dd.Gyro(scale_error=scale)):
        assert float(dd.gyrodometry.by_gyro(drive, ROBOT, believed).drift.max_heading) < 1e-4
        assert float(dd.gyrodometry.switched(drive, ROBOT, believed, threshold=0.0).drift.max_heading) < 1e-4
        assert float(dd.gyrodometry.filtered(drive, ROBOT, believed).drift.max_heading) < 1e-4
    wrong = dd.gyrodometry.filtered(drive, ROBOT, dd.Gyro(), scale_sigma=0.02)
    assert wrong.drift.heading_error[-1] == pytest.approx(4 * math.pi * scale, abs=1e-4)
    assert wrong.sigma[-1] == pytest.approx(4 * math.pi * 0.02 * (1 + scale), rel=1e-3)


def test_a_bias_that_is_believed_is_where_the_filter_begins():
    moving = np.zeros(50, dtype=bool)
    found = heading.filtered(np.full(50, 0.03), 0.1, moving, dd.Gyro(bias=0.3), bias_sigma=0.0)
    assert found.heading == pytest.approx(np.zeros(51), abs=1e-12)
    assert not found.sigma.any()


def test_what_cannot_be_done_is_refused_or_said():
    go = dd.simulate(ROBOT, dd.maneuvers.spin(ROBOT, turns=0.2, rest=0.0), sample_rate=100.0)
    without, moving = dd.sensors.measure(go), dd.sensors.measure(go, gyro=dd.Gyro(bias=0.1))
    for call in (dd.gyrodometry.by_gyro, lambda d, r: dd.gyrodometry.filtered(d, r, dd.Gyro())):
        with refused(ValueError, "has no gyro"):
            call(without, ROBOT)
    with refused(ValueError, "bias = None", "does not stand at first"):
        dd.gyrodometry.by_gyro(moving, ROBOT)
    estimate = dd.gyrodometry.filtered(moving, ROBOT, dd.Gyro())
    assert any("never stands" in warning for warning in estimate.warnings)
    assert estimate.sigma[-1] == pytest.approx(go.t[-1], rel=0.1)
    with refused(ValueError, "half a turn or more"):
        dd.gyrodometry.scale_error(moving, bias=0.1)
    blind = replace(go, truth=go.truth * [1, 1, 9])
    with refused(ValueError, "did not see"):
        dd.gyrodometry.scale_error(dd.sensors.measure(blind, gyro=dd.Gyro(range=0.5)), bias=0.0)
    with refused(ValueError, "wheels = None"):
        heading.filtered([0.1, 0.1], 0.1, [False, False], dd.Gyro(), seen=[True, False])
    with refused(TypeError, "standing"):
        heading.filtered([0.1, 0.1], 0.1, [0, 1], dd.Gyro())
    with refused(TypeError, "gyro"):
        heading.filtered([0.1, 0.1], 0.1, [False, True], 1e-3)


def test_why_the_bias_is_not_known_is_said():
    stands = measured("spin", turns=0.2, gyro=dd.Gyro(bias=0.1))
    lost = replace(stands, gyro=dd.GyroLog(stands.gyro.t, stands.gyro.rates, np.ones(len(stands.gyro.t), dtype=bool)))
    with refused(ValueError, "the gyro did not see the robot stand at first"):
        dd.gyrodometry.by_gyro(lost, ROBOT)
    assert "the gyro did not see the robot stand" in dd.gyrodometry.filtered(lost, ROBOT, dd.Gyro()).warnings[-1]
    sure = dd.gyrodometry.filtered(stands, ROBOT, dd.Gyro(), bias_sigma=0.0)
    assert "more than `bias_sigma` allows" in sure.warnings[-1]


@pytest.mark.parametrize("rate", [1.3, 2.9, 6.1])
def test_a_slow_gyros_reading_that_sees_the_robot_start_is_none_of_rest(rate):
    drive = measured("spin", turns=1.0, yaw_rate=2.0, gyro=dd.Gyro(sample_rate=rate, bias=0.1))
    assert dd.gyrodometry.by_gyro(drive, ROBOT).bias[-1] == pytest.approx(0.1, abs=1e-9)
    assert dd.gyrodometry.filtered(drive, ROBOT, dd.Gyro()).bias[-1] == pytest.approx(0.1, abs=1e-3)
