"""The drives of the conformance suite: what wheels do that odometry gets wrong, one kind a case."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array
from diffdrive_mj.judging.cases import Case, exact_case
from diffdrive_mj.kinematics import wheel_rates
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot

START = (2.0, -1.0, 0.5)
EQUAL = Robot(left_radius=0.033, right_radius=0.033, track_width=0.16)
# Radii with a ratio of 0.91; and those of a small robot, which differ by a percent.
MISMATCHED = Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
SMALL = Robot(
    left_radius=0.0331, right_radius=0.0327, track_width=0.163, encoder=WheelEncoder(ticks_per_revolution=4096)
)


def drives() -> Iterator[Case]:
    """Make the cases of the suite, in the order in which they are best read.

    Example:
        >>> next(drives()).name
        'straight'
    """
    yield from _paths()
    yield from _rates()
    yield from _counters()
    yield from _clocks()
    yield from _faults()
    yield _ten_hours()


def _driven(t: Array, speed: ArrayLike, yaw_rate: ArrayLike, robot: Robot, first: ArrayLike = (0.0, 0.0)) -> Array:
    """Wheel angles (T, 2) that follow speeds [m/s] and yaw rates [rad/s], to a millionth of a radian."""
    twist = np.stack(np.broadcast_arrays(speed, yaw_rate, t)[:2], axis=-1)
    steps = wheel_rates(twist[:-1], robot) * np.diff(t)[:, None]
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    # Rounded, so that every machine writes the same digits.
    return np.round(angles + first, 6)


def _ticks(
    angles: Array, robot: Robot, first: tuple[int, int] = (0, 0), bits: int | None = None, low: int = 0
) -> Array:
    """What counters show that hold some counts at first; those of some bits begin again at `low`."""
    counts = np.round(angles * (robot.encoder.ticks_per_wheel_turn / (2 * math.pi))) + first
    return counts if bits is None else (counts - low) % 2.0**bits + low


def _clock(seconds: float, rate: float) -> Array:
    return np.round(np.arange(round(seconds * rate) + 1) / rate, 9)


def _winding(t: Array, robot: Robot, first: ArrayLike = (0.0, 0.0)) -> Array:
    """Bends both ways, at a speed that changes."""
    return _driven(t, 0.3 + 0.1 * np.sin(0.7 * t), 1.2 * np.sin(0.9 * t) + 0.3, robot, first)


def _paths() -> Iterator[Case]:
    t, slow = _clock(6.0, 20.0), _clock(12.0, 20.0)
    yield exact_case("straight", "Straight ahead on equal wheels.", EQUAL, t, _driven(t, 0.5, 0.0, EQUAL), START)
    yield exact_case(
        "winding",
        "Bends both ways, from a start away from the origin.",
        EQUAL,
        slow,
        _winding(slow, EQUAL),
        (-7.0, 12.0, -2.0),
    )
    yield exact_case(
        "first_reading", "Wheels that have turned before the first reading: it is no motion.", EQUAL, t,
        _winding(t, EQUAL, first=(12.5, -3.25)), START,
    )  # fmt: skip
    turns = np.round(np.outer(np.arange(121) * 0.25, (0.91, 1.0)), 9)
    yield exact_case(
        "unequal_straight", "Wheels of unequal radii that run straight: turns are nothing but rounding.", MISMATCHED, t,
        turns, START,
    )  # fmt: skip
    yield exact_case(
        "unequal_winding", "Wheels of unequal radii, 0.1 and 0.091 m, on bends both ways.", MISMATCHED, slow,
        _winding(slow, MISMATCHED), START,
    )  # fmt: skip
    for name, sign in (("turn_left", 1), ("turn_right", -1)):
        yield exact_case(
            name, f"Three circles to the {name[5:]}, through {180 * sign:+d} degrees.", SMALL, slow,
            _driven(slow, 0.4, 1.6 * sign, SMALL), (1.0, 2.0, 2.0 * sign),
        )  # fmt: skip
    yield exact_case(
        "across_180", "A heading that swings across 180 degrees and back.", SMALL, slow,
        _driven(slow, 0.3, 0.8 * np.cos(2.0 * slow), SMALL), (4.0, -3.0, 3.1),
    )  # fmt: skip
    yield exact_case(
        "reverse",
        "Backwards, on bends both ways.",
        SMALL,
        slow,
        _driven(slow, -0.3, np.sin(slow), SMALL),
        (-1.0, 3.0, -2.5),
    )
    spins = np.where(slow < 5.0, 2.5, -3.0) * (np.abs(slow - 5.0) > 0.5)
    yield exact_case("spin", "On the spot, two turns to the left, then three to the right.", SMALL, slow,
                  _driven(slow, 0.0, spins, SMALL), START)  # fmt: skip
    omega = np.where(t < 3.0, 1.5, -1.5)
    pivots = _driven(t, SMALL.track_width / 2 * np.abs(omega), omega, SMALL)
    yield exact_case("pivot", "About the left wheel, then about the right one.", SMALL, t, pivots, START)
    yield exact_case("standstill", "Wheels that never move: the start, again and again.", SMALL, t,
                  np.full((len(t), 2), 7.5), (-3.0, 5.0, -1.25))  # fmt: skip
    yield _steps()


def _steps() -> Case:
    """Steps of 10 cm each that turn by 1e-12 to 1 rad, ahead to the left, then backwards to the right."""
    turns = np.logspace(-12, 0, 49)
    turn, distance = np.concatenate([turns, -turns]), np.repeat([0.1, -0.1], len(turns))
    rims = np.stack([distance - turn * EQUAL.track_width / 2, distance + turn * EQUAL.track_width / 2], axis=-1)
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(rims / EQUAL.left_radius, axis=0)])
    t, about = (
        _clock(len(turn) / 10.0, 10.0),
        "Steps that turn by 1e-12 to 1 rad, ahead to the left and back to the right.",
    )
    return exact_case("steps", about, EQUAL, t, np.round(angles, 15), START)


def _rates() -> Iterator[Case]:
    for name, rate, seconds in (("one_hertz", 1.0, 60.0), ("ten_hertz", 10.0, 20.0), ("kilohertz", 1000.0, 2.5)):
        t = _clock(seconds, rate)
        about = f"Readings every {1000 / rate:g} ms, bends both ways."
        yield exact_case(name, about, MISMATCHED, t, _winding(t, MISMATCHED), START)


def _counters() -> Iterator[Case]:
    t = _clock(10.0, 20.0)

    def case(name: str, about: str, robot: Robot, angles: Array, **counter: Any) -> Case:
        ticks = _ticks(angles, robot, **counter)
        return exact_case(name, about, robot, t, ticks, START, unit="ticks", counter_bits=counter.get("bits"))

    winding = _winding(t, SMALL)
    coarse = SMALL.replace(encoder=WheelEncoder(ticks_per_revolution=60))
    geared = SMALL.replace(encoder=WheelEncoder(ticks_per_revolution=64, gear=43.7))
    fine = SMALL.replace(encoder=WheelEncoder(ticks_per_revolution=65536))
    yield case("coarse_ticks", "60 ticks a turn: steps of a few whole ticks.", coarse, winding)
    yield case("geared_ticks", "2796.8 ticks a turn, not a whole number.", geared, winding, first=(-5000, 321))
    for bits in (16, 32):
        half = 2 ** (bits - 1)
        robot = fine if bits == 16 else SMALL
        for name, sign in (("forwards", 1), ("backwards", -1)):
            yield case(
                f"wrap_{bits}_{name}", f"Signed counters of {bits} bits that wrap, the wheels turning {name}.", robot,
                sign * winding, first=(sign * (half - 4000), sign * (half - 2500)), bits=bits, low=-half,
            )  # fmt: skip
        yield case(
            f"near_wrap_{bits}", f"Signed counters of {bits} bits, one at its highest count first, one at its lowest.",
            robot, _driven(t, 0.0, 2.0 * np.sin(2.0 * t), robot), first=(-half, half - 1), bits=bits, low=-half,
        )  # fmt: skip
    yield case(
        "wrap_16_unsigned", "Unsigned counters of 16 bits, 0 to 65535, that wrap both ways.", fine,
        _driven(t, 0.2 * np.cos(t), 0.8, fine), first=(3, 65530), bits=16,
    )  # fmt: skip
    fast = _driven(t, 1.6 * np.sin(0.6 * t), 4.0 * np.cos(0.8 * t), fine)
    yield case(
        "wrap_16_fast", "Signed counters of 16 bits that move by nearly half of their range between readings.", fine,
        fast, bits=16, low=-(2**15),
    )  # fmt: skip


def _clocks() -> Iterator[Case]:
    even = _clock(12.0, 20.0)
    k = np.arange(len(even))
    jitter = np.round(even + 0.02 * np.sin(2.3 * k) * np.cos(0.7 * k), 6)
    yield exact_case("jitter", "Times that vary by 20 ms, on the clock of Unix.", SMALL, 1.7e9 + jitter,
                  _winding(jitter, SMALL), START)  # fmt: skip
    winding = _winding(even, SMALL)
    stale = np.where(np.arange(len(even)) % 5 < 2, k - k % 5, k)  # each fifth reading comes twice
    yield exact_case("repeated", "Readings that come again, at later times: no motion, then all of it.", SMALL, even,
                  winding[stale], START)  # fmt: skip
    gone = (k % 17 == 3) | ((k > 60) & (k < 75)) | ((k > 150) & (k < 180))
    yield exact_case("missing", "Readings that are missing, single ones and 1.5 s of them.", SMALL, even[~gone],
                  winding[~gone], START)  # fmt: skip


def _faults() -> Iterator[Case]:
    t = 50.0 + _clock(6.0, 20.0)
    winding = _winding(t, SMALL)
    still = t.copy()
    still[[20, 50, 51, 90]] = still[[19, 49, 49, 89]]
    yield exact_case(
        "zero_dt", "Readings at the time of the one before: hold the pose; the next one takes the whole motion.", SMALL,
        still, winding, START,
    )  # fmt: skip
    back, late = t.copy(), winding.copy()
    for k, earlier in ((30, 27), (61, 55), (62, 56)):  # old readings that come late
        back[k], late[k] = t[earlier], winding[earlier]
    back[95] = 0.0
    yield exact_case(
        "reversed_time", "Old readings that come late, and a stamp of zero: hold the pose.", SMALL, back, late, START
    )
    times, lost = t.copy(), winding.copy()
    lost[25, 0] = lost[40, 1] = lost[70] = lost[71] = lost[72] = times[100] = np.nan
    yield exact_case(
        "nan", "Wheels or times that are no numbers: hold the pose; the next reading takes the whole motion.", SMALL,
        times, lost, START,
    )  # fmt: skip
    none_yet = winding.copy()
    none_yet[:3, 0] = np.nan
    yield exact_case(
        "nan_first", "The first readings are no numbers: the start holds until the first one that is.", SMALL, t,
        none_yet, START,
    )  # fmt: skip


def _ten_hours() -> Case:
    """Ten hours of driving as 3000 readings, 10 km from the origin."""
    clock = 12.0 * np.arange(3000, dtype=np.float64)
    angles = _driven(clock, 0.5, 0.05 * np.sin(clock / 300.0) + 0.01 * np.sin(clock / 37.0), MISMATCHED)
    about = "Ten hours in 3000 readings, from t = 36000 s, 10 km from the origin: single precision is lost here."
    return exact_case("ten_hours", about, MISMATCHED, 36000.0 + clock, angles, (8000.0, -6000.0, 1.0))
