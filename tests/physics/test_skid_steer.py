"""Skid steer: the physics against the balance of forces, that against least dissipation and a closed form."""

import dataclasses

import mujoco
import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.physics.model import compile_model, static_loads
from diffdrive_mj.physics.skidding import (
    SkidTurn,
    measured_turn,
    skid_acceleration,
    skid_turn,
    wheel_loads,
    wheel_places,
)
from diffdrive_mj.play.server import robots_by_name

# Clearpath Husky A200: husky_description of the ROS package "husky"; docs/howto/skid-steer.md has the numbers' places.
HUSKY = dd.Robot(
    name="husky",
    left_radius=0.1651,
    right_radius=0.1651,
    track_width=0.5708,
    body_mass=46.034,
    center_of_mass_height=0.194,
    tyres={"width": 0.1143, "mass": 2.637},
    skid_steer={"wheelbase": 0.512},
)
AHEAD = HUSKY.replace(center_of_mass_x=0.1)
LADEN = HUSKY.replace(center_of_mass_x=-0.05, payload={"mass": 20.0, "x": 0.1, "y": 0.08, "height": 0.5})
robots = st.builds(
    lambda radius, track, wheelbase, ahead: dd.Robot(
        left_radius=radius,
        right_radius=radius,
        track_width=track * radius,
        skid_steer={"wheelbase": wheelbase * track * radius},
        center_of_mass_x=ahead * wheelbase * track * radius,
    ),
    numbers(0.03, 0.2),
    numbers(2.5, 6.0),
    numbers(0.4, 1.5),
    numbers(-0.2, 0.2),
)


def rates(robot, speed, yaw_rate):
    """Wheel rates that drive about so fast."""
    half = yaw_rate * skid_turn(robot).effective_track / 2
    return np.array([speed - half, speed + half]) / [robot.left_radius, robot.right_radius]


def turn(robot, wheel_rates, physics=None, friction=1.0, seconds=6.0):
    """A steady turn, measured after a start of 3 s."""
    commands = np.tile(wheel_rates, (round(100 * (3 + seconds)), 1))
    commands[:100] *= np.arange(1, 101)[:, None] / 100
    recording = dd.simulate(robot, dd.Commands(0.01, commands), world=dd.World(friction=friction), physics=physics)
    assert not recording.lift
    return measured_turn(recording.during(3.0, recording.t[-1]))


# The effective track in physics


@pytest.mark.parametrize("robot", [HUSKY, AHEAD, LADEN], ids=["centred", "ahead", "laden"])
def test_the_effective_track_is_the_same_at_every_time_step(robot):
    slow, fast = rates(robot, 0.0, 0.2), rates(robot, 0.0, 1.0)
    for wheel_rates, friction in ((slow, 1.0), (fast, 1.0), (fast, 0.5)):
        expected = skid_turn(robot, wheel_rates, friction=friction).effective_track
        for timestep, bound in ((0.0005, 5e-4), (0.001, 5e-4), (0.002, 1e-3), (0.005, 4e-3)):
            measured = turn(robot, wheel_rates, dd.Physics.skidding(timestep), friction).effective_track
            assert measured == pytest.approx(expected, rel=bound)


def test_random_robots_turn_as_the_forces_balance():
    rng = np.random.default_rng(11)
    for _ in range(12):
        radius = 10 ** rng.uniform(-1.5, -0.7)
        track = radius * rng.uniform(2.5, 6.0)
        robot = dd.Robot(
            left_radius=radius,
            right_radius=radius * rng.uniform(0.97, 1.03),
            track_width=track,
            skid_steer={"wheelbase": track * rng.uniform(0.5, 1.3)},
            center_of_mass_x=track * rng.uniform(-0.08, 0.08),
        )
        wheel_rates, friction = rates(robot, rng.uniform(0, 2) * radius, rng.uniform(0.2, 0.6)), rng.uniform(0.4, 1.0)
        expected = skid_turn(robot, wheel_rates, friction=friction)
        measured = turn(robot, wheel_rates, friction=friction, seconds=4.0)
        assert measured.effective_track == pytest.approx(expected.effective_track, rel=0.003)
        assert measured.axle_x == pytest.approx(expected.axle_x, abs=0.01 * track)
        assert measured.axle_y == pytest.approx(expected.axle_y, abs=0.01 * track)


def test_a_turn_on_a_real_robots_floor():
    """Its makers multiply the track by 1.875; the friction of four points says 1.80."""
    assert HUSKY.effective_track / HUSKY.track_width == pytest.approx(1.875, rel=0.04)
    assert turn(HUSKY, rates(HUSKY, 0.0, 0.5)).effective_track == pytest.approx(HUSKY.effective_track, rel=2e-4)


def test_rolling_contacts_get_it_wrong_and_say_so():
    with pytest.warns(PhysicsWarning, match="throws up the wheels of a robot with skid steer"):
        recording = dd.simulate(HUSKY, dd.maneuvers.spin(HUSKY, turns=0.5, yaw_rate=0.5), physics=dd.Physics())
    assert recording.lift
    assert measured_turn(recording.during(2.0, 4.0)).effective_track > 1.3 * HUSKY.effective_track


# The balance of forces


@given(robots)
def test_a_centred_robot_has_the_closed_form(robot):
    centred = robot.replace(center_of_mass_x=0.0)
    found = skid_turn(centred)
    assert found.effective_track == pytest.approx(centred.effective_track, rel=1e-4)
    assert np.abs([found.axle_x, found.axle_y]).max() < 1e-4 * centred.track_width
    assert centred.replace(skid_steer={"wheelbase": 0.0}, center_of_mass_x=None).effective_track == centred.track_width


@pytest.mark.parametrize("share", [0.97, 1.03])
def test_wheels_that_carry_enough_stop_sliding(share):
    """N_front / N_rear of sqrt(1 + 4 (L / b)^2) holds the front wheels against the rear ones that drag behind."""
    length, width, mass = 0.512, HUSKY.track_width, HUSKY.mass
    ratio = share * np.sqrt(1 + 4 * (length / width) ** 2)
    ahead = (ratio / (1 + ratio) - 0.5) * length * mass / HUSKY.body_mass
    robot = HUSKY.replace(center_of_mass_x=float(ahead))
    loads = wheel_loads(robot)
    assert loads[:2].sum() / loads[2:].sum() == pytest.approx(ratio)
    for found, bound in ((skid_turn(robot), 1e-3), (turn(robot, (-0.6, 0.6)), 0.01)):
        held = found.effective_track == pytest.approx(width, rel=bound)
        assert held == (share > 1)
        assert (found.axle_x == pytest.approx(length / 2, rel=bound)) == (share > 1)


@given(robots)
def test_slow_turns_dissipate_least(robot):
    """Coulomb friction's quasi-static motion is that of the least power, sum of N |u|: a convex function."""
    places, loads = wheel_places(robot), wheel_loads(robot)
    along = np.array([-0.5, 0.5, -0.5, 0.5])

    def power(motion):
        v_x, v_y, omega = motion * (1.0, 1.0, 1 / robot.track_width)
        return loads @ np.hypot(v_x - omega * places[:, 1] - along, v_y + omega * places[:, 0]) / loads.sum()

    least = minimize(
        power, (0.0, 0.0, 0.5), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14, "maxiter": 2000}
    ).fun
    found = skid_turn(robot)
    omega = 1 / found.effective_track
    motion = (omega * found.axle_y, -omega * found.axle_x, omega * robot.track_width)
    assert power(np.array(motion)) == pytest.approx(least, rel=5e-5)


@given(robots, numbers(0.3, 1.0), numbers(-0.2, 0.2), numbers(0.5, 2.0))
def test_slow_turns_know_neither_speed_nor_friction(robot, friction, ahead, faster):
    slow, still = np.array([-1e-3, 1e-3]), skid_turn(robot, (-1e-3, 1e-3))
    for other in (
        skid_turn(robot, slow, friction=friction),
        skid_turn(robot, faster * slow),
        skid_turn(robot, slow + 1e-3 * ahead),
    ):
        assert dataclasses.astuple(other) == pytest.approx(dataclasses.astuple(still), abs=1e-3 * robot.track_width)


def test_a_turn_to_the_right_is_the_mirror_image():
    right, left = skid_turn(LADEN, (6.0, 2.0)), skid_turn(LADEN.replace(payload={"y": -0.08}), (2.0, 6.0))
    assert (right.effective_track, right.axle_x, right.axle_y) == pytest.approx(
        (left.effective_track, left.axle_x, -left.axle_y), abs=1e-9
    )


# How it stands and drives


@pytest.mark.parametrize("robot", [HUSKY, LADEN])
def test_the_wheels_carry_what_statics_says(robot):
    model = compile_model(robot, dd.Physics.skidding())
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=2000)
    names = [f"{wheel}_contact" for wheel in ("left", "right", "left_rear", "right_rear")]
    measured = [data.sensor(name).data[0] for name in names]
    assert measured == pytest.approx(static_loads(robot).tolist(), rel=1e-3)
    assert np.abs(data.qpos - model.qpos0).max() < 1e-6
    assert sum(measured) == pytest.approx(9.81 * robot.mass, rel=1e-6)
    x, y, _ = robot.loaded_center_of_mass
    share = 1 - 4 * robot.tyres.mass / robot.mass
    assert measured @ wheel_places(robot) / sum(measured) == pytest.approx([share * x, share * y], abs=1e-4)


def test_the_wheels_of_a_side_turn_as_one():
    model = compile_model(AHEAD, dd.Physics.skidding())
    data = mujoco.MjData(model)
    data.ctrl[:] = [-3.0, 3.0, -3.0, 3.0]
    apart = []
    for _ in range(1000):
        mujoco.mj_step(model, data)
        apart.append(data.qpos[7:9] - data.qpos[9:11])
    assert np.abs(data.qpos[7:9]).min() > 5
    assert np.abs(apart).max() < 1e-3


def test_the_rear_wheels_are_the_front_wheels_again():
    for physics in (dd.Physics.skidding(), dd.Physics.mujoco_defaults()):
        model = compile_model(HUSKY, physics)
        for side in ("left", "right"):
            front, rear = model.body(f"{side}_wheel"), model.body(f"{side}_rear_wheel")
            assert front.pos - rear.pos == pytest.approx([0.512, 0.0, 0.0])
            assert np.array_equal([*rear.mass, *rear.inertia], [*front.mass, *front.inertia])
            for part in ("tyre", "disc", "hub", "spoke"):
                one, other = model.geom(f"{side}_{part}"), model.geom(f"{side}_rear_{part}")
                for field in ("type", "size", "pos", "quat", "group", "matid", "contype"):
                    assert np.array_equal(getattr(one, field), getattr(other, field)), (part, field)
            one, other = model.pair(f"{side}_floor"), model.pair(f"{side}_rear_floor")
            for field in ("friction", "solref", "solimp", "dim"):
                assert np.array_equal(getattr(one, field), getattr(other, field)), field
            assert np.array_equal(*model.pair_solreffriction[[one.id, other.id]])


def test_it_drives_straight_and_weighs_what_its_wheels_weigh():
    assert HUSKY.mass == pytest.approx(46.034 + 4 * 2.637)
    recording = dd.simulate(HUSKY, dd.maneuvers.straight(HUSKY, speed=1.0, distance=5.0))
    assert recording.events == ()
    assert recording.drift(HUSKY).final_position < 1e-6
    assert recording.drift(HUSKY).max_position < 1e-3


def test_odometry_needs_the_effective_track_and_a_calibration_finds_it():
    believed = HUSKY.replace(track_width=HUSKY.effective_track)
    recording = dd.simulate(HUSKY, dd.maneuvers.square(believed, side=2.0, speed=0.5))
    assert abs(np.degrees(recording.drift(HUSKY).final_heading)) > 30
    drift = recording.drift(believed)
    assert drift.max_position < 1e-3
    assert len(drift.warnings) == 1
    found = dd.calibration.least_squares([dd.sensors.measure(recording)], believed).calibrated
    assert found.track_width == pytest.approx(HUSKY.effective_track, rel=5e-4)
    with refused(ValueError, "With skid steer: is track_width its effective_track?"):
        dd.calibration.least_squares([dd.sensors.measure(recording)], HUSKY)


def test_slip_is_no_surprise():
    recording = dd.simulate([HUSKY, AHEAD], dd.maneuvers.spin(HUSKY, turns=0.3, yaw_rate=0.5))
    assert recording.events == tuple(
        f"robot {run} (husky): its wheels slid, as those of skid steer do in turns: odometry needs its effective track"
        for run in (0, 1)
    )
    assert recording.friction_use == pytest.approx(np.ones((2, 2)), abs=0.01)
    alone = dd.simulate(AHEAD, recording.commands[1])
    assert np.array_equal(alone.truth, recording.truth[1])
    assert alone.physics == dd.Physics.skidding()


def test_it_speeds_up_as_fast_as_friction_lets_it():
    assert skid_acceleration(HUSKY, friction=0.5) == pytest.approx(0.5 * 9.81)
    tall = HUSKY.replace(center_of_mass_height=0.8)
    height = (46.034 * 0.8 + 4 * 2.637 * 0.1651) / tall.mass
    assert skid_acceleration(tall) == pytest.approx(9.81 * 0.256 / height)


def test_the_file_for_the_viewer_turns():
    model = mujoco.MjModel.from_xml_string(dd.to_mjcf(HUSKY))
    data = mujoco.MjData(model)
    data.ctrl[:] = (-2.0, 2.0)
    mujoco.mj_step(model, data, nstep=1500)
    before = data.qpos.copy()
    mujoco.mj_step(model, data, nstep=500)
    heading = 2 * np.arctan2(data.qpos[[6]], data.qpos[[3]]) - 2 * np.arctan2(before[[6]], before[[3]])
    rolled = (data.qpos[7:9] - before[7:9]) * HUSKY.mean_radius
    assert (rolled[1] - rolled[0]) / heading == pytest.approx(HUSKY.effective_track, rel=1e-3)


def test_its_file_reads_back(tmp_path):
    HUSKY.save(tmp_path / "husky.toml")
    assert dd.Robot.load(tmp_path / "husky.toml") == HUSKY
    assert HUSKY.skids
    assert not dd.Robot.load("matched").skids
    assert str(SkidTurn(1.0, -0.0, 0.1)) == "effective track 1.0000 m, axle at x = 0.0000 m, y = 0.1000 m"


# What is refused


def test_a_turn_in_which_a_wheel_would_lift():
    tall = HUSKY.replace(center_of_mass_height=2.0)
    with refused(ValueError, "lifts a wheel of robot husky off the floor; turn more slowly"):
        skid_turn(tall, rates(tall, 2.0, 2.5), friction=0.9)


def test_robots_that_stand_on_fewer_than_four_wheels():
    with refused(ValueError, "Robot.center_of_mass_x = 0.3 m", "skid_steer.wheelbase = 0.512 m"):
        HUSKY.replace(center_of_mass_x=0.3)
    with refused(ValueError, "Robot.payload = Payload(mass=200", "one of them carries nothing"):
        HUSKY.replace(payload={"mass": 200.0, "y": 0.3, "x": 0.2})
    with refused(ValueError, "Robot.caster", "stands on four wheels alone"):
        HUSKY.replace(caster={"x": -0.3})
    with refused(ValueError, "Robot.axle = 'rigid'", "independent"):
        HUSKY.replace(axle="rigid")
    with refused(ValueError, "SkidSteer.wheelbase = -1: must not be negative"):
        HUSKY.replace(skid_steer={"wheelbase": -1})


def test_the_page_of_play_does_not_drive_it():
    with refused(ValueError, "robot husky: has skid steer", "diffdrive play"):
        robots_by_name(HUSKY)


def test_what_skid_steer_cannot_do():
    spin, matched = dd.maneuvers.spin(HUSKY, turns=0.1), dd.Robot.load("matched")
    with refused(ValueError, "some have skid steer and some have none"):
        dd.simulate([HUSKY, matched], spin)
    ice = dd.Patch(x=(1.0, 2.0), y=(-0.5, 0.5), friction=0.05)
    with refused(ValueError, "World.patches", "one friction only"):
        dd.simulate(HUSKY, spin, world=dd.World(patches=(ice,)))
    with refused(ValueError, "wheel_rates: both sides are equally fast"):
        skid_turn(HUSKY, (1.0, 1.0))
    with refused(ValueError, "no steady turn of robot husky balances", "turn more slowly"):
        skid_turn(HUSKY, (0.0, 1000.0), friction=0.05)
    for function in (skid_turn, wheel_loads, wheel_places, skid_acceleration):
        with refused(ValueError, "robot matched: has no skid steer"):
            function(matched)
    with refused(ValueError, "recording: the robot has not turned"):
        measured_turn(dd.simulate(HUSKY, dd.maneuvers.straight(HUSKY, speed=0.5, distance=0.1)))
    with refused(ValueError, "robot husky: has skid steer, whose wheels do not roll"):
        dd.physics.mechanics.contact_forces(HUSKY)


@pytest.mark.slow
def test_forty_robots_keep_their_track_over_time_steps():
    """Any shape, load, servo, floor, speed and bend: one track at 0.5, 1 and 2 ms, and nearly that of the balance."""
    rng, spread, off = np.random.default_rng(77), [], []
    for _ in range(40):
        radius = 10 ** rng.uniform(-1.7, -0.8)
        track = radius * rng.uniform(2.2, 7.0)
        wheelbase = track * rng.uniform(0.35, 1.6)
        robot = dd.Robot(
            left_radius=radius,
            right_radius=radius * rng.uniform(0.95, 1.05),
            track_width=track,
            skid_steer={"wheelbase": wheelbase},
            center_of_mass_x=wheelbase * rng.uniform(-0.25, 0.25),
            center_of_mass_height=radius * rng.uniform(0.5, 2.0),
            servo={"gains": str(rng.choice(["matched", "equal"]))},
        )
        wheel_rates = rates(robot, rng.uniform(0.0, 0.8) * np.sqrt(radius / 0.1), rng.uniform(0.2, 1.2))
        friction = rng.uniform(0.3, 1.0)
        expected = skid_turn(robot, wheel_rates, friction=friction).effective_track
        measured = [
            turn(robot, wheel_rates, dd.Physics.skidding(step), friction).effective_track
            for step in (0.0005, 0.001, 0.002)
        ]
        spread.append(np.ptp(measured) / expected)
        off.append(abs(measured[-1] / expected - 1))
    assert max(spread) < 0.005
    assert np.median(spread) < 5e-4
    assert np.median(off) < 1e-3
    assert max(off) < 0.01
