"""One family of errors, each also the builtin that a caller would catch."""

from __future__ import annotations

import difflib
import io
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn

from diffdrive_mj._text import listed, one_line, shown


class DiffdriveError(Exception):
    """Base of every error that the package raises on purpose.

    Example:
        >>> try:
        ...     dd.Robot(left_radius=-0.1, right_radius=0.1, track_width=0.4)
        ... except dd.DiffdriveError as error:
        ...     print(error)
        Robot.left_radius = -0.1: must be positive
    """

    def __str__(self) -> str:
        """The message, in one line whatever the names in it hold."""
        return one_line(self.message())

    def message(self) -> str:
        """What is wrong."""
        return str(self.args[0]) if self.args else ""


class InvalidValue(DiffdriveError, ValueError):
    """A value, a shape or a file's content that cannot be used.

    Example:
        >>> dd.se2.wrap_angle(np.nan)
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.InvalidValue: theta = nan: must be finite
    """


class CalibrationRefused(InvalidValue):
    """A calibration that would be worth nothing: its drives are mixed up, or its outcome is not that of a robot.

    Attributes:
        reason: what is wrong, and what cures it.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> drive = dd.Drive([0.0, 1.0], [(0, 0), (10, 20)], [(0, 0, 0), (0.9, 1.0, 2.5)], name="lab")
        >>> dd.calibration.least_squares([drive, drive], robot)
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.CalibrationRefused: lab is given twice: ... anyway=True accepts it
    """

    def __init__(self, reason: str, accept: str = "anyway=True") -> None:
        """Build the message.

        Args:
            reason: what is wrong, and what cures it.
            accept: the option that accepts the calibration all the same; "" where none does.
        """
        super().__init__(reason, accept)
        self.reason = reason

    def message(self) -> str:
        """The reason, and the option that overrides it."""
        reason, accept = self.args
        return f"{reason}; {accept} accepts it" if accept else str(reason)


class InvalidType(DiffdriveError, TypeError):
    """A value of the wrong kind, such as a word where a number belongs.

    Example:
        >>> dd.odometry.integrate([(0.0, 0.0)], "matched")
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.InvalidType: robot = 'matched': must be a Robot; Robot.load('matched') gives that preset
    """


class UnknownName(DiffdriveError, KeyError, ValueError):
    """A name that is not among the valid ones; the message lists them and the nearest.

    Example:
        >>> dd.metrics.ate(np.zeros((2, 3)), np.zeros((2, 3)), align="origins")
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.UnknownName: unknown alignment 'origins': ... did you mean 'origin'?
    """

    def __init__(self, kind: str, name: object, valid: Iterable[str]) -> None:
        """Build the message.

        Args:
            kind: what is named, such as "method".
            name: what was given.
            valid: what may be given.
        """
        super().__init__(kind, name, tuple(sorted(valid)))

    def message(self) -> str:
        """The names that are valid, and the nearest of them."""
        kind, name, names = self.args
        close = difflib.get_close_matches(name, names, n=1) if isinstance(name, str) else ()
        hint = f"; did you mean {shown(close[0])}?" if close else ""
        return f"unknown {kind} {shown(name)}: choose from {listed(names)}{hint}"


class MissingFile(DiffdriveError, FileNotFoundError):
    """A file that is not there.

    Example:
        >>> dd.Robot.load("nowhere/robot.toml")
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.MissingFile: nowhere/robot.toml: no such robot file
    """


class MissingExtra(DiffdriveError, ImportError):
    """A package that only some of the work needs, and that is not installed.

    Example:
        >>> print(MissingExtra("lab.mcap: a bag", "rosbags", "ros"))
        lab.mcap: a bag needs rosbags: pip install 'diffdrive_mj[ros]'
    """

    def __init__(self, what: str, package: str, extra: str) -> None:
        """Build the message.

        Args:
            what: needs the package.
            package: that is missing.
            extra: under which it is installed.
        """
        super().__init__(what, package, extra)

    def message(self) -> str:
        """What needs which package, and the command that installs it."""
        what, package, extra = self.args
        return f"{what} needs {package}: pip install 'diffdrive_mj[{extra}]'"


class RobotFell(DiffdriveError, RuntimeError):
    """A robot that tipped over, came to lie on its chassis, or left the floor for good.

    Attributes:
        reason: which robot, how and when, and what keeps it up.

    Example:
        >>> robot = dd.Robot.load("turtlebot3_burger")
        >>> dd.simulate(robot, dd.maneuvers.straight(robot, speed=1.0, distance=1.0, ramp=0.2))
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.RobotFell: robot 0 (turtlebot3_burger) lies on its chassis at t = ...
    """

    @property
    def reason(self) -> str:
        """Without the option that keeps the recording."""
        return str(self.args[0])

    def message(self) -> str:
        """The reason, and the option that keeps the recording."""
        return f"{self.reason}; on_fall='record' keeps the recording"


class CandidateFailed(DiffdriveError, RuntimeError):
    """Odometry that could not be judged: it raised an error, hung, crashed, or returned no pose.

    Attributes:
        reading: the index of the reading that it answered so, or raised at; None where that is not known.

    Example:
        >>> print(CandidateFailed("./mine", "square", "ended with exit status 1 after 3 of 400 answers"))
        ./mine, square: ended with exit status 1 after 3 of 400 answers
    """

    def __init__(self, candidate: str, task: str, what: str, reading: int | None = None) -> None:
        """Build the message.

        Args:
            candidate: what failed.
            task: the drive on which it did.
            what: it did.
            reading: the index of the reading at which it did, if that is known.
        """
        super().__init__(candidate, task, what)
        self.reading = reading

    def message(self) -> str:
        """Who, where and what."""
        candidate, task, what = self.args
        return f"{candidate}, {task}: {what}"


class SimulationDiverged(DiffdriveError, RuntimeError):
    """The physics broke down: an engine warning or a state that is not finite.

    Attributes:
        runs: the numbers of all the robots whose physics had broken down by then; empty if they are not known.

    Example:
        >>> issubclass(dd.SimulationDiverged, RuntimeError)
        True
    """

    runs: tuple[int, ...] = ()


class RenderingFailed(DiffdriveError, RuntimeError):
    """Pictures that could not be drawn: there is no OpenGL, or the process that draws died.

    Example:
        >>> issubclass(dd.errors.RenderingFailed, RuntimeError)
        True
    """


class PhysicsWarning(UserWarning):
    """What wheel odometry cannot see: wheels that slip or leave the floor, or time steps that are too coarse.

    Example:
        A test that must not slip makes errors of them:

        >>> import warnings
        >>> with warnings.catch_warnings():
        ...     warnings.simplefilter("error", dd.errors.PhysicsWarning)
    """


@contextmanager
def exit_on_error(program: str) -> Iterator[None]:
    """End a program on bad input: the error's message in one line on stderr, exit status 2.

    So does it end where memory runs out or the output cannot be written; with status 130 where the user interrupts it,
    and with 141, silently, where whoever reads its output has stopped reading.

    Args:
        program: its name, for the message.

    Example:
        >>> import contextlib, io
        >>> with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.suppress(SystemExit):
        ...     with dd.errors.exit_on_error("my_program"):
        ...         dd.Robot.load("mached")
        >>> said.getvalue().split(":")[:2]
        ['my_program', " unknown preset 'mached'"]
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed: what is written goes nowhere
            setattr(sys, name, io.StringIO())
    if isinstance(sys.stdout, io.TextIOWrapper):
        # What a terminal cannot show is shown by its number.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            yield
        finally:
            # What cannot be written shows here, not when Python has ended.
            sys.stdout.flush()
    except RobotFell as error:  # a program keeps no recording
        _end(program, error.reason, 2)
    except DiffdriveError as error:
        _end(program, str(error), 2)
    except KeyboardInterrupt:
        _end(program, "interrupted", 130)
    except MemoryError:
        _end(program, "not enough memory", 2)
    except BrokenPipeError:
        _discard_output()
        sys.exit(141)
    except OSError as error:
        _discard_output()
        _end(program, str(error), 2)


def _end(program: str, message: str, status: int) -> NoReturn:
    print(f"{program}: {one_line(message)}", file=sys.stderr)
    sys.exit(status)


def _discard_output() -> None:
    """Keep Python from writing what is left when it ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
