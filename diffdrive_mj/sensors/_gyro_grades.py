"""Grades of gyros, as their data sheets state them; models/README.md has the sources."""

from __future__ import annotations

import math
from typing import Any

_DEGREE = math.pi / 180
_PER_HOUR = _DEGREE / 3600
_PER_ROOT_HOUR = _DEGREE / 60


def _grade(*, noise: float, stability: float, bias: float, scale: float, range: float, bits: int) -> dict[str, Any]:  # noqa: A002
    """The fields of a gyro in SI units.

    The bias's random walk K is none that data sheets state: it is the one with which the Allan deviation's minimum,
    sqrt(2 N K / sqrt(3)), is the in-run stability that they do.
    """
    return {
        "bias": bias, "angle_random_walk": noise, "bias_random_walk": math.sqrt(3) * stability**2 / (2 * noise),
        "scale_error": scale, "range": range, "resolution": range / 2 ** (bits - 1),
    }  # fmt: skip


GRADES = {
    "mpu6050": _grade(
        noise=0.005 * _DEGREE, stability=4.3 * _PER_HOUR, bias=20 * _DEGREE, scale=0.03, range=250 * _DEGREE, bits=16
    ),
    "bmi088": _grade(
        noise=0.014 * _DEGREE, stability=2 * _PER_HOUR, bias=1 * _DEGREE, scale=0.01, range=250 * _DEGREE, bits=16
    ),
    "adis16495": _grade(
        noise=0.09 * _PER_ROOT_HOUR, stability=0.8 * _PER_HOUR, bias=0.07 * _DEGREE, scale=0.002, range=125 * _DEGREE,
        bits=32,
    ),
}  # fmt: skip
