"""Models of noise: wheels with a turning gain, gyros, and counters whose phase nobody knows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_noise import farthest
from test_moments import NOISE, PATHS, ROBOT, wandering

import diffdrive_mj as dd
from diffdrive_mj.estimation._of_wheels import variances
from diffdrive_mj.estimation.noise import Noise, Readings, Steps

ANGLES = wandering(30.0, 150)
TIMES = 0.1 * np.arange(len(ANGLES))


def test_siegwarts_constants_are_the_squares():
    assert dd.WheelNoise.of_variances(left=4e-6, right=1e-6) == dd.WheelNoise(left=0.002, right=0.001)


@pytest.mark.parametrize("gain", [0.02, -0.2])
@pytest.mark.parametrize("path", ["random path of 200 m", "spin of 20 turns", "straight of 200 m"])
def test_a_turning_gain_is_that_of_the_noisy_ways(gain, path):
    robot, generator, angles = ROBOT.replace(turning_gain=gain), np.random.default_rng(4), PATHS[path][:150]
    found = dd.covariance(angles, robot, noise=dd.WheelNoise(left=0.005, right=0.003))
    radii = np.array([robot.left_radius, robot.right_radius])
    sigma = np.array([0.005, 0.003]) * np.sqrt(np.abs(np.diff(angles, axis=0)) * radii) / radii
    ends = []
    for _ in range(40):
        wander = np.cumsum(sigma * generator.normal(size=(1000, *sigma.shape)), axis=1)
        noisy = angles + np.pad(wander, ((0, 0), (1, 0), (0, 0)))
        ends.append(dd.odometry.integrate(noisy, robot)[:, -1])
    assert max(farthest(np.concatenate(ends), found.mean[-1], found.covariance[-1])) < 4


def test_a_steps_moments_are_those_of_its_noisy_wheels():
    """A single step whose noise is a third of its way: its turn is no linear function of the wheels' ways."""
    robot, increments = ROBOT.replace(turning_gain=0.4), np.array([0.3, 0.6])
    noise = dd.WheelNoise(left=0.06, right=0.08)
    readings = Readings.of([(0.0, 0.0), increments])
    found = noise.applied(Steps.of(readings, robot), readings, robot, np.zeros(0))
    radii = np.array([robot.left_radius, robot.right_radius])
    sigma = np.array([noise.left, noise.right]) * np.sqrt(increments * radii) / radii
    drawn = np.random.default_rng(0).normal(size=(1_000_000, 2))
    distance, turn = dd.kinematics.body_twist(increments + sigma * drawn, robot).T
    said = (found.turn, found.var_distance, found.covariance, found.var_turn)
    sampled = (turn.mean(), distance.var(), np.cov(distance, turn)[0, 1], turn.var())
    np.testing.assert_allclose(np.ravel(said), sampled, rtol=5e-3)
    # The turn's own shift is seen: it is many standard errors.
    assert abs(found.turn[0] - dd.kinematics.body_twist(increments, robot)[1]) > 10 * turn.std() / 1000


def gyro_drives(random_walk, bias_sigma, count, generator):
    """Where drives end whose distance is the noisy wheels' and whose turn is a gyro's."""
    x, y, theta = np.zeros((3, count))
    bias = bias_sigma * generator.normal(size=count)
    for left, right in np.diff(ANGLES, axis=0) * (ROBOT.left_radius, ROBOT.right_radius):
        ways = np.array([left, right])
        noise = (NOISE.left, NOISE.right) * np.sqrt(np.abs(ways)) * generator.normal(size=(count, 2))
        distance = (left + right + noise.sum(axis=1)) / 2
        turn = (right - left) / ROBOT.track_width - 0.1 * bias
        turn += random_walk * math.sqrt(0.1) * generator.normal(size=count)
        chord = distance * np.sinc(turn / 2 / np.pi)
        x += chord * np.cos(theta + turn / 2)
        y += chord * np.sin(theta + turn / 2)
        theta += turn
    return np.stack([x, y, theta], axis=-1)


@pytest.mark.parametrize(("random_walk", "bias_sigma"), [(0.02, 0.0), (0.02, 0.002), (0.05, 0.05)])
def test_a_gyros_random_walk_and_bias_are_those_of_monte_carlo(random_walk, bias_sigma):
    gyro = dd.GyroNoise(random_walk=random_walk, bias_sigma=bias_sigma)
    found = dd.covariance(ANGLES, ROBOT, noise=[NOISE, gyro], times=TIMES)
    ends = gyro_drives(random_walk, bias_sigma, 40_000, np.random.default_rng(8))
    assert max(farthest(ends, found.mean[-1], found.covariance[-1])) < 4


def test_a_drives_gyro_turns_the_robot_where_it_saw_it():
    t, still = np.arange(5.0), np.zeros((5, 2))
    log = dd.GyroLog(t, [0.0, 0.5, 0.5, 9.0, 0.5], [False, False, False, True, False])
    drive = dd.Drive(t, still, np.zeros((5, 3)), gyro=log)
    found = dd.covariance(drive, ROBOT, noise=[dd.GyroNoise(random_walk=0.01, bias=0.1)])
    np.testing.assert_allclose(found.mean[:, 2], [0, 0.4, 0.8, 0.8, 1.2])  # not where it was at its range
    np.testing.assert_allclose(found.covariance[:, 2, 2], 1e-4 * np.array([0, 1, 2, 2, 3]))


TICK = 2 * math.pi / 100


def counted(angles, tick, count, generator):
    """What odometry makes of angles that are counted with random phases: all poses (count, T, 3)."""
    encoder = dd.Encoder(ticks_per_revolution=2 * math.pi / tick, sample_rate=1.0)
    counts = encoder.read(np.arange(len(angles), dtype=float), angles, phase=generator.random((count, 2))).counts
    return dd.odometry.integrate(encoder.to_angles(counts), ROBOT)


def test_counters_are_those_of_monte_carlo_over_their_phases():
    found = dd.covariance(ANGLES, ROBOT, noise=dd.CounterPhases(tick=TICK))
    ends = counted(ANGLES, TICK, 10_000, np.random.default_rng(0))[:, -1]
    off = ends - found.mean[-1]
    products = np.einsum("ni,nj->nij", off, off)
    assert np.all(np.abs(off.mean(axis=0)) < 4 * found.sigma[-1] / 100)
    assert np.all(np.abs(products.mean(axis=0) - found.covariance[-1]) < 4 * products.std(axis=0) / 100)


class IndependentTicks(Noise):
    """Each increment off by the difference of two independent readings: what it is often taken for."""

    def __init__(self, tick):
        self.tick = tick

    def applied(self, steps, readings, robot, common):
        each = (self.tick * np.array([robot.left_radius, robot.right_radius])) ** 2 / 6
        return steps.noisier(*(np.full(steps.turn.shape, part) for part in variances(*each, robot.track_width)))


@pytest.mark.parametrize("bend", [0.0, 0.02])
def test_errors_of_counts_cancel_and_are_not_independent_noise(bend):
    """20 m at 0.5 m/s, straight or nearly, 400 ticks a turn: 32 mm at any rate, said to be 520 to 2310 mm."""
    robot, length, tick, rates = ROBOT.replace(right_radius=0.1), 20.0, 2 * math.pi / 400, (10, 50, 200)
    true, taken = [], []
    for rate in rates:
        way = np.linspace(0, length, 40 * rate + 1)
        angles = np.stack([way - bend * np.sin(way), way + bend * np.sin(way)], axis=-1) / 0.1
        for noise, said in ((dd.CounterPhases(tick=tick, phases=377), true), (IndependentTicks(tick), taken)):
            said.append(math.hypot(*dd.covariance(angles, robot, noise=noise).sigma[-1, :2]))
    # The heading is off as the first readings were: two uniform parts of a tick of the way.
    assert true == pytest.approx([length * 0.1 * tick / robot.track_width / math.sqrt(6)] * 3, rel=0.05)
    assert taken == pytest.approx([true[0] * math.sqrt(2 / 3 * 40 * rate) for rate in rates], rel=0.05)


def test_readings_in_whole_ticks_say_how_far_off_they_are():
    """A log has only the counts: the true poses scatter about what is stated of them as it says."""
    t = np.linspace(0, 20, 201)
    way, turn = 10 * (t / 20 - np.sin(t * math.pi / 10) / math.tau), 0.2 * np.minimum(t, 5) * 0.3
    angles = np.stack([way - turn, way + turn], axis=-1) / (ROBOT.left_radius, ROBOT.right_radius)
    truth = dd.odometry.integrate(angles, ROBOT)[-1]
    squares, stated = np.zeros(3), np.zeros(3)
    for phase in np.random.default_rng(6).random((30, 2)):
        read = np.floor(angles / 0.02 + phase) * 0.02
        found = dd.covariance(read - read[0], ROBOT, noise=dd.CounterPhases(tick=0.02, phases=144))
        squares += (truth - found.mean[-1]) ** 2
        stated += np.diag(found.covariance[-1])
    np.testing.assert_allclose(np.sqrt(squares / stated), 1, atol=0.4)


def test_counters_and_noise_add_up():
    counters, small = dd.CounterPhases(tick=TICK, phases=89), dd.WheelNoise(left=1e-4, right=1e-4)
    both = dd.covariance(ANGLES, ROBOT, noise=[small, counters])
    parts = [dd.covariance(ANGLES, ROBOT, noise=each).covariance for each in (small, counters)]
    np.testing.assert_allclose(both.covariance[-1], sum(parts)[-1], atol=0.01 * both.covariance[-1].max())


def test_ticks_are_an_encoders_or_a_robots():
    robot = dd.Robot.load("turtlebot3_burger")
    assert dd.CounterPhases.of(robot) == dd.CounterPhases.of(dd.Encoder(robot))


def test_a_model_of_ones_own_is_a_class():
    class Slipping(Noise):
        def applied(self, steps, readings, robot, common):
            return steps.noisier(var_distance=0.01 * steps.distance**2, covariance=0.0, var_turn=0.0)

    found = dd.covariance(np.linspace(0, 10, 11)[:, None] * (1 / 0.1, 1 / 0.091), ROBOT, noise=Slipping())
    assert found.sigma[-1, 0] == pytest.approx(0.1 * math.sqrt(10))
    steps = Steps.of(Readings.of(ANGLES), ROBOT)
    assert not steps.var_turn.any()
