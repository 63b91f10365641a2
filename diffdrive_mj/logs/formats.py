"""One `read` and one `write` for all formats, by a file's ending and its content.

A new format is a new file with a `FORMAT` in it, and its name in `FORMATS`.
"""

from __future__ import annotations

from pathlib import Path

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import as_path
from diffdrive_mj._text import a, listed, shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue, MissingFile
from diffdrive_mj.logs import csv, rosbag, tum, wpilog
from diffdrive_mj.logs._format import Contents, Format, Wheels
from diffdrive_mj.logs.csv import Columns
from diffdrive_mj.logs.topics import Topics
from diffdrive_mj.logs.wpilog import Entries
from diffdrive_mj.pose_log import PoseLog, poses_of
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot

# Those whose content is easily told come before those that any text may be.
FORMATS: tuple[Format, ...] = (rosbag.FOLDER, rosbag.MCAP, rosbag.SQLITE, wpilog.FORMAT, tum.FORMAT, csv.FORMAT)

Options = Columns | Topics | Entries

# By its first bytes, what is no log, and what makes one of it.
_FOREIGN = {
    b"#ROSBAG V": "a ROS 1 bag: rosbags-convert makes a ROS 2 bag of it",
    b"PK\x03\x04": "a ZIP archive or a spreadsheet: unpack it, or export it as CSV",
    b"\x1f\x8b": "a file compressed by gzip: unpack it first",
    b"\x28\xb5\x2f\xfd": "a file compressed by zstd: unpack it first",
    b"\xff\xfe": "a text in UTF-16: save it in UTF-8",
    b"\xfe\xff": "a text in UTF-16: save it in UTF-8",
    b"\x89HDF": "an HDF5 file: export it as CSV",
    b"PAR1": "a Parquet file: export it as CSV",
    b"{": "JSON: export it as CSV",
    b"[": "JSON: export it as CSV",
    b"<": "HTML or XML: export it as CSV",
}
_HEAD = 4096


def read(
    path: str | Path,
    options: Options | None = None,
    *,
    robot: Robot | None = None,
    truth: PoseLog | str | Path | None = None,
) -> Drive:
    r"""Read the drive in a log: its wheels, and its true poses.

    Args:
        path: of a CSV file, a rosbag2 folder, a `.mcap`, a `.db3` or a `.wpilog`.
        options: what in the log is what: `Columns`, `Topics` or `Entries`, by the format; defaults where not given.
        robot: whose encoder's ticks, or whose radii in metres, the wheels' numbers are of.
        truth: the true poses, or their own log, if they are not in this one; on the same clock.

    Returns:
        The drive, named after the log; what to know of its clocks is in its warnings.

    Raises:
        InvalidType: not a path, options of another format, not a robot.
        MissingFile: no such file.
        MissingExtra: the format needs a package that is not installed; the message has the command.
        UnknownName: a column, a topic or an entry that the log does not have.
        InvalidValue: anything else that is wrong with the log; the message says where.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     log, tracked = Path(folder, "log.csv"), Path(folder, "mocap.tum")
        ...     size = log.write_text("t,left,right\n0,0,0\n1,0.5,0.5\n2,1,1\n")
        ...     size = tracked.write_text("0.5 0 0 0 0 0 0 1\n1.5 0.1 0 0 0 0 0 1\n")
        ...     drive = dd.logs.read(log, dd.logs.Columns(wheel_unit="rotations"), truth=tracked)
        >>> drive.wheel_angles[-1].round(4).tolist(), drive.clock.tolist()
        ([6.2832, 6.2832], [0.5, 1.5])
    """
    if isinstance(truth, (str, Path)):
        truth = read_poses(truth)
    if truth is not None:
        checks.instance("truth", truth, PoseLog)
    path, contents = _loaded(path, options, robot, wheels=True, poses=truth is None)
    return Contents(contents.wheels, truth or contents.poses).drive(str(path))


def read_poses(path: str | Path, options: Options | None = None) -> PoseLog:
    r"""Read the poses in a log: an estimate, or the truth.

    Args:
        path: of a CSV or TUM file, a rosbag2 folder, a `.mcap`, a `.db3` or a `.wpilog`.
        options: what in the log is what: `Columns`, `Topics` or `Entries`, by the format; defaults where not given.

    Returns:
        The poses on their clock, named after the log; what to know of them is in their warnings.

    Raises:
        InvalidType: not a path, options of another format.
        MissingFile: no such file.
        MissingExtra: the format needs a package that is not installed; the message has the command.
        UnknownName: a column, a topic or an entry that the log does not have.
        InvalidValue: anything else that is wrong with the log; the message says where.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     path = Path(folder, "odom.tum")
        ...     size = path.write_text("0 0 0 0 0 0 0 1\n1 0.5 0 0 0 0 1 0\n")
        ...     dd.logs.read_poses(path).poses.round(4).tolist()
        [[0.0, 0.0, 0.0], [0.5, 0.0, 3.1416]]
    """
    _, contents = _loaded(path, options, None, wheels=False, poses=True)
    assert contents.poses is not None
    return contents.poses


def write(path: str | Path, log: Drive | Recording | PoseLog, options: Topics | None = None) -> None:
    """Write a drive, a recording or poses, whole or not at all, in the format that the ending says.

    TUM files have no room for wheels: of a drive and a recording they get the true poses. Bags have whole nanoseconds;
    they alone have room for the covariance of poses, which files of text leave out.

    Args:
        path: `.csv`, `.tum`, `.mcap` or `.db3`, whose earlier file is replaced; a new folder, without an ending, for a
            rosbag2 folder.
        log: to be written; of a recording with many runs one of its `runs`.
        options: names of topics, joints and frames in a bag.

    Raises:
        InvalidType: not a path, something else than a log, options of another format.
        MissingExtra: the format needs a package that is not installed; the message has the command.
        InvalidValue: an ending that is not known, times that the format cannot hold, or a file that cannot be written.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> poses = dd.PoseLog([0.0, 0.1], [(0.0, 0.0, 0.0), (0.1, 0.0, 0.2)])
        >>> with TemporaryDirectory() as folder:
        ...     dd.logs.write(Path(folder, "mine.csv"), poses)
        ...     print(Path(folder, "mine.csv").read_text(), end="")
        t,x,y,theta
        0.0,0.0,0.0,0.0
        0.1,0.1,0.0,0.2
    """
    path, contents, chosen = as_path("path", path), _contents(log), to_write(path)
    if options is not None and (chosen.options is not Topics or not isinstance(options, Topics)):
        cure = "must be a Topics" if chosen.options is Topics else f"{chosen.name} is written without options"
        raise InvalidType(f"options = {shown(options)}: {cure}")
    assert chosen.save is not None
    chosen.save(path, contents, options)


def to_write(path: str | Path) -> Format:
    """Say in which format `write` writes a log; who asks before a long computation is refused before it.

    Args:
        path: of the log.

    Raises:
        InvalidType: not a path.
        InvalidValue: an ending that is not known, or no folder for the log.

    Example:
        >>> to_write("mine.csv").name
        'a CSV file'
    """
    path = as_path("path", path)
    chosen = next((kind for kind in FORMATS if path.suffix.lower() == kind.endings[0]), None)
    if chosen is None or chosen.save is None:
        why = f"{chosen.name} is read and not written" if chosen else f"unknown ending {shown(path.suffix)}"
        raise InvalidValue(f"{path}: {why}; {_written_endings()}")
    if not path.parent.is_dir():
        raise InvalidValue(f"{path}: cannot be written (No such file or directory)")
    return chosen


def _contents(log: Drive | Recording | PoseLog) -> Contents:
    """What of a log can be written."""
    wheels = Wheels(log.t, log.wheel_angles) if isinstance(log, (Drive, Recording)) else None
    return Contents(wheels, poses_of("log", log))


def _loaded(path: str | Path, options: object, robot: Robot | None, wheels: bool, poses: bool) -> tuple[Path, Contents]:
    path = as_path("path", path)
    if robot is not None:
        checks.instance("robot", robot, Robot)
    if options is not None:
        checks.instance("options", options, Columns, Topics, Entries)
    chosen = _format_of(path, options)
    return path, chosen.load(path, options, robot, wheels, poses)


def _format_of(path: Path, options: object) -> Format:
    """The format of a file that is there.

    Raises:
        MissingFile, InvalidValue, InvalidType: as `read` says.
    """
    if not path.exists():
        raise MissingFile(f"{path}: no such file")
    suffix = "" if path.is_dir() else path.suffix.lower()
    by_ending = [kind for kind in FORMATS if suffix in kind.endings]
    try:
        head = _head(path)
        alike = [kind for kind in by_ending if kind.looks(path, head)]
    except OSError as error:
        raise InvalidValue(f"{path}: cannot be read ({error.strerror})") from None
    if not alike:
        if path.is_dir():
            raise InvalidValue(f"{path}: a folder without metadata.yaml: a rosbag2 folder has one")
        raise InvalidValue(f"{path}: {_mismatch(suffix, by_ending, path, head)}")
    fit = [kind for kind in alike if options is None or kind.options is type(options)]
    if not fit:
        takes = alike[0].options
        wanted = f"takes {takes.__name__}" if takes else "takes none"
        raise InvalidType(f"options = {a(type(options).__name__)}: {path} is {alike[0].name}, which {wanted}")
    return fit[0]


def _head(path: Path) -> bytes:
    """The beginning of a file; nothing of a folder."""
    if path.is_dir():
        return b""
    with path.open("rb") as file:
        return file.read(_HEAD)


def _mismatch(suffix: str, by_ending: list[Format], path: Path, head: bytes) -> str:
    """What is wrong with a file whose content is not what its ending says, or whose ending says nothing."""
    if not head:
        return "the file is empty"
    foreign = next((what for mark, what in _FOREIGN.items() if head.startswith(mark)), None)
    like = next((kind for kind in FORMATS if kind.looks(path, head)), None)
    unknown = "no log that is known" if b"\0" in head else "a text in another encoding: save it in UTF-8"
    looks = foreign or (f"{like.name}: name it {like.endings[0]}" if like else unknown)
    if not suffix:
        return f"it has no ending, and looks like {looks}; {_endings()}"
    if not by_ending:
        return f"unknown ending {shown(suffix)}, and it looks like {looks}; {_endings()}"
    return f"the ending is that of {by_ending[0].name}, but it looks like {looks}"


def _endings() -> str:
    known = dict.fromkeys(ending for kind in FORMATS for ending in kind.endings if ending)
    return f"logs end in {listed(list(known))}, and rosbag2 folders in nothing"


def _written_endings() -> str:
    known = [kind.endings[0] for kind in FORMATS if kind.save is not None]
    return f"logs are written to {listed(list(filter(None, known)))}, and to rosbag2 folders without an ending"
