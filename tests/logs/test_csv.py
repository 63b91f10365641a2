"""CSV files: every cell where it belongs, every bad file refused by line and column, written and read bit for bit."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj._files import write_whole
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
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


def test_other_things_than_drives_columns_and_robots(written, tmp_path):
    simulated = dd.simulate(ROBOT, dd.maneuvers.straight(ROBOT, distance=0.05, speed=0.1))
    with refused(TypeError, "drive = a Recording: must be a Drive; sensors.measure(recording) makes drives of it"):
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


def test_counts_that_do_not_fit_are_named_past_rows_without_wheels(written):
    text = "t,left,right,x,y,theta\n0,0,0,0,0,0\n0.1,,,0,0,0\n0.2,,,0,0,0\n0.3,1,70000,0,0,0\n"
    with refused(ValueError, "line 5, column 3 (right): 70000 does not fit in 16 bits"):
        written(text, ROBOT, wheel_unit="ticks", counter_bits=16)


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
        ({"wheel_unit": "grad"}, ValueError),
        ({"time_unit": "min"}, ValueError),
        ({"position_unit": "km"}, ValueError),
        ({"angle_unit": "grad"}, ValueError),
        ({"ticks_per_revolution": 0, "wheel_unit": "ticks"}, ValueError),
        ({"ticks_per_revolution": 100}, ValueError),
        ({"counter_bits": 8, "wheel_unit": "ticks"}, ValueError),
        ({"counter_bits": 16}, ValueError),
        ({"counter_bits": 16, "wheel_unit": "ticks", "wheels": "increments"}, ValueError),
        ({"reverse_left": "False"}, TypeError),
        ({"reverse_right": 1}, TypeError),
        ({"header": "no"}, TypeError),
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
    rows = int(rng.integers(1, 30))
    t = np.cumsum(rng.random(20) + 1e-9)
    clock = np.sort(rng.uniform(t[0], t[-1], 7)) if own_clock else t
    truth = rng.standard_normal((len(clock), 3)) * [1e-12, 1e9, np.pi]
    drive = Drive(t, rng.standard_normal((20, 2)) * 1e5, truth, clock)
    path = tmp_path_factory.mktemp("round") / "log.csv"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("diffdrive_mj.logs.csv._ROWS", rows)
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


def test_errors_are_the_packages_own():
    with pytest.raises(InvalidValue):
        Columns(time=0)
