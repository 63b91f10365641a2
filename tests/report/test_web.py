"""The page's scripts: their numbers are Python's, and in a real browser the page does what it says."""

import functools
import json
import math
import shutil
import subprocess
from pathlib import Path
from urllib.parse import parse_qs

import matplotlib
import numpy as np
import page_cases as cases
import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj._text import quantity
from diffdrive_mj.report import _inline
from diffdrive_mj.report.replays import from_json

NODE, CHROMIUM = shutil.which("node"), Path("/usr/bin/chromium")
WEB = Path(__file__).parent / "web"
needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed")
MODULES = ROOT / "node_modules"
needs_browser = pytest.mark.skipif(
    NODE is None
    or not CHROMIUM.exists()
    or not all((MODULES / name).is_dir() for name in ("playwright-core", "axe-core")),
    reason="node, /usr/bin/chromium, or playwright-core and axe-core (npm ci) are missing",
)
MINUS = "\N{MINUS SIGN}"
ROBOTS = [dd.Robot.load(name) for name in ("mismatched", "ct_bot")]


def run(script, *arguments, given=""):
    done = subprocess.run(
        [NODE, WEB / script, *map(str, arguments)],
        input=given,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def called(*calls):
    """What functions of the page's modules return: each call a module, a function, and its arguments."""
    return run("calls.mjs", given=json.dumps([[module, name, given] for module, name, *given in calls]))


def sizes(robot):
    return {name: getattr(robot, name) for name in ("left_radius", "right_radius", "track_width")}


@needs_node
def test_odometry_is_pythons():
    rng = np.random.default_rng(5)
    drives = [np.cumsum(rng.normal(size=(200, 2)) * scale, axis=0) for scale in (1e-6, 0.1, 3.0)]
    drives.append(np.outer(np.arange(50.0), [0.91, 1.0]))
    start = [1.0, -2.0, 0.5]
    calls = [("odometry", "integrate", drive.tolist(), sizes(robot), start) for drive in drives for robot in ROBOTS]
    for (_, _, angles, _, _), poses, robot in zip(calls, called(*calls), ROBOTS * len(drives), strict=True):
        np.testing.assert_allclose(poses, dd.odometry.integrate(angles, robot, start=start), atol=1e-12, rtol=1e-12)


def settings(**changes):
    (defaults,) = called(("settings", "defaults"))
    return defaults | changes


@needs_node
@pytest.mark.parametrize("method", ["arc", "midpoint", "euler"])
@pytest.mark.parametrize("hz", [1, 10, 100])
def test_k_by_hand_is_the_odometry_of_its_wheels(method, hz):
    chosen = settings(method=method, hz=hz, k=0.7, rate=12.0, right=96.5, believed_left=103.0, believed_track=390)
    ((drive, words),) = [called(("by_hand", "drive", chosen), ("by_hand", "inWords", chosen))]
    true = dd.Robot(left_radius=0.1, right_radius=0.0965, track_width=0.4)
    believed = dd.Robot(left_radius=0.103, right_radius=0.1, track_width=0.39)
    t = np.arange(0.0, 10.0 + 0.5 / hz, 1 / hz)
    angles = np.outer(t, [0.7 * 12.0, 12.0])
    truth = dd.odometry.integrate(angles, true)
    belief = dd.odometry.integrate(angles, believed, method)
    drift = dd.metrics.drift(truth, belief)
    every = (len(drive["t"]) - 1) // (10 * hz)
    (seen,) = drive["beliefs"]
    np.testing.assert_allclose(drive["t"][::every], t, atol=1e-12)
    for axis, name in enumerate(("x", "y", "theta")):
        np.testing.assert_allclose(drive["truth"][name][::every], truth[:, axis], atol=1e-11)
        np.testing.assert_allclose(seen[name][::every], belief[:, axis], atol=1e-11)
    np.testing.assert_allclose(seen["position_error"][::every], drift.position_error, atol=1e-11)
    np.testing.assert_allclose(seen["heading_error"][::every], drift.heading_error, atol=1e-11)
    radius = abs(dd.kinematics.turning_radius(dd.kinematics.body_twist([0.7 * 12.0, 12.0], true)))
    assert f"a circle of radius {quantity(float(radius), 'm')} about a point on its left" in words[0]
    assert f"{quantity(float(drift.final_position), 'm')} off" in words[1]


@needs_node
def test_k_by_hand_says_when_nothing_is_wrong():
    words = called(
        ("by_hand", "inWords", settings(believed_right=91)),
        ("by_hand", "inWords", settings(k=1.2, right=120, believed_right=120)),
        ("by_hand", "inWords", settings(right=100)),
    )
    assert words[0] == [
        "The robot drives straight: r_r = k r_l. After 10 s it is 15.0 m ahead of its start.",
        "Its odometry is right, to rounding.",
    ]
    assert words[1][0].startswith("The robot drives straight: r_r = k r_l.")
    assert words[2][0].startswith(
        "The robot drives a circle of radius 4.24 m about a point on its left."
    )  # as [Behnke] has it


@needs_node
def test_a_setting_comes_back_from_its_address_and_nonsense_does_not():
    chosen = settings(k=0.83, method="euler", hz=20, believed_left=99.5)
    (fragment,) = called(("settings", "toFragment", chosen))
    assert parse_qs(fragment.split("?")[1])["k"] == ["0.83"]
    back, none, other, beyond, rubbish = called(
        ("settings", "fromFragment", fragment),
        ("settings", "fromFragment", ""),
        ("settings", "fromFragment", "#bend?k=0.7"),
        ("settings", "fromFragment", "#k-by-hand?k=1e9&left=-5&hz=7&track=Infinity"),
        ("settings", "fromFragment", "#k-by-hand?k=<script>&method=rk4&left=&right=NaN&believed_left=0x10"),
    )
    assert back == chosen
    assert none is other is None
    assert beyond == settings(k=1.5, left=20, hz=5)
    assert rubbish == settings(believed_left=20)


@needs_node
def test_numbers_read_as_in_python():
    lengths = [0.0, 1e-13, 4.08e-8, 0.00123456, 0.0123, 0.9994, 0.9996, 1.0, 8.4885, 19.04, 123.4, 999.0, 1234.0, -0.02]
    said = called(*(("quantities", "quantity", value, "m") for value in lengths))
    assert said == [quantity(value, "m") for value in lengths]
    angles = called(
        *(("quantities", "degrees", math.radians(value)) for value in (0.0, 1e-5, -0.05, 9.99, 9.996, -147.34))
    )
    assert angles == ["0°", "below 0.01°", f"{MINUS}0.05°", "9.99°", "10.0°", f"{MINUS}147.3°"]


@needs_node
def test_errors_have_the_colours_of_plasma():
    """The part of it that can be seen on each paper."""
    shares = [-1.0, 0.0, 0.3, 0.5, 1.0, 7.0]
    for dark, low, high in ((False, 0.0, 0.74), (True, 0.36, 1.0)):
        for share, said in zip(shares, called(*(("colours", "errorColour", s, dark) for s in shares)), strict=True):
            wanted = matplotlib.colormaps["plasma"](low + (high - low) * min(max(share, 0.0), 1.0))
            given = [int(part) for part in said.removeprefix("rgb(").removesuffix(")").split()]
            np.testing.assert_allclose(
                given, 255 * np.array(wanted[:3]), atol=14
            )  # linear between eight of its colours


@needs_node
def test_the_page_interpolates_as_numpy_does():
    times, values = [0.0, 0.1, 0.5, 2.0], [1.0, -1.0, 3.0, 3.5]
    belief = {"position_error": values, "heading_error": values}
    asked = (0.0, 0.05, 0.1, 0.3, 1.9, 2.0, 9.0, -1.0)
    places = called(*(("replay", "locate", times, t) for t in asked))
    off = called(*(("replay", "errorAt", belief, at) for at in places))
    assert [each["position"] for each in off] == pytest.approx(np.interp(asked, times, values))
    # A heading error that passes half a turn does not pass zero.
    across = {"position_error": [0.0, 1.0], "heading_error": [3.1, -3.1]}
    found = called(*(("replay", "errorAt", across, [0, part]) for part in (0.0, 0.25, 0.75, 1.0)))
    gap = 2 * math.pi - 6.2
    wanted = [3.1, 3.1 + gap / 4, -3.1 - gap / 4, -3.1]
    assert [each["heading"] for each in found] == pytest.approx(wanted)


@needs_node
def test_outlines_are_those_of_pictures():
    """Corners at a pose, as matplotlib draws them."""
    pose, robot = (1.0, 2.0, 0.7), ROBOTS[0]
    given = sizes(robot) | {
        "tyre_width": robot.tyres.width,
        "caster_x": robot.caster.x,
        "caster_radius": robot.caster.radius,
    }
    ((body, wheels),) = [called(("outline", "outline", given))[0].values()]
    _, ax = dd.plots.figure("A finding")
    report.marks.robot_from_above(ax, robot, pose)
    drawn = [patch.get_xy()[:-1] for patch in ax.patches]
    for corners in (body, *wheels):
        (placed,) = called(("outline", "placed", corners, pose))
        found = {tuple(np.round(corner, 9)) for corner in placed}
        assert any(found == {tuple(np.round(corner, 9)) for corner in polygon} for polygon in drawn)
    scales = called(("outline", "enlarged", given, 1000.0), ("outline", "enlarged", given, 7.5))
    assert scales == [1.0, 10.0]  # 400 and 3 pixels wide


@needs_node
def test_grid_lines_are_round_numbers_apart():
    steps = called(*(("camera", "gridStep", scale) for scale in (70.0, 69.0, 100.0, 1.0, 7000.0)))
    assert steps == pytest.approx([1.0, 2.0, 1.0, 100.0, 0.01])


@needs_node
@pytest.mark.parametrize("name", ["camera", "scene"])
def test_the_camera_and_the_scene(name):
    done = subprocess.run([NODE, "--test", WEB / f"{name}.test.mjs"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_every_module_is_part_of_the_page():
    inline = {*_inline._MODULES}
    imported = {
        line.split("'#web/")[1].split(".mjs")[0]
        for name in inline
        for line in (_inline.WEB / f"{name}.mjs").read_text().splitlines()
        if line.startswith("import ")
    }
    assert imported | {"page"} == inline


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    faulty = cases.hostile(cases.faulty(folder / "faulty"))
    return [report.page(place) for place in (cases.good(folder / "good"), faulty)]


@pytest.fixture(scope="module")
def replays(pages):
    return from_json((pages[0].parent / "bend" / "replays.json").read_text())


def readout(replay, name, t):
    """What the page must say of a time."""
    off = replay.errors(name)
    position, heading = (np.interp(t, replay.t, error) for error in (off.position_error, off.heading_error))
    degrees = abs(math.degrees(heading))
    angle = "0°" if degrees == 0 else f"{MINUS if heading < 0 else ''}{degrees:.{1 if degrees >= 9.995 else 2}f}°"
    return {"clock": f"{t:.2f} s", "position": quantity(float(position), "m"), "heading": angle}


@needs_browser
def test_the_page_in_a_browser(pages, replays):
    """At two widths and in two themes: one start of the browser for all of it."""
    seen = run("browser.mjs", *(page.as_uri() for page in pages))
    faulty = seen.pop("faulty")
    assert faulty["cards"] == 27
    for name, found in {**seen, "faulty": faulty}.items():
        for kind, allowed in (("complaints", []), ("axe", []), ("overflow", 0), ("hacked", None)):
            assert found[kind] == allowed, (name, kind)
        assert [address.partition("#")[0] for address in found["requests"]] == [pages[name == "faulty"].as_uri()]
    assert min(found["usable"] for found in seen.values()) < 1000
    assert len({found["background"] for found in seen.values()}) == 2
    bend, back = replays
    for name in ("1280 light", "390 dark"):
        check_use(seen[name], bend, back)
    # On a narrow page a bound's name has the whole row.
    assert seen["1280 light"]["names"] < 0.7
    assert seen["390 dark"]["names"] > 0.9
    pinch = seen["390 dark"]["touch"]
    assert (pinch["pinched"], pinch["back"]) == (True, True)
    assert pinch["scrolled"] == {"pageMoved": True, "same": True}
    assert pinch["tapped"] == readout(bend, "equal wheels", 4.0)


def check_use(found, bend, back):
    """Keys, mouse and choices on one page."""
    steps = {"end": 500, "start": 0, "step5": 5, "step250": 250}
    read = found["readouts"]
    assert {name: read[name] for name in steps} == {
        name: readout(bend, "equal wheels", 4.0 * step / 500) for name, step in steps.items()
    }
    # The plot has margins of 8 pixels: a quarter of it is a little less of the time.
    assert 0.9 < float(read["clicked"]["clock"].removesuffix(" s")) < 1.0
    assert found["spoken"] == f"{read['clicked']['clock']}, {read['clicked']['position']} off"
    assert found["pictures"] == 3
    assert [step for step, done in found["zooms"].items() if not done] == []
    assert len(found["zooms"]) == 17
    assert (found["plays"]["label"], found["plays"]["after"]) == ("Pause", "Play")
    assert 0.1 < float(found["plays"]["clock"].removesuffix(" s")) < 3.9
    assert found["chosen"] == {
        "belief": readout(bend, "nearly right", 4.0),
        "drive": readout(back, "equal wheels", 4.0),
    }
    for words in ("the robot", "where it is believed to be", "believed path, error 0", "other beliefs"):
        assert words in found["key"]
    assert found["unreached"] == []
    assert found["paper"] == {
        "input": 0, "button": 0, "canvas": 0, "h3": 2, ".bounds": 2, ".picture": 1, "ink": "rgb(28, 29, 31)",
        "closed": 0, "closedAfter": 1,
    }  # fmt: skip
    check_by_hand(found["hand"])


SLIDERS = [
    "k", "rate", "hz", "left", "right", "track", "believed_left", "believed_right", "believed_track",
]  # fmt: skip


@functools.cache
def by_hand(k, method):
    """Where two wheels of 0.1 m, one of them taken for 0.091 m, end, and how far off that is."""
    true = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
    angles = np.outer(np.arange(101) / 10, [k * 16.5, 16.5])
    belief = dd.odometry.integrate(angles, true.replace(right_radius=0.1), method)
    truth = dd.odometry.integrate(angles, true)
    return truth[-1], quantity(float(dd.metrics.drift(truth, belief).final_position), "m")


def check_by_hand(hand):
    """The words, the address and what it brings back."""
    _, off = by_hand(0.91, "arc")
    assert hand["first"]["off"]["position"] == off
    assert f"Its odometry is {off} off" in hand["first"]["words"]
    (x, y, _), off = by_hand(0.94, "euler")
    assert hand["second"]["off"]["position"] == off
    assert f"{quantity(x, 'm')} ahead of and {quantity(-y, 'm')} to the right" in hand["second"]["words"]
    assert hand["second"]["hash"].startswith("#k-by-hand?k=0.94&")
    assert hand["seen"] == SLIDERS
    assert "other beliefs" not in hand["key"]
    assert hand["typed"] == "1.25"  # into the address of an open page
    shared = hand["shared"]
    assert (shared["words"], shared["k"]) == (hand["second"]["words"], "0.94")
    assert shared["complaints"] == []
    assert "Its odometry is right, to rounding." in hand["compensated"]
