"""Tables in blocks: however a file is cut, the same numbers and the same lines in messages, in little memory."""

import io
import itertools
import tracemalloc

import numpy as np
import pytest
from helpers import refused
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj import _progress, logs
from diffdrive_mj.logs import _rows
from diffdrive_mj.logs._table import open_table

NUMBERS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-(10**6), 10**6).map(str),
    st.sampled_from(["+1", "-0", ".5", "5.", "1E3", "007", "1e-400"]),
)
DRESSED = st.sampled_from(["{}", "{}", "{}", " {}", "{}\t", '"{}"', ' "{}" '])
BETWEEN = st.sampled_from(["", "", "", "\n", "# a comment, of course\n", "  # another\n", " \t\n"])
FAULTS = ["x", "1_0", "\u0663", "nan", "inf", "-Infinity", "1e999", "1,5", "0x10", "1 2", '"1"2"', "--1"]


@st.composite
def tables(draw):
    """Rows of three cells, of which the last two may be empty together, and lines between the rows."""
    count = draw(st.integers(1, 12))
    dress = [draw(DRESSED) for _ in range(3)]
    rows = []
    for _ in range(count):
        empty = draw(st.booleans())
        cells = [draw(NUMBERS)] + (["", ""] if empty else [draw(NUMBERS), draw(NUMBERS)])
        rows.append([look.format(cell) for look, cell in zip(dress, cells, strict=True)])
    return rows, [draw(BETWEEN) for _ in range(count)]


def text_of(rows, between, end="\n"):
    return "".join(gap + ";".join(row) + "\n" for gap, row in zip(between, rows, strict=True)).replace("\n", end)


def read(path, block):
    """The numbers of a table, in blocks of at least some characters."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_rows, "_BLOCK", block)
        with open_table(path, ";", header=False) as table:
            return table.read((0,), (1, 2))


def plain(cell):
    return cell.strip().strip('"').strip()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(table=tables(), block=st.integers(1, 200), end=st.sampled_from(["\n", "\r\n"]))
def test_numbers_do_not_depend_on_the_blocks(tmp_path, table, block, end):
    rows, between = table
    path = tmp_path / "table.csv"
    path.write_bytes(text_of(rows, between, end).encode())
    (first, all_there), (pairs, there) = read(path, block)
    assert all_there.all()
    np.testing.assert_array_equal(first[:, 0], [float(plain(row[0])) for row in rows])
    np.testing.assert_array_equal(there, [bool(plain(row[1])) for row in rows])
    expected = [[float(plain(cell)) for cell in row[1:]] for row in rows if plain(row[1])]
    np.testing.assert_array_equal(pairs, np.reshape(expected, (-1, 2)))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("fault", [*FAULTS, "", "short"])
@given(table=tables(), block=st.integers(1, 200), data=st.data())
def test_a_fault_is_named_by_line_and_column_wherever_it_is(tmp_path, table, block, fault, data):
    rows, between = table
    row, column = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, 2))
    other_is_empty = column > 0 and not plain(rows[row][3 - column])
    words = [f"column {column + 1}: {plain(fault)!r}"]
    if fault == "short":
        assume(row > 0)  # the first row says how many there are
        words = ["2 cells where line", "has 3"]
        rows[row].pop()
    else:
        rows[row][column] = fault
        if other_is_empty:
            words = [f"column {4 - column}: the cell is empty, column {column + 1} is not"]
        if not fault:
            assume(column > 0 and not other_is_empty)
            words = [f"column {column + 1}: the cell is empty, column {4 - column} is not"]
    path = tmp_path / "table.csv"
    path.write_text(text_of(rows, between), encoding="utf-8")
    line = row + 1 + sum(gap.count("\n") for gap in between[: row + 1])
    with refused(ValueError, f"{path}, line {line}", *words):
        read(path, block)


@pytest.mark.parametrize("block", [1, 7, 40, 1000])
def test_the_head_may_be_longer_than_a_block(tmp_path, monkeypatch, block):
    monkeypatch.setattr(_rows, "_BLOCK", block)
    path = tmp_path / "table.csv"
    path.write_text("\n# first\n\n# t,left\n\n0,1\n1,2\n")
    with open_table(path) as table:
        assert table.names == ("t", "left")
        assert [list(group[0][:, 0]) for group in table.read((0,), (1,))] == [[0, 1], [1, 2]]
    path.write_text("# nothing\n" * 5 + "t,left\n" + "# more\n" * 5 + "0,1\n1,x\n")
    with open_table(path) as table, refused(ValueError, "line 13, column 2 (left): 'x' is not a number"):
        table.read((0,), (1,))


def test_a_line_without_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(_rows, "_LONGEST", 1000)
    path = tmp_path / "table.csv"
    path.write_text("0," * 2000)
    with refused(ValueError, path, "a line of more than 1000 characters"), open_table(path):
        pass


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("ticks", [False, True])
def test_memory_is_a_few_times_that_of_the_arrays(tmp_path, monkeypatch, sparse, ticks):
    monkeypatch.setattr(_rows, "_BLOCK", 1 << 12)
    count = 20_000
    rng = np.random.default_rng(0)
    wheels = np.cumsum(rng.integers(0, 300, (count, 2)), axis=0) % 65536
    poses = np.cumsum(rng.normal(0, 0.01, (count, 3)), axis=0).tolist()
    path = tmp_path / "log.csv"
    with path.open("w") as file:
        print("t,left,right,x,y,theta", file=file)
        for k, (pair, pose) in enumerate(zip(wheels.tolist(), poses, strict=True)):
            print(0.01 * k, *pair, *([""] * 3 if sparse and k % 100 else pose), sep=",", file=file)
    columns = dd.logs.Columns(wheel_unit="ticks", counter_bits=16) if ticks else dd.logs.Columns()
    robot = dd.Robot.load("matched")
    logs.read_csv(path, columns, robot)  # what is loaded when first used
    tracemalloc.start()
    try:
        drive = logs.read_csv(path, columns, robot)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    arrays = sum(value.nbytes for value in (drive.t, drive.wheel_angles, drive.truth, drive.clock))
    assert peak < 5 * arrays


class Screen(io.StringIO):
    """What a person sees, or a program."""

    def __init__(self, terminal):
        super().__init__()
        self._terminal = terminal

    def isatty(self):
        return self._terminal


@pytest.mark.parametrize(("terminal", "slow"), list(itertools.product([True, False], repeat=2)))
def test_progress_of_what_takes_long_is_shown_to_people(tmp_path, monkeypatch, terminal, slow):
    path = tmp_path / "log.csv"
    path.write_text("t,left,right,x,y,theta\n" + "".join(f"{k},{k},{k},{k},0,0\n" for k in range(9)))
    monkeypatch.setattr(_rows, "_BLOCK", 20)
    monkeypatch.setattr("sys.stderr", screen := Screen(terminal))
    if slow:
        monkeypatch.setattr(_progress, "DELAY", 0.0)
    logs.read_csv(path)
    assert ("reading log.csv" in screen.getvalue()) == (terminal and slow)
    assert (f"/{path.stat().st_size} " in screen.getvalue()) == (terminal and slow)
