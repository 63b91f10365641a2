"""Cameras: what they must have in the picture, and that it fills it; projected by a pinhole of the tests' own."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.report.filming import _cameras
from diffdrive_mj.report.filming._take import Take

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
SIZE = (400, 300)


def take(seed=0, count=40):
    rng = np.random.default_rng(seed)
    t = np.arange(count) * 0.1
    truth, ghost = (np.cumsum(rng.normal(0.02, 0.1, (count, 3)), axis=0) for _ in range(2))
    return Take(ROBOT, dd.World(), t, truth, np.zeros((count, 2)), {"odometry": ghost})


def pinhole(view, k, point):
    """Where a camera sees a point: rotated about z by the azimuth, then about the picture's x axis by the elevation."""
    a, e = np.radians(view.azimuth[k]), np.radians(view.elevation[k])
    x, y, z = np.asarray(point) - view.position[k]
    ahead, left = np.cos(a) * x + np.sin(a) * y, -np.sin(a) * x + np.cos(a) * y
    depth, up = np.cos(e) * ahead + np.sin(e) * z, -np.sin(e) * ahead + np.cos(e) * z
    focal = SIZE[1] / 2 / np.tan(np.radians(view.fovy) / 2)
    return SIZE[0] / 2 - focal * left / depth, SIZE[1] / 2 - focal * up / depth


@pytest.mark.parametrize("camera", ["follow", "above", "oblique"])
@pytest.mark.parametrize("seed", range(4))
def test_robot_and_ghost_are_in_the_picture(camera, seed):
    whole = take(seed)
    view = _cameras.view(camera, [whole], whole, SIZE[0] / SIZE[1])
    for k in range(len(whole.t)):
        for x, y, _ in (whole.truth[k], whole.ghosts["odometry"][k]):
            for z in (0.0, 0.15):
                right, down = pinhole(view, k, (x, y, z))
                assert 0 < right < SIZE[0]
                assert 0 < down < SIZE[1]


@pytest.mark.parametrize("camera", ["above", "oblique"])
def test_a_still_camera_is_as_near_as_it_can_be(camera):
    near = take(1)
    ghosts = {name: 20 * poses for name, poses in near.ghosts.items()}
    whole = Take(ROBOT, dd.World(), near.t, 20 * near.truth, near.wheel_angles, ghosts)
    view = _cameras.view(camera, [whole], whole, SIZE[0] / SIZE[1])
    assert np.ptp(view.position, axis=0).max() == 0
    places = np.concatenate([whole.truth, whole.ghosts["odometry"]])[:, :2]
    seen = np.array([pinhole(view, 0, (x, y, 0.0)) for x, y in places])
    filled = np.ptp(seen, axis=0) / SIZE
    assert 0.87 < filled.max() < 0.95  # 0.94, and the size of the robot


def test_projection_is_that_of_a_pinhole():
    whole = take(2)
    view = _cameras.view("follow", [whole], whole, SIZE[0] / SIZE[1])
    point = (0.3, -0.2, 0.1)
    projected = view.project(np.tile(point, (len(whole.t), 1, 1)), SIZE)[:, 0]
    np.testing.assert_allclose(projected, [pinhole(view, k, point) for k in range(len(whole.t))], atol=1e-9)


def test_from_above_x_is_to_the_right_and_y_up():
    whole = take(3)
    wide = Take(ROBOT, dd.World(), whole.t, whole.truth * (1, 0.1, 1), whole.wheel_angles, {})
    view = _cameras.view("above", [wide], wide, SIZE[0] / SIZE[1])
    (x0, y0), (x1, y1), (x2, y2) = (pinhole(view, 0, p) for p in ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)))
    assert x1 - x0 > 1 and abs(y1 - y0) < 1e-6  # noqa: PT018
    assert y2 - y0 < -1 and abs(x2 - x0) < 1e-6  # noqa: PT018


def test_a_ghost_far_away_does_not_make_the_robot_tiny():
    whole = take(0)
    away = {"odometry": whole.truth + np.array((500.0, 0, 0))}
    far = Take(ROBOT, dd.World(), whole.t, whole.truth, whole.wheel_angles, away)
    view = _cameras.view("follow", [far], far, SIZE[0] / SIZE[1])
    assert view.distance.max() < 10


def test_drives_beside_each_other_are_seen_by_one_camera():
    first, second = take(0), take(1)
    views = [_cameras.view("oblique", [first, second], one, 1.0) for one in (first, second)]
    np.testing.assert_array_equal(views[0].position, views[1].position)
