"""The final error split among its causes: parts that add up, planted causes found, closed forms of each alone."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.estimation import attribution
from diffdrive_mj.estimation.attribution import attribute

TRUE = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3)


@pytest.fixture(scope="module")
def square():
    return dd.simulate(TRUE, dd.maneuvers.square(TRUE, side=1.0, speed=0.4), sample_rate=500.0)


@pytest.fixture(scope="module")
def ahead():
    return dd.simulate(TRUE, dd.maneuvers.straight(TRUE, speed=0.5, distance=2.0), sample_rate=500.0)


def part(found, cause):
    return found.parts[found.causes.index(cause)]


def test_parts_add_up_to_the_error_that_the_odometry_has(square):
    encoder = dd.Encoder(ticks_per_revolution=400, sample_rate=20.0, latency=0.02, jitter=0.005)
    believed = TRUE.replace(left_radius=0.0501, track_width=0.304)
    found = attribute(
        square, believed, method="euler", encoder=encoder, start_error=(0.01, 0.02, 0.01), clock_offset=0.05, seed=3
    )
    assert set(found.causes) == {
        attribution.SLIP, attribution.SAMPLING, attribution.TICKS, attribution.LATENCY, attribution.SCALE,
        attribution.RATIO, attribution.TRACK, attribution.START, attribution.CLOCK,
    }  # fmt: skip
    np.testing.assert_allclose(found.parts.sum(axis=0), found.error, atol=1e-12)


def test_the_error_is_that_of_a_robot_that_reads_its_encoder(square):
    encoder = dd.Encoder(ticks_per_revolution=400, sample_rate=20.0)
    believed = TRUE.replace(right_radius=0.05, track_width=0.304)
    found = attribute(square, believed, encoder=encoder, seed=3)
    # The same by hand: counts with the same phases, which are the generator's first two numbers.
    t = square.t[0] + np.arange(int(square.t[-1] * 20 + 1e-9) + 1) / 20.0
    turned = np.stack([np.interp(t, square.t, wheel) for wheel in square.wheel_angles.T], axis=-1)
    ticks = np.floor(turned * 400 / (2 * np.pi) + np.random.default_rng(3).random(2))
    end = dd.odometry.integrate(ticks * 2 * np.pi / 400, believed, start=square.truth[0])[-1]
    np.testing.assert_allclose(found.error, end - square.truth[-1], atol=1e-12)


def test_one_wrong_parameter_is_the_whole_error_and_what_a_formula_says(ahead):
    distance = ahead.truth[-1, 0]
    found = attribute(ahead, TRUE.replace(left_radius=0.0505, right_radius=0.04949))
    assert found.causes == (attribution.SCALE, attribution.SLIP)
    np.testing.assert_allclose(part(found, attribution.SCALE), [0.01 * distance, 0, 0], atol=1e-6)
    # A wrong ratio bends the line: it turns by M_21 of the distance.
    ratio = attribute(ahead, TRUE.replace(left_radius=0.0496, right_radius=0.0494))
    turned = dd.kinematics.belief_matrix(TRUE.replace(left_radius=0.0496, right_radius=0.0494), TRUE)[1, 0] * distance
    assert part(ratio, attribution.RATIO)[2] == pytest.approx(turned, rel=1e-5)


def test_a_start_error_turns_the_path_about_its_start(ahead):
    found = attribute(ahead, TRUE, start_error=(0.0, 0.0, 0.01))
    way = ahead.truth[-1] - ahead.truth[0]
    turned = 2 * np.sin(0.005) * np.hypot(*way[:2])
    assert np.hypot(*part(found, attribution.START)[:2]) == pytest.approx(turned, rel=1e-6)


def test_causes_that_are_not_there_are_left_out(square):
    found = attribute(square, TRUE)
    assert found.causes == (attribution.SLIP,)
    np.testing.assert_array_equal(found.spread, 0)


@pytest.mark.parametrize("seed", range(12))
def test_a_part_is_nearly_what_its_cause_does_alone(square, seed):
    check_a_mix(square, np.random.default_rng(seed))


def check_a_mix(recording, rng):
    true, ticks = recording.robot, float(rng.integers(100, 4000))
    near = {name: getattr(true, name) * (1 + 1e-4 * rng.normal()) for name in ("left_radius", "right_radius")}
    believed = true.replace(**near, track_width=true.track_width * (1 + 1e-3 * rng.normal()))
    encoder = dd.Encoder(ticks_per_revolution=ticks, sample_rate=10.0)
    found = attribute(recording, believed, encoder=encoder, start_error=(0, 0, 1e-3 * rng.normal()), seed=int(ticks))
    size = np.hypot(found.alone[:, 0], found.alone[:, 1]).sum()
    assert size < 0.003 * found.distance, "the mix is too large for the law"
    off = np.hypot(*(found.parts - found.alone)[:, :2].T)
    assert off.max() < max(0.02 * size, 0.5 * encoder.tick_angle * true.mean_radius)


def test_many_runs_are_refused(square):
    both = dd.simulate([TRUE, TRUE], dd.maneuvers.straight(TRUE, speed=0.5, distance=0.1))
    with refused(ValueError, "recording.runs"):
        attribute(both, TRUE)
