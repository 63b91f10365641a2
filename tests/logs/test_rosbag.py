"""ROS 2 bags: real ones, written by rosbags, are read message by message, and what is written is read by others."""

from contextlib import contextmanager

import bags
import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj.logs import Topics, _bag, rosbag

TIMES = 1_700_000_000 + 0.1 * np.arange(8)
LEFT, RIGHT = 0.3 * np.arange(8), 0.4 * np.arange(8) ** 1.1
X, Y, YAW = 0.1 * np.arange(8), 0.02 * np.arange(8) ** 2, 3.0 + 0.1 * np.arange(8)  # past pi
JOINTS = [bags.joints(t, a, b) for t, a, b in zip(TIMES, LEFT, RIGHT, strict=True)]
POSES = np.stack([X, Y, YAW], axis=-1)
KINDS = {"stamped": bags.stamped, "with covariance": bags.with_covariance, "odometry": bags.odometry}


def posed(kind=bags.stamped, times=TIMES, **more):
    return [kind(t, x, y, yaw, **more) for t, x, y, yaw in zip(times, X, Y, YAW, strict=True)]


# Reading


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("name", "storage"), [("a.mcap", "mcap"), ("a.db3", "sqlite3"), ("a", "mcap"), ("b", "sqlite3")]
)
def test_wheels_and_poses_of_every_kind_and_storage(tmp_path, kind, name, storage):
    path = bags.write(tmp_path / name, {"/joint_states": JOINTS, "/truth": posed(KINDS[kind])}, storage)
    drive = logs.read(path)
    np.testing.assert_allclose(drive.t, TIMES, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(drive.wheel_angles, np.stack([LEFT, RIGHT], axis=-1))
    np.testing.assert_allclose(drive.truth, POSES, atol=1e-15)  # continuous past pi
    np.testing.assert_array_equal(drive.clock, drive.t)
    assert drive.warnings == ()
    assert drive.name == str(path)
    estimate = logs.read_poses(path)
    np.testing.assert_array_equal(estimate.poses, drive.truth)


def test_times_have_all_their_nanoseconds(tmp_path):
    """A float of a second holds an epoch to 0.24 us; near zero nothing is lost."""
    times = np.array([0.0, 0.123456789, 1.000000001])
    log = logs.read_poses(bags.write(tmp_path / "a.mcap", {"/p": [bags.stamped(t, t) for t in times]}))
    np.testing.assert_array_equal(log.t, times)


@pytest.mark.parametrize(
    ("names", "options"),
    [
        (("wheel_left", "wheel_right"), {}),
        (("Right_Wheel", "arm", "LEFT_WHEEL"), {}),
        (("left_arm", "left_wheel", "right_arm", "right_wheel"), {}),
        (("fl", "fr", "rl"), {"left": "fl", "right": "fr"}),
        (("front_left", "rear_left", "right"), {"left": "rear_left"}),
    ],
)
def test_joints_are_found_by_their_names(tmp_path, names, options):
    side = {"left": LEFT, "right": RIGHT, "fl": LEFT, "fr": RIGHT}
    wanted = [options.get(s) or next(n for n in names if s in n.lower() and ("wheel" in n.lower() or n == s))
              for s in ("left", "right")]  # fmt: skip
    of = dict(zip(wanted, (side["left"], side["right"]), strict=True))
    messages = [
        bags.joints(t, 0, 0, names, [of[name][k] if name in of else 99.0 for name in names])
        for k, t in enumerate(TIMES)
    ]
    drive = logs.read(bags.write(tmp_path / "a.mcap", {"/j": messages, "/p": posed()}), Topics(**options))
    np.testing.assert_array_equal(drive.wheel_angles, np.stack([LEFT, RIGHT], axis=-1))


def test_joints_in_another_order_and_of_others_in_between(tmp_path):
    messages = list(JOINTS)
    messages[3] = bags.joints(TIMES[3], 0, 0, ("right_wheel_joint", "left_wheel_joint"), [RIGHT[3], LEFT[3]])
    messages.insert(4, bags.joints(TIMES[3] + 0.01, 0, 0, ("gripper",), [7.0]))
    drive = logs.read(bags.write(tmp_path / "a.mcap", {"/j": messages, "/p": posed()}))
    np.testing.assert_array_equal(drive.wheel_angles, np.stack([LEFT, RIGHT], axis=-1))


def test_reversed_wheels(tmp_path):
    path = bags.write(tmp_path / "a.mcap", {"/j": JOINTS, "/p": posed()})
    np.testing.assert_array_equal(logs.read(path, Topics(reverse_right=True)).wheel_angles[:, 1], -RIGHT)
    np.testing.assert_array_equal(logs.read(path, Topics(reverse_left=True)).wheel_angles[:, 0], -LEFT)


def test_several_topics_are_chosen_by_name(tmp_path):
    path = bags.write(
        tmp_path / "a.mcap",
        {"/j": JOINTS, "/j2": JOINTS[:4], "/p": posed(), "/odom": posed(bags.odometry), "/none": JOINTS[0][0]},
    )
    with refused(ValueError, "/j, /j2 may have the wheels: name one, as in Topics(wheels='/j')"):
        logs.read(path)
    with refused(ValueError, "/p, /odom may have the poses: name one, as in Topics(poses='/p')"):
        logs.read_poses(path)
    drive = logs.read(path, Topics(wheels="/j2", poses="/odom"))
    assert (len(drive.t), len(drive.truth), drive.dropped) == (4, 4, 4)


def test_stamps_of_the_header_or_of_the_bag(tmp_path):
    late = [(kind, t + 0.05, message) for kind, t, message in posed()]
    path = bags.write(tmp_path / "a.mcap", {"/p": late})
    np.testing.assert_allclose(logs.read_poses(path).t, TIMES, rtol=0, atol=1e-6)
    np.testing.assert_allclose(logs.read_poses(path, Topics(stamps="bag")).t, TIMES + 0.05, rtol=0, atol=1e-6)


def test_headers_without_stamps_leave_those_of_the_bag(tmp_path):
    without = [(kind, t, bags.stamped(0.0, x)[2]) for (kind, t, _), x in zip(posed(), X, strict=True)]
    log = logs.read_poses(bags.write(tmp_path / "a.mcap", {"/p": without}))
    np.testing.assert_allclose(log.t, TIMES, rtol=0, atol=1e-6)
    assert any("the headers' stamps are all zero, those of the bag were taken" in line for line in log.warnings)


def test_a_first_stamp_of_zero_is_a_time(tmp_path):
    """A clock that begins at zero, and one that was set after the first message: the latter leaves a gap."""
    log = logs.read_poses(bags.write(tmp_path / "a.mcap", {"/p": posed(times=0.1 * np.arange(8))}))
    assert (log.t[0], log.warnings) == (0.0, ())
    unset = [bags.stamped(0.0), *posed()[1:]]
    log = logs.read_poses(bags.write(tmp_path / "b.mcap", {"/p": unset}))
    assert log.t[0] == 0
    assert "1 gap, the longest of 1.7e+09 s at 0 s" in log.warnings[0]


@pytest.mark.parametrize(
    ("topic", "messages", "named", "what"),
    [
        ("/diff_drive/Odom", posed(bags.odometry), Topics(poses="/diff_drive/Odom"), "/diff_drive/Odom"),
        ("/tf", [bags.transforms(t, ("odom", "base_link", t - TIMES[0])) for t in TIMES],
         Topics(child_frame="base_link"), "odom -> base_link"),
    ],
)  # fmt: skip
def test_an_odometry_that_nobody_named_is_a_doubtful_truth(tmp_path, topic, messages, named, what):
    path = bags.write(tmp_path / "a.mcap", {"/j": JOINTS, topic: messages})
    assert logs.read(path).warnings == (f"{what} was taken for the truth, and by its name is an odometry",)
    assert logs.read(path, named).warnings == ()
    assert logs.read_poses(path).warnings == ()


# Transforms


def moving(parent, child, poses, times=TIMES):
    return [bags.transforms(t, (parent, child, *pose)) for t, pose in zip(times, poses, strict=True)]


def test_the_only_transform_is_taken(tmp_path):
    path = bags.write(tmp_path / "a.mcap", {"/tf": moving("odom", "base_link", POSES)})
    np.testing.assert_allclose(logs.read_poses(path).poses, POSES, atol=1e-15)


def test_a_chain_of_transforms_is_composed(tmp_path):
    """A map that corrects at a lower rate, odometry, and a mount that does not move."""
    fix = np.stack([np.linspace(0, 0.7, 2), np.zeros(2), np.linspace(0.0, 0.35, 2)], axis=-1)
    mount = (0.1, -0.05, np.pi / 2)
    both = moving("odom", "base", POSES) + moving("map", "odom", fix, TIMES[[0, -1]])
    path = bags.write(
        tmp_path / "a.mcap",
        {
            "/tf": sorted(both, key=lambda each: each[1]),
            "/tf_static": [bags.transforms(TIMES[0], ("base", "laser", 9, 9, 9)),
                           bags.transforms(TIMES[1], ("base", "laser", *mount))],
        },
    )  # fmt: skip
    log = logs.read_poses(path, Topics(frame="map", child_frame="laser"))
    # Constant twist between the two corrections: the arc through both.
    arc = dd.se2.log(dd.se2.between(fix[0], fix[1]))
    between = [dd.se2.exp(part * arc) for part in np.linspace(0, 1, 8)]
    expected = [dd.se2.compose(dd.se2.compose(c, p), mount) for c, p in zip(between, POSES, strict=True)]
    np.testing.assert_allclose(log.poses, expected, atol=1e-6)
    with refused(ValueError, "several of the transforms odom -> base, map -> odom may be meant", "name two frames"):
        logs.read_poses(path)
    np.testing.assert_allclose(logs.read_poses(path, Topics(child_frame="base")).poses, POSES, atol=1e-15)


@pytest.mark.parametrize(("sent", "known"), [([0], slice(None)), ([2, 5], slice(2, 6)), ([1, 3, 7], slice(1, 8))])
def test_a_chain_is_known_where_all_of_it_is(tmp_path, sent, known):
    """What was sent once holds; between two that were sent the first holds here, as they are the same."""
    fix = (1.0, 2.0, 0.5)
    both = moving("odom", "base", POSES) + moving("map", "odom", [fix] * len(sent), TIMES[sent])
    path = bags.write(tmp_path / "a.mcap", {"/tf": sorted(both, key=lambda each: each[1])})
    log = logs.read_poses(path, Topics(frame="map", child_frame="base"))
    np.testing.assert_allclose(log.t, TIMES[known], rtol=0, atol=1e-6)
    np.testing.assert_allclose(log.poses, dd.se2.compose(fix, POSES[known]), atol=1e-12)


def test_static_transforms_come_with_the_topic_and_others_do_not():
    there = {"/tf": _bag.TRANSFORMS, "/old": _bag.TRANSFORMS, "/a/tf_static": _bag.TRANSFORMS, "/tf_static": "other"}
    assert rosbag._with_static("/tf", there) == ["/tf", "/a/tf_static"]
    assert rosbag._with_static("/a/tf_static", there) == ["/a/tf_static"]


def test_progress_counts_every_message(tmp_path, monkeypatch):
    told = []

    @contextmanager
    def progress(what, total, unit):
        told.append((what, total, unit))
        yield told.append

    monkeypatch.setattr(_bag, "progress", progress)
    monkeypatch.setattr(_bag, "_STEP", 5)
    logs.read(bags.write(tmp_path / "a.mcap", {"/j": JOINTS, "/p": posed()}))
    assert told == [("reading a.mcap", 16, "messages"), 5, 5, 5]


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        (("map", "base"), "no transforms from 'map' to 'base': there are odom -> base, a -> b, b -> a"),
        (("base", "odom"), "no transforms from 'base' to 'odom'"),
        (("odom", "a"), "no transforms from 'odom' to 'a'"),
        (("odom", None), None),
        (("nowhere", None), "none of the transforms"),
    ],
)
def test_frames_that_no_chain_joins(tmp_path, frames, words):
    both = sorted(
        moving("odom", "base", POSES) + moving("a", "b", POSES) + moving("b", "a", POSES), key=lambda each: each[1]
    )
    path = bags.write(tmp_path / "a.mcap", {"/tf": both})
    options = Topics(**{k: v for k, v in zip(("frame", "child_frame"), frames, strict=True) if v})
    if words is None:
        assert len(logs.read_poses(path, options).t) == 8
    else:
        with refused(ValueError, words):
            logs.read_poses(path, options)


def test_transforms_that_do_not_move(tmp_path):
    path = bags.write(
        tmp_path / "a.mcap",
        {"/tf": moving("odom", "base", POSES), "/tf_static": [bags.transforms(0.0, ("base", "laser", 0, 0, 0))]},
    )
    with refused(ValueError, "nothing between these frames moves"):
        logs.read_poses(path, Topics(frame="base", child_frame="laser"))


# Writing


ROBOT = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3)


def driven():
    t = np.arange(200) / 50
    angles = np.stack([3 * t, 3.3 * t + 0.1 * np.sin(t)], axis=-1)
    truth = dd.odometry.integrate(angles, ROBOT, start=(1.0, 2.0, 3.0))[::4]
    return dd.Drive(t, angles, truth, t[::4], "lab")


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a"])
def test_what_is_written_is_read(tmp_path, name):
    drive = driven()
    logs.write(tmp_path / name, drive)
    again = logs.read(tmp_path / name)
    np.testing.assert_array_equal(again.t, drive.t)
    np.testing.assert_array_equal(again.wheel_angles, drive.wheel_angles)
    np.testing.assert_array_equal(again.clock, drive.clock)
    np.testing.assert_allclose(again.truth, drive.truth, atol=1e-14)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_what_is_written_is_read_by_rosbags(tmp_path):
    names = Topics(wheels="/w", left="l", right="r", poses="/mocap", frame="world")
    drive = driven()
    logs.write(tmp_path / "a.mcap", drive, names)
    with bags.rosbags.Reader(tmp_path / "a.mcap") as reader:
        kinds = {connection.topic: connection.msgtype for connection in reader.connections}
        assert kinds == {"/w": "sensor_msgs/msg/JointState", "/mocap": "geometry_msgs/msg/PoseStamped"}
        found = [(c.topic, stamp, bags.STORE.deserialize_cdr(raw, c.msgtype)) for c, stamp, raw in reader.messages()]
    assert [stamp for _, stamp, _ in found] == sorted(stamp for _, stamp, _ in found)
    assert all(stamp == m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, stamp, m in found)
    wheels = [m for topic, _, m in found if topic == "/w"]
    assert {tuple(m.name) for m in wheels} == {("l", "r")}
    np.testing.assert_array_equal([m.position for m in wheels], drive.wheel_angles)
    assert {(len(m.velocity), len(m.effort)) for m in wheels} == {(0, 0)}
    poses = [m for topic, _, m in found if topic == "/mocap"]
    assert {m.header.frame_id for m in poses} == {"world"}
    np.testing.assert_array_equal([(m.pose.position.x, m.pose.position.y) for m in poses], drive.truth[:, :2])
    yaw = [2 * np.arctan2(m.pose.orientation.z, m.pose.orientation.w) for m in poses]
    np.testing.assert_allclose(np.exp(1j * np.array(yaw)), np.exp(1j * drive.truth[:, 2]), atol=1e-14)


def test_poses_alone_are_written_to_one_topic(tmp_path):
    log = dd.PoseLog([0.0, 1.0], [(0, 0, 0), (1, 2, 3)])
    logs.write(tmp_path / "a.mcap", log)
    with bags.rosbags.Reader(tmp_path / "a.mcap") as reader:
        assert [connection.topic for connection in reader.connections] == ["/pose"]
    with refused(ValueError, "no topic has sensor_msgs/JointState: there is /pose (geometry_msgs/PoseStamped)"):
        logs.read(tmp_path / "a.mcap")


def test_a_folder_is_not_overwritten_and_a_file_is(tmp_path):
    logs.write(tmp_path / "a", driven())
    with refused(ValueError, "is there already, and no folder is overwritten"):
        logs.write(tmp_path / "a", driven())
    for _ in range(2):
        logs.write(tmp_path / "a.mcap", driven())


@pytest.mark.parametrize(
    ("t", "words"),
    [
        ([-1.0, 0.0], "from -1 to 0 s: a bag's stamps are from 0 to 2^31 s"),
        ([0.0, 2.0**31], "from 0 to 2147483648 s"),
        ([1.0, 1.0000000001, 2.0], "are one stamp in whole nanoseconds"),
    ],
)
def test_times_that_no_stamp_holds(tmp_path, t, words):
    with refused(ValueError, words):
        logs.write(tmp_path / "a.mcap", dd.PoseLog(t, np.zeros((len(t), 3))))
    assert list(tmp_path.iterdir()) == []


def test_two_things_on_one_topic(tmp_path):
    with refused(ValueError, "Topics.wheels and Topics.poses are both '/a'"):
        logs.write(tmp_path / "a.mcap", driven(), Topics(wheels="/a", poses="/a"))


def test_without_rosbags_one_line_has_the_command(tmp_path, monkeypatch):
    path = bags.write(tmp_path / "a.mcap", {"/p": posed()})
    monkeypatch.setitem(__import__("sys").modules, "rosbags.rosbag2", None)
    with refused(ImportError, f"{path}: a ROS 2 bag needs rosbags: pip install 'diffdrive_mj[ros]'"):
        logs.read_poses(path)
    with refused(ImportError, "pip install 'diffdrive_mj[ros]'"):
        logs.write(tmp_path / "new.mcap", driven())
    assert not (tmp_path / "new.mcap").exists()


# Covariances


def covariances(count=8, seed=0):
    parts = np.random.default_rng(seed).normal(size=(count, 3, 3))
    return parts @ np.swapaxes(parts, 1, 2)


@pytest.mark.parametrize("name", ["new.mcap", "new.db3", "new"])
def test_covariances_come_back_bit_for_bit(tmp_path, name):
    log = dd.PoseLog(np.arange(8.0), POSES, covariance=covariances())
    logs.write(tmp_path / name, log)
    back = logs.read_poses(tmp_path / name)
    np.testing.assert_array_equal(back.covariance, log.covariance)
    np.testing.assert_allclose(back.poses, POSES, atol=1e-15)
    assert back.warnings == ()


def test_an_odometry_message_is_laid_out_as_ros_has_it(tmp_path):
    """Rows of x, y, z, roll, pitch, yaw; the twist is that of the body between two poses."""
    stated = covariances()
    poses = np.stack([X, 0 * X, np.where(np.arange(8) < 4, 3.1, 3.2 - 2 * np.pi)], axis=-1)  # a heading that wraps
    logs.write(tmp_path / "new.mcap", dd.PoseLog(np.arange(8.0), poses, covariance=stated))
    with bags.rosbags.Reader(tmp_path / "new.mcap") as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == {"/odom": "nav_msgs/msg/Odometry"}
        messages = [bags.STORE.deserialize_cdr(raw, c.msgtype) for c, _, raw in reader.messages()]
    for k, message in enumerate(messages):
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
        whole = np.array(message.pose.covariance)
        for row, i in enumerate((0, 1, 5)):
            for column, j in enumerate((0, 1, 5)):
                assert whole[6 * i + j] == stated[k, row, column]
        rest = np.delete(whole.reshape(6, 6), [0, 1, 5], axis=1)
        np.testing.assert_array_equal(rest, np.vstack([np.zeros((2, 3)), 1e-6 * np.eye(3), np.zeros((1, 3))]))
    twist = messages[2].twist.twist
    assert twist.linear.x == pytest.approx(0.1 * np.cos(3.1))
    assert twist.linear.y == pytest.approx(-0.1 * np.sin(3.1))
    assert messages[4].twist.twist.angular.z == pytest.approx(0.1)


def test_topics_name_the_odometry(tmp_path):
    options = Topics(poses="/wheels/odom", frame="map", child_frame="base")
    logs.write(tmp_path / "new.mcap", dd.PoseLog(np.arange(8.0), POSES, covariance=covariances()), options)
    with bags.rosbags.Reader(tmp_path / "new.mcap") as reader:
        connection, _, raw = next(iter(reader.messages()))
        message = bags.STORE.deserialize_cdr(raw, connection.msgtype)
    assert (connection.topic, message.header.frame_id, message.child_frame_id) == ("/wheels/odom", "map", "base")


@pytest.mark.parametrize(
    ("at", "value", "words"),
    [(0, -1.0, "variance 0 is -1"), (1, 0.5, "must be symmetric"), (0, np.nan, "must be finite"), (14, 1e308, None)],
)
def test_a_covariance_that_is_none_is_left_out_and_reported(tmp_path, at, value, words):
    """Drivers fill it with what they like: the poses are read all the same. Variances of z are not read at all."""
    messages = posed(bags.odometry)
    for _, _, message in messages:
        message.pose.covariance[::7] = 1.0
    messages[3][2].pose.covariance[at] = value
    log = logs.read_poses(bags.write(tmp_path / "a.mcap", {"/odom": messages}))
    np.testing.assert_allclose(log.poses, POSES, atol=1e-15)
    if words is None:
        np.testing.assert_array_equal(log.covariance, np.broadcast_to(np.eye(3), (8, 3, 3)))
    else:
        assert log.covariance is None
        assert [w for w in log.warnings if "/odom: its covariance was left out (covariance[3" in w and words in w]


def test_covariances_of_zero_are_what_nobody_has_stated(tmp_path):
    assert logs.read_poses(bags.write(tmp_path / "a.mcap", {"/odom": posed(bags.odometry)})).covariance is None
