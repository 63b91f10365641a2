"""Films on terrain: cables and rough floors as they are, and the robot at its height and attitude, its ghosts level."""

import math
from dataclasses import replace

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.physics.mechanics import body_box, box_lift
from diffdrive_mj.report.filming import _cameras, _captions, _ground, _scene
from diffdrive_mj.report.filming._renderer import pictures
from diffdrive_mj.report.filming._take import Take
from diffdrive_mj.report.filming.strobes import strobe

ROBOT = dd.Robot.load("matched")
CABLE = dd.Cable(x=0.0, y=(-0.6, 0.6), height=0.03, radius=0.02)
ROUGH = dd.RoughFloor(x=(-2.0, 2.0), y=(-2.0, 2.0), rms=0.01, wavelength=0.5, level=0.1)


def standing(world=dd.World(), rise=0.0, pitch=0.0, pose=(0.0, 0.0, 0.0)):
    """A robot that stands still, higher than on the floor and nose down by some pitch."""
    nose_down = np.array((math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0))
    return dd.Recording(
        np.array([0.0, 1.0]),
        np.zeros((2, 2)),
        np.tile(pose, (2, 1)),
        ROBOT,
        dd.Commands(1.0, np.zeros((1, 2))),
        world,
        dd.Physics(),
        height=np.full(2, ROBOT.mean_radius + rise),
        attitude=np.tile(nose_down, (2, 1)),
    )


def drawn(recording, believed=(9.0, 9.0, 0.0), camera="follow", size=(240, 180)):
    """The first frame, and the camera's view."""
    take = Take.of(recording, {"odometry": np.tile(believed, (2, 1))})
    view = _cameras.view(camera, [take], take, size[0] / size[1])
    scene = _scene.moving(take, take, view, size)
    return np.asarray(next(pictures(_scene.Job((scene,)))), dtype=float), view


def test_between_samples_a_robot_turns_the_short_way():
    """A quaternion and its negative are the same attitude."""
    still = standing(pitch=0.2)
    signs = np.array([[1.0], [-1.0]])
    stance = Take.of(replace(still, attitude=signs * still.attitude), ROBOT).at(np.array([0.5])).stance
    np.testing.assert_allclose(stance[0], [ROBOT.mean_radius, math.cos(0.1), 0, math.sin(0.1), 0])


def test_what_was_not_recorded_stands_on_the_floor():
    take = Take.of(replace(standing(), height=None, attitude=None), ROBOT)
    assert take.stance is None
    assert take.at(take.t).stance is None


def test_cables_and_rough_floors_are_as_they_are():
    world = dd.World(cables=(CABLE,), rough=ROUGH)
    (bar,), (*pieces, field) = _ground.ground(world.replace(rough=None), 0.3), _ground.ground(world, 0.3)
    np.testing.assert_allclose(bar.ends, ((0.0, -0.6, 0.01), (0.0, 0.6, 0.01)))
    np.testing.assert_allclose(bar.moved(1.0, 2.0).ends[1], (1.0, 2.6, 0.01))
    assert {(piece.radius, piece.label) for piece in (bar, *pieces)} == {(0.02, "cable of 30 mm")}
    np.testing.assert_array_equal([piece.ends[0] for piece in pieces], CABLE.course(ROUGH)[:-1])
    assert pieces[-1].ends[1] == tuple(CABLE.course(ROUGH)[-1])
    np.testing.assert_array_equal(field.heights, ROUGH.grid[2])
    assert (field.centre, field.half, field.label) == ((0, 0), (2, 2), "rough floor of 10 mm RMS")
    assert _ground.levels([bar, field]) == (-ROUGH.depth, field.heights.max())
    assert _ground.levels([bar]) == (0.0, 0.0)
    take = Take.of(standing(world), ROBOT)
    said = [entry.text for entry in _captions.caption(take, take, 0)]
    assert {"cable of 30 mm", "rough floor of 10 mm RMS"} <= set(said)
    assert not any("squares" in text for text in said)  # which the rough floor hides


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize(("rise", "pitch"), [(0.0, 0.0), (0.08, 0.0), (0.08, 0.25), (0.08, -0.25)])
def test_a_robot_on_a_cable_is_seen_higher_and_inclined(rise, pitch):
    """Its chassis ends in the picture where a pinhole projects its corners."""
    shown, view = drawn(standing(rise=rise, pitch=pitch))
    length, width, thickness = body_box(ROBOT)
    x, y, z = np.meshgrid((-1, 1), (-1, 1), (-1, 1))
    x, z = (ROBOT.caster.x + ROBOT.mean_radius) / 2 + x * length / 2, box_lift(ROBOT) + z * thickness / 2
    c, s = math.cos(pitch), math.sin(pitch)
    corners = np.stack([c * x + s * z, y * width / 2, ROBOT.mean_radius + rise - s * x + c * z], axis=-1).reshape(
        1, -1, 3
    )
    projected = view.project(corners, (shown.shape[1], shown.shape[0]))[0]
    blue = np.array(np.nonzero(shown[..., 2] > 1.5 * shown[..., 0]))[::-1]  # to the right, down
    np.testing.assert_allclose(blue.min(axis=1), projected.min(axis=0), atol=3)


@pytest.mark.usefixtures("opengl")
def test_a_cable_is_seen_across_the_way():
    pose = (1.0, 0.0, 0.0)
    with_cable, view = drawn(standing(dd.World(cables=(CABLE,)), pose=pose), (-1.0, 0.0, 0.0), "above", (320, 240))
    without, _ = drawn(standing(pose=pose), (-1.0, 0.0, 0.0), "above", (320, 240))
    for y, there in ((0.4, True), (-0.4, True), (0.8, False)):
        right, down = view.project(np.array([[(0.0, y, 0.0)]]), (320, 240))[0, 0].round().astype(int)
        darker = without[down, right].mean() - with_cable[down, right].mean()
        assert (darker > 60) == there


@pytest.mark.usefixtures("opengl")
def test_a_rough_floor_is_shaded_and_the_trail_lies_above_its_crests():
    pose = (1.0, 0.0, 0.0)
    recording = replace(standing(dd.World(rough=ROUGH)), truth=np.array([(-1.0, -1.0, 0.0), pose]))
    take = Take.of(recording, {"odometry": np.array([(-1.0, -1.0, 0.0), (1.0, 0.9, 0.0)])})
    seen = take.at(take.t[-1:])
    view = _cameras.view("above", [take], seen, 4 / 3)
    scene = _scene.moving(take, seen, view, (320, 240))
    shown = np.asarray(next(pictures(_scene.Job((scene,)))), dtype=float)
    for share in np.linspace(0.1, 0.6, 11):
        x, y, _ = (1 - share) * take.truth[0] + share * take.truth[1]
        right, down = view.project(np.array([[(x, y, 0.0)]]), (320, 240))[0, 0].round().astype(int)
        near = shown[down - 3 : down + 4, right - 3 : right + 4]
        assert (near[..., 2] > 1.3 * near[..., 0]).any()
    right, down = view.project(np.array([[(-1.0, 1.0, 0.0), (1.0, -1.0, 0.0)]]), (320, 240))[0].T.round().astype(int)
    brightness = shown[min(down) : max(down), min(right) : max(right)].mean(axis=-1)
    assert np.ptp(np.percentile(brightness, (5, 50))) > 3


def test_a_patch_on_a_rough_floor_goes_up_and_down_with_it():
    """It is seen on crests and in hollows alike, and beyond the rough floor on the smooth one."""
    patch = dd.Patch(x=(1.0, 3.0), y=(-0.4, 0.4), friction=0.3)
    flat, over, _ = _ground.ground(dd.World(patches=(patch,), rough=ROUGH), 0.3)
    assert flat.centre == (2.0, 0.0, -ROUGH.depth)
    assert (over.centre, over.half, over.label) == ((1.5, 0.0), (0.5, 0.4), flat.label)
    rows, columns = over.heights.shape
    x, y = np.meshgrid(np.linspace(1.0, 2.0, columns), np.linspace(-0.4, 0.4, rows))
    np.testing.assert_allclose(over.heights - ROUGH.height_at(np.stack([x, y], axis=-1)), 0.0006, atol=1e-12)
    beyond = dd.Patch(x=(5.0, 6.0), y=(-0.4, 0.4), friction=0.3)
    assert len(_ground.ground(dd.World(patches=(beyond,), rough=ROUGH), 0.3)) == 2


@pytest.mark.usefixtures("opengl")
def test_a_patch_on_the_level_circle_of_a_rough_floor_is_drawn(tmp_path):
    world = dd.World(patches=(dd.Patch(x=(-0.1, 0.1), y=(-0.1, 0.1), friction=0.3),), rough=ROUGH)
    strobe(standing(world), ROBOT, tmp_path / "it.png", size=(320, 240))
    assert (tmp_path / "it.png").stat().st_size > 0
