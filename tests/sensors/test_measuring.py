"""From recordings to drives: what the tracker and the encoders write down, and where the randomness comes from."""

import dataclasses
import math

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.sensors import measure

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3, name="mine")
T = np.arange(401) * 0.01
# Both wheels at rates that change all the time.
ANGLES = np.stack([8 * T + np.sin(T), 7 * T - np.cos(2 * T) + 1], axis=-1)
TRUTH = dd.odometry.integrate(ANGLES, ROBOT, start=(1.0, -2.0, 0.5))


def recording(runs=None):
    rest = (dd.World(), dd.Physics())
    commands = dd.Commands(1.0, [[0.0, 0.0]])
    if runs is None:
        return dd.Recording(T, ANGLES, TRUTH, ROBOT, commands, *rest)
    robots = tuple(ROBOT.replace(name=f"robot {chr(97 + k)}") for k in range(runs))
    return dd.Recording(T, np.stack([ANGLES] * runs), np.stack([TRUTH] * runs), robots, (commands,) * runs, *rest)


# Ideal


def test_ideal_sensors_change_no_bit():
    drive = measure(recording())
    assert drive.name == "mine"
    for got, recorded in ((drive.t, T), (drive.clock, T), (drive.wheel_angles, ANGLES), (drive.truth, TRUTH)):
        np.testing.assert_array_equal(got, recorded)


def test_many_runs_make_a_list_of_drives():
    drives = measure(recording(3))
    assert [drive.name for drive in drives] == ["robot a, run 1", "robot b, run 2", "robot c, run 3"]
    for drive in drives:
        np.testing.assert_array_equal(drive.truth, TRUTH)
    (single,) = measure(recording(1))
    assert single.name == "robot a, run 1"


def test_a_tracker_at_a_rate_of_its_own_keeps_recorded_poses_bit_for_bit():
    drive = measure(recording(), tracker=dd.Tracker(sample_rate=20.0))
    np.testing.assert_array_equal(drive.t, T)
    np.testing.assert_allclose(drive.clock, T[::5], atol=1e-12)
    np.testing.assert_array_equal(drive.truth, TRUTH[::5])


def test_recorded_poses_stay_as_they_are_however_fast_the_robot_turns():
    """Between them a turn of 4 rad a sample is taken for one the shorter way; they themselves are what they are."""
    t = np.arange(4.0)
    truth = np.stack([t, -t, 4 * t], axis=-1)
    np.testing.assert_array_equal(dd.Tracker(sample_rate=1.0).read(t, truth).poses, truth)


def test_between_recorded_poses_the_robot_moves_on_arcs():
    """A circle recorded thrice a second: at 7 Hz all poses lie on it, at the angles that the time says."""
    t = np.arange(10) / 3
    circle = np.stack([np.sin(t), 1 - np.cos(t), t], axis=-1)
    track = dd.Tracker(sample_rate=7.0).read(t, circle)
    np.testing.assert_allclose(track.t, np.arange(22) / 7)
    expected = np.stack([np.sin(track.t), 1 - np.cos(track.t), track.t], axis=-1)
    np.testing.assert_allclose(track.poses, expected, atol=1e-12)


# The tracker's faults


def test_the_marker_is_where_it_is_mounted():
    """x forward and y to the left of the axle's midpoint, its own axis turned by the angle."""
    poses = dd.Tracker(x=0.1, y=-0.02, angle=0.3).read(T, TRUTH).poses
    x, y, theta = TRUTH.T
    np.testing.assert_allclose(poses[:, 0], x + 0.1 * np.cos(theta) + 0.02 * np.sin(theta), atol=1e-14)
    np.testing.assert_allclose(poses[:, 1], y + 0.1 * np.sin(theta) - 0.02 * np.cos(theta), atol=1e-14)
    np.testing.assert_allclose(poses[:, 2], theta + 0.3, atol=1e-14)


def test_a_clock_offset_stamps_the_same_poses_later():
    track = dd.Tracker(clock_offset=0.25).read(T, TRUTH)
    np.testing.assert_array_equal(track.poses, TRUTH)
    np.testing.assert_allclose(track.t - T, 0.25)
    drive = measure(recording(), tracker=dd.Tracker(clock_offset=0.25))
    assert drive.dropped == 25
    np.testing.assert_array_equal(drive.truth, TRUTH[:-25])


def test_gaps_are_times_without_poses():
    track = dd.Tracker(gaps=((0.0, 0.5), (1.0, 2.0))).read(T, TRUTH)
    kept = np.r_[50:100, 200:401]
    np.testing.assert_array_equal(track.t, T[kept])
    np.testing.assert_array_equal(track.poses, TRUTH[kept])
    with refused(ValueError, "Tracker.gaps", "must leave at least one pose"):
        dd.Tracker(gaps=[(0.0, 9.0)]).read(T, TRUTH)


def test_noise_is_white_and_as_large_as_said():
    """The mean square of N normal numbers is off by sqrt(2 / N) of itself, one standard deviation."""
    many = np.broadcast_to(TRUTH, (200, *TRUTH.shape))
    tracker = dd.Tracker(position_noise=0.02, heading_noise=0.003)
    noise = tracker.read(T, many, np.random.default_rng(0)).poses - TRUTH
    count = noise[..., 0].size
    for axis, sigma in enumerate((0.02, 0.02, 0.003)):
        assert np.mean(noise[..., axis] ** 2) / sigma**2 == pytest.approx(1.0, abs=5 * math.sqrt(2 / count))
        following = np.mean(noise[:, 1:, axis] * noise[:, :-1, axis]) / sigma**2
        assert following == pytest.approx(0.0, abs=5 / math.sqrt(count))
    assert abs(np.corrcoef(noise[..., 0].ravel(), noise[..., 1].ravel())[0, 1]) < 5 / math.sqrt(count)


# Both together


def test_an_encoder_of_the_robot_is_off_by_less_than_a_tick():
    encoder = dd.Encoder(ticks_per_revolution=360, sample_rate=50.0)
    drive = measure(recording(), encoder=encoder, seed=3)
    np.testing.assert_allclose(drive.t, T[::2], atol=1e-12)
    off = drive.wheel_angles - (ANGLES[::2] - ANGLES[0])
    assert np.abs(off).max() < encoder.tick_angle
    ticks = drive.wheel_angles / encoder.tick_angle
    np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-9)


def test_the_counters_start_at_random_phases():
    """At rest nothing is counted; in motion one drive is counted in many ways."""
    encoder = dd.Encoder(ticks_per_revolution=60, sample_rate=50.0)
    ends = {tuple(measure(recording(), encoder=encoder, seed=seed).wheel_angles[-1].tolist()) for seed in range(20)}
    assert len(ends) == 4  # either wheel a tick more or less


def test_each_run_draws_from_streams_of_its_own():
    """Neither more runs nor another tracker change what a run's encoder reads."""
    encoder = dd.Encoder(ticks_per_revolution=60, sample_rate=50.0, jitter=0.002)
    noisy = dd.Tracker(position_noise=1e-3)
    few = measure(recording(2), encoder=encoder, seed=7)
    more = measure(recording(5), encoder=encoder, tracker=noisy, seed=7)
    for one, other in zip(few, more, strict=False):
        np.testing.assert_array_equal(one.wheel_angles, other.wheel_angles)
    assert not np.array_equal(more[0].wheel_angles, more[1].wheel_angles)
    assert not np.array_equal(more[0].truth, more[1].truth)


def test_seeds_are_numbers_sequences_or_generators():
    noisy = dd.Tracker(position_noise=1e-3)
    reference = measure(recording(), tracker=noisy, seed=5)
    for seed in (np.int64(5), np.random.SeedSequence(5), np.random.default_rng(5)):
        np.testing.assert_array_equal(measure(recording(), tracker=noisy, seed=seed).truth, reference.truth)
    rng = np.random.default_rng(5)
    first, second = (measure(recording(), tracker=noisy, seed=rng).truth for _ in range(2))
    assert not np.array_equal(first, second)


# Refusals


@pytest.mark.parametrize(
    ("fields", "builtin", "words"),
    [
        ({"sample_rate": 0.0}, ValueError, "Tracker.sample_rate = 0.0: must be positive"),
        ({"position_noise": -1.0}, ValueError, "Tracker.position_noise"),
        ({"heading_noise": math.nan}, ValueError, "Tracker.heading_noise"),
        ({"x": "0.1"}, TypeError, "Tracker.x"),
        ({"clock_offset": math.inf}, ValueError, "Tracker.clock_offset"),
        ({"gaps": 3.0}, TypeError, "Tracker.gaps = 3.0: must be a tuple of (start, end)"),
        ({"gaps": ((1.0, 1.0),)}, ValueError, "Tracker.gaps: (1, 1): must end after they start"),
        ({"gaps": ((1.0, 2.0, 3.0),)}, ValueError, "Tracker.gaps has shape (3,)"),
    ],
)
def test_a_tracker_out_of_range_is_named(fields, builtin, words):
    with refused(builtin, words):
        dd.Tracker(**fields)


def test_what_cannot_be_measured_is_refused():
    noisy = dd.Tracker(heading_noise=1e-3)
    encoder = dd.Encoder(ticks_per_revolution=60, sample_rate=50.0)
    with refused(ValueError, "seed = None", "the tracker's noise is random"):
        measure(recording(), tracker=noisy)
    with refused(ValueError, "seed = None", "phase of the encoder's counters is random"):
        measure(recording(), encoder=encoder)
    for seed in ("0", 1.5, True, [1, 2]):
        with refused(TypeError, f"seed = {seed!r}"):
            measure(recording(), tracker=noisy, seed=seed)
    with refused(ValueError, "seed = -1: must be at least 0"):
        measure(recording(), tracker=noisy, seed=-1)
    with refused(TypeError, "recording = a Drive: must be a Recording"):
        measure(measure(recording()))
    with refused(TypeError, "encoder = a Tracker: must be an Encoder"):
        measure(recording(), encoder=noisy, seed=0)
    with refused(TypeError, "tracker = 20.0: must be a Tracker"):
        measure(recording(), tracker=20.0)
    with refused(TypeError, "rng = None: must be a numpy Generator"):
        noisy.read(T, TRUTH)
    with refused(ValueError, "t has shape"):
        noisy.read(T[:-1], TRUTH)


# The physics


def test_a_simulated_batch_becomes_drives_that_its_robots_explain():
    robots = [ROBOT, ROBOT.replace(right_radius=0.051, name="other")]
    simulated = dd.simulate(robots, dd.maneuvers.square(ROBOT, side=0.5, speed=0.3))
    for drive, robot in zip(measure(simulated, tracker=dd.Tracker(sample_rate=20.0)), robots, strict=True):
        assert drive.drift(robot).max_position < 1e-5
        assert drive.drift(robot.replace(track_width=0.31)).max_position > 1e-2


def test_readings_print_what_they_are():
    assert repr(dd.Tracker(sample_rate=1.0).read(T, TRUTH)) == "Track(5 poses, 0 to 4 s)"
    many = np.broadcast_to(TRUTH, (2, *TRUTH.shape))
    assert repr(dd.Tracker(sample_rate=1.0).read(T, many)) == "Track((2,) runs of 5 poses, 0 to 4 s)"
    assert dataclasses.replace(dd.Tracker(x=0.1), y=0.2) == dd.Tracker(x=0.1, y=0.2)


@pytest.mark.parametrize("seed", ["x", 1.5, None, [1]])
def test_a_seed_that_is_none_is_named_with_what_it_may_be(seed):
    words = "must be given" if seed is None else "must be a whole number, a SeedSequence or a Generator"
    with refused(ValueError if seed is None else TypeError, "seed", words):
        measure(recording(), tracker=dd.Tracker(position_noise=1e-3), seed=seed)
