"""`models/diffdrive.xml` by itself: the numbers of "mismatched", and a robot that drives in plain MuJoCo."""

import math

import mujoco
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.physics.mjcf import to_mjcf
from diffdrive_mj.physics.model import XML, compile_model
from diffdrive_mj.physics.servo import servo_gains

ROBOT = dd.Robot.load("mismatched")
UPRIGHT = math.cos(math.radians(15))
# What belongs to the file alone: its keyframes, its servos (tested apart), and what names and sizes follow from them.
OWN = ("key_", "actuator_", "name", "nkey", "na", "nu", "nactuator", "nout", "nJmom", "nnames", "nbuffer", "signature")


@pytest.fixture(scope="module")
def xml():
    return mujoco.MjModel.from_xml_path(str(XML))


def numbers(structure):
    """Every array and number of a MuJoCo structure by its name."""
    kinds = (np.ndarray, int, float)
    fields = {name: getattr(structure, name) for name in dir(structure) if not name.startswith("_")}
    return {name: value for name, value in fields.items() if isinstance(value, kinds)}


def different(ours, theirs):
    assert ours.keys() == theirs.keys()
    return {
        name: (ours[name], theirs[name])
        for name in ours
        if np.shape(ours[name]) != np.shape(theirs[name])
        or not np.allclose(ours[name], theirs[name], rtol=1e-9, atol=1e-15)
    }


def test_the_file_has_every_number_of_mismatched_but_for_its_servos(xml):
    ours = compile_model(ROBOT)
    for parts in ((xml, ours), (xml.opt, ours.opt), (xml.stat, ours.stat), (xml.vis.headlight, ours.vis.headlight)):
        wrong = different(*(numbers(part) for part in parts))
        assert not {name: pair for name, pair in wrong.items() if not name.startswith(OWN)}


def test_its_servos_are_the_damping_of_the_package_alone(xml):
    """The package adds an integral part to each servo and feeds half as much of the command forward."""
    ours = compile_model(ROBOT)
    assert [xml.actuator(i).name for i in range(xml.nu)] == ["left_servo", "right_servo"]
    for side, radius in (("left", ROBOT.left_radius), ("right", ROBOT.right_radius)):
        gains = servo_gains(ROBOT, dd.Physics(), radius)
        plain, servo, integral = (
            xml.actuator(f"{side}_servo"),
            *(ours.actuator(f"{side}_{part}") for part in ("servo", "integral")),
        )
        assert plain.gainprm[0] == pytest.approx(gains.damping, rel=1e-9)
        assert plain.biasprm[:3] == pytest.approx((0, 0, -gains.damping), rel=1e-9)
        assert servo.biasprm[:3] == pytest.approx((0, 0, -gains.damping), rel=1e-12)
        assert servo.gainprm[0] == pytest.approx(gains.damping / 2, rel=1e-12)
        assert (integral.gainprm[0], integral.biasprm[1]) == (gains.integral, -gains.integral)
        for actuator, kind in ((plain, "NONE"), (servo, "NONE"), (integral, "INTEGRATOR")):
            assert actuator.dyntype[0] == getattr(mujoco.mjtDyn, f"mjDYN_{kind}")
            assert actuator.trnid[0] == xml.joint(side).id == ours.joint(side).id
    assert ours.nu == 4
    assert xml.actuator_ctrllimited.all()
    assert xml.actuator_forcelimited.all()
    assert not ours.actuator_ctrllimited.any()
    assert not ours.actuator_forcelimited.any()


def test_its_limits_and_keyframes_are_those_that_any_robot_is_written_with(xml):
    written = mujoco.MjModel.from_xml_string(to_mjcf(ROBOT))
    for name in ("actuator_ctrlrange", "actuator_forcerange", "key_qpos", "key_qvel", "key_ctrl"):
        np.testing.assert_allclose(getattr(xml, name), getattr(written, name), rtol=2e-6)
    assert [xml.key(i).name for i in range(xml.nkey)] == ["rest", "straight"]
    speed = np.array([[ROBOT.left_radius, ROBOT.right_radius]]).T * xml.actuator_ctrlrange
    np.testing.assert_allclose(speed, [[-3, 3], [-3, 3]], rtol=1e-6)


def test_it_drives_straight_at_the_speed_of_the_task(xml):
    data = mujoco.MjData(xml)
    mujoco.mj_resetDataKeyframe(xml, data, xml.key("straight").id)
    mujoco.mj_step(xml, data, nstep=5000)
    x, y = data.qpos[:2]
    assert data.time == pytest.approx(10.0)
    assert data.qvel[0] == pytest.approx(1.5, rel=1e-8)
    assert 14 < x < 15
    assert abs(y) < 1e-6
    assert abs(data.joint("base").qpos[6]) < 1e-7
    assert not data.warning.number.any()


@pytest.mark.parametrize("ctrl", [(1, 1), (-1, -1), (1, -1), (0.5, 1)])
def test_its_sliders_may_jump(xml, ctrl):
    """From rest to one end of the sliders, to the other and to zero: the robot stays up, and stops where it is."""
    data = mujoco.MjData(xml)
    for sign in (1, -1, 0):
        data.ctrl[:] = sign * np.array(ctrl) * xml.actuator_ctrlrange[:, 1]
        for _ in range(20):
            mujoco.mj_step(xml, data, nstep=100)
            assert data.body("robot").xmat[8] > UPRIGHT
    assert np.abs(data.qvel).max() < 1e-6


def test_it_rests_without_a_motion(xml):
    data = mujoco.MjData(xml)
    mujoco.mj_resetDataKeyframe(xml, data, xml.key("rest").id)
    mujoco.mj_step(xml, data, nstep=1000)
    assert np.abs(data.qpos - xml.key("rest").qpos).max() < 1e-12
    assert np.abs(data.qvel).max() < 1e-9


def test_it_says_what_its_contacts_carry(xml):
    data = mujoco.MjData(xml)
    mujoco.mj_forward(xml, data)
    left, right, caster = (data.sensor(f"{name}_contact").data for name in ("left", "right", "caster"))
    assert left[0] + right[0] + caster[0] == pytest.approx(4.6 * 9.81, rel=1e-5)
    assert caster[0] == pytest.approx(4.0 * 9.81 * 0.06 / 0.2, rel=1e-5)
    assert data.sensor("chassis_contact").data == 0
