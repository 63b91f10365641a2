"""The page in headless Chromium: what it shows agrees with Python, and anybody can use it."""

import dataclasses
import json
import threading
import warnings
from urllib.parse import parse_qsl

import numpy as np
import pytest
from helpers import ROOT
from needs import chromium, node, run_node

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.play.drives import plan
from diffdrive_mj.play.server import PlayServer, robots_by_name
from diffdrive_mj.play.setting import Setting

ROBOTS = robots_by_name(dd.Robot.load("matched"))


@pytest.fixture(scope="module")
def seen():
    """One browser for all of it."""
    browser = chromium()
    node()
    with PlayServer(ROBOTS, ROOT / "node_modules") as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield json.loads(run_node("browser.mjs", server.address, browser, timeout=300))
        finally:
            server.shutdown()
            thread.join()


def simulated(shown):
    """Python's drive of the setting in an address, and its belief."""
    planned = plan(Setting.parsed(dict(parse_qsl(shown["hash"]))), ROBOTS)
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        recording = dd.simulate(
            planned.true, planned.commands, world=planned.world, physics=planned.physics,
            sample_rate=planned.setting.rate,
        )  # fmt: skip
    return recording, recording.odometry(planned.believed)


def test_both_widths_and_both_themes_are_without_fault(seen):
    assert len(seen["looks"]) == 4
    for look in seen["looks"]:
        assert look["said"] == [], look
        assert look["violations"] == [], look
        assert look["wide"] <= 0, look


def test_what_is_written_while_it_runs_has_a_layer_of_its_own(seen):
    # Without, a machine that draws without a GPU had 9 frames/s and not 24.
    assert seen["repainted"] == []


def test_it_runs_at_the_pace_that_was_chosen(seen):
    assert 1.5 < seen["pace"] < 8  # five, but for the frame that a busy machine is late with


def test_the_final_pose_after_moving_k_is_that_of_python(seen):
    recording, belief = simulated(seen["slid"])
    assert "k=0.88" in seen["slid"]["hash"]
    assert np.abs(np.subtract(seen["slid"]["pose"], recording.truth[-1])).max() < 1e-6
    assert np.abs(np.subtract(seen["slid"]["belief"], belief[-1])).max() < 1e-6
    assert seen["slid"]["clock"] == f"{recording.t[-1]:.1f} s"


def test_robot_and_ghost_are_drawn_at_their_poses(seen):
    slid = seen["slid"]
    assert np.abs(np.subtract(slid["drawn"], [slid["pose"][:2], slid["belief"][:2]])).max() < 1e-6


def test_another_robot_drives_the_same_maneuver(seen):
    assert seen["other"] == dataclasses.asdict(dataclasses.replace(Setting.of(ROBOTS["ct_bot"]), maneuver="square"))


def test_the_words_have_the_numbers(seen):
    recording, belief = simulated(seen["slid"])
    off = dd.metrics.drift(recording.truth, belief)
    assert f"{off.distance:.2f} m" in seen["slid"]["words"]
    assert f"{off.final_position:.2f} m" in seen["slid"]["words"]
    side = "left" if off.final_heading > 0 else "right"
    assert f"{np.degrees(abs(off.final_heading)):.1f}° further to the {side}" in seen["slid"]["words"]
    assert "It takes its right radius to be 9.0 % smaller than it is." in seen["slid"]["why"]


def test_an_address_shows_the_same_setting_elsewhere(seen):
    shared = dict(seen["shared"])
    assert shared.pop("said") == []
    assert shared == seen["slid"]


def test_with_the_wheels_fitted_it_drives_straight_and_knows_it(seen):
    x, y, theta = seen["compensated"]["pose"]
    assert abs(y) < 1e-4
    assert abs(theta) < 1e-4
    assert x > 10
    assert "the ghost is where the robot is" in seen["compensated"]["words"]
    assert "odometry works" in seen["compensated"]["why"]


def test_a_slippery_floor_is_named(seen):
    assert "Both wheels slip" in seen["slippery"]["why"]
    recording, _ = simulated(seen["slippery"])
    assert np.abs(np.subtract(seen["slippery"]["pose"], recording.truth[-1])).max() < 1e-6


def test_bad_settings_show_a_line(seen):
    assert seen["refused"] == "left_radius = -0.003 m: must lie between 0.005 and 0.5 m"
    assert seen["banana"] == {"alert": "k = 'banana': must be a number", "robot": "spin"}


def test_what_the_page_cannot_do_is_said(seen):
    assert seen["ended"] == "the server has ended: start diffdrive play again"
    assert seen["flat"].startswith("this browser cannot show the page: ")
    assert "WebGL" in seen["flat"]


def test_every_control_is_reached_with_the_keyboard(seen):
    assert len(seen["controls"]) > 25
    assert seen["reached"] == seen["controls"]
