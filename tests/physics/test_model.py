"""The compiled robot: what touches the floor where, what weighs how much, which servo turns which wheel."""

import math

import mujoco
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.physics.servo import servo_gains
from diffdrive_mj.physics.tilt import level_twin, resting_tilt

UNEQUAL = dd.Robot.load("mismatched")
RIGID = UNEQUAL.replace(axle="rigid")


def at_rest(robot, physics=dd.Physics()):
    model = compile_model(robot, physics)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=500)
    mujoco.mj_forward(model, data)
    return model, data


def contacts(model, data):
    """Where each geom touches the floor, by name."""
    return {model.geom(max(c.geom)).name: c.pos for c in data.contact}


@pytest.mark.parametrize("robot", [UNEQUAL, RIGID, UNEQUAL.replace(left_radius=0.08, axle="rigid")])
def test_the_wheels_touch_the_floor_where_the_geometry_says(robot):
    at = resting_tilt(robot)
    model, data = at_rest(robot)
    touching = contacts(model, data)
    left, right = touching["left_tyre"], touching["right_tyre"]
    body = data.body("robot")
    assert left[1] - right[1] == pytest.approx(at.track_width, abs=1e-7)
    assert (left[1] + right[1]) / 2 == pytest.approx(body.xpos[1], abs=1e-7)
    assert left[0] == pytest.approx(body.xpos[0], abs=1e-6)
    assert math.atan2(body.xmat[7], body.xmat[8]) == pytest.approx(at.roll, abs=1e-6)
    assert data.site("axle").xpos == pytest.approx(body.xpos)
    assert len(touching) == 3


@pytest.mark.parametrize("robot", [UNEQUAL, RIGID])
def test_a_robot_at_rest_has_all_its_weight_on_the_floor(robot):
    model, data = at_rest(robot)
    force = np.zeros(6)
    normal = 0.0
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        normal += force[0]
    assert normal == pytest.approx(robot.mass * 9.81, rel=1e-6)
    assert np.sum(model.body_mass) == pytest.approx(robot.mass)


@pytest.mark.parametrize("robot", [UNEQUAL, RIGID, UNEQUAL.replace(payload={"mass": 2.0, "x": -0.1, "y": 0.04})])
@pytest.mark.parametrize("physics", [dd.Physics(), dd.Physics.fast(), dd.Physics.sliding()])
def test_a_balanced_robot_is_at_rest_from_the_first_step(robot, physics):
    """Its wheels just touch the floor: they neither sink nor rise, and roll at their own radii."""
    model = compile_model(robot, physics)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # What is left is what the solver leaves, 1e-10 of the model's inertia.
    assert np.abs(data.qacc).max() < 1e-5
    mujoco.mj_step(model, data, nstep=200)
    mujoco.mj_forward(model, data)
    assert [abs(contact.dist) for contact in data.contact] == pytest.approx([0, 0, 0], abs=1e-11)


def test_contacts_without_a_balance_sink():
    model = compile_model(UNEQUAL, dd.Physics(balanced_contacts=False))
    assert not model.pair_margin.any()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=500)
    mujoco.mj_forward(model, data)
    balance = compile_model(UNEQUAL).pair_margin
    sunk = {model.geom(max(c.geom)).name: -c.dist for c in data.contact}
    for pair, geom in (("left_floor", "left_tyre"), ("right_floor", "right_tyre"), ("caster_floor", "caster")):
        assert sunk[geom] == pytest.approx(balance[model.pair(pair).id], rel=1e-3)


def test_the_caster_carries_the_share_that_the_lever_says():
    model, data = at_rest(dd.Robot.load("matched"))
    names = [model.geom(max(c.geom)).name for c in data.contact]
    force = np.zeros(6)
    mujoco.mj_contactForce(model, data, names.index("caster"), force)
    assert force[0] == pytest.approx(4.0 * 9.81 * 0.06 / 0.2, rel=1e-3)


def test_a_payload_moves_mass_centre_and_inertia_as_the_parallel_axis_theorem_says():
    empty = dd.Robot.load("matched")
    loaded = empty.replace(payload=dd.Payload(mass=2.0, x=-0.1, y=0.04, height=0.3))
    before, after = (compile_model(robot).body("robot") for robot in (empty, loaded))
    axle = after.pos[2]
    assert after.mass[0] == pytest.approx(6.0, rel=1e-15)
    centers = np.array([[-0.06, 0, 0.08 - axle], [-0.1, 0.04, 0.3 - axle]])
    center = np.array([4.0, 2.0]) @ centers / 6.0
    assert after.ipos == pytest.approx(center, abs=1e-15)
    expected = np.diag(before.inertia)
    for mass, place in zip((4.0, 2.0), centers, strict=True):
        x, y, z = place - center
        expected += mass * np.array(
            [[y * y + z * z, -x * y, -x * z], [-x * y, x * x + z * z, -y * z], [-x * z, -y * z, x * x + y * y]]
        )
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, after.iquat)
    axes = axes.reshape(3, 3)
    assert axes @ np.diag(after.inertia) @ axes.T == pytest.approx(expected, abs=1e-12)
    assert loaded.mass == empty.mass + 2.0 == np.sum(compile_model(loaded).body_mass)


def test_a_payload_presses_on_wheels_and_caster_as_the_levers_say():
    robot = dd.Robot.load("matched").replace(payload={"mass": 2.0, "x": -0.1, "y": 0.04, "height": 0.1})
    model, data = at_rest(robot)
    names = [model.geom(max(c.geom)).name for c in data.contact]
    force, loads = np.zeros(6), {}
    for i, name in enumerate(names):
        mujoco.mj_contactForce(model, data, i, force)
        loads[name] = force[0] / 9.81
    caster = (4.0 * 0.06 + 2.0 * 0.1) / 0.2
    assert loads["caster"] == pytest.approx(caster, rel=1e-3)
    assert loads["left_tyre"] + loads["right_tyre"] == pytest.approx(robot.mass - caster, rel=1e-3)
    assert loads["left_tyre"] - loads["right_tyre"] == pytest.approx(2 * 2.0 * 0.04 / 0.4, rel=1e-3)


def test_one_model_serves_equal_robots():
    assert compile_model(UNEQUAL) is compile_model(dd.Robot.load("mismatched"))
    assert compile_model(UNEQUAL) is not compile_model(RIGID)


def test_matched_gains_go_with_the_radius_squared_and_equal_ones_do_not():
    left, right = (servo_gains(UNEQUAL, dd.Physics(), r) for r in (UNEQUAL.left_radius, UNEQUAL.right_radius))
    for one, other in zip(vars(left).values(), vars(right).values(), strict=True):
        assert other / one == pytest.approx(0.91**2)
    equal = UNEQUAL.replace(servo={"gains": "equal"})
    assert servo_gains(equal, dd.Physics(), 0.1) == servo_gains(equal, dd.Physics(), 0.091)
    assert servo_gains(UNEQUAL.replace(servo={"law": "P"}), dd.Physics(), 0.1).integral == 0


def test_a_coarse_time_step_lowers_the_stiffness_to_what_a_free_wheel_can_stand():
    stiff = UNEQUAL.replace(servo={"bandwidth": 1000.0})
    for dt in (0.001, 0.002, 0.004):
        gains = servo_gains(stiff, dd.Physics(timestep=dt), UNEQUAL.mean_radius)
        free_inertia = stiff.tyres.mass * stiff.mean_radius**2 / 2 + stiff.motor.rotor_inertia
        assert gains.damping * dt / free_inertia == pytest.approx(0.5)
        # Softer than asked, and still without overshoot: damping^2 = 4 integral J.
        driven_inertia = free_inertia + stiff.mass * stiff.mean_radius**2 / 2
        assert gains.damping**2 == pytest.approx(4 * gains.integral * driven_inertia)
        assert gains.feedforward == pytest.approx(gains.damping / 2)


def test_a_driven_robot_reaches_the_rates_that_it_is_told():
    """PI ends up at the rate; P falls behind by the load's torque over its gain, here that of a turn on the spot."""
    drive = dd.maneuvers.spin(UNEQUAL, turns=4, yaw_rate=3.0)
    told = drive.wheel_rates[500]
    for law, error in (("PI", 1e-4), ("P", 1e-1)):
        recording = dd.simulate(UNEQUAL.replace(servo={"law": law}), drive)
        reached = (recording.wheel_angles[500] - recording.wheel_angles[490]) / 0.1
        assert reached == pytest.approx(told, rel=error)


def test_cylinder_wheels_lie_across_the_axle():
    model, _ = at_rest(UNEQUAL.replace(tyres={"shape": "cylinder"}), dd.Physics())
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axis = data.geom("left_tyre").xmat.reshape(3, 3)[:, 2]
    assert np.abs(axis) == pytest.approx((0, 1, 0))


def test_odometry_of_a_tilted_robot_should_believe_its_level_twin():
    recording = dd.simulate(RIGID, dd.maneuvers.square(RIGID, side=1.0))

    assert recording.drift(level_twin(RIGID)).max_position_per_metre < 1e-6
    assert recording.drift(RIGID).max_position_per_metre > 1e-4


def test_cylinders_are_as_wide_as_the_tyre():
    robot = dd.Robot.load("mismatched").replace(tyres={"shape": "cylinder"})
    model = compile_model(robot, dd.Physics.mujoco_defaults())
    for side, radius in (("left", robot.left_radius), ("right", robot.right_radius)):
        assert model.geom(f"{side}_tyre").type[0] == mujoco.mjtGeom.mjGEOM_CYLINDER
        assert model.geom(f"{side}_tyre").size[:2] == pytest.approx((radius, robot.tyres.width / 2))
