"""The guaranteed drift against Monte Carlo, corners and refined maxima; against closed forms, codac and invariances."""

from __future__ import annotations

import importlib.util
import itertools
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import refused
from many_robots import drifts, lengths_of, paths
from scipy.optimize import minimize

import diffdrive_mj as dd
from diffdrive_mj import maneuvers
from diffdrive_mj.estimation.set_membership import GuaranteedDrift, guarantee

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
MANEUVERS = ("straight", "arc", "square", "slalom", "spin", "eight")
EXACT = dd.Tolerances(radius=0.0, radius_ratio=0.0, track_width=0.0)


def known(radius=0.0, ratio=0.0, track=0.0):
    return dd.Tolerances(radius=radius, radius_ratio=ratio, track_width=track)


def driven(maneuver, robot, generator, distance, period=0.1):
    """Wheel angles of a maneuver of about some distance."""
    speed = 0.5
    if maneuver == "straight":
        commands = maneuvers.straight(robot, speed=speed, distance=distance, period=period)
    elif maneuver == "arc":
        radius = generator.uniform(0.2, 5.0)
        commands = maneuvers.arc(robot, radius=radius, distance=distance, speed=speed, period=period)
    elif maneuver == "square":
        clockwise = bool(generator.integers(2))
        commands = maneuvers.square(robot, side=distance / 4, speed=speed, clockwise=clockwise, period=period)
    elif maneuver == "slalom":
        commands = maneuvers.slalom(robot, wavelength=distance / 3, speed=speed, period=period)
    elif maneuver == "spin":
        commands = maneuvers.spin(robot, turns=generator.uniform(-10, 10), period=period)
    else:
        commands = maneuvers.figure_eight(robot, radius=distance / 12, speed=speed, period=period)
    return commands.wheel_angles


def drawn(generator):
    """A robot, tolerances and a distance."""
    left, track = generator.uniform(0.02, 0.3), generator.uniform(0.1, 1.0)
    robot = dd.Robot(left_radius=left, right_radius=left * generator.uniform(0.8, 1.25), track_width=track)
    parts = 10 ** generator.uniform(-3, math.log10(0.05), 3)
    return robot, known(*parts), 10 ** generator.uniform(0, math.log10(50))


def largest_found(angles, robot, tolerances, generator, samples, starts=12, anywhere=False):
    """The largest drift by Monte Carlo, at the corners, and by climbing from the best of these."""
    parts = np.array([tolerances.radius, tolerances.radius_ratio, tolerances.track_width])
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    at = np.concatenate([corners, generator.uniform(-1, 1, (samples, 3))])

    def drift(points):
        return drifts(angles, robot, lengths_of(robot, *(points * parts).T), anywhere=anywhere)

    chunk = max(1, 2_000_000 // len(angles))
    found = np.concatenate([drift(at[k : k + chunk]) for k in range(0, len(at), chunk)])
    best = found.max()
    for k in np.argsort(-found)[:starts]:
        climbed = minimize(
            lambda x: -drift(np.clip(x, -1, 1)[None])[0], at[k], bounds=[(-1, 1)] * 3, method="Nelder-Mead",
            options={"maxfev": 150},
        )  # fmt: skip
        best = max(best, -climbed.fun)
    return best


def check(seed, maneuver, samples, anywhere=False):
    generator = np.random.default_rng([seed, MANEUVERS.index(maneuver)])
    robot, tolerances, distance = drawn(generator)
    # A few hundred samples: as many robots are worth more.
    angles = driven(maneuver, robot, generator, distance, period=max(0.02, distance / 100))
    bound = guarantee(angles, robot, tolerances, anywhere=anywhere)
    found = largest_found(angles, robot, tolerances, generator, samples, anywhere=anywhere)
    assert found <= bound.position <= found + max(0.05 * found, 1e-3)
    assert not bound.warnings
    worst = [[bound.worst.left_radius, bound.worst.right_radius, bound.worst.track_width]]
    assert bound.found == pytest.approx(drifts(angles, robot, worst, anywhere=anywhere)[0], abs=1e-8)


@pytest.mark.parametrize("maneuver", MANEUVERS)
@pytest.mark.parametrize("seed", range(5))
def test_no_robot_exceeds_the_bound_and_some_come_close(maneuver, seed):
    check(seed, maneuver, samples=1000)


@pytest.mark.parametrize("maneuver", MANEUVERS)
def test_nor_anywhere_on_the_way(maneuver):
    check(100, maneuver, samples=300, anywhere=True)


@pytest.mark.slow
@pytest.mark.parametrize("maneuver", MANEUVERS)
@pytest.mark.parametrize("seed", range(200, 203))
def test_no_robot_of_a_hundred_thousand_exceeds_the_bound(maneuver, seed):
    check(seed, maneuver, samples=100_000)


@pytest.mark.parametrize("anywhere", [False, True])
@pytest.mark.parametrize("radius", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("part", [0.01, 0.05])
def test_a_robot_that_circles_on_and_on_ends_anywhere_on_its_circle(radius, part, anywhere):
    """Tolerances that leave the heading open by many turns: as far as a circle's other side, hardly farther."""
    robot = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.1)
    commands = maneuvers.arc(robot, radius=radius, distance=100.0, speed=1.0, period=0.2)
    bound = guarantee(commands, robot, known(part, part, part), anywhere=anywhere)
    found = largest_found(
        commands.wheel_angles, robot, known(part, part, part), np.random.default_rng(0), 500, 3, anywhere
    )
    assert found <= bound.position <= 1.05 * found
    assert not bound.warnings


def test_a_wrong_scale_is_that_part_of_the_way():
    bound = guarantee(maneuvers.straight(ROBOT, distance=10.0), ROBOT, known(radius=0.02))
    assert 0.2 <= bound.position < 0.2 * 1.01
    assert bound.heading == pytest.approx(0, abs=1e-6)


def test_a_wrong_ratio_is_the_chord_of_an_arc():
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    bound = guarantee(maneuvers.straight(robot, distance=10.0), robot, known(ratio=0.01))
    # The wheels' ways differ by 2 q of their mean, q = (rho - 1) / (rho + 1): more below a ratio of 1 than above.
    turn = 10.0 * 2 * 0.01 / 1.99 / 0.4
    off = 10.0 * abs(np.sinc(turn / 2 / np.pi) * np.exp(0.5j * turn) - 1)
    assert off <= bound.position < 1.01 * off
    assert turn <= bound.heading < turn * (1 + 1e-6)


def test_a_wrong_heading_turns_the_whole_path():
    bound = guarantee(maneuvers.straight(ROBOT, distance=10.0), ROBOT, EXACT, heading=0.3)
    assert 20 * math.sin(0.15) <= bound.position < 20 * math.sin(0.15) * 1.01
    assert 0.3 <= bound.heading < 0.3 + 1e-6
    assert abs(bound.worst_heading) == pytest.approx(0.3)


def test_a_wrong_track_turns_a_spin_on_the_spot():
    spin = maneuvers.spin(ROBOT, turns=2.0)
    bound = guarantee(spin, ROBOT, known(track=0.01))
    assert bound.position < 2e-4
    assert bound.heading == pytest.approx(4 * math.pi / 0.99 * 0.01, rel=1e-6)


@pytest.mark.parametrize("maneuver", MANEUVERS)
def test_a_robot_known_exactly_does_not_drift(maneuver):
    angles = driven(maneuver, ROBOT, np.random.default_rng(0), 20.0)
    bound = guarantee(angles, ROBOT, EXACT)
    assert bound.position < 1.5e-4
    assert bound.found < 1e-8
    assert bound.heading < 1e-6


def test_a_robot_that_stands_does_not_drift():
    for angles in ([(3.0, 4.0)], [(3.0, 4.0)] * 3):
        bound = guarantee(angles, ROBOT, ticks=100, anywhere=True)
        assert bound.by_tolerances.tolist() == [0, 0]


def test_corners_are_no_bound():
    robot = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.1)
    bound = guarantee(maneuvers.straight(robot, distance=30.0), robot, known(ratio=0.02))
    assert bound.at_corners < 0.95 * bound.found


def test_the_same_bound_for_any_unit_of_length_and_any_zero_of_the_encoders():
    angles = driven("slalom", ROBOT, np.random.default_rng(0), 8.0)
    bound = guarantee(angles, ROBOT)
    twice = dd.Robot(left_radius=0.200, right_radius=0.182, track_width=0.800)
    assert guarantee(angles, twice).position == pytest.approx(2 * bound.position, rel=0.01)
    assert guarantee(angles + np.array([1e3, -7.0]), ROBOT).position == pytest.approx(bound.position, rel=1e-6)


def test_intervals_of_the_lengths():
    angles = driven("square", ROBOT, np.random.default_rng(0), 8.0)
    spans = np.array([(0.099, 0.1), (0.091, 0.0925), (0.395, 0.41)])
    bound = guarantee(angles, ROBOT, left_radius=spans[0], right_radius=spans[1], track_width=spans[2], heading=0.01)
    generator = np.random.default_rng(0)
    lengths, heading = generator.uniform(*spans.T, (20_000, 3)), generator.uniform(-0.01, 0.01, 20_000)
    corners = np.array(list(itertools.product(*spans, (-0.01, 0.01))))
    found = max(
        drifts(angles, ROBOT, lengths, heading).max(), drifts(angles, ROBOT, corners[:, :3], corners[:, 3]).max()
    )
    assert found <= bound.position <= 1.05 * found


def test_tolerances_are_those_of_the_robot_if_none_are_given():
    angles = driven("arc", ROBOT, np.random.default_rng(0), 8.0)
    known_well = ROBOT.replace(tolerances={"radius": 0.001, "radius_ratio": 0.002, "track_width": 0.003})
    assert guarantee(angles, known_well).position == guarantee(angles, ROBOT, known(0.001, 0.002, 0.003)).position


def test_it_agrees_with_codac():
    """Interval arithmetic encloses the same drifts: it is never below what is found, nor tighter than this bound."""
    if importlib.util.find_spec("codac") is None:  # imported here it would change how this process rounds
        pytest.skip("needs codac")
    for maneuver in ("straight", "arc", "square"):
        angles = driven(maneuver, ROBOT, np.random.default_rng(0), 4.0, period=0.5)
        bound = guarantee(angles, ROBOT, known(0.005, 0.002, 0.005))
        upper = by_codac(angles, boxes(ROBOT, (0.005, 0.002, 0.005), 6))
        assert bound.found <= upper
        assert bound.position <= upper * 1.01
        # Where boxes are small its bound is not far off.
        assert upper <= 2 * bound.position


def boxes(robot, parts, pieces):
    """The tolerances in small boxes of mean radius, asymmetry and track, each (3, 2)."""
    ratio = robot.radius_ratio * (1 + np.array([-1, 1]) * parts[1])
    spans = [robot.mean_radius * (1 + np.array([-1, 1]) * parts[0]), (ratio - 1) / (ratio + 1),
             robot.track_width * (1 + np.array([-1, 1]) * parts[2])]  # fmt: skip
    cuts = [np.linspace(*span, pieces + 1) for span in spans]
    return itertools.product(*[np.stack([cut[:-1], cut[1:]], axis=-1) for cut in cuts])


def by_codac(angles, spans):
    """The largest drift over the boxes, in interval arithmetic, as `integrate` computes it."""
    given = {
        "angles": (angles - angles[0]).tolist(),
        "boxes": [np.array(box).tolist() for box in spans],
        "end": dd.odometry.integrate(angles, ROBOT)[-1, :2].tolist(),
    }
    script = Path(__file__).with_name("by_codac.py")
    done = subprocess.run([sys.executable, script], input=json.dumps(given), capture_output=True, text=True, check=True)
    return float(done.stdout)


def test_commands_recordings_and_drives_are_drives():
    commands = maneuvers.straight(ROBOT, distance=0.5, speed=0.5)
    recording = dd.simulate(ROBOT, commands)
    drive = dd.Drive(recording.t, recording.wheel_angles, recording.truth)
    found = [guarantee(each, ROBOT).position for each in (commands, recording, drive, recording.wheel_angles)]
    assert found == pytest.approx([found[0]] * 4, rel=1e-3)
    assert found[1] == found[2] == found[3]
    many = dd.simulate([ROBOT, ROBOT], [commands, commands])
    with refused(ValueError, "recording.runs"):
        guarantee(many, ROBOT)


def test_it_prints_its_parts():
    bound = guarantee(maneuvers.square(ROBOT, side=1.0), ROBOT, ticks=4096, acceleration=2.0)
    assert bound.position == pytest.approx(bound.by_tolerances[0] + bound.by_ticks[0] + bound.by_sampling[0])
    lines = str(bound).splitlines()
    assert lines[0].startswith("robot: no robot within the tolerances ends more than ")
    assert [line.split()[0] for line in lines[4:8]] == ["tolerances", "ticks", "sampling", "sum"]
    assert f"{1e3 * bound.position:.4g}" in lines[7]
    assert "At the corners" in lines[9]
    assert "<table>" in bound._repr_html_()
    assert "is anywhere" in str(guarantee(maneuvers.square(ROBOT, side=1.0), ROBOT, anywhere=True))


def test_a_loose_bound_says_so(monkeypatch):
    monkeypatch.setattr("diffdrive_mj.estimation.set_membership._MOST_BOXES", 6)
    robot = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.1)
    bound = guarantee(maneuvers.straight(robot, distance=50.0), robot, known(0.05, 0.05, 0.05))
    assert "may be loose" in bound.warnings[0]
    assert bound.position >= bound.found
    assert "warning: the bound holds" in str(bound)
    assert "may be loose" in bound._repr_html_()


def test_a_long_drive_ends_after_fewer_boxes(monkeypatch):
    monkeypatch.setattr("diffdrive_mj.estimation.set_membership._MOST_WORK", 2000)
    bound = guarantee(driven("slalom", ROBOT, np.random.default_rng(0), 50.0), ROBOT, known(0.05, 0.05, 0.05))
    assert bound.boxes < 20
    assert f"after {bound.boxes} boxes" in bound.warnings[0]


def test_a_bound_for_a_test():
    drift = dd.guarantee(maneuvers.square(ROBOT, side=0.5), ROBOT, known(0.002, 0.002, 0.005), ticks=4096)
    assert isinstance(drift, GuaranteedDrift)
    assert drift.position < 0.040


def test_one_line_for_each_refusal():
    angles = np.zeros((3, 2))
    with refused(ValueError, "hold robots that cannot be: Robot.left_radius = -0.01"):
        guarantee(angles, ROBOT, left_radius=(-0.01, 0.1), right_radius=(0.09, 0.1))
    with refused(ValueError, "hold robots that cannot be", "track_width"):
        guarantee(angles, ROBOT, track_width=(0.0, 0.1))
    with refused(ValueError, "track_width = (0.5, 0.4)"):
        guarantee(angles, ROBOT, track_width=(0.5, 0.4))
    with refused(ValueError, "give both intervals"):
        guarantee(angles, ROBOT, left_radius=(0.1, 0.11))
    with refused(ValueError, "believed.turning_gain = 0.1"):
        guarantee(angles, ROBOT.replace(turning_gain=0.1))
    with refused(ValueError, "in degrees? then 0.1745"):
        guarantee(angles, ROBOT, heading=10)
    with refused(ValueError, "give period"):
        guarantee(angles, ROBOT, acceleration=1.0)
    with refused(ValueError, "ticks = 0"):
        guarantee(angles, ROBOT, ticks=0)
    with refused(ValueError, "(2, 3, 2)"):
        guarantee(np.zeros((2, 3, 2)), ROBOT)
    with refused(TypeError, "tolerances = 0.01"):
        guarantee(angles, ROBOT, 0.01)
    with refused(TypeError, "Robot.load('matched')"):
        guarantee(angles, "matched")
    with refused(TypeError, "has its own times"):
        guarantee(maneuvers.straight(ROBOT, distance=1.0), ROBOT, period=0.1)


def test_the_other_arithmetic_is_right():
    """What these tests judge by, against the package's odometry."""
    angles = driven("slalom", ROBOT, np.random.default_rng(0), 8.0)
    poses = dd.odometry.integrate(angles, ROBOT, start=(0, 0, 0.3))
    own = paths(angles, ROBOT.left_radius, ROBOT.right_radius, ROBOT.track_width, 0.3)[0]
    np.testing.assert_allclose(own, poses[:, 0] + 1j * poses[:, 1], atol=1e-9)
