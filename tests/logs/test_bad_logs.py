"""Bad logs and bad options: each is refused in one line that says what, where and what would be right."""

import os
import sqlite3
from pathlib import Path

import bags
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.judging.evaluation import evaluate
from diffdrive_mj.logs import Columns, Entries, Topics

TUM = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"
CSV = "t,left,right,x,y,theta\n0,0,0,0,0,0\n1,1,1,1,0,0\n2,2,2,2,0,0\n"
POSES = dd.PoseLog([0.0, 1.0, 2.0], np.zeros((3, 3)), "truth")
DRIVE = dd.Drive([0.0, 1.0], np.zeros((2, 2)), np.zeros((2, 3)))
ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
JOINTS = [bags.joints(t, t, t) for t in (0.0, 1.0, 2.0)]
POSED = [bags.stamped(t, t) for t in (0.0, 1.0, 2.0)]
ODOM = [bags.transforms(t, ("odom", "base", t)) for t in (0.0, 2.0)]
BACK = [*ODOM, ("tf2_msgs/msg/TFMessage", 3.0, bags.transforms(1.0, ("odom", "base", 1.0))[2])]
GOOD = {"/joint_states": JOINTS, "/truth": POSED}
LEFT, RIGHT = "/left", "/right"
ENTRIES = {LEFT: "double", RIGHT: "double", "/pose": "struct:Pose2d"}
RECORDS = [(name, 10 * k, (1.0 * k,) * (3 if name == "/pose" else 1)) for k in range(4) for name in ENTRIES]


def text(name, content):
    return lambda: Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())


def bag(name="log.mcap", storage="mcap", **topics):
    """A bag of two good topics with some changed or, if they are None, left out."""
    renamed = {"joints": "/joint_states", "poses": "/truth"}
    there = {**GOOD, **{renamed.get(topic, f"/{topic}"): messages for topic, messages in topics.items()}}
    return lambda: bags.write(name, {topic: messages for topic, messages in there.items() if messages}, storage)


def changed(messages, k, message):
    return [*messages[:k], message, *messages[k + 1 :]]


def data_log(records=RECORDS, **kinds):
    return lambda: bags.wpilog("log.wpilog", {**ENTRIES, **{f"/{k}": v for k, v in kinds.items()}}, records)


def edited(path, edit, name="log.mcap", storage="mcap"):
    """A good bag, one of whose files is edited: bytes in, bytes out."""

    def make():
        bag(name, storage)()
        Path(path).write_bytes(edit(Path(path).read_bytes()))

    return make


def with_huge_message(raw):
    """The length of the first message's record comes 58 bytes before the first joint's name."""
    k = raw.index(b"left_wheel_joint") - 58
    return raw[:k] + b"\xff" * 7 + b"\x0f" + raw[k + 8 :]


def edited_log(edit):
    """A good data log that is edited: bytes in, bytes out."""

    def make():
        path = data_log()()
        path.write_bytes(edit(path.read_bytes()))

    return make


def database(path="log.db3"):
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE notes (line TEXT)")
    connection.close()


def folder(*parts):
    return lambda: [Path(part).mkdir() for part in parts]


def read(path, *options, **more):
    return lambda: logs.read(path, *options, **more)


def poses(path, *options):
    return lambda: logs.read_poses(path, *options)


def write(path, log=POSES, *options):
    return lambda: logs.write(path, log, *options)


def nothing():
    pass


two = dd.simulate((ROBOT, ROBOT), dd.maneuvers.straight(ROBOT, distance=0.05, speed=0.2), sample_rate=10.0)
METADATA = "log/metadata.yaml"

# What is there, what is called, the builtin of the error, and words of its line.
KINDS = {
    # Files that are not what their names say
    "no such file": (nothing, read("log.csv"), OSError, "log.csv: no such file"),
    "ending that is not known": (text("log.dat", TUM), poses("log.dat"), ValueError,
                                 "unknown ending '.dat', and it looks like a TUM file: name it .tum"),
    "no ending": (text("log", b"\x00\x01"), read("log"), ValueError, "log: it has no ending, "
                  "and looks like no log that is known; logs end in"),
    "CSV that is MCAP": (text("log.csv", b"\x89MCAP0\r\n\0"), read("log.csv"), ValueError,
                         "the ending is that of a CSV file, but it looks like an MCAP file: name it .mcap"),
    "CSV that is a spreadsheet": (text("log.csv", b"PK\x03\x04\0"), read("log.csv"), ValueError, "export it as CSV"),
    "CSV that is compressed": (text("log.csv", b"\x1f\x8b\x08\0"), read("log.csv"), ValueError, "unpack it first"),
    "CSV in UTF-16": (text("log.csv", CSV.encode("utf-16")), read("log.csv"), ValueError, "save it in UTF-8"),
    "CSV in Latin-1": (text("log.csv", b"# \xe9t\xe9\n" + CSV.encode()), read("log.csv"), ValueError,
                       "looks like a text in another encoding: save it in UTF-8"),
    "CSV in Latin-1 further down": (text("log.csv", CSV.encode() + b"3,0,0,0,0,0\n" * 900 + b"# \xe9\n"),
                                    read("log.csv"),
                                    ValueError, "log.csv: cannot be read (not a text file in UTF-8)"),
    "CSV that is Parquet": (text("log.csv", b"PAR1\x15\0"), read("log.csv"), ValueError, "a Parquet file"),
    "CSV that is HDF5": (text("log.csv", b"\x89HDF\r\n\x1a\n\0"), read("log.csv"), ValueError, "an HDF5 file"),
    "MCAP that is TUM": (text("log.mcap", TUM), poses("log.mcap"), ValueError, "looks like a TUM file: name it .tum"),
    "MCAP of no bytes": (text("log.mcap", b""), read("log.mcap"), ValueError, "log.mcap: the file is empty"),
    "database that is MCAP": (text("log.db3", b"\x89MCAP0\r\n\0"), read("log.db3"), ValueError,
                              "that of a rosbag2 database, but it looks like an MCAP file: name it .mcap"),
    "data log that is CSV": (text("log.wpilog", CSV), read("log.wpilog"), ValueError, "looks like a CSV file"),
    "TUM that is MCAP": (text("log.tum", b"\x89MCAP0\r\n\0"), poses("log.tum"), ValueError, "an MCAP file"),
    "ROS 1 bag": (text("log.bag", b"#ROSBAG V2.0\n"), read("log.bag"), ValueError, "a ROS 1 bag: rosbags-convert"),
    "ROS 1 bag named MCAP": (text("log.mcap", b"#ROSBAG V2.0\n"), read("log.mcap"), ValueError, "rosbags-convert"),
    "folder that is no bag": (folder("log"), read("log"), ValueError, "a folder without metadata.yaml"),
    "folder named like a file": (folder("log.csv"), read("log.csv"), ValueError, "a folder without metadata.yaml"),
    "path that is a number": (nothing, read(5), TypeError, "path = 5: must be a path"),
    "path of no letters": (nothing, poses(""), ValueError, "must name a file"),
    # Options
    "topics of a CSV file": (text("log.csv", CSV), read("log.csv", Topics()), TypeError,
                             "options = a Topics: log.csv is a CSV file, which takes Columns"),
    "columns of a bag": (bag(), read("log.mcap", Columns()), TypeError, "is an MCAP file, which takes Topics"),
    "entries of a bag": (bag(), read("log.mcap", Entries()), TypeError,
                         "options = an Entries: log.mcap is an MCAP file, which takes Topics"),
    "options of a TUM file": (text("log.tum", TUM), poses("log.tum", Columns()), TypeError, "which takes none"),
    "options in a dict": (text("log.csv", CSV), read("log.csv", {"time": 1}), TypeError, "options = a dict: must be a"),
    "robot by its name": (text("log.csv", CSV), read("log.csv", robot="ct_bot"), TypeError, "Robot.load('ct_bot')"),
    "truth that is an array": (text("log.csv", CSV), read("log.csv", truth=np.zeros(3)), TypeError,
                               "truth = a ndarray"),
    "truth that is not there": (text("log.csv", CSV), read("log.csv", truth="gt.tum"), OSError, "gt.tum: no such file"),
    "truth of another day": (text("log.csv", CSV), read("log.csv", truth=dd.PoseLog([9, 10], np.zeros((2, 3)))),
                             ValueError, "the true poses span 9 to 10 s and the encoder 0 to 2 s"),
    "topic without a name": (nothing, lambda: Topics(wheels=""), ValueError, "Topics.wheels = ''"),
    "topic that is a number": (nothing, lambda: Topics(poses=1), TypeError, "Topics.poses = 1: must be a string"),
    "one joint for both": (nothing, lambda: Topics(left="a", right="a"), ValueError, "are both 'a': must differ"),
    "one frame for both": (nothing, lambda: Topics(frame="a", child_frame="a"), ValueError, "are both 'a'"),
    "stamps of the receiver": (nothing, lambda: Topics(stamps="gps"), ValueError, "choose from bag, header"),
    "reversal by a word": (nothing, lambda: Topics(reverse_left="no"), TypeError, "must be True or False"),
    "one entry for both": (nothing, lambda: Entries(left="a", right="a"), ValueError, "are both 'a'"),
    "entry without a name": (nothing, lambda: Entries(pose=""), ValueError, "Entries.pose = ''"),
    "unit of a wheel": (nothing, lambda: Entries(wheel_unit="feet"), ValueError, "unknown Entries.wheel_unit 'feet'"),
    "gear of ticks": (nothing, lambda: Columns(wheel_unit="ticks", gear=2), ValueError, "has the gear in it"),
    "gear of metres": (nothing, lambda: Entries(wheel_unit="metres", gear=2), ValueError, "wheel_unit is 'metres'"),
    "gear of zero": (nothing, lambda: Columns(gear=0), ValueError, "Columns.gear = 0: must be positive"),
    "metres without a robot": (text("log.csv", CSV), read("log.csv", Columns(wheel_unit="metres")), ValueError,
                               "log.csv: wheels in metres need a robot"),
    # CSV files
    "CSV without wheels": (text("log.csv", "t,x,y,theta\n0,0,0,0\n1,1,0,0\n"), read("log.csv"), ValueError,
                           "unknown column of log.csv 'left'"),
    "CSV without poses": (text("log.csv", "t,left,right\n0,0,0\n1,1,1\n"), poses("log.csv"), ValueError,
                          "unknown column of log.csv 'x'"),
    "two rows of one time": (text("log.csv", CSV.replace("2,2,2", "1,2,2")), read("log.csv"), ValueError,
                             "log.csv, line 4, column 1 (t): 1 s after 1 s: times must increase; only a sample that"),
    "clock that goes back": (text("log.csv", CSV.replace("2,2,2", "0.5,2,2")), poses("log.csv"), ValueError,
                             "line 4, column 1 (t): 0.5 s after 1 s"),
    # TUM files
    "TUM of no line": (text("log.tum", ""), poses("log.tum"), ValueError, "log.tum: the file is empty"),
    "TUM of comments": (text("log.tum", "# nothing\n"), poses("log.tum"), ValueError, "log.tum: the file is empty"),
    "TUM of seven cells": (text("log.tum", TUM.replace(" 1\n", "\n")), poses("log.tum"), ValueError,
                           "line 1: 7 cells: a TUM file has 8, timestamp tx ty tz qx qy qz qw"),
    "TUM with commas": (text("log.tum", TUM.replace(" ", ",")), poses("log.tum"), ValueError, "with blanks in between"),
    "row of nine cells": (text("log.tum", TUM.replace("1 1 0", "1 1 1 0")), poses("log.tum"), ValueError,
                          "line 2: 9 cells where line 1 has 8"),
    "word among numbers": (text("log.tum", TUM.replace("1 1 0", "1 one 0")), poses("log.tum"), ValueError,
                           "line 2, column 2: 'one' is not a number"),
    "pose that is not finite": (text("log.tum", TUM.replace("1 1 0", "1 nan 0")), poses("log.tum"), ValueError,
                                "line 2, column 2: 'nan': must be finite"),
    "quaternion of zeros": (text("log.tum", TUM.replace("1 1 0 0 0 0 0 1", "1 1 0 0 0 0 0 0")), poses("log.tum"),
                            ValueError, "line 2: quaternion (0, 0, 0, 0): must have a norm of 1"),
    "quaternion with w before": (text("log.tum", "# w x y z\n" + TUM.replace("0 0 0 1\n", "1 0 0 0\n")),
                                 poses("log.tum"),
                                 ValueError, "line 2: the robot leans by 180 deg"),
    "TUM whose clock goes back": (text("log.tum", TUM.replace("2 2 0", "0.5 2 0")), poses("log.tum"), ValueError,
                                  "line 3: 0.5 s after 1 s: times must increase"),
    "TUM of two poses at a time": (text("log.tum", TUM.replace("2 2 0", "1 2 0")), poses("log.tum"), ValueError,
                                   "line 3: 1 s after 1 s"),
    "TUM of one pose": (text("log.tum", TUM[:16]), poses("log.tum"), ValueError, "log.tum: 1 samples: must be"),
    "TUM read for its wheels": (text("log.tum", TUM), read("log.tum"), ValueError, "logs.read_poses reads it"),
    # Bags that are damaged
    "MCAP cut short": (edited("log.mcap", lambda raw: raw[:-50]), read("log.mcap"), ValueError,
                       "cannot be read as a ROS 2 bag (File end magic is invalid); `mcap recover` mends"),
    "MCAP of its magic alone": (text("log.mcap", b"\x89MCAP0\r\n"), read("log.mcap"), ValueError,
                                "bag (damaged); `mcap"),
    "MCAP with a hole": (edited("log.mcap", lambda raw: raw[:300] + bytes(400) + raw[700:]), read("log.mcap"),
                         ValueError,
                         "log.mcap, /joint_states: none of its 3 messages can be read: the bag is damaged"),
    "MCAP of a length beyond memory": (edited("log.mcap", with_huge_message), read("log.mcap"), ValueError,
                                       "log.mcap: cannot be read as a ROS 2 bag (Truncated record at offset"),
    "database of something else": (database, read("log.db3"), ValueError, "as a ROS 2 bag (Cannot open database"),
    "database cut short": (edited("log.db3", lambda raw: raw[:5000], "log.db3", "sqlite3"), read("log.db3"), ValueError,
                           "cannot be read as a ROS 2 bag"),
    "metadata that are no YAML": (edited(METADATA, lambda raw: b"a: [", "log"), read("log"), ValueError,
                                  "Could not load"),
    "metadata of something else": (edited(METADATA, lambda raw: b"a: 1", "log"), read("log"), ValueError,
                                   "A metadata key is missing"),
    "metadata from the future": (edited(METADATA, lambda raw: raw.replace(b"version: 9", b"version: 99"), "log"),
                                 read("log"), ValueError, "version 99 not supported"),
    "storage that is not known": (edited(METADATA, lambda raw: raw.replace(b"identifier: mcap", b"identifier: tape"),
                                  "log"),
                                  read("log"), ValueError, "Storage plugin 'tape' not supported"),
    "folder without its file": (lambda: (bag("log")(), Path("log/log.mcap").unlink()), read("log"), ValueError,
                                "files are missing"),
    "message of too few bytes": (bag(poses=changed(POSED, 1, (POSED[1][0], 1.0, b"\0\1\0\0abc"))), poses("log.mcap"),
                                 ValueError, "/truth, message 2: its 7 bytes are no geometry_msgs/msg/PoseStamped"),
    # What is in bags
    "bag without wheels": (bag(joints=None), read("log.mcap"), ValueError,
                           "no topic has sensor_msgs/JointState: there is /truth (geometry_msgs/PoseStamped)"),
    "bag without poses": (bag(poses=None), poses("log.mcap"), ValueError, "no topic has nav_msgs/Odometry, "
                          "geometry_msgs"),
    "bag of topics without messages": (bag(joints=None, poses="nav_msgs/msg/Odometry"), poses("log.mcap"), ValueError,
                                       "there are no messages"),
    "topic that is not there": (bag(), poses("log.mcap", Topics(poses="/trut")), ValueError, "did you mean '/truth'?"),
    "topic of another type": (bag(), read("log.mcap", Topics(wheels="/truth")), ValueError,
                              "/truth has geometry_msgs/PoseStamped: must have sensor_msgs/JointState"),
    "topics that may be the wheels": (bag(arm=JOINTS), read("log.mcap"), ValueError, "/joint_states, "
                                      "/arm may have the"),
    "topics that may be the poses": (bag(odom=POSED), poses("log.mcap"), ValueError, "as in Topics(poses='/truth')"),
    "joints of an arm": (bag(joints=[bags.joints(0, 1, 2, ("shoulder", "elbow"))]), read("log.mcap"), ValueError,
                         "no message has the joints 'left' and 'right': choose Topics.left and Topics.right"),
    "joints of four wheels": (bag(joints=[bags.joints(0, 0, 0, ("fl_left", "rl_left", "right"), [1, 2, 3])]),
                              read("log.mcap"), ValueError, "fl_left, rl_left may be the left wheel: name one, as in"),
    "joint that is not there": (bag(), read("log.mcap", Topics(left="l")), ValueError, "no message has the joints 'l'"),
    "joints without positions": (bag(joints=changed(JOINTS, 1, bags.joints(1.0, 0, 0, position=[]))), read("log.mcap"),
                                 ValueError, "/joint_states, message 2: 0 positions for 2 joints"),
    "wheel that is not finite": (bag(joints=changed(JOINTS, 2, bags.joints(2.0, 0, np.nan))), read("log.mcap"),
                                 ValueError,
                                 "/joint_states, message 3: a wheel's position is not finite"),
    "wheels whose clock goes back": (bag(joints=changed(JOINTS, 2, (JOINTS[0][0], 2.0, bags.joints(0.5, 1, 1)[2]))),
                                     read("log.mcap"), ValueError, "/joint_states, message 3: 0.5 s after 1 s"),
    "poses whose stamp stands still": (bag(poses=changed(POSED, 2, (POSED[0][0], 2.0, bags.stamped(1.0, 5.0)[2]))),
                                       poses("log.mcap"), ValueError, "/truth, message 3: 1 s after 1 s"),
    "wheels of one message": (bag(joints=JOINTS[:1]), read("log.mcap"), ValueError, "1 samples: must be at least two"),
    "poses of one message": (bag(poses=POSED[:1]), poses("log.mcap"), ValueError, "1 samples: must be at least two"),
    "orientation that nobody set": (bag(poses=changed(POSED, 1, bags.stamped(1.0, q=(0.0, 0.0, 0.0, 0.0)))),
                                    poses("log.mcap"), ValueError, "/truth, message 2: quaternion (0, 0, 0, 0)"),
    "position that is not finite": (bag(poses=changed(POSED, 1, bags.stamped(1.0, np.inf))), poses("log.mcap"),
                                    ValueError,
                                    "/truth, message 2: a number of the pose is not finite"),
    "camera's axes": (bag(poses=[bags.stamped(t, q=(-0.5, 0.5, -0.5, 0.5)) for t in (0.0, 1.0)]), poses("log.mcap"),
                      ValueError, "the robot leans by 90 deg: z must point up"),
    "frames of a bag without transforms": (bag(), poses("log.mcap", Topics(frame="map")), ValueError,
                                           "no topic has tf2_msgs/TFMessage"),
    "frames that are not there": (bag(tf=[bags.transforms(t, ("odom", "base", t)) for t in (0.0, 1.0)]),
                                  poses("log.mcap", Topics(frame="map", child_frame="base")), ValueError,
                                  "no transforms from 'map' to 'base': there are odom -> base"),
    "transforms whose clock goes back": (bag(poses=None, tf=BACK), poses("log.mcap"), ValueError,
                                         "log.mcap, /tf, odom -> base, message 3: 1 s after 2 s"),
    "transforms of nothing": (bag(poses=None, tf=[bags.transforms(0.0)]), poses("log.mcap"), ValueError,
                              "log.mcap: its messages hold no transforms"),
    # Data logs
    "data log of its magic alone": (text("log.wpilog", b"WPILOG"), read("log.wpilog"), ValueError, "header is damaged"),
    "data log whose entry is damaged": (edited_log(lambda raw: raw.replace(LEFT.encode(), b"\xff\xff\xff\xff\xff")),
                                        read("log.wpilog"), ValueError, "the start of an entry is damaged"),
    "data log without entries": (lambda: bags.wpilog("log.wpilog", {}, []), read("log.wpilog"), ValueError,
                                 "no entry of"),
    "entry that is not there": (data_log(), read("log.wpilog", Entries(left="/lef")), ValueError,
                                "did you mean '/left'?"),
    "entry of another type": (data_log(mode="boolean"), read("log.wpilog", Entries(left="/mode")), ValueError,
                              "/mode is of type boolean: must be double or float or int64"),
    "entries that may be the wheel": (data_log(left_rate="double"), read("log.wpilog"), ValueError,
                                      "/left, /left_rate may be left: name one, as in Entries(left='/left')"),
    "value of too few bytes": (data_log([*RECORDS, ("/pose", 50, b"short")]), read("log.wpilog"), ValueError,
                               "/pose, value 5: its 5 bytes are no struct:Pose2d"),
    "wheel of too few bytes": (data_log([*RECORDS, (LEFT, 50, b"short")]), read("log.wpilog"), ValueError,
                               "/left, value 5: its 5 bytes are no double"),
    "value that is not finite": (data_log([*RECORDS, (LEFT, 50, np.inf)]), read("log.wpilog"), ValueError,
                                 "log.wpilog, /left, value 5: must be finite"),
    "values whose clock goes back": (data_log([*RECORDS, (LEFT, 5, 1.0)]), read("log.wpilog"), ValueError,
                                     "/left, value 5: 5e-06 s after 3e-05 s: times must increase"),
    "entry of one value": (data_log(RECORDS[:3]), read("log.wpilog"), ValueError,
                           "/pose: 1 samples: must be at least two"),
    "wheels at different times": (data_log([(LEFT, 0, 1.0), (LEFT, 1, 1.0), (RIGHT, 5, 1.0), (RIGHT, 6, 1.0),
                                            ("/pose", 0, (0.0, 0.0, 0.0)), ("/pose", 1, (0.0, 0.0, 0.0))]),
                                  read("log.wpilog"), ValueError,
                                  "one of the wheels ends before the other begins, at 5e-06 s"),
    "wheels of one value": (data_log(RECORDS[:3] + RECORDS[5::3]), read("log.wpilog"), ValueError,
                            "log.wpilog: both wheels are known at 1 times: must be two"),
    "wheel without a value": (data_log(RECORDS[1:2] + RECORDS[2::3]), read("log.wpilog"), ValueError,
                              "/left: 0 samples: must be at least one"),
    "times beyond all sizes": (text("log.csv", CSV.replace("2,2,2", "1e308,2,2")), read("log.csv"), ValueError,
                               "t[2] = 1e+308: must be within 1e+100"),
    "cell of a book": (text("log.csv", CSV.replace("2,2,2", "2," + "z" * 9999 + ",2")), read("log.csv"), ValueError,
                       "line 4, column 2 (left): 'zzzzzzzzzzzzzzzzzzzzzzzzzzzzzz'... is not a number"),
    "decimal commas": (text("log.csv", CSV.replace(",", ";").replace("1;1", "1;1,5", 1)), read("log.csv"), ValueError,
                       "'1,5' is not a number: decimal commas must be points"),
    "TUM with decimal commas": (text("log.tum", TUM.replace("1 1", "1 1,5")), poses("log.tum"), ValueError,
                                "line 2, column 2: '1,5' is not a number: decimal commas must be points"),
    "JSON": (text("log.json", "{}"), read("log.json"), ValueError, "it looks like JSON: export it as CSV"),
    "HTML": (text("log.html", "<html>"), read("log.html"), ValueError, "it looks like HTML or XML: export it as CSV"),
    "MCAP in capitals": (text("log.MCAP", b"\x89MCAP0\r\n"), read("log.MCAP"), ValueError,
                         "log.MCAP: the ending of a bag must be in small letters, .mcap"),
    "bag written in capitals": (nothing, write("log.DB3"), ValueError, "must be in small letters, .db3"),
    "pipe in the place of a file": (lambda: os.mkfifo("log.csv"), write("log.csv"), ValueError,
                                    "log.csv: is a device or a pipe, which no file replaces"),
    "pipe in the place of a bag": (lambda: os.mkfifo("log.mcap"), write("log.mcap"), ValueError,
                                   "log.mcap: is a device or a pipe, which no file replaces"),
    "pose beyond all sizes": (text("log.tum", TUM.replace("1 1 0", "1 1e300 1e308")), poses("log.tum"), ValueError,
                              "log.tum: poses[1, 0] = 1e+300: must be within 1e+100 of zero"),
    "wheels beyond all sizes": (text("log.csv", CSV.replace("1,1,1", "1,1e308,1")),
                                read("log.csv", Columns(wheel_unit="rotations")), ValueError,
                                "log.csv: wheel_angles[1, 0] = inf: must be finite"),
    # Writing
    "write to an ending that is not known": (nothing, write("new.bag"), ValueError, "unknown ending '.bag'; logs are"),
    "write to a data log": (nothing, write("new.wpilog"), ValueError, "is read and not written"),
    "write to a text": (nothing, write("new.txt"), ValueError, "unknown ending '.txt'"),
    "write a list": (nothing, write("new.csv", [POSES]), TypeError, "log = a list: must be a PoseLog or a Drive"),
    "write many runs": (nothing, write("new.csv", two), ValueError,
                        "a recording of 2 runs: take one of recording.runs"),
    "write over a folder": (folder("new"), write("new", DRIVE), ValueError, "no folder is overwritten"),
    "write nowhere": (nothing, write("nowhere/new.mcap", DRIVE), ValueError, "cannot be written (No such file"),
    "write before time zero": (nothing, write("new.mcap", dd.PoseLog([-1, 0], np.zeros((2, 3)))), ValueError,
                               "times from -1 to 0 s: a bag's stamps are from 0"),
    "write within a nanosecond": (nothing, write("new.db3", dd.PoseLog([0, 1e-10], np.zeros((2, 3)))), ValueError,
                                  "new.db3: 0 and 1e-10 s are one stamp in whole nanoseconds"),
    "write topics to CSV": (nothing, write("new.csv", DRIVE, Topics()), TypeError, "a CSV file is written without"),
    "write columns to a bag": (nothing, write("new.mcap", DRIVE, Columns()), TypeError, "must be a Topics"),
    # Evaluating
    "estimate that is an array": (nothing, lambda: evaluate(POSES, np.zeros((3, 3))), TypeError, "must be a PoseLog(t, "
                                  "po"),
    "truth that is a list": (nothing, lambda: evaluate([POSES], POSES), TypeError, "truth = a list: must be a PoseLog"),
    "clocks without a common time": (nothing, lambda: evaluate(POSES, dd.PoseLog([10, 11], np.zeros((2, 3)), "odom")),
                                     ValueError, "odom spans 10 to 11 s and the truth 0 to 2 s", "offset = -10 would"),
    "alignment that is not known": (nothing, lambda: evaluate(POSES, POSES, align="sim3"), ValueError, "choose from"),
    "stretch of zero": (nothing, lambda: evaluate(POSES, POSES, stretch=0), ValueError,
                        "stretch = 0: must be positive"),
    "offset that is not finite": (nothing, lambda: evaluate(POSES, POSES, offset=np.nan), ValueError, "offset = nan"),
    "poses without a heading": (nothing, lambda: dd.PoseLog([0, 1], np.zeros((2, 2))), ValueError, "must be (..., T, "
                                "3)"),
    "poses of too few times": (nothing, lambda: dd.PoseLog([0, 1], np.zeros((3, 3))), ValueError, "and t 2 times"),
    "poses of many runs": (nothing, lambda: dd.PoseLog([0, 1], np.zeros((4, 2, 3))), ValueError, "must be (T, 3)"),
}  # fmt: skip


def everything(path):
    return {each: each.read_bytes() if each.is_file() else None for each in path.rglob("*")}


@pytest.mark.parametrize("kind", KINDS)
def test_one_line_says_what_where_and_what_would_be_right(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make, call, builtin, *words = KINDS[kind]
    make()
    before = everything(tmp_path)
    with pytest.raises(DiffdriveError) as info:
        call()
    assert isinstance(info.value, builtin)
    message = info.value.message()
    assert all(word in message for word in words), message
    assert len(message.splitlines()) == 1
    assert everything(tmp_path) == before
    assert capsys.readouterr() == ("", "")


def test_there_are_enough_kinds():
    assert len(KINDS) >= 120
