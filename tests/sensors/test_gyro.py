"""The gyro: its noise by the Allan deviation, its readings by closed forms, and what a log of them stands for."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import diffdrive_mj as dd
from diffdrive_mj.sensors._gyro_grades import GRADES
from diffdrive_mj.sensors.allan import allan_deviation

STILL = np.zeros((2, 3))


def at_rest(gyro: dd.Gyro, duration: float, runs: int, seed: int) -> np.ndarray:
    return gyro.read([0.0, duration], np.broadcast_to(STILL, (runs, 2, 3)), np.random.default_rng(seed)).rates


def over_runs(gyro: dd.Gyro, times: np.ndarray, *, seed: int) -> np.ndarray:
    """The Allan deviation of 60 runs, each 40 times as long as the longest averaging."""
    readings = at_rest(gyro, 40 * float(times[-1]), 60, seed)
    return np.sqrt((allan_deviation(readings, gyro.interval, times) ** 2).mean(axis=0))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [10.0, 97.0])
def test_white_noise_falls_as_it_should(rate, seed):
    times = np.array([1, 3, 10, 40]) / rate
    found = over_runs(dd.Gyro(sample_rate=rate, angle_random_walk=2e-3), times, seed=seed)
    assert found == pytest.approx(2e-3 / np.sqrt(times), rel=0.05)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [10.0, 97.0])
def test_the_biass_walk_climbs_as_it_should(rate, seed):
    """From the shortest averaging on: each reading is the mean of a continuous walk."""
    times = np.array([1, 3, 10, 40]) / rate
    found = over_runs(dd.Gyro(sample_rate=rate, bias=0.3, bias_random_walk=5e-4), times, seed=seed)
    assert found == pytest.approx(5e-4 * np.sqrt(times / 3), rel=0.05)


@pytest.mark.parametrize("grade", GRADES)
def test_a_grade_has_the_allan_deviation_of_its_data_sheet(grade):
    """White noise at a second, and the in-run stability as the minimum, at tau = sqrt(3) N / K."""
    gyro = dd.Gyro.load(grade, sample_rate=0.02)
    bottom = math.sqrt(3) * gyro.angle_random_walk / gyro.bias_random_walk
    times = np.array([bottom / 3, bottom, 3 * bottom])
    found = over_runs(dd.Gyro.load(grade, sample_rate=12 / bottom, resolution=0.0), times, seed=0)
    assert found == pytest.approx(gyro.allan_deviation(times), rel=0.05)
    stated = {"mpu6050": (0.005, 4.3), "bmi088": (0.014, 2.0), "adis16495": (0.09 / 60, 0.8)}[grade]
    assert np.degrees(gyro.angle_random_walk) == pytest.approx(stated[0])
    assert 3600 * np.degrees(gyro.allan_deviation(bottom)) == pytest.approx(stated[1])
    assert (gyro.allan_deviation(times[[0, 2]]) > gyro.allan_deviation(bottom)).all()


def test_allan_deviation_of_the_published_numbers():
    """The 1000 numbers of NIST's special publication 1065 and their overlapping Allan deviation."""
    numbers = [1234567890]
    for _ in range(999):
        numbers.append(16807 * numbers[-1] % 2147483647)
    found = allan_deviation(np.array(numbers) / 2147483647, 1.0, [1, 10, 100])
    assert found == pytest.approx([2.922319e-1, 9.159953e-2, 3.241343e-2], rel=1e-6)


@pytest.mark.parametrize("grade", ["white", "walking"])
def test_the_drift_after_a_rest_is_the_scatter(grade):
    noise = {"white": {"angle_random_walk": 1e-3}, "walking": {"bias_random_walk": 1e-3}}[grade]
    gyro = dd.Gyro(sample_rate=10.0, bias=0.3, **noise)
    rates = at_rest(gyro, 50.0, 4000, 6)
    angle = (rates[:, 150:].sum(axis=-1) - 350 * rates[:, :150].mean(axis=-1)) / 10
    assert angle.std() == pytest.approx(gyro.drift(35.0, rest=15.0), rel=0.05)


def test_the_angle_of_a_walking_bias_does_not_depend_on_the_rate():
    """Its variance is K^2 T^3 / 3, whatever the number of readings."""
    for rate in (0.5, 20.0):
        angle = at_rest(dd.Gyro(sample_rate=rate, bias_random_walk=0.01), 10.0, 4000, 1).sum(axis=-1) / rate
        assert angle.std() == pytest.approx(0.01 * math.sqrt(1000 / 3), rel=0.05)


@given(st.integers(0, 2**32), st.floats(1.0, 200.0), st.floats(1.0, 300.0))
def test_the_turns_of_a_noise_free_gyro_are_those_of_the_drive(seed, recorded, rate):
    """Whatever both rates: over whole intervals of the gyro the headings come back."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 5.0, 1 / recorded)
    truth = np.zeros((3, len(t), 3))
    truth[..., 2] = np.cumsum(rng.normal(size=truth.shape[:2]), axis=-1)
    if t[-1] < 2 / rate:
        return
    log = dd.Gyro(sample_rate=rate).read(t, truth)
    expected = [np.interp(log.t, t, heading) for heading in truth[..., 2]]
    turned = truth[..., :1, 2] + np.cumsum(log.rates, axis=-1) / rate
    assert turned == pytest.approx(np.array(expected), abs=1e-9)


def test_scale_bias_range_and_resolution():
    t, truth = [0.0, 1.0, 2.0, 3.0], [(0, 0, 0), (0, 0, 1.0), (0, 0, -2.0), (0, 0, -1.5)]
    gyro = dd.Gyro(sample_rate=1.0, scale_error=0.1, bias=0.02, range=2.0, resolution=0.05)
    log = gyro.read(t, truth)
    assert log.rates == pytest.approx([1.1, -2.0, 0.55])  # 1.12, -3.28, 0.57
    assert log.at_range.tolist() == [False, True, False]
    assert "1 of 3 readings are at its range" in log.warnings[0]
    assert "1 of 3 saturated" in repr(log)


def test_rounding_is_white_noise():
    """A gyro whose noise is about its resolution: what is white in all is what `white_noise` says."""
    gyro = dd.Gyro(sample_rate=10.0, angle_random_walk=1e-3, resolution=5e-3)
    found = over_runs(gyro, np.array([0.1, 1.0, 4.0]), seed=2)
    assert found == pytest.approx(gyro.white_noise / np.sqrt([0.1, 1.0, 4.0]), rel=0.05)


angles = st.floats(-1.5, 1.5)


@given(angles, angles)
def test_a_tilted_axis_sees_the_cosine_of_a_turn_on_a_level_floor(roll, pitch):
    gyro = dd.Gyro(sample_rate=1.0, roll=roll, pitch=pitch)
    tilt = math.acos(math.cos(roll) * math.cos(pitch))
    log = gyro.read([0.0, 2.0], [(0, 0, 0), (0, 0, 1.0)])
    assert log.rates == pytest.approx([0.5 * math.cos(tilt)] * 2)
    assert np.linalg.norm(gyro.axis) == pytest.approx(1)


def product(p, q):
    """Hamilton's, as matrices of complex numbers."""

    def matrix(w, x, y, z):
        return np.array([[w + 1j * x, y + 1j * z], [-y + 1j * z, w - 1j * x]])

    m = matrix(*p) @ matrix(*q)
    return np.array([m[0, 0].real, m[0, 0].imag, m[0, 1].real, m[0, 1].imag])


@given(hnp.arrays(float, 3, elements=st.floats(-2, 2)), angles, angles, st.integers(0, 10))
def test_a_constant_rotation_in_the_body_is_seen_along_the_axis(rates, roll, pitch, seed):
    """Attitudes q_k+1 = q_k exp(w dt / 2), of either sign: each reading is w along the axis."""
    rng, dt = np.random.default_rng(seed), 0.1
    size = np.linalg.norm(rates)
    step = np.array([1.0, 0, 0, 0])
    if size > 0:
        step = np.concatenate([[math.cos(size * dt / 2)], math.sin(size * dt / 2) * rates / size])
    attitude = [np.array([0.5, 0.5, -0.5, 0.5])]
    for _ in range(20):
        attitude.append(product(attitude[-1], step))
    attitude = np.array(attitude) * rng.choice([-1, 1], size=(21, 1))
    gyro = dd.Gyro(sample_rate=10.0, roll=roll, pitch=pitch)
    log = gyro.read(dt * np.arange(21), np.zeros((21, 3)), attitude=attitude)
    assert log.rates == pytest.approx(np.full(20, rates @ gyro.axis), abs=1e-9)


def test_a_rigid_axle_of_unequal_wheels_tilts_the_gyro():
    """On a spin the body keeps its roll: the gyro sees the cosine, and a gyro rolled back sees the turn."""
    robot = dd.Robot.load("mismatched").replace(axle="rigid")
    recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=1.0), sample_rate=100.0)
    w, x, y, z = recording.attitude[0]
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    assert abs(roll) > 0.01
    turned = recording.truth[-1, 2]
    for own, seen in ((0.0, math.cos(roll)), (-roll, 1.0)):
        log = dd.Gyro(roll=own).read(recording.t, recording.truth, attitude=recording.attitude)
        assert log.rates.sum() / 100 == pytest.approx(turned * seen, rel=1e-5)


def test_the_gyro_of_a_drive_in_physics_turns_as_the_robot_does():
    robot = dd.Robot.load("matched")
    recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot, radius=0.5), sample_rate=100.0)
    drive = dd.sensors.measure(recording, gyro=dd.Gyro(sample_rate=50.0))
    assert drive.gyro is not None
    turns, seen = drive.gyro.turns(recording.t[::2])
    assert seen.all()
    assert np.cumsum(turns) == pytest.approx(recording.truth[2::2, 2], abs=1e-9)


def test_neither_encoder_nor_tracker_read_otherwise_with_a_gyro():
    robot = dd.Robot.load("matched")
    recording = dd.simulate([robot, robot], [dd.maneuvers.spin(robot, turns=0.1)] * 2, sample_rate=50.0)
    sensors = {"encoder": dd.Encoder(robot, jitter=1e-3), "tracker": dd.Tracker(position_noise=1e-3)}
    without = dd.sensors.measure(recording, **sensors, seed=3)
    both = dd.sensors.measure(recording, **sensors, gyro=dd.Gyro.load("bmi088"), seed=3)
    for one, other in zip(without, both, strict=True):
        assert one.gyro is None
        assert np.array_equal(one.wheel_angles, other.wheel_angles)
        assert np.array_equal(one.truth, other.truth)
    assert not np.array_equal(both[0].gyro.rates, both[1].gyro.rates)
    alone = dd.sensors.measure(recording, gyro=dd.Gyro.load("bmi088"), seed=3)
    assert np.array_equal(alone[1].gyro.rates, both[1].gyro.rates)


@given(hnp.arrays(float, 8, elements=st.floats(-3, 3)), st.lists(st.floats(0, 4), min_size=3, max_size=9, unique=True))
def test_turns_add_up_however_time_is_cut(rates, cuts):
    log = dd.GyroLog(0.5 * np.arange(1, 9), rates)
    times = np.array(sorted(cuts))
    times = times[np.diff(times, prepend=-1) > 1e-6]
    if len(times) < 2:
        return
    turns, seen = log.turns(times)
    whole, _ = log.turns(times[[0, -1]])
    fine = np.linspace(times[0], times[-1], 20001)
    mean = (fine[1:] + fine[:-1]) / 2
    numerically = np.sum(rates[np.minimum((mean / 0.5).astype(int), 7)]) * (fine[1] - fine[0])
    assert turns.sum() == pytest.approx(whole[0], abs=1e-9)
    assert whole[0] == pytest.approx(numerically, abs=6e-3)
    assert seen.all()


def test_what_the_gyro_did_not_see():
    """Before it begins, after it ends, in a gap, and where it saturates."""
    log = dd.GyroLog([1.0, 2.0, 3.0, 10.0, 11.0], np.ones(5), [False, True, False, False, False])
    _, seen = log.turns([-0.5, 0.0, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 10.5, 11.0, 11.5])
    assert seen.tolist() == [False, True, False, False, True, False, False, True, True, False]
    assert len(log.warnings) == 2


def test_a_reading_is_the_same_in_a_batch():
    gyro, truth = dd.Gyro(range=0.4), np.cumsum(np.full((2, 30, 3), 0.05), axis=1)
    truth[1] *= 2
    together = gyro.read(0.1 * np.arange(30), truth)
    for run in range(2):
        assert np.array_equal(gyro.read(0.1 * np.arange(30), truth[run]).rates, together.rates[run])


def test_attitudes_are_the_same_in_a_batch():
    half = np.cumsum(np.full((2, 30), 0.02), axis=1) * [[1], [-1.5]]
    attitude = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)
    gyro, truth, t = dd.Gyro(sample_rate=5.0, pitch=0.2), np.zeros((2, 30, 3)), 0.1 * np.arange(30)
    together = gyro.read(t, truth, attitude=attitude)
    for run, rate in enumerate((0.4, -0.6)):
        assert np.array_equal(gyro.read(t, truth[run], attitude=attitude[run]).rates, together.rates[run])
        assert together.rates[run] == pytest.approx(rate * math.cos(0.2))


def test_bad_gyros_are_refused():
    for field, value, words in (
        ("range", 0.0, "Gyro.range = 0.0: must be positive"),
        ("range", -1.0, "must be positive"),
        ("sample_rate", 0.0, "must be positive"),
        ("angle_random_walk", -1e-3, "must not be negative"),
        ("scale_error", -1.0, "reads nothing"),
        ("pitch", 1.6, "quarter turn"),
        ("bias", math.nan, "must be finite"),
    ):
        with refused(ValueError, f"Gyro.{field}", words):
            dd.Gyro(**{field: value})
    with refused(ValueError, "must not be above its range"):
        dd.Gyro(range=1.0, resolution=2.0)
    with refused(KeyError, "unknown gyro 'mpu6500'", "mpu6050"):
        dd.Gyro.load("mpu6500")


def test_bad_readings_are_refused():
    with refused(TypeError, "rng"):
        dd.Gyro(angle_random_walk=1e-3).read([0.0, 1.0], STILL)
    with refused(ValueError, "too short"):
        dd.Gyro(sample_rate=1.0).read([0.0, 1.5], STILL)
    with refused(ValueError, "attitude has shape"):
        dd.Gyro().read([0.0, 1.0], STILL, attitude=np.ones((3, 4)))
    with refused(ValueError, "below half a turn"):
        dd.Gyro().read([0.0, 1.0], [(0, 0, 0), (0, 0, 4.0)], attitude=np.ones((2, 4)))
    with refused(ValueError, "seed = None", "gyro's noise"):
        robot = dd.Robot.load("matched")
        recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.1), sample_rate=50.0)
        dd.sensors.measure(recording, gyro=dd.Gyro.load("bmi088"))
    with refused(ValueError, "must be those of one run"):
        dd.Drive([0.0, 1.0], np.zeros((2, 2)), STILL, gyro=dd.GyroLog([0.0, 1.0], np.zeros((3, 2))))
    for time in (0.4, 6.0):
        with refused(ValueError, "averaging_time", "half of the readings, 5 s"):
            allan_deviation(np.zeros(10), 1.0, [time])
