"""The wheel encoder: ticks, wraps, late and shaken readings, faults, and what is refused."""

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers import refused
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from strategies import drives, numbers, robots, sizes

import diffdrive_mj as dd
from diffdrive_mj.sensors._counters import unwrap_counts, wrap_counts
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.optical_flow import count_error_covariance

BITS = (16, 32)
# Sampling intervals and latencies that are whole numbers of these are exact in binary.
FINE = 1 / 1024
resolutions = sizes(1, 1e6)
phases = st.tuples(numbers(-3, 3), numbers(-3, 3))


def plain(ticks=1000.0, rate=100.0, **others):
    return Encoder(ticks_per_revolution=ticks, sample_rate=rate, **others)


def at_every_sample(angles, ticks=1000.0, **others):
    """The counts of an encoder that is read once at every sample."""
    return plain(ticks, 1.0, **others).read(np.arange(len(angles)), angles, phase=0).counts


def ramp(rates=(3.0, -2.0), duration=4.0):
    """Wheels at constant rates, recorded at 1024 Hz: times (T,), angles (T, 2)."""
    t = np.arange(round(duration / FINE) + 1) * FINE
    return t, t[:, None] * rates


def wander(seed=0, duration=4.0):
    """Wheels whose rates vary, forwards and backwards, recorded at 1024 Hz."""
    t = np.arange(round(duration / FINE) + 1) * FINE
    a, b, c, d = np.random.default_rng(seed).uniform(1, 4, 4)
    return t, np.stack([a * np.sin(b * t), c * np.sin(d * t) - t], axis=-1)


# Resolution


def test_the_ct_bot():
    """60 marks a turn on wheels of 56.7 mm, 97.2 mm apart."""
    robot = dd.Robot.load("ct_bot")
    made = Encoder(robot, sample_rate=100)
    assert made.tick_angle == pytest.approx(math.radians(6), rel=1e-15)
    assert made.distance_per_tick(robot) == pytest.approx([2.96881e-3] * 2, abs=5e-9)
    assert np.degrees(made.heading_per_tick(robot)) == pytest.approx([-1.750, 1.750], abs=5e-4)


@given(robots, resolutions)
def test_a_tick_of_one_wheel_moves_the_odometry_by_its_share(robot, ticks):
    made = plain(ticks)
    for wheel in (0, 1):
        counts = np.zeros((2, 2), dtype=int)
        counts[1, wheel] = 1
        x, y, turn = dd.odometry.integrate(made.to_angles(counts), robot)[-1]
        assert turn == pytest.approx(made.heading_per_tick(robot)[wheel], rel=1e-12)
        half = turn / 2
        assert math.hypot(x, y) == pytest.approx(
            made.distance_per_tick(robot)[wheel] / 2 * abs(math.sin(half) / half), rel=1e-9
        )


def test_a_gear_multiplies_the_ticks():
    geared = plain(64, gear=43.7)
    assert geared.tick_angle == pytest.approx(2 * math.pi / 2796.8, rel=1e-15)
    assert geared == Encoder(dd.Robot.load("optiodom"), sample_rate=geared.sample_rate)
    t, angles = wander()
    np.testing.assert_array_equal(geared.read(t, angles).counts, plain(64 * 43.7).read(t, angles).counts)


def test_of_a_robot_takes_the_other_fields():
    made = Encoder(dd.Robot.load("turtlebot3_burger"), sample_rate=20, latency=0.01, counter_bits=32, swapped=True)
    assert made == plain(4096, 20, latency=0.01, counter_bits=32, swapped=True)
    with pytest.raises(TypeError, match="got an unexpected keyword argument 'latncy'"):
        Encoder(dd.Robot.load("ct_bot"), sample_rate=20, latncy=1.0)
    with refused(TypeError, "robot = 'ct_bot': must be a Robot; Robot.load('ct_bot') gives that preset"):
        Encoder("ct_bot", sample_rate=20)


def test_a_robot_is_enough_and_what_is_given_goes_first():
    robot = dd.Robot.load("optiodom")
    assert Encoder(robot) == plain(64, 100.0, gear=43.7)
    assert Encoder(robot, gear=2.0) == plain(64, 100.0, gear=2.0)
    assert Encoder(robot, ticks_per_revolution=10) == plain(10, 100.0, gear=43.7)
    assert replace(Encoder(robot), sample_rate=20.0) == plain(64, 20.0, gear=43.7)
    with refused(TypeError, "Encoder(...): needs a robot or ticks_per_revolution"):
        Encoder(sample_rate=50.0)


# Counting


@given(drives(), resolutions, phases)
def test_a_counter_holds_the_floor(angles, ticks, phase):
    made = plain(ticks, 1.0)
    read = made.read(np.arange(len(angles)), angles, phase=phase)
    np.testing.assert_array_equal(read.t, np.arange(len(angles)))
    np.testing.assert_array_equal(read.counts, np.floor(angles / made.tick_angle + phase))
    assert read.counts.dtype == np.int64


@given(drives(), resolutions, phases)
def test_angles_come_back_within_a_tick(angles, ticks, phase):
    """At every reading, forwards or backwards, however far; the first is zero."""
    made = plain(ticks, 1.0)
    back = made.to_angles(made.read(np.arange(len(angles)), angles, phase=phase).counts)
    np.testing.assert_array_equal(back[0], 0)
    assert np.abs(back - (angles - angles[0])).max() < made.tick_angle * (1 + 1e-9)


def test_by_default_a_counter_rounds():
    """A wheel that trembles about its start by less than half a tick reads zero."""
    tick = plain().tick_angle
    t, angles = np.arange(4), np.array([[0, 0], [1e-12, -1e-12], [-0.49, 0.49], [0.51, -0.51]]) * (tick, tick)
    np.testing.assert_array_equal(plain(rate=1).read(t, angles).counts, [[0, 0], [0, 0], [0, 0], [1, -1]])
    np.testing.assert_array_equal(plain(rate=1).read(t, angles, phase=0).counts[:, 0], [0, 0, -1, 0])


@given(drives(), resolutions)
def test_the_way_back_reads_the_same(angles, ticks):
    counts = at_every_sample(np.concatenate([angles, angles[::-1]]), ticks)
    np.testing.assert_array_equal(counts, counts[::-1])


@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.5, 0.83])
def test_over_random_phases_a_counter_is_right_on_average(fraction):
    """E floor(x + U) = x, with the variance f (1 - f): what `count_error_covariance` says."""
    runs, made = 20_000, plain(rate=1)
    moved = np.broadcast_to([(0, 0), (made.tick_angle * (7 + fraction), -made.tick_angle * 3)], (runs, 2, 2))
    counts = made.read([0, 1], moved, np.random.default_rng(1), phase="random").counts
    ticks = (counts[:, 1] - counts[:, 0])[:, 0]
    variance = count_error_covariance([7 + fraction])[0, 0]
    assert variance == pytest.approx(fraction * (1 - fraction), abs=1e-12)
    assert ticks.mean() == pytest.approx(7 + fraction, abs=4 * math.sqrt(variance / runs) + 1e-9)
    assert ticks.var() == pytest.approx(variance, abs=0.01)


def test_random_phases_are_uniform_and_each_wheels_own():
    """At a wheel angle of half a tick the counter shows one in half of the runs."""
    runs, made = 4000, plain(rate=1)
    angles = np.broadcast_to(np.full((2, 2), made.tick_angle / 2), (runs, 2, 2))
    counts = made.read([0, 1], angles, np.random.default_rng(2), phase="random").counts[:, 0]
    assert set(counts.ravel()) == {0, 1}
    assert counts.mean(axis=0) == pytest.approx([0.5, 0.5], abs=0.03)
    assert np.mean(counts[:, 0] == counts[:, 1]) == pytest.approx(0.5, abs=0.03)


# Times


def test_stamps_start_with_the_recording_and_readings_lie_inside_it():
    t, angles = ramp(duration=1.0)
    for start in (0.0, 12.5, -3.0):
        np.testing.assert_allclose(plain(rate=4).read(start + t, angles).t, start + np.arange(5) / 4, rtol=1e-15)
    np.testing.assert_array_equal(plain(rate=4, latency=0.25).read(t, angles).t, np.arange(1, 5) / 4)
    np.testing.assert_array_equal(plain(rate=4, latency=0.3).read(t, angles).t, np.arange(2, 5) / 4)
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(plain(rate=4, jitter=0.1).read(t, angles, rng).t, np.arange(1, 4) / 4)
    np.testing.assert_array_equal(plain(rate=4, jitter=0.1, latency=0.1).read(t, angles, rng).t, np.arange(1, 5) / 4)
    np.testing.assert_array_equal(plain(rate=3).read(t, angles).t, np.arange(4) / 3)


@given(st.integers(1, 7), numbers(0.5, 500.0))
def test_between_samples_the_wheels_turn_evenly(seed, rate):
    """The recorded angles, interpolated; an encoder of 2^30 ticks shows them to 1e-8 rad."""
    t, angles = wander(seed)
    made = plain(2.0**30, rate)
    read = made.read(t, angles)
    expected = np.stack([np.interp(read.t, t, side) for side in angles.T], axis=-1)
    np.testing.assert_allclose(read.counts * made.tick_angle, expected, rtol=0, atol=1.01 * made.tick_angle)


def test_times_need_not_be_even():
    t = np.array([0.0, 0.1, 0.7, 2.0])
    angles = np.stack([t, -2 * t], axis=-1)
    made = plain(2.0**30, 10.0)
    read = made.read(t, angles)
    assert len(read.t) == 21
    np.testing.assert_allclose(made.to_angles(read.counts), np.stack([read.t, -2 * read.t], axis=-1), atol=1e-8)


def test_reading_at_recorded_times_reads_the_recorded_angles():
    """Tenths of seconds are no binary numbers; no rounding of the times moves an angle that lies on an edge."""
    edges = plain(8).tick_angle * np.stack([np.arange(1000), -np.arange(1000)], axis=-1)
    for start, latency in ((0.0, 0.0), (7.3, 0.0), (0.0, 0.1 + 0.2), (7.3, 0.7)):
        made = plain(8, 10.0, latency=latency)
        read = made.read(start + np.arange(1000) * 0.1, edges, phase=0)
        late = round(latency / 0.1)
        assert len(read.t) == 1000 - late
        np.testing.assert_array_equal(read.counts, np.floor(edges / made.tick_angle)[: 1000 - late])


def test_a_standing_wheel_reads_the_same_even_on_an_edge():
    tick = plain().tick_angle
    t, standing = np.arange(4), np.ones((4, 1)) * (tick * np.arange(1, 1001))
    angles = np.stack([standing.T, -standing.T], axis=-1)
    counts = plain(rate=7).read(t, angles, phase=0).counts
    assert (counts == counts[:, :1]).all()


def test_the_last_recorded_time_is_read():
    """0.29 * 100 is less than 29."""
    t = np.arange(30) * 0.01
    np.testing.assert_allclose(plain(rate=100).read(t, np.zeros((30, 2))).t, t, rtol=1e-15)


@given(st.integers(0, 512), st.integers(0, 9), resolutions)
def test_latency_shifts_exactly(late, seed, ticks):
    """What is stamped t is what an encoder without latency reads at t - latency, to the bit."""
    t, angles = wander(seed)
    read = plain(ticks, 64.0, latency=late * FINE).read(t, angles)
    every = plain(ticks, 1024.0).read(t, angles)
    places = np.round(read.t / FINE).astype(int) - late
    assert places[0] == -late % 16
    np.testing.assert_array_equal(read.counts, every.counts[places])


def test_jitter_shakes_the_times_of_both_wheels_together():
    """At constant rates the angles are off by rate times u, u uniform in [-jitter, jitter)."""
    t, angles = ramp((3.0, -6.0), duration=40.0)
    made = plain(2.0**30, 100.0, jitter=0.004)
    read = made.read(t, angles, np.random.default_rng(3))
    u = read.counts * made.tick_angle / (3.0, -6.0) - read.t[:, None]
    np.testing.assert_allclose(u[:, 0], u[:, 1], rtol=0, atol=1e-8)
    assert np.abs(u).max() <= 0.004 + 1e-8
    assert u.mean() == pytest.approx(0, abs=4 * 0.004 / math.sqrt(3 * len(u)))
    assert u.std() == pytest.approx(0.004 / math.sqrt(3), rel=0.03)
    assert abs(np.corrcoef(u[1:, 0], u[:-1, 0])[0, 1]) < 4 / math.sqrt(len(u))


@given(st.integers(0, 99))
def test_shaken_readings_keep_their_order(seed):
    t, angles = ramp((3.0, -6.0), duration=2.0)
    read = plain(2.0**30, 20.0, jitter=0.02499).read(t, angles, np.random.default_rng(seed))
    assert (np.diff(read.counts, axis=0) * (1, -1) > 0).all()


def test_jitter_comes_on_top_of_latency():
    t, angles = ramp((2.0, 2.0), duration=20.0)
    made = plain(2.0**30, 50.0, latency=0.1, jitter=0.001)
    read = made.read(t, angles, np.random.default_rng(0))
    late = read.t - read.counts[:, 0] * made.tick_angle / 2.0
    assert late.min() >= 0.099 - 1e-8
    assert late.max() <= 0.101 + 1e-8
    assert late.mean() == pytest.approx(0.1, abs=1e-4)


# Wrapping


def paths(bits, most=40):
    """Counts (T, 2) whose jumps are below half the range of a counter, both ways."""
    half = 2 ** (bits - 1)
    shape = st.tuples(st.integers(1, most), st.just(2))
    jumps = hnp.arrays(np.int64, shape, elements=st.integers(-half + 1, half - 1))
    return jumps.map(lambda steps: steps.cumsum(axis=0))


@pytest.mark.parametrize("bits", BITS)
@given(st.data())
def test_unwrapping_undoes_wrapping(bits, data):
    path = data.draw(paths(bits))
    shown = wrap_counts(path, bits)
    assert shown.min() >= -(2 ** (bits - 1))
    assert shown.max() < 2 ** (bits - 1)
    assert ((shown - path) % 2**bits == 0).all()
    back = unwrap_counts(shown, bits)
    np.testing.assert_array_equal(back - back[0], path - path[0])
    np.testing.assert_array_equal(back[0], shown[0])


@pytest.mark.parametrize("bits", BITS)
@given(st.data())
def test_counters_without_sign_unwrap_too(bits, data):
    path = data.draw(paths(bits))
    shown = (path % 2**bits).astype(f"uint{bits}")
    back = unwrap_counts(shown, bits)
    np.testing.assert_array_equal(back - back[0], path - path[0])


@pytest.mark.parametrize(("bits", "kind"), [(16, np.int16), (32, np.int32)])
def test_wrapping_is_twos_complement(bits, kind):
    edge = 2 ** (bits - 1)
    path = np.array([[0, 0], [edge - 1, -edge + 1], [edge, -edge], [edge + 1, -edge - 1], [2 * edge, -2 * edge]])
    np.testing.assert_array_equal(wrap_counts(path, bits), path.astype(kind))
    assert wrap_counts(path, bits)[2:4, 0].tolist() == [-edge, -edge + 1]
    assert wrap_counts(path, bits)[2:4, 1].tolist() == [-edge, edge - 1]


@pytest.mark.parametrize("bits", BITS)
@pytest.mark.parametrize("direction", [1, -1])
def test_wheels_turn_through_many_wraps(bits, direction):
    """Ten ranges one way with one wheel, the other way with the other: angles come back within a tick."""
    ticks = 2.0**bits / 8
    t = np.arange(1000) * 0.01
    angles = direction * np.linspace(0, 10 * 8 * 2 * np.pi, 1000)[:, None] * (1, -1)
    made = plain(ticks, 100.0, counter_bits=bits)
    read = made.read(t, angles)
    assert np.abs(read.counts).max() <= 2 ** (bits - 1)
    jumps = np.abs(np.diff(read.counts, axis=0)) > 2 ** (bits - 1)
    assert (jumps.sum(axis=0) == 10).all()
    np.testing.assert_allclose(made.to_angles(read.counts), angles, rtol=0, atol=made.tick_angle)
    np.testing.assert_array_equal(
        made.to_angles(read.counts), plain(ticks).to_angles(plain(ticks).read(t, angles).counts)
    )


def test_without_bits_nothing_wraps():
    path = np.array([[0, 0], [2**40, -(2**40)], [3, 3]])
    np.testing.assert_array_equal(wrap_counts(path, None), path)
    np.testing.assert_array_equal(unwrap_counts(path, None), path)
    np.testing.assert_array_equal(unwrap_counts(path.astype(float), None), path)


@pytest.mark.parametrize("bits", BITS)
def test_a_jump_of_half_the_range_goes_neither_way(bits):
    half = 2 ** (bits - 1)
    for before, after in ((0, -half), (-half, 0), (5, 5 - half)):
        shown = np.array([[0, before], [0, after]])
        with refused(ValueError, "right at reading 1 jumps by", f"exactly half of the range of {bits} bits"):
            unwrap_counts(shown, bits)
    longest = np.array([[0, 0], [half - 1, 1 - half]])
    np.testing.assert_array_equal(unwrap_counts(longest, bits), longest)


def test_a_jump_beyond_half_the_range_is_taken_the_shorter_way():
    """Counts alone cannot tell; the wheel's largest rate can."""
    shown = np.array([[0, 0], [30_000, 0], [-30_000, 0]])
    assert unwrap_counts(shown, 16)[-1, 0] == 2**16 - 30_000
    assert unwrap_counts(shown, 16, max_step=30_000)[-1, 0] == 2**16 - 30_000
    with refused(ValueError, "left at reading 1 jumps by 30000 ticks", "at most max_step = 29999"):
        unwrap_counts(shown, 16, max_step=29_999)
    with refused(ValueError, "run [1], right at reading 2 jumps by -7 ticks", "max_step = 6"):
        unwrap_counts([[[0, 0]] * 3, [[0, 0], [0, 0], [0, -7]]], None, max_step=6)
    with refused(ValueError, "max_step = 32768", "below 32768", "read more often"):
        unwrap_counts(shown, 16, max_step=32_768)


def test_the_largest_rate_of_a_wheel_limits_the_jumps():
    """At 10 rad/s and 100 Hz a wheel moves by 0.1 rad, 15.9 ticks of 1000: 16 edges at most, or 17 with jitter."""
    made = plain(1000, 100)
    for most in (16, -16):
        assert made.to_angles([[0, 0], [0, most]], max_rate=10.0)[1, 1] == most * made.tick_angle
        with refused(ValueError, "right at reading 1 jumps by", "max_step = 16"):
            made.to_angles([[0, 0], [0, most + np.sign(most)]], max_rate=10.0)
    assert plain(1000, 100, jitter=0.0005).to_angles([[0, 0], [0, 18]], max_rate=10.0)[1, 1] == 18 * made.tick_angle
    with refused(ValueError, "max_step", "read more often"):
        plain(2.0**20, 1, counter_bits=16).to_angles([[0, 0], [0, 1]], max_rate=1.0)
    for bad in (0, -1.0, math.nan):
        with refused(ValueError, "max_rate"):
            made.to_angles([[0, 0], [0, 1]], max_rate=bad)


@given(drives(), resolutions, st.integers(0, 99))
def test_no_drive_within_the_rate_is_refused(angles, ticks, seed):
    """Wheels of at most 2 rad a second, read once a second with much jitter, in any phase."""
    made = plain(ticks, 1.0, jitter=0.4)
    assume(len(angles) > 4)
    read = made.read(np.arange(len(angles)), angles, np.random.default_rng(seed), phase="random")
    made.to_angles(read.counts, max_rate=2.0)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_wheel_too_fast_for_its_counter_is_refused_when_read(direction):
    ticks, t = 2.0**16, np.arange(5)
    turned = direction * np.array([0, 0.1, 0.2, 0.2 + 0.5, 0.8]) * 2 * np.pi
    angles = np.stack([np.zeros(5), turned], axis=-1)
    with refused(ValueError, "right at reading 3 jumps by", "16 bits", "32768", "read it more often"):
        plain(ticks, 1.0, counter_bits=16).read(t, angles)
    assert plain(ticks, 1.0, counter_bits=32).read(t, angles).counts[3, 1] == pytest.approx(
        direction * 0.7 * 2**16, abs=1
    )
    back = plain(ticks, 2.0, counter_bits=16)
    np.testing.assert_allclose(
        back.to_angles(back.read(t, angles).counts)[::2], angles, rtol=0, atol=1.01 * back.tick_angle
    )


# Faults


@given(st.integers(0, 9), st.booleans(), st.booleans())
def test_swapped_wheels(seed, left, right):
    """The reversal belongs to the wheel, whatever counter it is plugged into."""
    t, angles = wander(seed)
    straight = plain(reversed=(left, right)).read(t, angles, phase=(0.1, 0.7))
    crossed = plain(reversed=(left, right), swapped=True).read(t, angles, phase=(0.1, 0.7))
    np.testing.assert_array_equal(crossed.counts, straight.counts[:, ::-1])


def test_reversed_wheels():
    t, angles = wander()
    both = plain(reversed=(True, True)).read(t, angles, phase=0.3).counts
    np.testing.assert_array_equal(both, plain().read(t, -angles, phase=0.3).counts)
    left = plain(reversed=[True, False]).read(t, angles, phase=0.3).counts
    np.testing.assert_array_equal(left[:, 0], both[:, 0])
    np.testing.assert_array_equal(left[:, 1], plain().read(t, angles, phase=0.3).counts[:, 1])


def test_faults_stay_in_the_angles():
    """Swapped wheels turn the other way, reversed ones drive backwards: what a builder sees."""
    robot = dd.Robot.load("matched")
    t, angles = ramp((4.0, 5.0), duration=2.0)

    def believed(**faults):
        made = plain(4096, **faults)
        return dd.odometry.integrate(made.to_angles(made.read(t, angles).counts), robot)[-1]

    x, y, turn = believed()
    assert turn > 0.1
    assert believed(swapped=True) == pytest.approx((x, -y, -turn), abs=2e-3)
    assert believed(reversed=(True, True)) == pytest.approx((-x, y, -turn), abs=2e-3)
    assert believed(swapped=True, reversed=(True, True)) == pytest.approx((-x, -y, turn), abs=2e-3)


def test_missed_ticks_are_binomial():
    """Of n edges (1 - p) n are counted, with the variance n p (1 - p), both ways."""
    runs, p = 400, 0.05
    t, angles = ramp((20.0, -20.0), duration=4.0)
    exact = plain().read(t, angles, phase=0).counts
    made = plain(missed_ticks=p)
    counts = made.read(t, np.broadcast_to(angles, (runs, *angles.shape)), np.random.default_rng(4), phase=0).counts
    edges = np.abs(exact[-1] - exact[0])
    seen = np.abs(counts[:, -1] - counts[:, 0])
    sigma = np.sqrt(edges * p * (1 - p))
    assert (np.sign(counts[:, -1]) == (1, -1)).all()
    assert np.abs(seen.mean(axis=0) - (1 - p) * edges).max() < 4 * sigma.max() / math.sqrt(runs)
    assert seen.std(axis=0) == pytest.approx(sigma, rel=0.15)
    assert abs(np.corrcoef(seen.T)[0, 1]) < 4 / math.sqrt(runs)
    steps = np.diff(counts, axis=1) * (1, -1)
    assert steps.min() >= 0
    assert (steps <= np.diff(exact, axis=0) * (1, -1)).all()


def test_a_standing_wheel_misses_nothing():
    t = np.arange(100) * 0.01
    angles = np.full((100, 2), 1.234)
    counts = plain(missed_ticks=0.9).read(t, angles, np.random.default_rng(0)).counts
    assert (counts == counts[0]).all()


def test_missed_ticks_do_not_come_back():
    """There and back again: forwards and backwards edges are missed alike, each on its own."""
    t = np.arange(401) * 0.01
    angles = (2 - np.abs(t - 2))[:, None] * (30.0, 30.0)
    made = plain(missed_ticks=0.2)
    ends = made.read(t, np.broadcast_to(angles, (300, 401, 2)), np.random.default_rng(5), phase=0).counts[:, -1]
    edges = 2 * 60.0 / made.tick_angle
    assert ends.std() == pytest.approx(math.sqrt(edges * 0.2 * 0.8), rel=0.1)
    assert abs(ends.mean()) < 4 * math.sqrt(edges * 0.16 / 600)


# Many runs, and the generator

ALL = {"latency": 0.02, "jitter": 0.002, "missed_ticks": 0.01, "counter_bits": 16, "swapped": True}


def test_runs_are_read_as_if_alone():
    many = np.stack([wander(seed)[1] for seed in range(6)]).reshape(2, 3, -1, 2)
    t = wander()[0]
    made = plain(latency=0.013, counter_bits=16, reversed=(False, True), swapped=True)
    read = made.read(t, many)
    assert read.counts.shape == (2, 3, len(read.t), 2)
    assert read.counts.flags.c_contiguous
    for place in np.ndindex(2, 3):
        np.testing.assert_array_equal(read.counts[place], made.read(t, many[place]).counts)
    angles = made.to_angles(read.counts)
    for place in np.ndindex(2, 3):
        np.testing.assert_array_equal(angles[place], made.to_angles(read.counts[place]))
    assert "(2, 3) runs of" in repr(read)


def test_many_phases_read_one_drive():
    t, angles = wander()
    held = np.random.default_rng(0).random((5, 2))
    read = plain().read(t, angles, phase=held)
    assert read.counts.shape == (5, len(read.t), 2)
    for phase, counts in zip(held, read.counts, strict=True):
        np.testing.assert_array_equal(counts, plain().read(t, angles, phase=phase).counts)
    shaken = plain(jitter=0.002).read(t, angles, np.random.default_rng(0), phase=np.full((5, 2), 0.5)).counts
    assert len({run.tobytes() for run in shaken}) == 5


def test_the_same_generator_reads_the_same():
    t = wander()[0]
    many = np.stack([wander(seed)[1] for seed in range(3)])
    made = plain(2000, **ALL)

    def counts(seed):
        return made.read(t, many, np.random.default_rng(seed), phase="random").counts

    np.testing.assert_array_equal(counts(7), counts(7))
    assert (counts(7) != counts(8)).any()


def test_runs_have_their_own_randomness():
    t, angles = wander()
    for options, phase in (({"jitter": 0.002}, 0.5), ({"missed_ticks": 0.1}, 0.5), ({}, "random")):
        read = plain(**options).read(t, np.stack([angles] * 3), np.random.default_rng(0), phase=phase)
        assert len({run.tobytes() for run in read.counts}) == 3


def test_without_randomness_the_generator_is_left_alone():
    rng = np.random.default_rng(0)
    t, angles = wander()
    np.testing.assert_array_equal(plain().read(t, angles, rng).counts, plain().read(t, angles).counts)
    assert rng.bit_generator.state == np.random.default_rng(0).bit_generator.state


def test_inputs_are_left_alone():
    t, angles = wander()
    before, held = angles.copy(), np.full(2, 0.25)
    plain(**ALL, reversed=(True, False)).read(t, angles, np.random.default_rng(0), phase=held)
    np.testing.assert_array_equal(angles, before)
    np.testing.assert_array_equal(held, 0.25)
    counts = np.array([[0, 0], [5, 5]])
    unwrap_counts(counts, 16)[...] = 9
    wrap_counts(counts, None)[...] = 9
    np.testing.assert_array_equal(counts, [[0, 0], [5, 5]])


def test_a_drive_of_the_physics():
    """The c't-Bot drives a metre: counts come back within a tick of what the wheels turned."""
    robot = dd.Robot.load("ct_bot")
    recording = dd.simulate(robot, dd.maneuvers.straight(robot, distance=1.0, speed=0.2), sample_rate=500.0)
    made = Encoder(robot, sample_rate=50.0, counter_bits=16)
    read = made.read(recording.t, recording.wheel_angles)
    back, exact = made.to_angles(read.counts), recording.at_rate(50.0).wheel_angles
    assert np.abs(back - exact).max() < made.tick_angle
    assert abs(float(read.counts[-1, 0]) - 1.0 / made.distance_per_tick(robot)[0]) < 1


def test_it_loads_nothing_heavy():
    code = (
        "import sys, diffdrive_mj.sensors.encoder; print(*sorted({'mujoco', 'matplotlib', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split() == []


def test_readings_say_what_they_are():
    assert repr(plain(rate=4).read(*ramp(duration=1.0))) == "Readings(5 samples, 0 to 1 s)"


# What is refused


@pytest.mark.parametrize("field", ["ticks_per_revolution", "sample_rate", "gear"])
@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
def test_resolution_rate_and_gear_are_positive(field, value):
    fields = {"ticks_per_revolution": 60, "sample_rate": 10, field: value}
    with refused(ValueError, f"Encoder.{field} = {value}", "must be"):
        Encoder(**fields)
    with refused(TypeError, f"Encoder.{field} = '60'", "must be a number"):
        Encoder(**(fields | {field: "60"}))


@pytest.mark.parametrize("field", ["latency", "jitter", "missed_ticks"])
@pytest.mark.parametrize("value", [-1e-9, math.nan, math.inf])
def test_times_and_probabilities_are_not_negative(field, value):
    with refused(ValueError, f"Encoder.{field} = {value}", "must"):
        plain(**{field: value})


def test_jitter_below_half_of_the_interval():
    assert plain(rate=100, jitter=0.00499).jitter == 0.00499
    for value in (0.005, 0.1):
        with refused(ValueError, f"Encoder.jitter = {value}", "below half of the sampling interval, 0.005 s"):
            plain(rate=100, jitter=value)


@pytest.mark.parametrize("value", [1, 1.5])
def test_missed_ticks_are_a_probability(value):
    assert plain(missed_ticks=0.999).missed_ticks == 0.999
    with refused(ValueError, f"Encoder.missed_ticks = {value}", "probability below 1"):
        plain(missed_ticks=value)


@pytest.mark.parametrize("bits", [0, 8, 64, -16, 16.0, "16", True, (16,)])
def test_counters_have_16_or_32_bits(bits):
    with refused(ValueError, f"Encoder.counter_bits = {bits!r}", "must be None, 16 or 32"):
        plain(counter_bits=bits)
    for function in (wrap_counts, unwrap_counts):
        with refused(ValueError, f"bits = {bits!r}", "must be None, 16 or 32"):
            function([[0, 0]], bits)


@pytest.mark.parametrize("value", [True, (True,), (True, False, True), (1, 0), "lr", None])
def test_reversed_is_one_flag_a_wheel(value):
    with refused(TypeError, "Encoder.reversed = ", "True or False"):
        plain(reversed=value)


@pytest.mark.parametrize("value", [1, "yes", None, (True, False)])
def test_swapped_is_a_flag(value):
    with refused(TypeError, f"Encoder.swapped = {value!r}", "True or False"):
        plain(swapped=value)


def test_encoders_are_frozen_and_compare():
    assert plain() == plain(1000, 100)
    assert hash(plain(reversed=[True, False])) == hash(plain(reversed=(True, False)))
    with pytest.raises(AttributeError):
        plain().latency = 1.0
    with pytest.raises(TypeError):
        Encoder(1000, 100)


def test_randomness_needs_a_generator():
    t, angles = wander()
    for options, phase, words in (
        ({"jitter": 0.001}, 0.5, "Encoder.jitter is random"),
        ({"missed_ticks": 0.1}, 0.5, "Encoder.missed_ticks is random"),
        ({}, "random", "phase is random"),
        ({"jitter": 0.001, "missed_ticks": 0.1}, "random", "phase and Encoder.jitter and Encoder.missed_ticks"),
    ):
        with refused(ValueError, "rng = None: must be a numpy Generator", words):
            plain(**options).read(t, angles, phase=phase)
    for bad in (0, np.random, np.random.RandomState(0)):
        with refused(TypeError, "rng = ", "must be a numpy Generator", "default_rng"):
            plain(jitter=0.001).read(t, angles, bad)


def test_phases():
    t, angles = wander()
    with refused(KeyError, "unknown phase 'randm'", "choose from random"):
        plain().read(t, angles, np.random.default_rng(0), phase="randm")
    for bad, words in ((math.nan, "must be finite"), ((0.1, 0.2, 0.3), "must be (..., 2)"), ([[0.1]], "(..., 2)")):
        with refused(ValueError, "phase", words):
            plain().read(t, angles, phase=bad)
    with refused(ValueError, "wheel_angles (3,), phase (2,)", "must broadcast"):
        plain().read(t, np.stack([angles] * 3), phase=np.zeros((2, 2)))


@pytest.mark.parametrize("t", [[0, 1, 1], [0, 2, 1], [2, 1, 0], [0, 5e-324, 1], [0, 9e-13, 1]])
def test_times_increase(t):
    with refused(ValueError, "t[", "must increase by a picosecond or more"):
        plain(rate=1).read(t, np.zeros((3, 2)))
    assert len(dd.Drive([0, 1.1e-12, 1], np.zeros((3, 2)), np.zeros((3, 3))).t) == 3


def test_shapes_fit():
    t = np.arange(4)
    for angles in (np.zeros((4, 3)), np.zeros(4), np.zeros((4, 2, 1)), np.zeros((0, 4, 2))):
        with refused(ValueError, "wheel_angles", "(..., T, 2)"):
            plain(rate=1).read(t, angles)
    with refused(ValueError, "t has shape (4,)", "(..., 5)"):
        plain(rate=1).read(t, np.zeros((5, 2)))
    with refused(ValueError, "t has shape (2, 4)", "(4,)"):
        plain(rate=1).read([t, t], np.zeros((4, 2)))
    with refused(ValueError, "wheel_angles[1, 0] = nan", "finite"):
        plain(rate=1).read(t[:2], [[0, 0], [math.nan, 0]])
    with refused(ValueError, "t[1] = nan", "finite"):
        plain(rate=1).read([0, math.nan], np.zeros((2, 2)))
    with refused(ValueError, "t has shape (1,)", "at least two"):
        plain(rate=1).read([0], np.zeros((1, 2)))
    for counts in (np.zeros(4), np.zeros((4, 3)), np.zeros((0, 2))):
        with refused(ValueError, "counts", "(..., T, 2)"):
            plain().to_angles(counts)


def test_nobody_reads_beyond_the_recording():
    t, angles = ramp(duration=1.0)
    for options in ({"rate": 0.9}, {"rate": 4, "latency": 0.8}, {"rate": 4, "latency": 5}, {"rate": 1, "jitter": 0.4}):
        with refused(ValueError, "t spans 1 s: too short for two readings", "latency", "jitter"):
            plain(**options).read(t, angles, np.random.default_rng(0))
    assert len(plain(rate=1).read(t, angles).t) == 2
    assert len(plain(rate=4, latency=0.75).read(t, angles).t) == 2


def test_counts_are_whole_and_small_enough_to_tell_apart():
    with refused(ValueError, "right at reading 1: 0.5 must be whole"):
        unwrap_counts([[0, 0], [0, 0.5]], None)
    with refused(ValueError, "counts[1, 1] = nan", "finite"):
        unwrap_counts([[0, 0], [0, math.nan]], None)
    with refused(TypeError, "counts", "real numbers"):
        unwrap_counts([["a", "b"]], None)
    with refused(ValueError, "left at reading 1: ", "must be at most 2^53"):
        plain(1e99).read([0, 1], [[0, 0], [1, 1]])
    with refused(ValueError, "right at reading 1: 9007199254740994 must be at most 2^53"):
        unwrap_counts([[0, 0], [0, 2**53 + 2]], None)
    with refused(ValueError, "left at reading 1: -32769 does not fit in 16 bits"):
        unwrap_counts([(-32768, 0), (-32769, 0)], 16)
    with refused(ValueError, "right at reading 1: -32769 does not fit in 16 bits"):
        unwrap_counts([[0, 0], [0, -32_769]], 16)
    with refused(ValueError, "right at reading 1: 40000 beside -1 does not fit in 16 bits"):
        unwrap_counts([[-1, 0], [0, 40_000]], 16)
    with refused(ValueError, "right at reading 1: 65536 does not fit in 16 bits"):
        unwrap_counts([[0, 0], [0, 65_536]], 16)
    for bad in (0, -3, math.nan):
        with refused(ValueError, "max_step"):
            unwrap_counts([[0, 0]], 16, max_step=bad)
