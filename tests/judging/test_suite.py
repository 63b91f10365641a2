"""The suite: exact poses against an arithmetic of its own, files that hold all of it, and who passes."""

import json
import math
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from helpers import cos_sin, refused

import diffdrive_mj as dd
from diffdrive_mj.judging import suite
from diffdrive_mj.judging.candidates import poses_of
from diffdrive_mj.judging.causes import distance_between
from diffdrive_mj.judging.readings import counting, held
from diffdrive_mj.judging.right import Right

CASES = {case.name: case for case in suite.cases()}
FAULTY = ("zero_dt", "reversed_time", "nan", "nan_first")
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("suite") / "cases"
    suite.write(path)
    return path


def told(path):
    """The header and the rows of a file, in the words of the page that lies beside it."""
    header, columns, *rows = path.read_text().splitlines()
    assert header.startswith("# diffdrive 1 ")
    assert columns == "t,left,right,x,y,theta"
    return dict(pair.split("=") for pair in header.split(" ")[3:]), [row.split(",") for row in rows]


def decimal_poses(header, rows):
    """The poses by the page's rules in 60 digits, with sine and cosine by their Taylor series."""
    number = {name: Decimal(text) for name, text in header.items() if name != "unit"}
    # Numbers are what a float64 makes of their digits.
    number = {name: Decimal(float(value)) for name, value in number.items()}
    tick = 2 * PI / number["ticks_per_revolution"] if header["unit"] == "ticks" else Decimal(1)
    x, y, theta, last = number["x"], number["y"], number["theta"], None
    for t, left, right, *_ in rows:
        now = [float(cell) for cell in (t, left, right)]
        if all(map(math.isfinite, now)) and (last is None or now[0] > last[0]):
            if last is not None:
                rims = []
                for k, radius in ((1, number["left_radius"]), (2, number["right_radius"])):
                    step = Decimal(now[k]) - Decimal(last[k])
                    if "counter_bits" in header:
                        whole = Decimal(2 ** int(header["counter_bits"]))
                        step -= whole * ((step + whole / 2) / whole).to_integral_value("ROUND_FLOOR")
                    rims.append(radius * tick * step)
                turn = (rims[1] - rims[0]) / number["track_width"]
                chord = sum(rims) / 2
                if turn:
                    chord *= cos_sin(turn / 2)[1] / (turn / 2)
                cosine, sine = cos_sin(theta + turn / 2)
                x, y, theta = x + chord * cosine, y + chord * sine, theta + turn
            last = now
        yield x, y, theta


@pytest.mark.parametrize("name", CASES)
def test_expected_poses_are_exact_to_1e_15_of_distance_or_coordinate(name, folder):
    header, rows = told(folder / f"{name}.csv")
    rows = rows[:: len(rows) // 400 + 1] if "counter_bits" not in header else rows  # what is left out is missing
    if len(rows) < len(CASES[name].t):
        of = CASES[name]
        step = len(of.t) // 400 + 1
        thinned = suite.exact_case("thinned", "", of.robot, of.t[::step], of.readings[::step], of.start)
        rows = [[*row[:3], *map(repr, pose)] for row, pose in zip(rows, thinned.poses.tolist(), strict=True)]
    with localcontext(prec=60):
        driven, before = 0.0, None
        for row, exact in zip(rows, decimal_poses(header, rows), strict=True):
            pose = [Decimal(float(cell)) for cell in row[3:]]
            driven += (
                0.0 if before is None else math.hypot(*(float(a - b) for a, b in zip(exact[:2], before, strict=True)))
            )
            before = exact[:2]
            allowed = Decimal("1e-15") * max(Decimal(driven), *map(abs, exact))
            assert all(abs(is_ - should) <= allowed for is_, should in zip(pose, exact, strict=True))


def test_circles_straights_and_spins_end_where_closed_forms_say():
    """Headings are linear in the wheels; places lie on a circle, on a line, at rest, about a wheel."""
    for name in ("turn_left", "turn_right"):
        case = CASES[name]
        left, right = (case.readings[-1] * case.radii).tolist()
        turn = (right - left) / case.robot.track_width
        radius = (left + right) / 2 / turn
        x, y, theta = case.start
        center = (x - radius * math.sin(theta), y + radius * math.cos(theta))
        distances = np.hypot(*(case.poses[:, :2] - center).T)
        # Wheels that are rounded to a millionth of a radian do not drive quite a circle.
        assert distances == pytest.approx(abs(radius), abs=1e-6)
        assert case.poses[-1, 2] == pytest.approx(theta + turn, abs=1e-13)
        assert abs(turn) > 6 * math.pi
    straight = CASES["straight"]
    ahead = straight.start[:2] + np.outer(straight.readings[:, 0] * 0.033, (math.cos(0.5), math.sin(0.5)))
    assert straight.poses[:, :2] == pytest.approx(ahead, abs=1e-15)
    assert (straight.poses[:, 2] == 0.5).all()
    assert CASES["spin"].poses[:, :2] == pytest.approx(np.tile((2.0, -1.0), (241, 1)), abs=1e-6)
    assert np.ptp(CASES["spin"].poses[:, 2]) > 4 * math.pi
    pivot = CASES["pivot"]
    left_wheel = pivot.poses[:, :2] + 0.0815 * np.stack(
        [-np.sin(pivot.poses[:, 2]), np.cos(pivot.poses[:, 2])], axis=-1
    )
    assert np.ptp(left_wheel[:60], axis=0).max() < 1e-6


def test_the_cases_are_what_their_names_say():
    assert 25 <= len(CASES) <= 35
    steps = np.abs(np.diff(CASES["steps"].poses[:, 2]))
    assert steps.min() == pytest.approx(1e-12, rel=0.01)
    assert steps.max() == pytest.approx(1.0)
    for name, period in (("one_hertz", 1.0), ("ten_hertz", 0.1), ("kilohertz", 1e-3)):
        assert np.diff(CASES[name].t) == pytest.approx(period)
    hours = CASES["ten_hours"]
    assert (len(hours.t), hours.t[0]) == (3000, 36000.0)
    assert np.ptp(hours.t) == pytest.approx(36000, rel=1e-3)
    assert np.hypot(*hours.poses[0, :2]) == 10_000
    assert hours.rolled > 15_000
    for name, case in CASES.items():
        if name.startswith(("wrap", "near_wrap")):
            jumps = np.abs(np.diff(case.readings, axis=0)) > 2.0 ** (case.bits - 1)
            assert jumps.any(axis=0).all(), name
    turned = np.abs(np.diff(CASES["wrap_16_fast"].wheel_angles, axis=0)).max() / CASES["wrap_16_fast"].unit_angle
    assert 30_000 < turned < 2**15
    for name, wrapped in (("turn_left", 1), ("turn_right", -1), ("across_180", 0)):
        crossed = np.diff(np.sign(np.sin(CASES[name].poses[:, 2])))[np.cos(CASES[name].poses[1:, 2]) < 0]
        assert np.count_nonzero(crossed) >= 3
        assert {*np.sign(crossed).tolist()} - {0.0} == ({-wrapped} if wrapped else {-1, 1})
        assert case.counting.all() == (name not in FAULTY), name
        assert case.start.any()


def test_readings_that_do_not_count_hold_the_pose():
    for name in FAULTY:
        case = CASES[name]
        (held_at,) = np.nonzero(~case.counting)
        assert len(held_at) >= 3
        for k in held_at:
            assert np.array_equal(case.poses[k], case.poses[max(k - 1, 0)])
    assert np.array_equal(CASES["nan_first"].poses[:4], np.tile(CASES["nan_first"].start, (4, 1)))


def in_single(wheel_angles, t, robot, start):
    """A right arc whose sums are in single precision."""
    counts = counting(t, wheel_angles)
    pose = np.array(start, dtype=np.float32)
    answers = [pose]
    for left, right in np.diff(wheel_angles[counts], axis=0):
        dl, dr = robot.left_radius * left, robot.right_radius * right
        half = (dr - dl) / robot.track_width / 2
        chord = (dl + dr) / 2 * (math.sin(half) / half if half else 1.0)
        step = (chord * math.cos(pose[2] + half), chord * math.sin(pose[2] + half), 2 * half)
        pose = pose + np.array(step, dtype=np.float32)
        answers.append(pose)
    return held(np.array(answers, dtype=np.float64), counts)


def by(method):
    def mine(wheel_angles, t, robot, start):
        counts = counting(t, wheel_angles)
        return held(dd.odometry.integrate(wheel_angles[counts], robot, method, start), counts)

    return mine


class Streamed:
    """The package's own odometer, which is told what counts."""

    def __init__(self, robot, start):
        self.odometer, self.last = dd.odometry.Odometer(robot, start=start), -math.inf

    def update(self, wheels, t):
        if all(map(math.isfinite, (*wheels, t))) and t > self.last:
            self.odometer.update(wheels)
            self.last = t
        return tuple(self.odometer.pose)


@pytest.mark.parametrize("candidate", [by("arc"), Streamed, Right], ids=["function", "class", "class with a header"])
def test_right_odometry_passes_all_of_it(candidate):
    verdict = dd.judge(candidate, CASES.values())
    assert verdict.holds, verdict
    assert all(row.reason == "" for row in verdict.rows)
    # Far below the tolerance, so that other compilers and libraries pass too.
    assert max(row.arithmetic / row.allowed for row in verdict.rows) < 0.1


def test_a_robot_of_the_right_numbers_passes_and_another_does_not():
    for case in CASES.values():
        for robot, right in (
            (case.robot, True),
            (case.robot.replace(left_radius=0.99 * case.robot.left_radius), False),
        ):
            off = distance_between(case, poses_of(robot, case), case.expected)
            assert (off <= case.allowed) == (right or case.name == "standstill")


def test_wpilibs_arc_passes_where_every_reading_counts():
    geometry, kinematics = pytest.importorskip("wpimath.geometry"), pytest.importorskip("wpimath.kinematics")

    class Wpilib:
        def __init__(self, robot, start):
            x, y, theta = map(float, start)
            self.pose = geometry.Pose2d(x, y, geometry.Rotation2d(theta))
            self.kinematics = kinematics.DifferentialDriveKinematics(robot.track_width)
            self.robot, self.last = robot, None

        def update(self, wheels, t):
            rims = wheels[0] * self.robot.left_radius, wheels[1] * self.robot.right_radius
            last = self.last or rims
            twist = self.kinematics.toTwist2d(rims[0] - last[0], rims[1] - last[1])
            self.pose = self.pose.exp(twist) if hasattr(self.pose, "exp") else self.pose + twist.exp()
            self.last = rims
            return self.pose.X(), self.pose.Y(), self.pose.rotation().radians()

    verdict = dd.judge(Wpilib, [case for case in CASES.values() if case.name not in FAULTY])
    assert verdict.holds, verdict


@pytest.mark.parametrize(
    ("wrong", "passes"),
    [
        (in_single, {"straight", "standstill"}),
        (by("euler"), {"straight", "unequal_straight", "standstill"}),
        (by("midpoint"), {"straight", "unequal_straight", "standstill"}),
    ],
    ids=["single precision", "Euler", "midpoint"],
)
def test_what_is_wrong_fails_wherever_it_can_show(wrong, passes):
    off = {
        name: distance_between(case, poses_of(wrong, case), case.poses) / case.tolerance for name, case in CASES.items()
    }
    assert {name for name, ratio in off.items() if ratio <= 1} <= passes
    # By far: rounding would not do it. On the spot only the rounding of the wheels moves the robot.
    assert min(ratio for name, ratio in off.items() if name not in {*passes, "spin"}) > 10, off


def test_tolerances_are_far_above_rounding_and_far_below_mistakes():
    """Twice the largest sum of roundings; never above 1e-9 m per metre but where steps turn by 1e-8."""
    for case in CASES.values():
        assert case.tolerance > 10 * distance_between(case, case.odometry(case.robot), case.poses)
        assert case.tolerance < 2e-9 * max(case.rolled, 1.5), case.name
        assert len(f"{case.tolerance:.15g}".split("e")[0].replace(".", "").strip("0")) <= 2


def test_what_is_written_is_read(folder):
    index = json.loads((folder / "index.json").read_text())
    assert [entry["name"] for entry in index["cases"]] == list(CASES)
    assert {path.name for path in folder.iterdir()} == set(index["files"])
    for entry in index["cases"]:
        case, again = CASES[entry["name"]], suite.read(folder / entry["file"])
        assert (entry["readings"], entry["about"]) == (len(case.t), case.about)
        assert entry["tolerance"] == case.tolerance
        assert list(again.rows()) == list(case.rows())
        assert np.array_equal(again.wheel_angles, case.wheel_angles, equal_nan=True)
        assert again.poses.tobytes() == case.poses.tobytes()
    assert dd.judge(Right, map(suite.read, sorted(folder.glob("*.csv")))).holds


def test_a_program_over_the_pipe_gets_what_the_files_hold(folder):
    for name in ("wrap_16_fast", "nan", "straight"):
        header, _, *rows = (folder / f"{name}.csv").read_text().splitlines()
        for unit in ("rad", "ticks"):
            assert list(CASES[name].lines(unit)) == [header, *(row.rsplit(",", 3)[0] for row in rows)]


def test_its_own_files_are_replaced_and_no_others(tmp_path):
    folder = tmp_path / "cases"
    suite.write(folder)
    others = [folder / "mine.csv", tmp_path / "mine.csv", folder / "mine.txt"]
    for path in others:
        path.write_text("mine")
    index = json.loads((folder / "index.json").read_text())
    (folder / "former.csv").write_text("of a former suite")
    (folder / "straight.csv").write_text("broken")
    more = [*index["files"], "former.csv", "../mine.csv", "mine.txt"]  # no names that it would have written
    (folder / "index.json").write_text(json.dumps({**index, "files": more}))
    suite.write(str(folder))
    assert [path.read_text() for path in others] == ["mine"] * 3
    assert not (folder / "former.csv").exists()
    assert suite.read(folder / "straight.csv").name == "straight"
    assert json.loads((folder / "index.json").read_text()) == index


@pytest.mark.parametrize("name", ["index.json", "README.md", "nan.csv"])
def test_a_file_that_is_not_its_own_is_never_replaced(name, tmp_path):
    (tmp_path / name).write_text('{"what": "mine", "files": ["nan.csv", "README.md"]}')
    with refused(ValueError, f"{tmp_path / name}: was not written by diffdrive suite"):
        suite.write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with refused(ValueError, "file: cannot be written"):
        suite.write(tmp_path / "file")
    with refused(TypeError, "folder = 3"):
        suite.write(3)


GOOD = (
    "# diffdrive 1 unit=rad left_radius=0.1 right_radius=0.1 track_width=0.4 ticks_per_revolution=100 x=0 y=0 theta=0 "
)
BROKEN = {
    "": "line 1: must begin with '# diffdrive 1'",
    "# diffdrive 2 unit=rad": "line 1: must begin with '# diffdrive 1'",
    GOOD: "line 1: tolerance is missing",
    GOOD + "tolerance=1e-9\nt,left,right": "line 2: must name the columns, t,left,right,x,y,theta",
    GOOD + "tolerance=1e-9\nt,left,right,x,y,theta": "a header and nothing below it",
    GOOD + "tolerance=1e-9\nt,left,right,x,y,theta\n0,0,0,0,0": "line 3: must be t,left,right,x,y,theta, six numbers",
    GOOD + "tolerance=1e-9\nt,left,right,x,y,theta\n0,0,0,0,0,0\n1,1,1,NaN,0,0": "line 4: must be",
    GOOD + "tolerance=1e-9\nt,left,right,x,y,theta\n0,0,zero,0,0,0": "line 3: must be",
    GOOD + "tolerance=small\nt,left,right,x,y,theta\n0,0,0,0,0,0": "line 1: tolerance=small: must be a number",
    GOOD.replace("rad", "deg", 1) + "tolerance=1\nt,left,right,x,y,theta\n0,0,0,0,0,0": "unit=deg: must be rad",
    GOOD + "tolerance=1e-9\nt,left,right,x,y,theta\nNaN,0,0,0,0,0": "no reading has a time and both wheels",
    GOOD + "tolerance=-1\nt,left,right,x,y,theta\n0,0,0,0,0,0": "tolerance = -1.0: must be positive",
    GOOD + "counter_bits=1 tolerance=1\nt,left,right,x,y,theta\n0,0,0,0,0,0": "counter_bits=1: must be 2 to 53",
}  # fmt: skip


@pytest.mark.parametrize("text", BROKEN)
def test_broken_files_are_refused_with_their_line(text, tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with refused(ValueError, str(path), BROKEN[text]):
        suite.read(path)


def test_files_that_are_not_there_or_no_text(tmp_path):
    with refused(FileNotFoundError, "nowhere.csv: no such file"):
        suite.read(tmp_path / "nowhere.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with refused(ValueError, "binary.csv: cannot be read (not a text file in UTF-8)"):
        suite.read(Path(tmp_path / "binary.csv"))
    with refused(ValueError, "cannot be read"):
        suite.read(tmp_path)


@pytest.mark.parametrize("bits", [2, 53])
def test_a_file_is_taken_by_its_word(bits, tmp_path):
    """Also for poses that its readings do not lead to, and for the narrowest and the widest counters."""
    path = tmp_path / "mine.csv"
    header = GOOD.replace("rad", "ticks", 1) + f"counter_bits={bits} tolerance=0.5"
    path.write_text(f"{header}\nt,left,right,x,y,theta\n0,0,0,1,2,3\n1,1,1,4,5,6\n")
    case = suite.read(path)
    assert case.poses.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert (case.bits, case.tolerance) == (bits, 0.5)
