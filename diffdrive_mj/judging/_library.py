"""A program that answers for a shared library: odometry in C, or in what can be called as C, in a process of its own.

    python -m diffdrive_mj.judging._library ./libodometry.so

It reads and writes the lines of any program that is judged, and calls the two functions of examples/odometry.h.
"""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Iterable, Iterator
from typing import TextIO

NUMBERS = ("left_radius", "right_radius", "track_width", "ticks_per_revolution", "x", "y", "theta")


class _Robot(ctypes.Structure):
    """`struct robot` of examples/odometry.h."""

    _fields_ = tuple((name, ctypes.c_double) for name in NUMBERS)


def answers(library: ctypes.CDLL, lines: Iterable[str]) -> Iterator[str]:
    """The library's poses, a line for each reading."""
    start, update, pose = library.start, library.update, (ctypes.c_double * 3)()
    start.restype = update.restype = None
    update.argtypes = (ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_double))
    wheels = [Wheel(1.0, None)] * 2
    for line in lines:
        if line.startswith("#"):
            told = dict(pair.split("=") for pair in line.split() if "=" in pair)
            unit = 2 * math.pi / float(told["ticks_per_revolution"]) if told["unit"] == "ticks" else 1.0
            wheels = [Wheel(unit, told.get("counter_bits")) for _ in range(2)]
            start(ctypes.byref(_Robot(*(float(told[name]) for name in NUMBERS))))
        elif line.strip():
            t, *read = map(float, line.split(","))
            update(t, *(wheel.angle(count) for wheel, count in zip(wheels, read, strict=True)), pose)
            yield ",".join(map(repr, pose))


class Wheel:
    """The angle of a wheel [rad] from what is read of it: counters have been unwrapped for a library."""

    def __init__(self, unit: float, bits: str | None) -> None:
        self.unit, self.half = unit, 2 ** (int(bits) - 1) if bits else None
        self.count: float | None = None
        self.turns = 0

    def angle(self, count: float) -> float:
        """Take in a reading; NaN and infinity come back as NaN."""
        if not math.isfinite(count):
            return math.nan
        if self.half and self.count is not None:
            step = count - self.count
            self.turns += round(((step + self.half) % (2 * self.half) - self.half - step) / (2 * self.half))
        self.count = count
        return self.unit * (count + self.turns * 2 * (self.half or 0))


def main(path: str) -> None:
    """Answer the lines of the standard input."""
    with _alone() as out:
        try:
            library = ctypes.CDLL(path)
        except OSError as error:
            sys.exit(str(error))
        for name in ("start", "update"):
            if not hasattr(library, name):
                sys.exit(f'{path}: has no function {name}; in C++ it is declared extern "C", as odometry.h does')
        for answer in answers(library, sys.stdin):
            print(answer, file=out)


def _alone() -> TextIO:
    """Take the standard output for the answers alone: what a library prints goes to standard error.

    Each line is written at once: a library that crashes has answered those before.
    """
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    return out


if __name__ == "__main__":
    main(sys.argv[1])
