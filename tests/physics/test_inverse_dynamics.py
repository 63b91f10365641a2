"""The forces on the contacts, against the inverse dynamics that the engine computes from the same motion."""

import copy

import mujoco
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.physics.model import compile_model

MATCHED = dd.Robot.load("matched")
ROBOTS = {
    "matched": MATCHED,
    "heavy wheels": MATCHED.replace(tyres={"mass": 1.5, "width": 0.08}),
    "laden": MATCHED.replace(payload=dd.Payload(mass=1.5, x=-0.1, y=0.05, height=0.2)),
    "caster ahead": MATCHED.replace(caster={"x": 0.2}, center_of_mass_x=0.06),
}
WORLDS = [dd.World(), dd.World(slope={"angle": 0.2, "direction": 0.7}), dd.World(gravity=1.62)]


def wrench(robot, twist, acceleration, world):
    """What the floor must do to a robot that rolls so: force (3,) and moment about the axle's midpoint (3,)."""
    model = copy.copy(compile_model(robot, world=world))  # which is shared
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    (v, omega), (a, alpha) = twist, acceleration
    height = robot.left_radius
    assert data.body("robot").xpos == pytest.approx((0, 0, height), abs=1e-4)  # as high as its axle
    data.qvel[:6], data.qacc[:6] = (v, 0, 0, 0, 0, omega), (a, v * omega, 0, 0, 0, alpha)
    for side, sign in (("left", -1), ("right", 1)):
        dof = model.joint(side).dofadr[0]
        data.qvel[dof] = (v + sign * omega * robot.track_width / 2) / robot.left_radius
        data.qacc[dof] = (a + sign * alpha * robot.track_width / 2) / robot.left_radius
    mujoco.mj_inverse(model, data)
    return data.qfrc_inverse[:3], data.qfrc_inverse[3:6]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    ("twist", "acceleration"),
    [
        ((0.0, 0.0), (0.0, 0.0)),
        ((0.0, 0.0), (0.0, 2.0)),
        ((0.0, 0.0), (1.0, 0.0)),
        ((0.0, 3.0), (0.0, 0.0)),
        ((0.8, 1.5), (0.7, -2.0)),
    ],
)
@pytest.mark.parametrize("world", WORLDS, ids=["level", "slope", "moon"])
def test_the_contacts_add_up_to_what_the_motion_takes(name, twist, acceleration, world):
    """The engine's robot faces along x; on a floor that is turned as far as the robot is, the forces are the same."""
    robot = ROBOTS[name]
    turned = world.replace(slope={"angle": 0.2, "direction": 2.0}) if world.slope else world
    forces = contact_forces(robot, twist, acceleration, turned, 2.0 - 0.7)
    force, moment = wrench(robot, twist, acceleration, world)
    half, r = robot.track_width / 2, robot.left_radius
    left, right, caster = forces.load
    weight = force[2]
    assert left + right + caster == pytest.approx(weight, rel=1e-6)
    # r x F of forces at the floor: loads at the wheels and the caster, pull and side force under the wheels.
    assert half * (left - right) + r * force[1] == pytest.approx(moment[0], abs=2e-4 * weight * half)
    assert -r * force[0] - robot.caster.x * caster == pytest.approx(moment[1], abs=2e-4 * weight * half)
    # The pulls along x, which with the side forces at the axle turn the robot; the two wheels share these.
    pull_right = (force[0] + moment[2] / half) / 2
    pull_left = force[0] - pull_right
    assert forces.pull == pytest.approx(np.hypot([pull_left, pull_right], force[1] / 2), abs=2e-4 * weight)
