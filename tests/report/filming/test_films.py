"""Films and pictures as drawn: robot and ghost are where they should be, in their colours, and wheels turn."""

import importlib.util
import shutil
import subprocess

import numpy as np
import pytest
from helpers import ROOT, refused
from PIL import Image

import diffdrive_mj as dd
from diffdrive_mj.report.filming import _cameras, _captions, _scene
from diffdrive_mj.report.filming._renderer import pictures
from diffdrive_mj.report.filming._sheet import Group, Sheet
from diffdrive_mj.report.filming._take import Take

pytestmark = pytest.mark.usefixtures("opengl")

ROBOT = dd.Robot.load("matched")
HERE = (0.3, -0.2, 2.0)
SMALL = (160, 120)


def standing(wheel_angles=((0, 0), (0, 0)), world=dd.World(), pose=HERE):
    """A recording of a robot that stays where it is, whatever its wheels do."""
    commands = dd.Commands(1.0, np.zeros((1, 2)))
    t = np.linspace(0, 1, len(wheel_angles))
    return dd.Recording(
        t, np.array(wheel_angles, float), np.tile(pose, (len(t), 1)), ROBOT, commands, world, dd.Physics()
    )


def beside(dx, dy, pose=HERE):
    return np.tile(np.add(pose, (dx, dy, 0)), (2, 1))


def pixels(path):
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=float)


def picture(tmp_path, recording, believed, size=(240, 180), **options):
    """The drawn part of a still picture, without its caption."""
    dd.film(recording, believed, tmp_path / "still.png", size=size, **options)
    take = Take.of(recording, believed)
    seen = take.at(take.t[-1:])
    cameras = (options.get("camera", "follow"),)
    sheet = Sheet([Group("", take, seen, cameras)], size, _captions.caption)
    return pixels(tmp_path / "still.png")[: sheet.height], take, seen


def blue(shown):
    return (shown[..., 2] > 1.5 * shown[..., 0]) & (shown[..., 2] > 1.2 * shown[..., 1])


def orange(shown):
    return (shown[..., 0] > 2.2 * shown[..., 2]) & (shown[..., 0] > 1.25 * shown[..., 1])


def green(shown):
    return (shown[..., 1] > 1.5 * shown[..., 0]) & (shown[..., 1] > 1.1 * shown[..., 2])


def centre(mask):
    down, right = np.nonzero(mask)
    return np.array([right.mean(), -down.mean()])


def test_robot_and_ghosts_stand_where_they_should(tmp_path):
    """Seen from above: one metre ahead along x is to the right, along y up, and a metre is as long as it should be."""
    pose = (0.3, -0.2, 0.0)
    believed = {"a": beside(1.0, 0.0, pose), "b": beside(0.0, 1.0, pose)}
    shown, _, _ = picture(tmp_path, standing(pose=pose), believed, camera="above")
    robot, a, b = (centre(colour(shown)) for colour in (blue, orange, green))
    metre = float(np.ptp(np.nonzero(blue(shown))[0]) + 1) / 0.34  # the chassis is that wide
    # The lens shows what is high a little farther out.
    np.testing.assert_allclose(a - robot, (metre, 0), atol=0.08 * metre)
    np.testing.assert_allclose(b - robot, (0, metre), atol=0.08 * metre)


@pytest.mark.parametrize("camera", ["follow", "oblique", "above"])
def test_colours_are_where_a_pinhole_projects_the_poses(tmp_path, camera):
    believed = {"odometry": beside(-0.2, 0.9)}
    shown, take, seen = picture(tmp_path, standing(), believed, camera=camera)
    view = _cameras.view(camera, [take], seen, shown.shape[1] / shown.shape[0])
    for (x, y, theta), colour in ((HERE, blue), (believed["odometry"][0], orange)):
        roof = (x - 0.18 * np.cos(theta), y - 0.18 * np.sin(theta), 0.18)  # near its rear edge
        right, down = view.project(np.array([[roof]]), (shown.shape[1], shown.shape[0]))[0, 0].round().astype(int)
        assert colour(shown)[down, right], shown[down, right]
    assert not orange(shown)[:5].any()


def test_a_right_belief_hides_its_ghost_in_the_robot_and_a_wrong_one_shows_it(tmp_path):
    pose = (0.3, -0.2, 0.0)
    right, wrong, near = (
        picture(tmp_path, standing(pose=pose), {"odometry": beside(dx, dy, pose)}, camera="above", size=(200, 150))[0]
        for dx, dy in ((0, 0), (0.05, 0.08), (1e-7, 0))
    )
    np.testing.assert_allclose(right, near, atol=8)
    robot = blue(right)
    inside = orange(right)[tuple(slice(i.min(), i.max() + 1) for i in np.nonzero(robot))]
    assert not inside.any()
    assert robot.sum() > 1.15 * blue(wrong).sum()  # the ghost covers some of it
    assert orange(right).sum() > 0.2 * robot.sum()  # the glow around it


def test_the_robot_throws_a_shadow_away_from_the_sun_and_its_ghost_none(tmp_path):
    """From above, x to the right, the sun goes 0.5 to the right and 0.35 up for each metre down."""
    pose = (0.3, -0.2, 0.0)
    recording, believed = standing(pose=pose), {"odometry": beside(1.2, 0.0, pose)}
    shown, take, seen = picture(tmp_path, recording, believed, camera="above", size=(640, 480))
    view = _cameras.view("above", [take], seen, shown.shape[1] / shown.shape[0])
    assert view.azimuth[0] == 90

    def brightness(x, y):
        right, down = view.project(np.array([[(x, y, 0.0)]]), shown.shape[1::-1])[0, 0].round().astype(int)
        return shown[down, right].mean()

    radius, outside = ROBOT.mean_radius, ROBOT.track_width / 2 + ROBOT.tyres.width / 2
    # Rays past the highest point of the left wheel's outer side end at the tip of its shadow.
    top = np.array((pose[0], pose[1] + outside))
    shade, beyond = (top + share * 2 * radius * np.array((0.5, 0.35)) for share in (0.85, 1.3))
    assert brightness(*shade) < 190
    for place in (beyond, (pose[0], pose[1] - outside - 0.05), shade + np.array((1.2, 0))):
        assert brightness(*place) > 215


def test_wheels_turn():
    angles = [(0, 0), (1.0, 1.0), (2 * np.pi, -2 * np.pi)]
    take = Take.of(standing(angles), {"odometry": np.tile(HERE, (3, 1))})
    scene = _scene.moving(take, take, _cameras.view("follow", [take], take, 4 / 3), (320, 240))
    first, turned, around = (np.asarray(frame, dtype=float) for frame in pictures(_scene.Job((scene,))))
    assert (np.abs(first - turned).max(axis=-1) > 40).sum() > 20
    assert (np.abs(first - around).max(axis=-1) > 40).sum() == 0


def test_far_from_the_origin_it_looks_the_same():
    """The floor has squares of 0.2 m, so that a kilometre further they are where they were."""
    shots = []
    for away in (0.0, 1000.0):
        ice = dd.Patch(x=(away, away + 0.5), y=(-away - 0.2, -away + 0.3), friction=0.1)
        pose = (0.1 + away, -away, 0.3)
        recording = standing([(0, 0), (1, 1)], dd.World(patches=(ice,)), pose)
        take = Take.of(recording, {"odometry": beside(0.4, 0.3, pose)})
        scene = _scene.moving(take, take, _cameras.view("oblique", [take], take, 4 / 3), (160, 120))
        shots.append(np.asarray(next(pictures(_scene.Job((scene,)))), dtype=float))
    assert np.abs(shots[0] - shots[1]).max() < 8


def test_patches_lie_on_the_floor(tmp_path):
    ice = dd.Patch(x=(-0.5, 1.5), y=(-1.5, 1.5), friction=0.05)
    world = dd.World(patches=(ice,))
    believed = {"odometry": beside(2.4, 0)}
    shown, *_ = picture(tmp_path, standing(world=world), believed, camera="above", size=(200, 150))
    blueish = shown[..., 2] - shown[..., 0] > 30
    assert blueish[:, :10].mean() > 0.9  # the robot stands on the ice, which ends between it and its ghost
    assert 0.2 < blueish.mean() < 0.8


@pytest.fixture(scope="module")
def driven():
    commands = dd.maneuvers.straight(ROBOT, speed=1.0, distance=0.5)
    return dd.simulate(ROBOT, commands, sample_rate=50.0)


WRONG = ROBOT.replace(right_radius=0.09)


def test_a_film_has_its_frames_and_the_robot_moves(driven, tmp_path):
    made = dd.film(driven, WRONG, tmp_path / "film.webp", size=SMALL, fps=10, speed=1.5, camera="above")
    expected = int(driven.t[-1] * 10 / 1.5 + 1e-9) + 1
    assert (made.frames, made.size, made.seconds) == (expected, SMALL, expected / 10)
    with Image.open(tmp_path / "film.webp") as film:
        assert (film.n_frames, film.size) == (expected, SMALL)
        places = []
        for k in (0, expected - 1):
            film.seek(k)
            shown = np.asarray(film.convert("RGB"), dtype=float)[:80]
            places.append(np.nonzero(blue(shown))[1].max())
    assert places[1] > places[0] + 20
    assert "data:image/webp;base64," in made._repr_html_()
    (tmp_path / "film.webp").unlink()
    assert "no longer there" in made._repr_html_()


def test_an_mp4_is_a_film_too(driven, tmp_path):
    if not (shutil.which("ffmpeg") and shutil.which("ffprobe")):
        pytest.skip("there is no ffmpeg")
    made = dd.film(driven, WRONG, tmp_path / "film.mp4", size=(161, 121), fps=5, camera="both")
    probe = [
        "ffprobe",
        "-v",
        "error",
        "-count_frames",
        "-show_entries",
        "stream=nb_read_frames,width,height",
        "-of",
        "csv=p=0",
    ]
    said = subprocess.run([*probe, str(made.path)], capture_output=True, text=True, check=True).stdout
    assert said.strip() == f"162,122,{made.frames}"


def test_without_ffmpeg_one_line_names_webp(driven, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with refused(FileNotFoundError, "needs ffmpeg", ".webp"):
        dd.film(driven, WRONG, tmp_path / "film.mp4")


def test_an_ffmpeg_that_fails_is_one_line_and_leaves_nothing(driven, tmp_path, monkeypatch):
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "ffmpeg").write_text("#!/bin/sh\necho no such codec >&2\nexit 7\n")
    (programs / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", str(programs))
    with refused(RuntimeError, "exit status 7 (no such codec)", ".webp"):
        dd.film(driven, WRONG, tmp_path / "film.mp4", size=SMALL, fps=5)
    assert [path.name for path in tmp_path.iterdir()] == ["bin"]


def test_a_strobe_shows_as_many_robots_as_asked(driven, tmp_path):
    believed = {"odometry": driven.truth + np.array((0, 1.2, 0))}
    areas = []
    for times in (2, [driven.t[-1]]):
        dd.strobe(driven, believed, tmp_path / "strobe.png", times=times, size=(320, 240), camera="above")
        areas.append(orange(pixels(tmp_path / "strobe.png")[30:190]).sum())
    assert 1.6 < areas[0] / areas[1] < 2.1  # and the trail


def test_drives_beside_each_other(driven, tmp_path):
    made = dd.strobe({"one": driven, "other": driven}, WRONG, tmp_path / "both.webp", size=(400, 200))
    assert made.size == (400, 200)
    shown = pixels(made.path)[40:150]
    np.testing.assert_allclose(shown[:, 5:190], shown[:, 205:390], atol=2)


def test_the_picture_at_the_head_of_the_readme_says_what_happens():
    """[Behnke]: equal radii turn about (b / 2) (1 + k) / (1 - k), and r_r = k r_l drives straight."""
    path = ROOT / "examples" / "ghost.py"
    spec = importlib.util.spec_from_file_location("ghost", path)
    ghost = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ghost)
    recordings, believed = ghost.drives()
    circling, straight = (recording.truth[-1] for recording in recordings.values())
    radius = ROBOT.track_width / 2 * (1 + ghost.K) / (1 - ghost.K)
    np.testing.assert_allclose(
        circling[:2], radius * np.array((np.sin(circling[2]), 1 - np.cos(circling[2]))), rtol=2e-3
    )
    np.testing.assert_allclose(straight, (2.2 * ghost.SPEED, 0, 0), atol=2e-3)
    off = [float(recording.drift(believed).final_position) for recording in recordings.values()]
    assert 1.2 < off[0] < 1.5
    assert off[1] < 1e-6
    folder = ROOT / "experiments" / "pictures"
    assert (folder / "strobe.png").stat().st_size < 2e6
    assert (folder / "film.webp").stat().st_size < 2e6
