"""What a film shows: the drive between its samples, ghosts under any form of a belief, and what is refused."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.report.filming._take import Take

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, name="mine")
OTHER = ROBOT.replace(right_radius=0.09, name="other")


def recording(angles, t=None, robot=ROBOT, truth=None):
    angles = np.asarray(angles, dtype=float)
    t = np.arange(len(angles)) * 0.5 if t is None else np.asarray(t)
    truth = dd.odometry.integrate(angles, ROBOT) if truth is None else truth
    commands = dd.Commands(1.0, np.zeros((1, 2)))
    return dd.Recording(t, angles, truth, robot, commands, dd.World(), dd.Physics())


DRIVEN = recording([(0, 0), (1, 2), (4, 3)])


def test_between_samples_poses_and_wheels_go_in_a_straight_line():
    take = Take.of(DRIVEN, OTHER).at(np.array([0.25, 0.75]))
    assert take.wheel_angles.tolist() == [[0.5, 1.0], [2.5, 2.5]]
    np.testing.assert_allclose(take.truth[0], DRIVEN.truth[:2].mean(axis=0))
    believed = DRIVEN.odometry(OTHER)
    np.testing.assert_allclose(take.ghosts["odometry (other)"][1], believed[1:].mean(axis=0))


@pytest.mark.parametrize(
    ("believed", "names"),
    [
        (ROBOT, ["odometry"]),
        (OTHER, ["odometry (other)"]),
        ([ROBOT, OTHER], ["mine", "other"]),
        ([OTHER, OTHER], ["other 1", "other 2"]),
        ({"a": OTHER, "b": np.zeros((3, 3))}, ["a", "b"]),
        ({"two\nlines": OTHER}, ["two\\nlines"]),
    ],
)
def test_the_forms_of_a_belief(believed, names):
    assert list(Take.of(DRIVEN, believed).ghosts) == names


def test_how_far_a_ghost_is():
    poses = DRIVEN.truth + np.array((0.3, -0.4, 9.0))
    np.testing.assert_allclose(Take.of(DRIVEN, {"poses": poses}).apart["poses"], 0.5)


def test_headings_that_are_wrapped_go_the_short_way():
    """As a filter's or a log's from 179 to -179 degrees."""
    poses = np.zeros((3, 3))
    poses[:, 2] = np.radians((179, -179, -177))
    halfway = np.array([0.25])
    ghost = Take.of(DRIVEN, {"filter": poses}).at(halfway).ghosts["filter"]
    np.testing.assert_allclose(ghost[0, 2], np.pi)
    log = dd.Drive(DRIVEN.t, DRIVEN.wheel_angles, poses)
    np.testing.assert_allclose(Take.of(log, ROBOT).at(halfway).truth[0, 2], np.pi)


def test_the_drive_of_a_log_is_seen_at_its_true_poses():
    t = np.linspace(0, 4, 41)
    angles = np.stack([t, 1.1 * t], axis=-1)
    clock = np.array([0.5, 1.25, 2.0, 3.0])
    truth = np.stack([clock, 0 * clock, 0 * clock], axis=-1)
    log = dd.Drive(t, angles, truth, truth_t=clock)
    take = Take.of(log, {"filter": truth + 1.0, "as sold": OTHER, "mine": ROBOT})
    assert take.robot == OTHER  # the first robot
    assert take.t.tolist() == clock.tolist()
    np.testing.assert_allclose(take.wheel_angles, np.stack([clock, 1.1 * clock], axis=-1))
    np.testing.assert_allclose(take.ghosts["mine"], log.odometry(ROBOT))
    assert take.world == dd.World()
    assert list(Take.of(log, OTHER).ghosts) == ["odometry"]


SPARSE = dd.Drive([0, 1, 2, 3], np.zeros((4, 2)), np.zeros((2, 3)), truth_t=[0, 3])


@pytest.mark.parametrize(
    ("angles", "ratio"),
    [
        ([(0, 0), (0.91, 1), (9.1, 10)], 0.91),
        ([(5, 7), (4, 8), (3, 9)], -1.0),
        ([(0, 0), (0, 3), (0, 4)], 0.0),
        ([(0, 0), (1, 1), (1.5, 2)], None),
        ([(0, 0), (1, 0), (2, 0)], None),
        ([(0, 0), (0, 0)], None),
    ],
)
def test_k_is_said_where_it_is_constant(angles, ratio):
    assert Take.of(recording(angles), ROBOT).speed_ratio == (ratio if ratio is None else pytest.approx(ratio))


NAN = DRIVEN.truth.copy()
NAN[1, 0] = np.nan


@pytest.mark.parametrize(
    ("shown", "believed", "builtin", "words"),
    [
        (recording(np.zeros((1, 2))), ROBOT, ValueError, ("1 sample:", "two or more")),
        (recording(np.zeros((0, 2)), truth=np.zeros((0, 3))), ROBOT, ValueError, ("0 samples:",)),
        (recording([(0, 0), (1, 2), (4, 3)], truth=NAN), ROBOT, ValueError, ("recording.truth[1, 0]", "finite")),
        (recording([(0, 0), (1, 2)], robot=(ROBOT, ROBOT)), ROBOT, ValueError, ("2 runs", "recording.runs[0]")),
        ("drive.csv", ROBOT, TypeError, ("recording = 'drive.csv'", "a Recording or a Drive")),
        (DRIVEN, "ct_bot", TypeError, ("believed = 'ct_bot'",)),
        (DRIVEN, {"a": "ct_bot"}, TypeError, ("Robot.load('ct_bot')",)),
        (DRIVEN, {"a": NAN}, ValueError, ("believed['a'][1, 0]", "finite")),
        (DRIVEN, {"a": np.zeros((2, 3))}, ValueError, ("believed['a']", "(..., 3, 3)")),
        (SPARSE, ROBOT, ValueError, ("drive: true poses are 3 s apart", "at least every 1 s")),
        (dd.Drive(DRIVEN.t, DRIVEN.wheel_angles, DRIVEN.truth), {"a": DRIVEN.truth}, ValueError, ("a Robot too",)),
        (dd.Drive(DRIVEN.t, DRIVEN.wheel_angles, DRIVEN.truth), {}, ValueError, ("empty",)),
        (DRIVEN, {}, ValueError, ("empty",)),
        (DRIVEN, [ROBOT] * 6, ValueError, ("6 beliefs", "at most 5")),
        (DRIVEN, {1: ROBOT}, TypeError, ("name of a belief = 1",)),
    ],
)
def test_what_cannot_be_shown(shown, believed, builtin, words):
    with refused(builtin, *words):
        Take.of(shown, believed)
