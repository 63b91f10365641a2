"""The final error split among its causes: parts that add up, planted causes found, closed forms of each alone."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
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


@pytest.fixture(scope="module")
def slid():
    half = TRUE.track_width / 2
    ice = dd.Patch(x=(0.75, 0.95), y=(0.5 * half, 1.5 * half), friction=0.03)
    push = dd.Push(start=8.0, duration=0.3, acceleration=(0.5, 1.0, 0.0))
    world = dd.World(friction=0.2, patches=(ice,), pushes=(push,))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return dd.simulate(
            TRUE, dd.maneuvers.square(TRUE, side=1.0, speed=0.4), world=world, sample_rate=500.0, slip=True
        )


@pytest.mark.parametrize(
    "believed",
    [TRUE, TRUE.replace(left_radius=0.06, track_width=0.2), TRUE.replace(right_radius=0.03)],
    ids=["true", "wrong", "very wrong"],
)
def test_the_slip_at_the_contacts_is_the_slip_alone_whatever_is_believed(slid, believed):
    found = attribute(slid, believed, encoder=dd.Encoder(ticks_per_revolution=50, sample_rate=5.0), clock_offset=0.1)
    alone = found.alone[found.causes.index(attribution.SLIP)]
    off = slid.odometry(TRUE)[-1] - slid.truth[-1]
    np.testing.assert_allclose(alone, off, atol=1e-12)
    assert np.hypot(*off[:2]) > 0.02
    np.testing.assert_allclose(found.slip, off, rtol=0, atol=1e-3 * np.hypot(*off[:2]))
    assert "\nslip at the contacts" in str(found)
    assert found.as_dict()["slip"]["x_m"] == found.slip[0]


def test_a_robot_that_is_not_the_one_that_drove_contradicts_the_contacts(slid):
    """Its radii are wrong in all replays alike, so that the replays call their error slip; the contacts do not."""
    other = replace(slid, robot=TRUE.replace(left_radius=0.0501, right_radius=0.0491))
    found = attribute(other, other.robot)
    assert np.hypot(*(part(found, attribution.SLIP) - found.slip)[:2]) > 1e-3
    right = attribute(slid, TRUE)
    np.testing.assert_allclose(found.slip, right.slip, atol=0.02 * np.hypot(*right.slip[:2]))


def test_without_slip_recorded_there_is_no_row_for_it(square):
    found = attribute(square, TRUE)
    assert found.slip is None
    assert found.as_dict()["slip"] is None
    assert str(found).splitlines()[-1].startswith("all")


@pytest.fixture(scope="module")
def logged(square):
    """The drive as a robot and a tracker write it down: true poses at 20 Hz, headings wrapped."""
    at = square.at_rate(20.0)
    truth = np.column_stack([at.truth[:, :2], dd.se2.wrap_angle(at.truth[:, 2])])
    return dd.Drive(t=square.t, wheel_angles=square.wheel_angles + 7.0, truth=truth, truth_t=at.t, name="lab")


def test_a_log_has_the_parts_of_the_recording(square, logged):
    believed = TRUE.replace(left_radius=0.0501, track_width=0.304)
    simulated = attribute(square, believed, start_error=(0.01, 0.0, 0.01))
    found = attribute(logged, believed, true=TRUE, start_error=(0.01, 0.0, 0.01))
    assert found.name == "lab"
    names = {attribution.SLIP: attribution.REST}
    assert found.causes == tuple(names.get(cause, cause) for cause in simulated.causes)
    np.testing.assert_allclose(found.parts, simulated.parts, atol=1e-6)  # the truth ends a moment before the recording
    np.testing.assert_allclose(found.parts.sum(axis=0), found.error, atol=1e-12)


def test_the_error_of_a_log_is_that_of_its_odometry(logged):
    believed = TRUE.replace(left_radius=0.0501, track_width=0.304)
    found = attribute(logged, believed, true=TRUE, method="euler")
    drift = logged.drift(believed, "euler")
    assert np.hypot(*found.error[:2]) == pytest.approx(drift.final_position, abs=1e-12)
    assert abs(found.error[2]) == pytest.approx(abs(drift.final_heading), abs=1e-9)
    assert attribution.METHOD in found.causes


def test_what_the_reference_does_not_explain_is_the_rest(logged):
    wrong = TRUE.replace(track_width=0.31)
    found = attribute(logged, wrong, true=wrong)
    assert found.causes == (attribution.REST,)
    np.testing.assert_allclose(found.error, part(found, attribution.REST))
    assert np.hypot(*found.error[:2]) == pytest.approx(logged.drift(wrong).final_position, abs=1e-12)


@pytest.mark.parametrize("late", [0.3, -0.3])
def test_a_clock_that_is_known_to_be_off_is_a_cause_of_its_own(ahead, late):
    """The stamps of the wheels are off while the robot speeds up: odometry sees another part of the drive."""
    part_of_it = ahead.during(0.6, 3.5)
    t, truth = part_of_it.t, part_of_it.truth
    drive = dd.Drive(t=t - late, wheel_angles=part_of_it.wheel_angles, truth=truth[::50], truth_t=t[::50])
    found = attribute(drive, TRUE, true=TRUE, clock_offset=late)
    assert set(found.causes) == {attribution.CLOCK, attribution.REST}
    assert np.hypot(*part(found, attribution.REST)[:2]) < 1e-7
    # Of the true poses, those within the stamps and within what they should have been.
    kept = t[::50][(t[::50] >= max(t[0], t[0] - late)) & (t[::50] <= min(t[-1], t[-1] - late))]
    begin, end, seen_begin, seen_end = np.interp(
        [kept[0], kept[-1], kept[0] + late, kept[-1] + late], ahead.t, ahead.truth[:, 0]
    )
    expected = (seen_end - seen_begin) - (end - begin)
    assert abs(expected) > 0.01
    assert part(found, attribution.CLOCK)[0] == pytest.approx(expected, abs=1e-6)


def test_logs_and_recordings_take_their_own_options(square, logged):
    with refused(ValueError, "true = None: lab was measured"):
        attribute(logged, TRUE)
    with refused(ValueError, "encoder: lab was measured"):
        attribute(logged, TRUE, true=TRUE, encoder=dd.Encoder(TRUE))
    with refused(ValueError, "true: a recording has the true robot"):
        attribute(square, TRUE, true=TRUE)
    with refused(ValueError, "clock_offset = 100 s: lab has 0 true poses"):
        attribute(logged, TRUE, true=TRUE, clock_offset=100.0)
    with refused(TypeError, "drive"):
        attribute("lab.csv", TRUE)


def test_of_a_robot_that_turns_on_the_spot_headings_count():
    spun = dd.simulate(TRUE, dd.maneuvers.spin(TRUE, turns=2), sample_rate=500.0)
    found = attribute(spun, TRUE.replace(track_width=0.303), start_error=(1e-3, 0.0, 0.0))
    assert found.causes[0] == attribution.TRACK
    assert found.sizes_alone[0] == pytest.approx(4 * np.pi / 101, rel=1e-3)
    assert "after 720 degrees on the spot" in found.title
    assert "alone [deg]" in str(found)


def test_a_turning_gain_that_is_believed_is_a_cause(square):
    believed = TRUE.replace(turning_gain=0.02)
    found = attribute(square, believed)
    assert found.causes == (attribution.GAIN, attribution.SLIP)
    np.testing.assert_allclose(found.error, square.odometry(believed)[-1] - square.truth[-1], atol=1e-12)


def test_ticks_that_an_encoder_misses_are_the_encoders(ahead):
    encoder = dd.Encoder(ticks_per_revolution=1000, sample_rate=50.0, missed_ticks=0.1)
    found = attribute(ahead, TRUE, encoder=encoder, seed=1)
    assert part(found, attribution.TICKS)[0] == pytest.approx(-0.1 * found.distance, rel=0.05)
    np.testing.assert_allclose(found.parts.sum(axis=0), found.error, atol=1e-12)


def test_a_counter_that_wraps_is_read_as_one_that_does_not(ahead):
    coarse, wraps = (
        attribute(ahead, TRUE, encoder=dd.Encoder(ticks_per_revolution=1e5, sample_rate=50.0, counter_bits=bits))
        for bits in (None, 16)
    )
    np.testing.assert_allclose(wraps.parts, coarse.parts, atol=1e-12)
    with refused(ValueError, "16 bits"):
        attribute(ahead, TRUE, encoder=dd.Encoder(ticks_per_revolution=1e6, sample_rate=5.0, counter_bits=16))


@pytest.mark.parametrize(
    ("encoder", "words"),
    [
        ({"swapped": True}, "swapped"), ({"reversed": (False, True)}, "reversed"),
        ({"sample_rate": 0.1}, "too short for two readings every 10 s"),
    ],
    ids=["swapped", "reversed", "slow"],
)  # fmt: skip
def test_an_encoder_of_which_no_part_can_be_told_is_refused(ahead, encoder, words):
    with refused(ValueError, words):
        attribute(ahead, TRUE, encoder=dd.Encoder(TRUE, **encoder))


def test_two_true_poses_of_a_round_trip_are_a_way_all_the_same(square):
    """A tape measure says where the robot stood before and after; that it drove a square the wheels say."""
    drive = dd.Drive(square.t, square.wheel_angles, square.truth[[0, -1]], square.t[[0, -1]])
    found = attribute(drive, TRUE.replace(track_width=0.303), true=TRUE)
    assert not found.on_the_spot
    assert found.distance == pytest.approx(4.0, rel=1e-3)
    assert "after 4 m" in found.title


def test_of_a_spin_that_an_encoder_has_logged_headings_count():
    spun = dd.simulate(TRUE, dd.maneuvers.spin(TRUE, turns=2), sample_rate=500.0)
    logged = dd.sensors.measure(spun, encoder=dd.Encoder(TRUE, ticks_per_revolution=300), seed=0)
    drive = dd.Drive(logged.t, logged.wheel_angles, logged.truth[[0, -1]], logged.clock[[0, -1]])
    found = attribute(drive, TRUE.replace(track_width=0.303), true=TRUE)
    assert found.on_the_spot
    assert np.degrees(found.turned) == pytest.approx(720, rel=0.01)


def test_what_happened_on_the_drive_is_said(slid, logged):
    found = attribute(slid, TRUE)
    assert found.warnings == slid.events
    assert "\nwarning: robot robot: the left wheel used 100 % of its friction" in str(found)
    assert "wheel used 100 % of its friction" in found._repr_html_()
    assert found.as_dict()["warnings"] == list(slid.events)
    gap = replace(logged, warnings=("lab: 1 gap",))
    assert str(attribute(gap, TRUE, true=TRUE)).splitlines()[-1] == "warning: lab: 1 gap"


def test_rounding_is_not_printed_as_an_error(ahead):
    found = attribute(ahead, TRUE, clock_offset=0.5)
    assert "e-1" not in str(found)
    still = attribute(dd.simulate(TRUE, dd.Commands(0.01, np.zeros((5, 2)))), TRUE)
    assert "after 0 degrees on the spot" in still.title
