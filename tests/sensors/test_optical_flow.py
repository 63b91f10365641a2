"""The mouse sensor: 000's formulas, any mounting, counting, and what the engine says of its place."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.sensors.optical_flow import FlowSensor, count_error_covariance, lever_arm, mounting_angle

finite = st.floats(-5, 5)
lever = st.floats(0.005, 0.2) | st.floats(-0.2, -0.005)
sensors = st.builds(FlowSensor, x=lever, y=st.floats(-0.2, 0.2), angle=finite)
ROBOT = dd.Robot.load("mismatched")


@given(alpha=st.floats(-3, 3), r=st.floats(-5, 5), m=st.floats(0.005, 0.2))
def test_the_formulas_of_the_document(alpha, r, m):
    """X = alpha m to the right, Y = alpha r, alpha clockwise, r the radius of a right turn."""
    forward, left = FlowSensor(x=m).displacement((alpha * r, -alpha))
    assert forward == pytest.approx(alpha * r)
    assert -left == pytest.approx(alpha * m)


@given(sensors, finite, finite)
def test_the_motion_comes_back(sensor, distance, turn):
    assert sensor.motion(sensor.displacement((distance, turn))) == pytest.approx((distance, turn), abs=1e-9)


@given(sensors, finite, finite, st.floats(-3, 3))
def test_the_sensor_sees_the_motion_of_its_own_place(sensor, distance, slide, turn):
    """Its place, moved rigidly along the arc, comes to where its own displacement leads it."""
    mount = np.array([sensor.x, sensor.y, sensor.angle])
    robot_after = dd.se2.exp((distance, slide, turn))
    place = dd.se2.between(mount, dd.se2.compose(robot_after, mount))
    seen = sensor.displacement((distance, slide, turn))
    assert dd.se2.exp((*seen, turn)) == pytest.approx(place, abs=1e-9)


def test_a_turn_at_400_counts_per_inch_and_15_mm():
    sensor = FlowSensor(x=0.015)
    _, left = sensor.displacement((0.0, 2 * math.pi))
    assert left * sensor.counts_per_metre == pytest.approx(1484.2, abs=0.05)
    assert 1 / (sensor.counts_per_metre * sensor.x) == pytest.approx(4.2e-3, abs=0.05e-3)


@pytest.mark.parametrize("axle", ["independent", "rigid"])
def test_the_flow_is_the_way_of_the_sensors_place(axle):
    """Chords of the place's true path, seen in the mean heading of each step, add up to the flow."""
    robot = ROBOT.replace(axle=axle)
    sensor = FlowSensor(x=0.08, y=-0.05, angle=0.4)
    recording = dd.simulate(
        robot, dd.maneuvers.figure_eight(robot, radius=0.5), flow_sensor=sensor, sample_rate=500, start=(2.0, 1.0, -0.8)
    )
    place = dd.se2.compose(recording.truth, (sensor.x, sensor.y, 0.0))
    mean = (place[1:, 2] + place[:-1, 2]) / 2
    moved = dd.se2.rotate(np.diff(place[:, :2], axis=0), -(mean + sensor.angle))
    assert np.cumsum(moved, axis=0) == pytest.approx(recording.flow[1:], abs=1e-6)
    assert np.abs(recording.flow[-1]).min() > 0.5


@pytest.mark.parametrize("name", ["straight", "square", "spin", "arc"])
@pytest.mark.parametrize("x", [0.015, -0.1])
def test_the_pose_in_the_ideal_world(name, x):
    sensor = FlowSensor(x=x, y=0.02, angle=-0.7)
    options = {"square": {"side": 1.0}, "spin": {"turns": 1}, "straight": {"distance": 3.0}, "arc": {"distance": 3.0}}[
        name
    ]
    recording = dd.simulate(ROBOT, getattr(dd.maneuvers, name)(ROBOT, **options), flow_sensor=sensor)
    estimate = dd.odometry.accumulate(sensor.from_flow(recording.flow), start=recording.truth[0])
    drift = dd.metrics.drift(recording.truth, estimate)
    driven = math.pi * ROBOT.track_width if name == "spin" else float(drift.distance)
    assert float(drift.max_position) / driven < 50e-6


def test_the_flow_does_not_depend_on_the_sample_rate_or_the_batch():
    sensor = FlowSensor(x=0.05)
    drive = dd.maneuvers.arc(ROBOT, distance=1.0)
    fine = dd.simulate([ROBOT] * 2, drive, flow_sensor=sensor, sample_rate=500)
    coarse = dd.simulate(ROBOT, drive, flow_sensor=sensor, sample_rate=10)
    assert fine.flow[1, ::50][: len(coarse.t)] == pytest.approx(coarse.flow, abs=1e-12)
    assert np.array_equal(fine.at_rate(10).flow[0], fine.flow[0, ::50])
    assert dd.simulate(ROBOT, drive).flow is None


def test_the_lever_arm_and_the_angle_come_out_of_a_spin_and_a_straight_line():
    sensor = FlowSensor(x=0.04, y=-0.07, angle=0.3)
    spin = dd.simulate(ROBOT, dd.maneuvers.spin(ROBOT, turns=1), flow_sensor=sensor)
    line = dd.simulate(ROBOT, dd.maneuvers.straight(ROBOT, distance=1.0), flow_sensor=sensor)
    angle = mounting_angle(line.flow[-1])
    assert angle == pytest.approx(sensor.angle, abs=1e-6)
    assert lever_arm(spin.flow[-1], spin.truth[-1, 2], angle) == pytest.approx((0.04, -0.07), abs=1e-6)


@given(st.lists(st.floats(-0.01, 0.01), min_size=2, max_size=30), st.floats(0, 0.999))
def test_counters_are_within_a_count_of_the_truth(steps, phase):
    sensor = FlowSensor(x=0.02)
    flow = np.cumsum(np.stack([steps, steps[::-1]], axis=-1), axis=0)
    exact = (flow - flow[0]) * sensor.counts_per_metre
    counts = sensor.counts(flow, phase=(phase, 0.5))
    assert np.array_equal(counts[0], (0, 0))
    assert (np.abs(counts - exact) <= 1 + 1e-9).all()


def test_the_covariance_of_counting_is_that_of_many_random_phases():
    exact = np.array([0.2, 3.7, -1.4, 12.0])
    phases = (np.arange(200_000) + 0.5) / 200_000
    errors = np.floor(exact[:, None] + phases) - exact[:, None]
    assert count_error_covariance(exact) == pytest.approx(errors @ errors.T / len(phases), abs=1e-4)


def test_a_lifted_sensor_counts_nothing():
    sensor = FlowSensor(x=0.02, counts_per_metre=1000)
    flow = np.stack([np.linspace(0, 1, 11), np.zeros(11)], axis=-1)
    lifted = np.zeros(11, dtype=bool)
    lifted[3:6] = True
    counts = sensor.counts(flow, lifted=lifted)
    assert counts[:, 0].tolist() == [0, 100, 200, 200, 200, 200, 300, 400, 500, 600, 700]


def test_runs_are_leading_dimensions():
    sensor = FlowSensor(x=0.02)
    flow = np.random.default_rng(0).normal(size=(3, 4, 10, 2)).cumsum(axis=-2) / 1000
    phase = np.random.default_rng(1).random((3, 4, 2))
    counts = sensor.counts(flow, phase=phase)
    assert counts.shape == (3, 4, 10, 2)
    assert np.array_equal(counts[2, 1], sensor.counts(flow[2, 1], phase=phase[2, 1]))
    assert sensor.from_counts(counts).shape == (3, 4, 9, 2)


@pytest.mark.parametrize(
    ("make", "builtin", "words"),
    [
        (lambda: FlowSensor(x=0), ValueError, "FlowSensor.x = 0: must not be zero.*rotation cannot be seen"),
        (lambda: FlowSensor(x=math.nan), ValueError, "FlowSensor.x"),
        (
            lambda: FlowSensor(x=0.1, counts_per_metre=0),
            ValueError,
            "FlowSensor.counts_per_metre = 0: must be positive",
        ),
        (lambda: FlowSensor(x=0.1, counts_per_metre=-1), ValueError, "FlowSensor.counts_per_metre"),
        (lambda: FlowSensor(x="far"), TypeError, "FlowSensor.x"),
        (lambda: FlowSensor(x=0.1).motion((1.0, 2.0, 3.0)), ValueError, "displacement has shape"),
        (lambda: FlowSensor(x=0.1).displacement((1.0,)), ValueError, "motion has shape"),
        (lambda: FlowSensor(x=0.1).counts([(0, math.nan)]), ValueError, "flow"),
        (lambda: FlowSensor(x=0.1).counts([(0, 0)], phase=1.0), ValueError, "phase: must be at least 0 and below 1"),
        (lambda: FlowSensor(x=0.1).counts([(0, 0)], lifted=[0]), TypeError, "lifted: must be an array of bool"),
        (lambda: FlowSensor(x=0.1).counts([(0, 0)], lifted=[True, True]), TypeError, "lifted"),
        (lambda: FlowSensor(x=0.1).from_counts([(0, 0)]), ValueError, "must have at least two"),
        (lambda: lever_arm((0.1, 0.1), 0.0), ValueError, "turned = 0"),
        (lambda: mounting_angle((0.0, 0.0)), ValueError, "displacement = "),
    ],
)
def test_bad_input_is_named(make, builtin, words):
    with pytest.raises(dd.DiffdriveError, match=words) as raised:
        make()
    assert isinstance(raised.value, builtin)
    with refused(builtin):
        make()


@pytest.mark.parametrize(
    ("options", "builtin", "words"),
    [
        ({"lifted": [[True], [True, False]]}, TypeError, "lifted: must be an array of bool, one for each of the 6"),
        (
            {"lifted": np.zeros((4, 6), dtype=bool)},
            ValueError,
            "leading dimensions of flow (3,), phase (), lifted (4,)",
        ),
        ({"phase": np.zeros((4, 2))}, ValueError, "leading dimensions of flow (3,), phase (4,), lifted ()"),
        ({"phase": np.zeros(3)}, ValueError, "phase has shape (3,): must be (..., 2)"),
    ],
)
def test_runs_of_a_flow_sensor_fit_together(options, builtin, words):
    with refused(builtin, words):
        dd.FlowSensor(x=0.1).counts(np.zeros((3, 6, 2)), **options)


def test_runs_of_lifts_are_runs():
    assert dd.FlowSensor(x=0.1).counts(np.zeros((6, 2)), lifted=np.zeros((4, 6), dtype=bool)).shape == (4, 6, 2)


def test_the_phases_of_an_encoder_are_numbers():
    encoder = dd.Encoder(ticks_per_revolution=100, sample_rate=1.0)
    with refused(TypeError, "phase: must be an array of real numbers"):
        encoder.read([0.0, 1.0], np.zeros((2, 2)), phase=[[1, 2], [3]])


def test_two_samples_are_one_step():
    sensor = dd.FlowSensor(x=0.1)
    assert sensor.from_flow([(0.0, 0.0), (0.3, 0.01)]).tolist() == [pytest.approx([0.3, 0.1])]
    with refused(ValueError, "at least two to move between"):
        sensor.from_flow([(0.0, 0.0)])
