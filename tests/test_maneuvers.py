import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import j0
from strategies import numbers, robots, signs, sizes, wheel_rates

import diffdrive_mj as dd
from diffdrive_mj import kinematics, maneuvers, se2
from diffdrive_mj.commands import Commands
from diffdrive_mj.maneuvers import Segment

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)

ramps = st.just(0.0) | numbers(0.02, 2.0)
options = st.fixed_dictionaries({"period": sizes(0.005, 0.1), "ramp": ramps, "rest": numbers(0.0, 1.0)})
speeds = sizes(0.2, 3.0)

# Each drives at a given speed or yaw rate; with it the distance and the angle that it covers in all.
ALL = {
    "straight": (lambda r, v, **o: maneuvers.straight(r, speed=v, distance=3.7, **o), (3.7, 0)),
    "back": (lambda r, v, **o: maneuvers.straight(r, speed=v, distance=-0.9, **o), (-0.9, 0)),
    "arc": (lambda r, v, **o: maneuvers.arc(r, speed=v, radius=1.7, distance=4, **o), (4, 4 / 1.7)),
    "right arc": (lambda r, v, **o: maneuvers.arc(r, speed=v, radius=-0.5, distance=2, **o), (2, -4)),
    "spin": (lambda r, v, **o: maneuvers.spin(r, yaw_rate=v, turns=-1.25, **o), (0, -2.5 * np.pi)),
    "square": (lambda r, v, **o: maneuvers.square(r, speed=v, yaw_rate=v, side=0.8, **o), (3.2, 2 * np.pi)),
    "clockwise": (
        lambda r, v, **o: maneuvers.square(r, speed=v, yaw_rate=v, side=0.8, clockwise=True, **o),
        (3.2, -2 * np.pi),
    ),
    "eight": (lambda r, v, **o: maneuvers.figure_eight(r, speed=v, radius=0.4, **o), (1.6 * np.pi, 0)),
    "slalom": (
        lambda r, v, **o: maneuvers.slalom(r, speed=v, amplitude=0.7, wavelength=2, waves=1.25, **o),
        (2.5, 0.7),
    ),
}
every_maneuver = pytest.mark.parametrize(("drive", "total"), ALL.values(), ids=ALL)


# What every maneuver keeps


@every_maneuver
@given(robots, speeds, options)
def test_rates_sum_up_to_the_wheel_angles(drive, total, robot, speed, options):
    commands = drive(robot, speed, **options)
    turned = commands.wheel_rates.sum(axis=0) * commands.period
    np.testing.assert_allclose(turned, kinematics.wheel_rates(total, robot), rtol=1e-12, atol=1e-11)
    assert commands.period == options["period"]


@every_maneuver
@given(speeds, options)
def test_the_speed_is_a_limit(drive, total, speed, options):
    """Also when many segments or legs follow each other; only what rounding needs is added."""
    v, omega = _twists(drive(ROBOT, speed, **options)).T
    limited = omega if total[0] == 0 else v
    assert np.abs(limited).max() <= speed * (1 + 1e-8)


@every_maneuver
@given(speeds, sizes(0.005, 0.1), numbers(0.02, 2.0))
def test_speed_changes_no_faster_than_the_ramp(drive, total, speed, period, ramp):
    """From rest to rest: the acceleration is that of full speed in one ramp, the start and the end included."""
    v, omega = _twists(drive(ROBOT, speed, period=period, ramp=ramp, rest=0)).T
    limited = omega if total[0] == 0 else v
    steps = np.diff(limited, prepend=0, append=0)
    assert np.abs(steps).max() <= speed / ramp * period * (1 + 1e-8) + 1e-12


@every_maneuver
@given(speeds, options)
def test_standing_still_at_the_end(drive, total, speed, options):
    rates = drive(ROBOT, speed, **options).wheel_rates
    moving = drive(ROBOT, speed, **(options | {"rest": 0})).wheel_rates
    np.testing.assert_array_equal(rates[: len(moving)], moving)
    np.testing.assert_array_equal(rates[len(moving) :], 0)
    still = (len(rates) - len(moving)) * options["period"]
    assert options["rest"] - 1e-9 <= still < options["rest"] + options["period"]


@every_maneuver
def test_only_radii_and_track_matter(drive, total):
    other = ROBOT.replace(body_mass=1, caster={"x": -0.3}, name="other")
    np.testing.assert_array_equal(drive(other, 1.0).wheel_rates, drive(ROBOT, 1.0).wheel_rates)


@every_maneuver
@given(robots, speeds, options)
def test_every_robot_believes_the_same_path(drive, total, robot, speed, options):
    ours, theirs = (_path(drive(r, speed, **options), r) for r in (ROBOT, robot))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-9)


# The profile of the speed


def test_the_speed_is_a_trapezoid():
    """1.5 m/s over 3 m with ramps of 0.5 s: up, 1.5 s of cruise, down, then rest; period means are midpoint values."""
    commands = maneuvers.straight(ROBOT, speed=1.5, distance=3, ramp=0.5, rest=0.3, period=0.1)
    t = (np.arange(28) + 0.5) * 0.1
    expected = 1.5 * np.clip(np.minimum(t / 0.5, (2.5 - t) / 0.5), 0, 1)
    np.testing.assert_allclose(_twists(commands), np.stack([expected, 0 * t], axis=-1), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("distance", [0.1, -0.1])
def test_a_leg_shorter_than_its_ramps_is_a_triangle(distance):
    """At 1 m/s in 0.4 s, 2.5 m/s^2, 0.1 m takes 0.2 s up to 0.5 m/s and 0.2 s down."""
    commands = maneuvers.straight(ROBOT, speed=1, distance=distance, ramp=0.4, rest=0, period=0.02)
    t = (np.arange(20) + 0.5) * 0.02
    expected = math.copysign(2.5, distance) * np.minimum(t, 0.4 - t)
    np.testing.assert_allclose(_twists(commands)[:, 0], expected, rtol=1e-12)


def test_no_ramp_is_a_jump():
    commands = maneuvers.spin(ROBOT, turns=1, yaw_rate=np.pi, ramp=0, rest=0, period=0.1)
    np.testing.assert_allclose(_twists(commands), np.tile((0, np.pi), (20, 1)), rtol=1e-12, atol=1e-12)


@given(speeds, sizes(0.05, 10.0), numbers(0.02, 2.0), sizes(0.005, 0.1))
def test_duration(speed, distance, ramp, period):
    """Distance over speed and one ramp; for a short leg twice the time to half of it, sqrt(distance / acceleration)."""
    commands = maneuvers.straight(ROBOT, speed=speed, distance=distance, ramp=ramp, rest=0, period=period)
    cruise = distance / speed
    least = cruise + ramp if cruise >= ramp else 2 * math.sqrt(cruise * ramp)
    assert least - 1e-9 <= commands.duration < least + period


# Each path, as the exact odometry of the believed robot sees it at the rate of the commands


@given(robots, speeds, options, signs)
def test_straight(robot, speed, options, sign):
    path = _path(maneuvers.straight(robot, speed=speed, distance=sign * 2, **options), robot)
    np.testing.assert_allclose(path[:, 1:], 0, atol=1e-12)
    np.testing.assert_allclose(path[-1, 0], sign * 2, rtol=1e-12)
    assert (sign * np.diff(path[:, 0]) >= -1e-12).all()


@given(robots, speeds, options, signs, signs)
def test_arc(robot, speed, options, side, direction):
    radius, distance = side * 0.7, direction * 3.0
    path = _path(maneuvers.arc(robot, radius=radius, distance=distance, speed=speed, **options), robot)
    np.testing.assert_allclose(np.hypot(path[:, 0], path[:, 1] - radius), 0.7, rtol=1e-11)
    np.testing.assert_allclose(path[-1, 2], distance / radius, rtol=1e-12)


@given(robots, speeds, options, numbers(0.1, 2.0), signs)
def test_spin(robot, rate, options, turns, sign):
    path = _path(maneuvers.spin(robot, turns=sign * turns, yaw_rate=rate, **options), robot)
    np.testing.assert_allclose(path[:, :2], 0, atol=1e-10)
    np.testing.assert_allclose(path[-1, 2], sign * 2 * np.pi * turns, rtol=1e-10)


@pytest.mark.parametrize("clockwise", [False, True])
@given(robots, speeds, speeds, options)
def test_the_square_closes(clockwise, robot, speed, rate, options):
    commands = maneuvers.square(robot, side=2, speed=speed, yaw_rate=rate, clockwise=clockwise, **options)
    path = _path(commands, robot)
    left = -1 if clockwise else 1
    np.testing.assert_allclose(path[-1], (0, 0, left * 2 * np.pi), atol=1e-10)
    corners = np.array([(2, 0), (2, left * 2), (0, left * 2), (0, 0)])
    gaps = np.linalg.norm(path[:, None, :2] - corners, axis=-1)
    reached = gaps.argmin(axis=0)
    np.testing.assert_allclose(gaps.min(axis=0), 0, atol=1e-10)
    assert (np.diff(reached[:3]) > 0).all()


@given(robots, speeds, options)
def test_the_figure_eight_is_two_circles(robot, speed, options):
    path = _path(maneuvers.figure_eight(robot, radius=0.8, speed=speed, **options), robot)
    np.testing.assert_allclose(path[-1], 0, atol=1e-9)
    crossing = path[:, 2].argmax()
    np.testing.assert_allclose(path[crossing], (0, 0, 2 * np.pi), atol=1e-9)
    np.testing.assert_allclose(np.hypot(path[:crossing, 0], path[:crossing, 1] - 0.8), 0.8, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(path[crossing:, 0], path[crossing:, 1] + 0.8), 0.8, rtol=1e-9)


def test_the_slalom_swings_as_a_sine():
    amplitude, wavelength, waves, speed = 0.8, 3.0, 2, 1.0
    commands = maneuvers.slalom(
        ROBOT, amplitude=amplitude, wavelength=wavelength, waves=waves, speed=speed, period=0.005
    )
    way, heading = np.cumsum(_twists(commands) * commands.period, axis=0).T
    # Between two of 200 samples a wave the heading is interpolated: off by at most amplitude (2 pi / 200)^2 / 8.
    sag = amplitude * (2 * np.pi / 200) ** 2 / 8
    np.testing.assert_allclose(heading, amplitude * np.sin(2 * np.pi * way / wavelength), rtol=0, atol=sag + 1e-10)
    # Over whole waves the mean of cos(A sin u) is J0(A), that of sin(A sin u) zero.
    x, y, theta = _path(commands, ROBOT)[-1]
    assert x == pytest.approx(waves * wavelength * j0(amplitude), abs=waves * wavelength * sag)
    assert (y, theta) == pytest.approx((0, 0), abs=1e-5)


@given(
    st.lists(st.builds(Segment, numbers(-3, 3), numbers(-4, 4), numbers(0.2, 3)), min_size=1, max_size=4),
    robots,
    options,
)
def test_legs_are_arcs_one_after_the_other(segments, robot, options):
    pose = (0, 0, 0)
    for segment in segments:
        pose = se2.compose(pose, se2.exp((segment.distance, 0, segment.angle)))
    path = _path(maneuvers.sequence(robot, [[segment] for segment in segments], **options), robot)
    np.testing.assert_allclose(path[-1], pose, rtol=0, atol=1e-10)


def test_segments_of_a_leg_are_driven_without_a_stop():
    segments = [Segment(2, 0, 2), Segment(2, 1, 2), Segment(2, -1, 2)]
    v = _twists(maneuvers.sequence(ROBOT, [segments], ramp=0.5, rest=0))[:, 0]
    np.testing.assert_allclose(v[50:-50], 1, rtol=1e-10)
    stops = _twists(maneuvers.sequence(ROBOT, [[segment] for segment in segments], ramp=0.5, rest=0))[:, 0]
    assert (stops < 0.02).sum() == 6


# Wheels that know of no robot


@given(wheel_rates, numbers(0.1, 5.0), ramps, sizes(0.005, 0.1))
def test_constant_rates(rates, duration, ramp, period):
    commands = maneuvers.constant_rates(rates, duration, ramp=ramp, rest=0, period=period)
    turned = commands.wheel_rates.sum(axis=0) * period
    np.testing.assert_allclose(turned, np.multiply(rates, duration), rtol=1e-12, atol=1e-12)
    left, right = commands.wheel_rates.T
    np.testing.assert_allclose(left * rates[1], right * rates[0], rtol=1e-12, atol=1e-12)


def test_constant_rates_are_reached_after_the_ramp():
    commands = maneuvers.constant_rates((9.1, 10), 3, ramp=0.5, rest=0.2)
    np.testing.assert_allclose(commands.wheel_rates[50:300], np.tile((9.1, 10), (250, 1)), rtol=1e-12)
    np.testing.assert_array_equal(commands.wheel_rates[350:], np.zeros((20, 2)))


# Commands


def test_commands_are_a_value():
    rates = np.ones((4, 2))
    commands = Commands(0.1, rates)
    rates[:] = 0
    np.testing.assert_array_equal(commands.wheel_rates, np.ones((4, 2)))
    with pytest.raises(ValueError, match="read-only"):
        commands.wheel_rates[0] = 7
    with pytest.raises(AttributeError):
        commands.period = 1
    assert commands.duration == pytest.approx(0.4)
    assert repr(commands) == "Commands(4 periods of 0.1 s, 0.4 s)"


def test_extended_by_standing_still():
    commands = Commands(0.1, np.ones((4, 2)))
    longer = commands.extended(1)
    assert longer.duration == pytest.approx(1)
    np.testing.assert_array_equal(longer.wheel_rates, [[1, 1]] * 4 + [[0, 0]] * 6)
    np.testing.assert_array_equal(commands.extended(0.4).wheel_rates, commands.wheel_rates)
    with refused(ValueError, "duration = 0.2 s", "at least", "0.4 s"):
        commands.extended(0.2)
    for bad in (0, -1, math.nan):
        with refused(ValueError, f"duration = {bad}"):
            commands.extended(bad)


@pytest.mark.parametrize(
    ("period", "rates", "words"),
    [
        (0, [(1, 1)], ("Commands.period = 0", "positive")),
        (math.nan, [(1, 1)], ("Commands.period = nan",)),
        (0.1, (1, 1), ("Commands.wheel_rates has shape (2,)", "(..., T, 2)")),
        (0.1, np.ones((4, 3)), ("Commands.wheel_rates has shape (4, 3)",)),
        (0.1, np.ones((5, 4, 2)), ("Commands.wheel_rates has shape (5, 4, 2)", "(T, 2)", "list")),
        (0.1, np.ones((0, 2)), ("Commands.wheel_rates is empty",)),
        (0.1, [(1, math.inf)], ("Commands.wheel_rates[0, 1] = inf", "finite")),
    ],
)
def test_bad_commands_are_refused(period, rates, words):
    with refused(ValueError, *words):
        Commands(period, rates)


# Bad input


def test_bad_segments_are_refused():
    for duration in (0, -1, math.inf):
        with refused(ValueError, f"Segment.duration = {duration}"):
            Segment(1, 0, duration)
    with refused(ValueError, "Segment.distance = nan", "finite"):
        Segment(math.nan, 0, 1)
    with refused(TypeError, "Segment.angle = 'left'", "number"):
        Segment(1, "left", 1)


@pytest.mark.parametrize("legs", [[], [[]], [[Segment(1, 0, 1)], []]])
def test_empty_legs_are_refused(legs):
    with refused(ValueError, "legs", "at least one"):
        maneuvers.sequence(ROBOT, legs)


@every_maneuver
@pytest.mark.parametrize(
    ("option", "value"), [("ramp", -0.1), ("rest", -1), ("period", 0), ("period", -0.1), ("ramp", math.nan)]
)
def test_bad_options_are_refused(drive, total, option, value):
    with refused(ValueError, f"{option} = {value}"):
        drive(ROBOT, 1.0, **{option: value})


@every_maneuver
@pytest.mark.parametrize("speed", [0, -1, math.nan, math.inf])
def test_bad_speeds_are_refused(drive, total, speed):
    with refused(ValueError, "yaw_rate" if total[0] == 0 else "speed", f"= {speed}"):
        drive(ROBOT, speed)


@pytest.mark.parametrize(
    ("maneuver", "field", "value"),
    [
        (maneuvers.straight, "distance", 0),
        (maneuvers.straight, "distance", math.nan),
        (maneuvers.arc, "distance", 0),
        (maneuvers.arc, "radius", 0),
        (maneuvers.arc, "radius", math.inf),
        (maneuvers.spin, "turns", 0),
        (maneuvers.spin, "turns", math.inf),
        (maneuvers.square, "side", 0),
        (maneuvers.square, "side", -1),
        (maneuvers.square, "yaw_rate", 0),
        (maneuvers.figure_eight, "radius", 0),
        (maneuvers.figure_eight, "radius", -1),
        (maneuvers.slalom, "wavelength", 0),
        (maneuvers.slalom, "waves", -1),
        (maneuvers.slalom, "amplitude", math.nan),
    ],
)
def test_bad_sizes_are_refused(maneuver, field, value):
    with refused(ValueError, f"{field} = {value}", "must"):
        maneuver(ROBOT, **{field: value})
    with refused(TypeError, f"{field} = 'far'", "number"):
        maneuver(ROBOT, **{field: "far"})


def test_bad_constant_rates_are_refused():
    with refused(ValueError, "rates has shape (3, 2)", "(2,)"):
        maneuvers.constant_rates(np.ones((3, 2)), 1)
    with refused(ValueError, "rates[1] = nan"):
        maneuvers.constant_rates((1, math.nan), 1)
    for name in ("duration", "period"):
        for bad in (0, -1, math.nan):
            with refused(ValueError, f"{name} = {bad}"):
                maneuvers.constant_rates((1, 1), **({"duration": 1} | {name: bad}))
    for name in ("ramp", "rest"):
        with refused(ValueError, f"{name} = -1"):
            maneuvers.constant_rates((1, 1), 1, **{name: -1})


def _twists(commands):
    return kinematics.body_twist(commands.wheel_rates, ROBOT)


def _path(commands, robot):
    """The poses after each period, and the start, as the robot that obeys exactly believes them."""
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    return dd.odometry.integrate(angles, robot)


@pytest.mark.parametrize(("speed", "ramp", "period"), [(1.0, 0.0, 0.01), (1e30, 1.0, 0.01), (0.5, 0.0, 1e9)])
def test_a_leg_covers_its_distance_however_short_it_is(speed, ramp, period):
    """One of a billionth of a period did nothing, without a word."""
    commands = dd.maneuvers.straight(ROBOT, speed=speed, distance=0.004, ramp=ramp, rest=0.0, period=period)
    way = commands.wheel_rates.sum(axis=0) * commands.period * (ROBOT.left_radius, ROBOT.right_radius)
    assert way == pytest.approx([0.004, 0.004], rel=1e-12)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("square", {"side": 4.0, "speed": 0.5, "yaw_rate": 1.0, "clockwise": False}),
        ("spin", {"yaw_rate": 1.0}),
    ],
)
def test_defaults_are_those_of_the_documentation(name, said):
    robot = dd.Robot.load("matched")
    maneuver = getattr(dd.maneuvers, name)
    assert np.array_equal(maneuver(robot).wheel_rates, maneuver(robot, **said).wheel_rates)
    for field, value in said.items():
        other = maneuver(robot, **{field: not value if isinstance(value, bool) else 2 * value})
        assert not np.array_equal(maneuver(robot).wheel_rates, other.wheel_rates), field
