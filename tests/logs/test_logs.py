"""Logs: every cell where it belongs, every bad file refused by line and column, every planted fault named."""

import dataclasses

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj import diagnosis, logs
from diffdrive_mj._files import write_whole
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.logs import Columns

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3, encoder={"ticks_per_revolution": 1000})
GOOD = "t,left,right,x,y,theta\n0,0,0,0,0,0\n0.1,1,2,0.01,0,0.02\n0.2,2,4,0.02,0.001,0.04\n"


def same(a, b):
    fields = ("t", "wheel_angles", "truth", "truth_t")
    return all(np.array_equal(getattr(a, f), getattr(b, f)) for f in fields)


@pytest.fixture
def written(tmp_path):
    """Text in a file, and the drive that is read from it."""

    def read(text, robot=None, **columns):
        path = tmp_path / "log.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return logs.read_csv(path, Columns(**columns), robot)

    return read


# Reading


def test_the_default_columns(written, tmp_path):
    drive = written(GOOD)
    assert drive.name == str(tmp_path / "log.csv")
    np.testing.assert_array_equal(drive.t, [0, 0.1, 0.2])
    np.testing.assert_array_equal(drive.wheel_angles, [[0, 0], [1, 2], [2, 4]])
    np.testing.assert_array_equal(drive.truth, [[0, 0, 0], [0.01, 0, 0.02], [0.02, 0.001, 0.04]])
    np.testing.assert_array_equal(drive.clock, drive.t)


@pytest.mark.parametrize(
    "text",
    [
        GOOD.replace(",", ";"),
        GOOD.replace(",", "\t"),
        GOOD.replace(",", "  "),
        GOOD.replace("\n", "\r\n"),
        "\ufeff" + GOOD,
        "# a comment\n\n" + GOOD + "# the end\n\n",
        "# " + GOOD,
        "# a comment, with, six, cells, in, it\n# " + GOOD,
        GOOD.replace(",", "  ").replace("0.1  1", "  0.1 \t 1"),
        '"t","left","right","x","y","theta"\n' + GOOD.split("\n", 1)[1],
        GOOD.replace(",", " , "),
        GOOD.rstrip("\n"),
    ],
    ids=[
        "semicolon",
        "tab",
        "blanks",
        "crlf",
        "bom",
        "comments",
        "savetxt",
        "savetxt below a comment",
        "runs of blanks",
        "quotes",
        "padded",
        "no newline",
    ],
)
def test_dialects(written, text):
    assert same(written(text), written(GOOD))


def test_columns_by_number_and_by_name(written):
    body = GOOD.split("\n", 1)[1]
    numbers = {"time": 1, "left": 2, "right": 3, "x": 4, "y": 5, "theta": 6}
    assert same(written(body, **numbers), written(GOOD))
    assert same(written(GOOD, **numbers), written(GOOD))
    assert same(written(body, header=False, **numbers), written(GOOD))
    names = GOOD.replace("t,left,right,x,y,theta", "stamp [s],enc l,enc r,px,py,yaw")
    assert same(
        written(names, time="stamp [s]", left="enc l", right="enc r", x="px", y="py", theta="yaw"), written(GOOD)
    )
    assert same(written("1,2,3,4,5,6\n" + body, header=True, **numbers), written(GOOD))


def test_other_columns_may_hold_anything(written):
    lines = [line + f",{word}," for line, word in zip(GOOD.split(), ("note", "go", "nan", ""), strict=True)]
    assert same(written("\n".join(lines)), written(GOOD))


@pytest.mark.parametrize(("unit", "parts"), [("s", 1), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_units_of_time(written, unit, parts):
    drive = written(f"t,left,right,x,y,theta\n{0 * parts},0,0,0,0,0\n{3 * parts},1,1,1,0,0\n", time_unit=unit)
    np.testing.assert_array_equal(drive.t, [0, 3])


def test_units_of_the_pose(written):
    text = "t,left,right,x,y,theta\n0,0,0,0,0,0\n1,1,1,250,-500,90\n"
    np.testing.assert_array_equal(written(text, position_unit="mm").truth[1], [0.25, -0.5, 90])
    np.testing.assert_array_equal(written(text, position_unit="cm").truth[1], [2.5, -5, 90])
    np.testing.assert_allclose(written(text, angle_unit="deg").truth[1], [250, -500, np.pi / 2], rtol=1e-15)


def test_ticks_are_those_of_the_columns_or_of_the_robot(written):
    expected = written(GOOD).wheel_angles * 2 * np.pi / 1000
    np.testing.assert_allclose(written(GOOD, ROBOT, wheel_unit="ticks").wheel_angles, expected, rtol=1e-15)
    fixed = written(GOOD, ROBOT, wheel_unit="ticks", ticks_per_revolution=500)
    np.testing.assert_allclose(fixed.wheel_angles, 2 * expected, rtol=1e-15)


def test_increments_add_up(written):
    drive = written(GOOD, wheels="increments")
    np.testing.assert_array_equal(drive.wheel_angles, [[0, 0], [1, 2], [3, 6]])


def test_reversed_wheels(written):
    plain = written(GOOD).wheel_angles
    np.testing.assert_array_equal(written(GOOD, reverse_left=True).wheel_angles, plain * [-1, 1])
    np.testing.assert_array_equal(written(GOOD, reverse_right=True).wheel_angles, plain * [1, -1])


@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize("signed", [True, False])
@given(data=st.data())
def test_wrapping_is_undone_in_both_directions(tmp_path_factory, bits, signed, data):
    """Every walk whose steps are below half of the range comes back, whether the counter is signed or not."""
    half = 2 ** (bits - 1)
    steps = data.draw(
        hnp.arrays(np.int64, st.tuples(st.integers(1, 20), st.just(2)), elements=st.integers(1 - half, half - 1))
    )
    counts = data.draw(st.integers(-half, half)) + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])
    shown = (counts + half) % (2 * half) - half if signed else counts % (2 * half)
    path = tmp_path_factory.mktemp("wrap") / "log.csv"
    rows = [f"{k},{left},{right},{k},0,0" for k, (left, right) in enumerate(shown)]
    path.write_text("\n".join(["t,left,right,x,y,theta", *rows]))
    columns = Columns(wheel_unit="ticks", ticks_per_revolution=1, counter_bits=bits)
    turns = logs.read_csv(path, columns).wheel_angles / (2 * np.pi)
    np.testing.assert_array_equal(np.rint(turns), np.concatenate([shown[:1], shown[:1] + np.cumsum(steps, axis=0)]))


def test_sparse_truth_and_truth_between_the_samples(written):
    text = "t,left,right,x,y,theta\n0,0,0,1,2,3\n0.1,1,2,,,\n0.15,,,1.5,2,3\n0.2,2,4,,,\n0.3,3,6,2,2,3\n"
    drive = written(text)
    np.testing.assert_array_equal(drive.t, [0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(drive.clock, [0, 0.15, 0.3])
    np.testing.assert_array_equal(drive.truth[:, 0], [1, 1.5, 2])


# Refusing

BAD = {
    "": ("empty",),
    "\n# only this\n": ("empty",),
    "t,left,right,x,y,theta\n": ("header", "nothing below"),
    GOOD.replace("0.01,", "o.o1,"): ("line 3", "column 4 (x)", "'o.o1'", "not a number"),
    GOOD.replace("0.01,", "1_0,"): ("line 3", "column 4 (x)", "'1_0'", "not a number"),
    GOOD.replace("0.01,", "\u0663,"): ("line 3", "column 4 (x)", "'\u0663'", "not a number"),
    GOOD.replace("0.01,", "nan,"): ("line 3", "column 4 (x)", "finite"),
    GOOD.replace("0.01,", "inf,"): ("line 3", "column 4 (x)", "finite"),
    GOOD.replace("0.1,1,2", "0.1,1,nan"): ("line 3", "column 3 (right)", "finite"),
    GOOD.replace("0.1,1,2", "0.1,1,"): ("line 3", "column 3 (right)", "empty", "column 2 (left)"),
    GOOD.replace("0.01,0,0.02", "0.01,,0.02"): ("line 3", "column 5 (y)", "empty"),
    GOOD.replace("0.1,", ",", 1): ("line 3", "column 1 (t)", "empty"),
    GOOD.replace("0.1,1", "0.1,1,1"): ("line 3", "7 cells", "line 1 has 6"),
    GOOD.replace("0.2,2,4,0.02,", "0.2,2,4,"): ("line 4", "5 cells", "line 1 has 6"),
    GOOD.replace("0.2,", "0.1,", 1): ("line 4", "column 1 (t)", "0.1 s after 0.1 s", "increase"),
    GOOD.replace("0.2,", "0.05,", 1): ("line 4", "column 1 (t)", "0.05 s after 0.1 s", "increase"),
    "t,left,right,x,y,theta\n0,0,0,0,0,0\n": ("1 samples of the wheels", "at least two"),
    "t,left,right,x,y,theta\n0,0,0,0,0,0\n1,1,1,,,\n": ("1 true poses", "at least two"),
    "t,left,right,x,y,theta\n0,0,0,,,\n1,1,1,,,\n": ("0 true poses", "at least two"),
    GOOD.replace("theta", "thta"): ("unknown column", "'theta'", "thta", "did you mean 'thta'"),
    GOOD.replace("theta", "x"): ("'x'", "2 columns"),
    GOOD.split("\n", 1)[1]: ("no header", "1 to 6"),
    b"\xff\xfe\x00\x01": ("UTF-8",),
    "\0\0\0": ("nothing below",),
    "t,left,right,x,y,theta\n0,0,0,0,0,0\n1,1,1,0,0,1e999\n": ("line 3", "finite"),
}


@pytest.mark.parametrize("text", BAD, ids=lambda text: repr(text)[:60])
def test_bad_files_are_refused_by_line_and_column(written, tmp_path, text):
    with refused(ValueError, tmp_path / "log.csv", *BAD[text]):
        written(text)


@pytest.mark.parametrize("places", [{"left": 7}, {"time": 99}])
def test_columns_that_are_not_there(written, places):
    with refused(ValueError, "columns 1 to 6"):
        written(GOOD, **places)


def test_one_column_for_two_things(written):
    with refused(ValueError, "left and right", "column 2 (left)"):
        written(GOOD, right="left")


def test_a_typing_error_in_the_first_row_is_no_header(written):
    body = GOOD.split("\n", 1)[1].replace("0,0,0,0,0,0", "0,0,O,0,0,0")
    with refused(ValueError, "line 1", "column 3", "'O'"):
        written(body, time=1, left=2, right=3, x=4, y=5, theta=6)


def test_missing_files_and_folders(tmp_path):
    with refused(FileNotFoundError, tmp_path / "nothing.csv", "no such file"):
        logs.read_csv(tmp_path / "nothing.csv")
    with refused(ValueError, tmp_path, "cannot be read"):
        logs.read_csv(tmp_path)


BAD_PATHS = [(None, TypeError), (b"log.csv", TypeError), (7, TypeError), ("", ValueError), ("log\0.csv", ValueError)]


@pytest.mark.parametrize(("path", "builtin"), BAD_PATHS)
def test_what_is_not_a_path(written, path, builtin):
    drive = written(GOOD)
    for call in (logs.read_csv, lambda path: logs.write_csv(path, drive)):
        with refused(builtin, "path = ", repr(path)):
            call(path)
    for call in (logs.read_optiodom, logs.optiodom_robot):
        with refused(builtin, "folder = ", repr(path)):
            call(path)


@pytest.mark.parametrize("path", [".", "/"])
def test_a_folder_is_not_written_over(written, path):
    with refused(ValueError, "must name a file"):
        logs.write_csv(path, written(GOOD))


def test_other_things_than_drives_columns_and_robots(written, tmp_path, simulated):
    with refused(TypeError, "drive = a Recording: must be a Drive"):
        logs.write_csv(tmp_path / "it.csv", simulated)
    with refused(TypeError, "drive = a list: must be a Drive"):
        logs.write_csv(tmp_path / "it.csv", [written(GOOD)])
    with refused(TypeError, "columns = 't': must be a Columns"):
        logs.read_csv(tmp_path / "log.csv", "t")
    with refused(TypeError, "robot = 'matched': must be a Robot", "Robot.load('matched')"):
        logs.read_csv(tmp_path / "log.csv", Columns(), "matched")
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_ticks_without_a_revolution(written):
    with refused(ValueError, "ticks_per_revolution"):
        written(GOOD, wheel_unit="ticks")


@pytest.mark.parametrize(
    ("cell", "bits", "words"),
    [
        ("65536", 16, "65536 does not fit in 16 bits"),
        ("-32769", 16, "-32769 does not fit in 16 bits"),
        ("4294967296", 32, "4294967296 does not fit in 32 bits"),
        ("1.5", 16, "1.5 must be whole"),
        # Half of the range could be either way.
        ("32768", 16, "jumps by -32768 ticks: exactly half of the range of 16 bits"),
        ("-32768", 16, "jumps by -32768 ticks"),
        ("2147483648", 32, "jumps by -2147483648 ticks: exactly half of the range of 32 bits"),
    ],
)
def test_counts_that_the_bits_cannot_hold(written, cell, bits, words):
    with refused(ValueError, "line 3, column 2 (left)", words):
        written(GOOD.replace("0.1,1", f"0.1,{cell}"), ROBOT, wheel_unit="ticks", counter_bits=bits)


def test_counters_are_signed_or_unsigned_but_not_both(written):
    text = "t,left,right,x,y,theta\n0,-5,0,0,0,0\n0.1,{},0,0,0,0\n\n0.2,3,0,0,0,0\n"
    with refused(
        ValueError, "line 3, column 2 (left): 40000 beside -5 does not fit in 16 bits", "unsigned, 0 to 65535"
    ):
        written(text.format(40000), ROBOT, wheel_unit="ticks", counter_bits=16)
    assert written(text.format(30000), ROBOT, wheel_unit="ticks", counter_bits=16).t[-1] == 0.2


@pytest.mark.parametrize(
    ("fields", "builtin"),
    [
        ({"time": 0}, ValueError),
        ({"left": True}, TypeError),
        ({"x": 1.5}, TypeError),
        ({"wheels": "counter"}, ValueError),
        ({"wheel_unit": "degrees"}, ValueError),
        ({"time_unit": "min"}, ValueError),
        ({"position_unit": "km"}, ValueError),
        ({"angle_unit": "grad"}, ValueError),
        ({"ticks_per_revolution": 0, "wheel_unit": "ticks"}, ValueError),
        ({"ticks_per_revolution": 100}, ValueError),
        ({"counter_bits": 8, "wheel_unit": "ticks"}, ValueError),
        ({"counter_bits": 16}, ValueError),
        ({"counter_bits": 16, "wheel_unit": "ticks", "wheels": "increments"}, ValueError),
        ({"delimiter": ""}, ValueError),
        ({"delimiter": "::"}, ValueError),
    ],
)
def test_columns_that_make_no_sense(fields, builtin):
    with refused(builtin, f"Columns.{next(iter(fields))}"):
        Columns(**fields)


# Writing


@given(seed=st.integers(0, 2**32 - 1), own_clock=st.booleans())
def test_what_is_written_is_read_bit_for_bit(tmp_path_factory, seed, own_clock):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.random(20) + 1e-9)
    clock = np.sort(rng.uniform(t[0], t[-1], 7)) if own_clock else t
    truth = rng.standard_normal((len(clock), 3)) * [1e-12, 1e9, np.pi]
    drive = Drive(t, rng.standard_normal((20, 2)) * 1e5, truth, clock)
    path = tmp_path_factory.mktemp("round") / "log.csv"
    logs.write_csv(path, drive)
    assert same(logs.read_csv(path), drive)


def test_a_failed_write_leaves_the_earlier_file_alone(tmp_path, written):
    drive = written(GOOD)
    path = tmp_path / "there.csv"
    path.mkdir()
    with refused(ValueError, path, "cannot be written"):
        logs.write_csv(path, drive)
    with refused(ValueError, "cannot be written"):
        logs.write_csv(tmp_path / "no folder" / "log.csv", drive)
    with refused(ValueError, "cannot be written"):
        write_whole(tmp_path / "log.csv", "\ud800")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.csv", "there.csv"]
    assert (tmp_path / "log.csv").read_text() == GOOD


# Simulations


@pytest.fixture(scope="module")
def simulated():
    robots = [ROBOT, ROBOT.replace(right_radius=0.051, name="other")]
    return dd.simulate(robots, dd.maneuvers.square(ROBOT, side=0.5, speed=0.3), sample_rate=100.0)


# A real robot


def recordings():
    return sorted(path.parent for path in optiodom_folder().glob("*/*/*_metadata.csv"))


# Largest final position error of the nominal robot [mm], published with the data set.
PUBLISHED = {
    "230620202042": 33.256, "230620202317": 33.461, "231220200040": 113.891, "250620202104": 50.799,
    "250620202119": 48.736, "250620202236": 50.992, "231220200150": 112.868, "231220200157": 75.005,
    "231220200057": 20.698, "250620201738": 24.368, "030120210001": 54.486,
}  # fmt: skip
# On these the robot neither runs straight between turns on the spot nor turns one way all the time: every fault shows.
TURNING_BOTH_WAYS = ("230620202042", "230620202317", "231220200040", "250620202104", "250620202119", "030120210001")


def test_optiodom_reads_as_its_authors_do():
    for folder in recordings():
        drives, nominal = logs.read_optiodom(folder), logs.optiodom_robot(folder)
        assert [drive.name for drive in drives] == [f"{folder.name}_run-{k + 1:02d}" for k in range(len(drives))]
        # The published column takes one nominal robot throughout; the metadata of two recordings name another.
        published_robot = dd.Robot.load("optiodom")
        sizes = {field: getattr(nominal, field) for field in ("left_radius", "track_width")}
        assert nominal == published_robot.replace(name=nominal.name, right_radius=nominal.left_radius, **sizes)
        assert sizes["left_radius"] == {"250620202236": 0.0425}.get(folder.name, 0.042)
        assert sizes["track_width"] == {"250620202119": 0.205, "250620202236": 0.205}.get(folder.name, 0.2)
        worst = 1e3 * max(drive.drift(published_robot).final_position for drive in drives)
        # The clocks of a free drive are 0.05 s apart, which its authors take out.
        assert worst == pytest.approx(PUBLISHED[folder.name], abs=0.1 if folder.parent.name == "free" else 0.002)


def test_real_runs_look_clean_and_faults_planted_in_them_are_found():
    for folder in recordings():
        nominal = logs.optiodom_robot(folder)
        for drive in logs.read_optiodom(folder):
            for factor in (0.9, 1.0, 1.1):
                for field in ("left_radius", "track_width"):
                    believed = nominal.replace(**{field: factor * getattr(nominal, field)})
                    assert diagnosis.suspicions(drive, believed) == ()
            if folder.name in TURNING_BOTH_WAYS:
                for words, faulty in faults(drive).items():
                    (found,) = diagnosis.suspicions(faulty, nominal)
                    assert words in found


def optiodom_copy(folder, **changes):
    """A small recording in the data set's form; `changes` replace rows of the metadata."""
    metadata = {"Li": "0.2,", "Di": "0.084,0.080", "ngear": "43.7,", "encRes": "64,", "N": "1,"} | changes
    (folder / "7_metadata.csv").write_text("".join(f"{key},{cells}\n" for key, cells in metadata.items()))
    (folder / "7_run-01.csv").write_text("0,0,0,0,0,0\n0.05,0.1,0.2,0.3,10,20\n")
    return folder


def test_optiodom_has_the_right_wheel_first(tmp_path):
    folder = optiodom_copy(tmp_path)
    robot, (drive,) = logs.optiodom_robot(folder), logs.read_optiodom(folder)
    assert (robot.left_radius, robot.right_radius, robot.track_width) == (0.040, 0.042, 0.2)
    assert robot.encoder.ticks_per_wheel_turn == pytest.approx(2796.8)
    np.testing.assert_allclose(drive.wheel_angles[1], np.array([20, 10]) * 2 * np.pi / 2796.8)
    np.testing.assert_array_equal(drive.truth[1], [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"Li": ","}, ("Li", "0 values")),
        ({"Di": "0.084,"}, ("Di", "1 values")),
        ({"ngear": "many,"}, ("line 3", "'many'")),
        ({"Di": "0,0.084"}, ("right_radius",)),
    ],
)
def test_bad_optiodom_metadata(tmp_path, changes, words):
    with refused(ValueError, *words):
        logs.read_optiodom(optiodom_copy(tmp_path, **changes))


def test_folders_that_are_no_recording(tmp_path):
    with refused(FileNotFoundError, tmp_path, "0 files"):
        logs.read_optiodom(tmp_path)
    with refused(FileNotFoundError, "nowhere"):
        logs.optiodom_robot(tmp_path / "nowhere")
    (optiodom_copy(tmp_path) / "7_run-01.csv").unlink()
    with pytest.raises(MissingFile, match="7_run-NN"):
        logs.read_optiodom(tmp_path)


# Suspicions


def kinematic(maneuver, robot=ROBOT, noise=0.0):
    """A drive without physics, from commands that the robot follows exactly."""
    commands = maneuver(robot)
    angles = np.concatenate([[[0, 0]], np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    truth = dd.odometry.integrate(angles, robot, start=(1.0, -2.0, 0.7))
    truth = truth + noise * np.random.default_rng(4).standard_normal(truth.shape)
    return Drive(np.arange(len(angles)) * commands.period, angles, truth)


def eight(robot):
    return dd.maneuvers.figure_eight(robot)


def square(robot):
    return dd.maneuvers.square(robot, side=1.5, speed=0.4)


def faults(drive):
    """Drives with one fault each, by the words that must name it."""
    angles, truth, change = drive.wheel_angles, drive.truth, dataclasses.replace
    return {
        "left and right look swapped": change(drive, wheel_angles=angles[:, ::-1]),
        "left wheel looks reversed": change(drive, wheel_angles=angles * [-1, 1]),
        "right wheel looks reversed": change(drive, wheel_angles=angles * [1, -1]),
        "both wheels look reversed": change(drive, wheel_angles=-angles),
        "theta looks clockwise": change(drive, truth=truth * [1, 1, -1]),
        "theta looks clockwise and 9": change(drive, truth=truth * [1, 1, -1] + [0, 0, np.pi / 2]),
        "theta looks given in degrees": change(drive, truth=truth * [1, 1, 180 / np.pi]),
        "unit of x and y": change(drive, truth=truth * [1000, 1000, 1]),
        "and of the wheels": change(drive, wheel_angles=angles * 20),
        "is the time": change(drive, t=drive.t * 1000, truth_t=drive.clock * 1000),
    }


@pytest.mark.parametrize("maneuver", [square, eight])
@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_planted_faults_are_named(maneuver, noise):
    drive = kinematic(maneuver, noise=noise)
    assert diagnosis.suspicions(drive, ROBOT) == ()
    for words, faulty in faults(drive).items():
        (found,) = diagnosis.suspicions(faulty, ROBOT)
        assert words in found


@pytest.mark.parametrize("radius", [0.3, 1.0, -1.0])
def test_on_a_circle_too(radius):
    drive = kinematic(lambda robot: dd.maneuvers.arc(robot, radius=radius, distance=4.0, speed=0.5))
    for words, faulty in faults(drive).items():
        (found,) = diagnosis.suspicions(faulty, ROBOT)
        assert words in found


@pytest.mark.parametrize("angle", [-90, 20, 180])
def test_a_heading_that_is_off_by_a_constant(angle):
    drive = kinematic(square)
    off = dataclasses.replace(drive, truth=drive.truth + np.array([0, 0, np.radians(angle)]))
    (found,) = diagnosis.suspicions(off, ROBOT)
    assert f"theta looks {angle} deg off" in found.replace("-180", "180")


def test_smaller_and_larger_units():
    drive = kinematic(square)
    for factor in (1e-3, 1e-2, 1e2, 1e3):
        (found,) = diagnosis.suspicions(dataclasses.replace(drive, truth=drive.truth * [factor, factor, 1]), ROBOT)
        assert "drives" in found
        assert f"{factor:.0e}"[-2:] in found or f"{factor:g}" in found
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, t=drive.t / 1000, truth_t=drive.clock / 1000), ROBOT)
    assert "is the time in another unit" in found


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("at", [3.0, 8.0])
@pytest.mark.parametrize("believed", [ROBOT, ROBOT.replace(left_radius=0.055)], ids=["right", "wrong"])
def test_a_robot_that_is_pushed_or_carried(noise, at, believed):
    drive = kinematic(square, noise=noise)
    truth, after = drive.truth.copy(), drive.t >= at
    carried = dd.se2.compose(truth[after][0], [0.1, 0.15, 0.3])
    truth[after] = dd.se2.compose(carried, dd.se2.between(truth[after][0], truth[after]))
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, truth=truth), believed)
    assert "pushed or lifted" in found
    assert abs(float(found.split()[2]) - at) < 0.3


def test_a_robot_that_is_lifted_while_its_wheels_turn():
    drive = kinematic(square)
    turning = np.cumsum(np.where((drive.t > 4) & (drive.t < 5), np.gradient(drive.t) * 20, 0.0))
    (found,) = diagnosis.suspicions(
        dataclasses.replace(drive, wheel_angles=drive.wheel_angles + turning[:, None]), ROBOT
    )
    assert "pushed or lifted" in found
    assert abs(float(found.split()[2]) - 4.5) < 0.6


def test_clocks_that_are_not_one():
    drive = kinematic(square)
    (found,) = diagnosis.suspicions(
        Drive(drive.t, drive.wheel_angles, drive.truth[drive.t > 4], drive.t[drive.t > 4]), ROBOT
    )
    assert "% of the wheels' turning lies outside" in found
    late = Drive(drive.t, drive.wheel_angles, drive.truth, drive.t + 2)
    found = diagnosis.suspicions(late, ROBOT)
    assert "true poses lie outside the time of the wheels" in found[0]
    early = Drive(drive.t[drive.t < 9], drive.wheel_angles[drive.t < 9], drive.truth, drive.t)
    (found,) = diagnosis.suspicions(early, ROBOT)
    assert f"{early.dropped} of {len(drive.t)} true poses" in found


@pytest.mark.parametrize("believed", [{"left_radius": 0.055}, {"right_radius": 0.0455}, {"track_width": 0.35}])
@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize("maneuver", ["square", "figure_eight", "straight", "arc", "spin"])
def test_a_wrong_belief_is_no_suspicion(maneuver, believed, noise):
    make = {
        "square": square,
        "figure_eight": eight,
        "straight": lambda robot: dd.maneuvers.straight(robot, speed=0.5, distance=5),
        "arc": lambda robot: dd.maneuvers.arc(robot, radius=1.0, distance=5.0, speed=0.5),
        "spin": lambda robot: dd.maneuvers.spin(robot, turns=2.0),
    }[maneuver]
    assert diagnosis.suspicions(kinematic(make, noise=noise), ROBOT.replace(**believed)) == ()


@pytest.mark.parametrize("maneuver", [square, eight])
@pytest.mark.parametrize("rate", [100, 10, 1, 0.2])
def test_truth_taken_beside_the_axle_is_no_suspicion(maneuver, rate):
    drive = kinematic(maneuver)
    place = dd.se2.compose(drive.truth, [0.05, -0.02, 0.0])[:: int(100 / rate)]
    clock = drive.t[:: int(100 / rate)]
    for believed in (ROBOT, ROBOT.replace(left_radius=0.055), ROBOT.replace(track_width=0.33)):
        assert diagnosis.suspicions(Drive(drive.t, drive.wheel_angles, place, clock), believed) == ()


def test_simulated_drives_look_clean(simulated):
    for rate in (None, 20.0, 1.0):
        for drive in dd.sensors.measure(simulated, tracker=dd.Tracker(sample_rate=rate)):
            assert diagnosis.suspicions(drive, ROBOT) == ()


def test_drives_that_tell_nothing():
    still = Drive([0.0, 1, 2, 3], np.zeros((4, 2)), np.zeros((4, 3)))
    assert diagnosis.suspicions(still, ROBOT) == ()
    drive = kinematic(square)
    ends = Drive(drive.t, drive.wheel_angles, drive.truth[[0, -1]], drive.t[[0, -1]])
    assert diagnosis.suspicions(ends, ROBOT) == ()
    short = Drive([0.0, 0.1], np.zeros((2, 2)), np.zeros((2, 3)))
    assert diagnosis.suspicions(short, ROBOT) == ()


def test_errors_are_the_packages_own():
    with pytest.raises(InvalidValue):
        Columns(time=0)
