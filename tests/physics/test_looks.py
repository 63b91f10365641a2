"""What the eye sees of a robot: round wheels with a mark, a caster that hangs from the body, a nose in front."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import laden_robots

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.robot import presets

REFERENCE = dd.Robot.load("matched")
PHYSICS_GROUP = 3  # which viewers hide at first
NO_OPENGL = 77


def box(model, name):
    """The lowest and the highest corner of a geom that is not turned, in its body's frame."""
    geom = model.geom(name)
    half = geom.size[[0, 0, 1]] if name == "caster_leg" else geom.size
    return geom.pos - half, geom.pos + half


def check(robot):
    model = compile_model(robot)
    chassis, leg, nose = (box(model, name) for name in ("chassis", "caster_leg", "nose"))
    caster = model.geom("caster")
    # The leg holds the ball at its middle and reaches into the body, or up to it.
    assert leg[0][2] == pytest.approx(caster.pos[2])
    assert leg[1][2] >= chassis[0][2] - 1e-12
    assert leg[1][2] > leg[0][2]
    assert caster.size[0] < model.geom("caster_leg").size[0] < 1.2 * caster.size[0]
    assert leg[0][:2] + leg[1][:2] == pytest.approx(2 * caster.pos[:2])  # upright over the ball
    assert leg[1][2] == pytest.approx(max(chassis[0][2], caster.pos[2] + 1.2 * caster.size[0]))
    # The nose lies on the front half of the body and juts out ahead and above.
    assert (chassis[0][0] + chassis[1][0]) / 2 < nose[0][0] < chassis[1][0] < nose[1][0]
    assert nose[0][2] < chassis[1][2] < nose[1][2]
    assert nose[0][1] == -nose[1][1]
    for side, radius in (("left", robot.left_radius), ("right", robot.right_radius)):
        tyre, disc, hub, spoke = (model.geom(f"{side}_{part}") for part in ("tyre", "disc", "hub", "spoke"))
        assert tyre.group[0] == PHYSICS_GROUP
        assert disc.size[:2] == pytest.approx((radius, robot.tyres.width / 2))
        # Seen from the side: the mark over the hub over the disc, none of them larger than the wheel.
        assert disc.size[1] < hub.size[1] < spoke.size[1]
        assert 0.5 * radius < hub.size[0] < radius
        assert spoke.pos[:2] == pytest.approx((0, 0))
        assert 0 < spoke.size[0] < 0.15 * radius
        assert spoke.size[2] > 0.4 * radius
        assert spoke.pos[2] + spoke.size[2] < radius
        assert spoke.pos[2] - spoke.size[2] >= 0  # on one side of the hub alone: one mark a turn
    assert 0 < model.site("axle").size[0] < 0.1 * robot.mean_radius
    # Camera and lamp stand as far off as the robot is large.
    scale = max(robot.track_width, *np.ptp(chassis, axis=0)[:2], np.ptp(chassis, axis=0)[2]) / REFERENCE.track_width
    for of, at in ((model.camera("follow"), "cam_pos"), (model.light("lamp"), "light_pos")):
        first = getattr(compile_model(REFERENCE), at)[of.id]
        assert of.pos == pytest.approx(scale * first)
    assert not model.geom_contype.any()
    assert not model.geom_conaffinity.any()


@pytest.mark.parametrize("name", presets())
def test_a_preset_looks_like_a_robot(name):
    check(dd.Robot.load(name))
    check(dd.Robot.load(name).replace(axle="rigid"))


def test_a_robot_with_its_caster_in_front_looks_like_one():
    check(dd.Robot.load("mismatched").replace(caster={"x": 0.2}, center_of_mass_x=0.06))


@settings(max_examples=50, deadline=None)
@given(laden_robots)
def test_any_robot_looks_like_one(robot):
    try:
        compile_model(robot)
    except DiffdriveError:
        return
    check(robot)


def test_no_contact_is_with_what_is_for_the_eye_alone():
    model = compile_model(dd.Robot.load("mismatched"))
    touching = {
        model.geom(int(geom)).name for pair in zip(model.pair_geom1, model.pair_geom2, strict=True) for geom in pair
    }
    assert touching == {"floor", "left_tyre", "right_tyre", "caster", "chassis"}


SEEN = """
import sys

try:
    import mujoco

    mujoco.GLContext(8, 8).free()
except Exception as error:
    print(error, file=sys.stderr)
    sys.exit(77)
import numpy as np
import diffdrive_mj as dd
from diffdrive_mj.physics.model import compile_model

model = compile_model(dd.Robot.load(sys.argv[1]))
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
first = mujoco.MjvCamera()
mujoco.mjv_defaultFreeCamera(model, first)
renderer = mujoco.Renderer(model, 480, 640)
renderer.enable_segmentation_rendering()
for camera in (first, "follow"):
    renderer.update_scene(data, camera)
    ids, kinds = np.moveaxis(renderer.render(), -1, 0)
    geoms = ids[kinds == mujoco.mjtObj.mjOBJ_GEOM]
    print(*(f"{model.geom(int(k)).name}={(geoms == k).sum()}" for k in np.unique(geoms)))
"""


@pytest.mark.parametrize("name", ["mismatched", "ct_bot"])
def test_what_the_viewer_and_the_camera_show(name):
    """Rendered in a process of its own, since MuJoCo reads MUJOCO_GL once."""
    environment = {**os.environ, "MUJOCO_GL": "egl"}
    program = [sys.executable, "-c", SEEN, name]
    done = subprocess.run(program, env=environment, capture_output=True, text=True, check=False)
    if done.returncode == NO_OPENGL:
        pytest.skip(f"nothing renders here: {done.stderr[-200:]}")
    assert done.returncode == 0, done.stderr
    views = [dict(part.split("=") for part in line.split()) for line in done.stdout.splitlines()]
    pixels = [{geom: int(count) for geom, count in view.items()} for view in views]
    assert len(pixels) == 2
    for view in pixels:
        assert not {"left_tyre", "right_tyre"} & set(view)
        assert min(view[geom] for geom in ("chassis", "nose", "right_disc", "right_hub", "right_spoke")) > 30
        robot = sum(count for geom, count in view.items() if geom != "floor")
        assert 0.03 < robot / (480 * 640) < 0.5
    assert pixels[1]["caster_leg"] > 20
