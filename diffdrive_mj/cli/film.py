"""`diffdrive film`: a film of the robot beside the ghost of where it believes it is, or a picture for a paper."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import own_files
from diffdrive_mj._text import quantity
from diffdrive_mj.cli._left_out import Name, Number, WorldName, floor
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot

if TYPE_CHECKING:
    from diffdrive_mj.recording import Recording
    from diffdrive_mj.report.filming.films import Film

# Where films go if nobody says; the folder is made.
_FOLDER = Path("results") / "film"
OutputFile = Annotated[Path | None, tyro.conf.arg(metavar="FILE")]


def command(
    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT", help_behavior_hint="(required)")],
    /,
    output: OutputFile = None,
    believed: Annotated[tuple[str, ...], tyro.conf.arg(metavar="[ROBOT ...]")] = (),
    maneuver: str = "square",
    camera: Name = None,
    strobe: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    times: Annotated[int | None, tyro.conf.arg(metavar="INT")] = None,
    still: Annotated[float | None, tyro.conf.arg(metavar="TIME")] = None,
    size: Annotated[tuple[int, int] | None, tyro.conf.arg(metavar="WIDTH HEIGHT")] = None,
    fps: Number = None,
    speed: Number = None,
    world: WorldName = None,
    friction: Number = None,
) -> None:
    """Film a robot beside the ghost of where its odometry believes it is.

      diffdrive film my_robot.toml

    The drive is simulated. Its commands are computed for the believed robot, so that the ghost drives what was meant
    and the robot what comes of it. If nobody says what is believed, odometry takes unequal wheels for equal; and of a
    robot with equal wheels the right one is 1 % smaller than its file says.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        robot: that is driven: the name of a preset, or a TOML file.
        output: the file, which replaces an earlier one: .webp, .mp4 (if ffmpeg is installed), or .png for a picture;
            if not given one in results/film.
        believed: what the odometry takes the robot for: presets or TOML files, a ghost each.
        maneuver: straight, square, figure_eight, spin or slalom, sized to the robot.
        camera: follow (if not given), above, oblique or both; with --strobe oblique (if not given) or above.
        strobe: draw the whole drive in one picture instead.
        times: how often the robot is seen with --strobe; 6 if not given.
        still: draw a single picture instead, at this time of the drive [s].
        size: width and height [pixel]; 640 480 if not given, with --strobe 1600 1000.
        fps: frames per second; 25 if not given.
        speed: seconds of the drive in a second of the film; 1 if not given.
        world: in which it drives: the name of a preset, or a TOML file; ideal if not given.
        friction: of the floor; that of the world if not given.

    Raises:
        DiffdriveError: bad input, or OpenGL cannot be used; nothing is written then.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["film", "ct_bot", "--maneuver", "squar"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    options: dict[str, Any] = {
        "camera": camera,
        "size": size,
        "fps": fps,
        "speed": speed,
        "times": times,
        "time": still,
    }
    given = {name: value for name, value in options.items() if value is not None}
    target = _target(output, strobe, still)
    _refuse_needless(given, strobe, target)
    from diffdrive_mj.report import filming
    from diffdrive_mj.report.filming import _choices

    commands_for = checks.one_of("maneuver", maneuver, _choices.DRIVES)
    true = Robot.load(robot)
    beliefs = {name: Robot.load(name) for name in believed}
    words = f"its odometry believes {', '.join(beliefs)}"
    if not beliefs:
        true, beliefs, words = _choices.usual_belief(true)
    place = floor(world, friction)
    if output is None:
        _take_place(target)
    from diffdrive_mj.physics.simulation import simulate  # loads MuJoCo

    recording = simulate(true, commands_for(next(iter(beliefs.values()))), world=place)
    made = (filming.strobe if strobe else filming.film)(recording, beliefs, target, **given)
    _say(recording, beliefs, words, maneuver, made)


def _target(output: Path | None, strobe: bool, still: float | None) -> Path:
    if strobe and still is not None:
        raise InvalidValue("--strobe and --still: must be one of them")
    if output is None:
        return _FOLDER / ("strobe.png" if strobe else "film.webp" if still is None else "still.png")
    if still is not None and output.suffix.lower() != ".png":
        raise InvalidValue(f"--output {output}: must end on .png beside --still")
    return output


def _refuse_needless(given: Iterable[str], strobe: bool, target: Path) -> None:
    """Options that would not be read."""
    needless: tuple[str, ...]
    if strobe:
        needless, why = ("fps", "speed"), "a strobe picture has no frames"
    elif target.suffix.lower() == ".png":
        needless, why = ("fps", "speed", "times"), "a single picture is of one time, --still"
    else:
        needless, why = ("times",), "it is for --strobe"
    for name in needless:
        if name in given:
            raise InvalidValue(f"--{name}: is not read here, {why}")


def _take_place(target: Path) -> None:
    """Make the folder of a file that nobody has named, and refuse what is there and is not a film of this command."""
    from diffdrive_mj.report.filming._encoders import MARK

    def own(folder: Path) -> set[str]:
        return {target.name} if target.exists() and MARK.encode() in target.read_bytes() else set()

    foreign = "was not written by this command: move it, or name another file (--output)"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        own_files(target.parent, [target.name], own, foreign)
    except OSError as error:
        raise InvalidValue(f"{target}: cannot be written ({error.strerror}); --output names another file") from None


def _say(recording: Recording, beliefs: dict[str, Robot], words: str, maneuver: str, made: Film) -> None:
    from diffdrive_mj.report.filming._captions import distance

    print(f"{recording.robot.name}: {words}")
    for name, belief in beliefs.items():
        drift = recording.drift(belief)
        after, off = quantity(float(drift.distance), "m"), distance(float(drift.final_position))
        turned = abs(math.degrees(float(drift.final_heading)))
        print(f"{maneuver}: after {after} {name} is {off} and {turned:.1f} degrees off")
    print(f"written: {shlex.quote(str(made.path))} ({str(made).removeprefix(f'{made.path}: ')})")
