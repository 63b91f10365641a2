"""What small errors cost: against odometry on dense wheel angles, closed forms, orders and laws of scale."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, robots

import diffdrive_mj as dd
from diffdrive_mj.estimation.sensitivities import error_budget
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import presets

EQUAL = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.3, encoder={"ticks_per_revolution": 1000})
DRIVES = ("straight", "square", "spin", "arc")
# Distance and turn of each segment, as the figures of the drives say.
SEGMENTS = {
    "straight": [(10, 0)],
    "square": [(4, 0), (0, math.pi / 2)] * 4,
    "spin": [(0, 6 * math.pi)],
    "arc": [(10, 10 / 1.8)],
}


def cost(budget, cause, drive):
    """Position [m] and heading error [rad] of the cause that begins so."""
    (k,) = [k for k, name in enumerate(budget.causes) if name.startswith(cause)]
    i = list(budget.drives).index(drive)
    return budget.position_error[k, i], budget.heading_error[k, i]


def dense_angles(robot, segments, steps=400):
    """The wheel angles of a robot of which the wheels roll, by the constraints of its two wheels."""
    moves = np.repeat(np.array(segments, dtype=float), steps, axis=0) / steps
    left = (moves[:, 0] - moves[:, 1] * robot.track_width / 2) / robot.left_radius
    right = (moves[:, 0] + moves[:, 1] * robot.track_width / 2) / robot.right_radius
    return np.vstack([(0, 0), np.cumsum(np.stack([left, right], axis=-1), axis=0)])


def beliefs(robot, part):
    mean, ratio = robot.left_radius + robot.right_radius, (1 + part) * robot.right_radius / robot.left_radius
    left, right = np.linalg.solve([[1, 1], [ratio, -1]], [mean, 0])
    return {
        "wheel radii": robot.replace(
            left_radius=(1 + part) * robot.left_radius, right_radius=(1 + part) * robot.right_radius
        ),
        "radius ratio": robot.replace(left_radius=left, right_radius=right),
        "track width": robot.replace(track_width=(1 + part) * robot.track_width),
    }


@given(robots, numbers(1e-4, 0.1))
def test_wrong_beliefs_are_what_odometry_makes_of_dense_wheel_angles(robot, part):
    budget = error_budget(robot, tolerance=part)
    for drive, segments in SEGMENTS.items():
        angles = dense_angles(robot, segments)
        truth = integrate(angles, robot)[-1]
        for cause, believed in beliefs(robot, part).items():
            x, y, theta = integrate(angles, believed)[-1] - truth
            assert cost(budget, cause, drive) == pytest.approx((math.hypot(x, y), theta), rel=1e-8, abs=1e-9)


@given(robots)
def test_a_tick_too_many_at_the_start(robot):
    robot = robot.replace(encoder={"ticks_per_revolution": 100, "gear": 7})
    budget = error_budget(robot)
    for drive, segments in SEGMENTS.items():
        angles = dense_angles(robot, segments)
        counted = angles.copy()
        counted[1:, int(robot.right_radius >= robot.left_radius)] += 2 * math.pi / 700
        # The tick comes first, by itself.
        counted = np.insert(counted, 1, counted[1] - angles[1], axis=0)
        x, y, theta = integrate(counted, robot)[-1] - integrate(angles, robot)[-1]
        assert cost(budget, "one encoder tick", drive) == pytest.approx((math.hypot(x, y), theta), rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("gain", [-0.1, 0.05])
def test_a_turning_gain_is_believed_as_it_is(gain):
    robot = EQUAL.replace(turning_gain=gain)
    budget = error_budget(robot, tolerance=0.02)
    # On the spot the gain and the track are one; 2 % of the track are 2 % of the turn, whatever the gain.
    assert cost(budget, "track width", "spin") == pytest.approx((0, -6 * math.pi * 0.02 / 1.02), abs=1e-12)
    assert cost(budget, "wheel radii", "spin") == pytest.approx((0, 6 * math.pi * 0.02), abs=1e-12)


def test_closed_forms_of_the_straight_line_and_the_spin():
    budget = error_budget(EQUAL, tolerance=0.01)
    assert cost(budget, "wheel radii", "straight") == pytest.approx((0.1, 0), abs=1e-12)
    assert cost(budget, "wheel radii", "spin") == pytest.approx((0, 0.06 * math.pi), abs=1e-12)
    assert cost(budget, "track width", "straight") == pytest.approx((0, 0), abs=1e-12)
    assert cost(budget, "track width", "spin") == pytest.approx((0, -0.06 * math.pi / 1.01), abs=1e-12)
    # Radii R (1 -+ e), e = 0.005 / 1.005: an arc that turns by 2 e L / b, to the left.
    turn = 2 * 0.005 / 1.005 * 10 / 0.3
    off = abs(10 * (np.exp(1j * turn) - 1) / (1j * turn) - 10)
    assert cost(budget, "radius ratio", "straight") == pytest.approx((off, turn), rel=1e-12)
    assert cost(budget, "radius ratio", "spin") == pytest.approx((0, 0), abs=1e-12)
    # A tick of the right wheel: half of it ahead, and a turn by all of it over the track.
    tick = 0.05 * 2 * math.pi / 1000
    off = abs(10 * (np.exp(1j * tick / 0.3) - 1) + 0.15j * (1 - np.exp(1j * tick / 0.3)))
    assert cost(budget, "one encoder tick", "straight") == pytest.approx((off, tick / 0.3), rel=1e-9)


@given(numbers(0.05, 3.0), numbers(0.05, 5.0), numbers(1e-4, 1.0))
def test_latency_shows_where_the_robot_was(speed, yaw_rate, latency):
    budget = error_budget(EQUAL, speed=speed, yaw_rate=yaw_rate, latency=latency)
    assert cost(budget, "latency", "straight") == pytest.approx((speed * latency, 0), rel=1e-9, abs=1e-12)
    assert cost(budget, "latency", "spin") == pytest.approx((0, -yaw_rate * latency), rel=1e-9, abs=1e-12)
    chord = 2 * 1.8 * math.sin(speed * latency / 1.8 / 2)
    assert cost(budget, "latency", "arc") == pytest.approx((abs(chord), -speed * latency / 1.8), rel=1e-9, abs=1e-12)
    if yaw_rate * latency < math.pi / 2:
        assert cost(budget, "latency", "square") == pytest.approx((0, -yaw_rate * latency), rel=1e-9, abs=1e-12)


def test_latency_longer_than_the_last_turn_and_than_the_drive():
    budget = error_budget(EQUAL, speed=1.0, yaw_rate=1.0, latency=1.0 + math.pi / 2)
    assert cost(budget, "latency", "square") == pytest.approx((1.0, -math.pi / 2), rel=1e-12)
    budget = error_budget(EQUAL, latency=1e6)
    assert cost(budget, "latency", "straight") == pytest.approx((10.0, 0), rel=1e-12)
    assert cost(budget, "latency", "square") == pytest.approx((0.0, -2 * math.pi), abs=1e-12)


@given(st.integers(2, 400))
def test_sampling_an_arc_by_the_geometric_sum(count):
    """N equal steps of a turn a: Euler turns them by -a / 2, and Euler and midpoint stretch them by 1 / sinc(a / 2)."""
    budget = error_budget(EQUAL, speed=1.0, rate=count / 10)  # the last reading is at the end
    half = 10 / 1.8 / count / 2
    chord, long = 2 * 1.8 * math.sin(5 / 1.8), half / math.sin(half)
    closed_forms = {"euler": chord * abs(long * np.exp(-1j * half) - 1), "midpoint": chord * (long - 1), "arc": 0.0}
    for method, expected in closed_forms.items():
        assert cost(budget, f"{count / 10:g} Hz, {method}", "arc") == pytest.approx((expected, 0), rel=1e-6, abs=1e-11)


def test_orders_of_convergence_along_the_arc():
    budgets = [error_budget(EQUAL, rate=rate) for rate in (20.0, 40.0, 80.0)]
    for method, order in (("euler", 1), ("midpoint", 2)):
        errors = [cost(b, f"{rate} Hz, {method}", "arc")[0] for b, rate in zip(budgets, (20, 40, 80), strict=True)]
        np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), order, atol=0.02)


@given(numbers(0.1, 2.0), numbers(0.2, 3.0), numbers(2.0, 100.0))
def test_sampling_costs_only_where_a_step_holds_two_segments(speed, yaw_rate, rate):
    budget = error_budget(EQUAL, speed=speed, yaw_rate=yaw_rate, rate=rate)
    # A step that is part s = f v / rate straight and part a = (1 - f) omega / rate turn is off by less than s a.
    a_corner = speed * yaw_rate / rate**2 / 4
    for method in ("euler", "midpoint", "arc"):
        cause = f"{rate:g} Hz, {method}"
        for drive in ("straight", "spin"):
            assert cost(budget, cause, drive) == pytest.approx((0, 0), abs=1e-10)
        position, heading = cost(budget, cause, "square")
        assert position <= 8 * a_corner * (1 + yaw_rate / rate) + 1e-12
        assert heading == pytest.approx(0, abs=1e-11)


@given(robots, numbers(1e-7, 1e-6))
def test_small_tolerances_cost_in_proportion(robot, part):
    one, three = error_budget(robot, tolerance=part), error_budget(robot, tolerance=3 * part)
    for cause in ("wheel radii", "radius ratio", "track width"):
        for drive in DRIVES:
            expected = 3 * np.array(cost(one, cause, drive))
            # Second order, of a lever of 10 m over the track.
            bound = 3 * part**2 * (10 / robot.track_width) ** 2 * 100 + 1e-12
            np.testing.assert_allclose(cost(three, cause, drive), expected, atol=bound, rtol=0)


@given(robots, numbers(0.5, 1.5))
def test_only_the_ratio_of_the_radii_matters_to_beliefs(robot, factor):
    larger = robot.replace(left_radius=factor * robot.left_radius, right_radius=factor * robot.right_radius)
    budgets = error_budget(robot), error_budget(larger)
    for cause in ("wheel radii", "radius ratio", "track width"):
        for drive in DRIVES:
            first, second = (cost(budget, cause, drive) for budget in budgets)
            assert second == pytest.approx(first, rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("name", presets())
def test_every_preset_prints_with_the_worst_first(name):
    robot = dd.Robot.load(name)
    budget = error_budget(robot)
    worst_of_each = budget.position_error.max(axis=1)
    assert list(worst_of_each) == sorted(worst_of_each, reverse=True)
    assert budget.worst[0] == 0
    assert budget.position_error[budget.worst] == worst_of_each[0]
    lines = str(budget).splitlines()
    assert lines[0].startswith(robot.name)
    assert [line.split("  ")[0] for line in lines[4 : 4 + len(budget.causes)]] == list(budget.causes)
    assert f"worst is {budget.causes[0]}" in lines[-1]
    assert "e-1" not in str(budget)


def test_the_worst_depends_on_the_robot():
    fine = {"ticks_per_revolution": 1e6}
    budget = error_budget(EQUAL.replace(encoder={"ticks_per_revolution": 4}), tolerance=1e-4)
    assert "worst is one encoder tick" in str(budget)
    budget = error_budget(EQUAL.replace(encoder=fine), tolerance=1e-6, rate=2.0)
    assert "worst is 2 Hz, euler" in str(budget)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tolerance": 0}, "tolerance = 0: must be positive"),
        ({"tolerance": 0.6}, "at most 0.5"),
        ({"rate": 0}, "rate = 0"),
        ({"rate": 1e99}, "samples"),
        ({"latency": -1}, "latency = -1"),
        ({"speed": math.nan}, "speed = nan"),
        ({"speed": 1e-99}, "samples"),
        ({"yaw_rate": -1}, "yaw_rate = -1"),
        ({"yaw_rate": 1e-100}, "samples"),
    ],
)
def test_refusals(options, words):
    with refused(ValueError, words):
        error_budget(EQUAL, **options)
    with refused(TypeError, "Robot.load('matched')"):
        error_budget("matched")


@pytest.mark.parametrize("options", [{"rate": 1e-100}, {"speed": 1e100, "latency": 1e100}, {"yaw_rate": 1e100}])
def test_extremes_are_numbers_without_warnings(options):
    budget = error_budget(EQUAL, **options)
    assert np.isfinite(budget.position_error).all()
    assert np.isfinite(budget.heading_error).all()


@pytest.mark.parametrize("rate", [1e-3, 1e-100])
def test_a_drive_shorter_than_a_sample_is_one_step(rate):
    budget = error_budget(EQUAL, rate=rate)
    for drive in ("straight", "spin", "arc"):
        assert cost(budget, f"{rate:g} Hz, arc", drive) == pytest.approx((0, 0), abs=1e-12)
    # Euler goes straight on.
    chord_of_the_arc = 1.8 * np.array([math.sin(10 / 1.8), 1 - math.cos(10 / 1.8)])
    assert cost(budget, f"{rate:g} Hz, euler", "arc")[0] == pytest.approx(math.dist((10, 0), chord_of_the_arc))
