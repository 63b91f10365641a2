"""What is thrown at the package: values, words and numbers, and what of it would be right."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import diffdrive_mj as dd

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3)
ANGLES = np.cumsum(np.tile([0.9, 1.1], (4, 1)), axis=0)
POSES = dd.odometry.integrate(ANGLES, ROBOT)
DRIVE = dd.Drive(np.arange(4.0), ANGLES, POSES)
COMMANDS = dd.Commands(0.01, ANGLES)
RECORDING = dd.Recording(np.arange(4.0), ANGLES, POSES, ROBOT, COMMANDS, dd.World(), dd.Physics(), flow=ANGLES)
OBJECTS = (
    ROBOT, DRIVE, COMMANDS, RECORDING, dd.World(), dd.Physics(), dd.Tracker(), dd.FlowSensor(x=0.1), dd.logs.Columns(),
    dd.Encoder(ticks_per_revolution=100, sample_rate=1.0), dd.odometry.Odometer(ROBOT),
    dd.course_tracker.CourseTracker(), dd.GoToPose(ROBOT, goal=(1.0, 0.0, 0.0)),
    dd.Patch(x=(0.0, 1.0), y=(0.0, 1.0), friction=0.5),
)  # fmt: skip
# What a parameter of some name, of a function's or of any, or else of some annotation, may well be.
USUAL = {
    "robot": ROBOT, "believed": ROBOT, "true": ROBOT, "nominal": ROBOT, "calibrated": ROBOT, "drive": DRIVE,
    "path": "a.csv", "drives": [DRIVE, DRIVE], "recording": RECORDING, "commands": COMMANDS, "wheel_angles": ANGLES,
    "truth": POSES, "estimate": POSES, "t": np.arange(4.0), "pose": POSES[1], "rng": np.random.default_rng(0),
    "film.path": "a.webp", "strobe.path": "a.png", "camera": "above", "size": (320, 240), "times": 3,
    "float": 0.5, "int": 3, "bool": True, "legs": [[dd.maneuvers.Segment(1.0, 0.0, 1.0)]],
}  # fmt: skip
NUMBERS = (0, -1, 1, 3, 0.5, -0.0, 1e-9, 1e9, 1e99, 1e200, 1e308, 5e-324, 2**63, 10**400, np.nan, np.inf, -np.inf)
RUBBISH = (
    None, "", "x", "arc", b"x", "line\nbreak", "\x1b[31m", "nul\0", "ü" * 300, True, np.True_, [], [[]], [1, [2]],
    (1, 2), {}, {"a": 1}, 1j, object(), object, print, range(3), np.array("x"), np.zeros((0, 3)), np.datetime64("now"),
    np.zeros(3, [("x", float)]), np.ma.masked_equal([1.0, 2, 3], 2), [ROBOT], 10**5000, Path("nowhere"), *OBJECTS,
)  # fmt: skip

LOG = "t,left,right,x,y,theta\n" + "".join(f"{k / 10},{k},{1.1 * k},{k / 50},0,{k / 90}\n" for k in range(9))
TOML = dd.Robot.load("ct_bot").to_toml() + '[caster]\nx = -0.05\n[servo]\nlaw = "PI"\n'
METADATA = "Li,0.2,\nDi,0.084,0.080\nngear,43.7,\nencRes,64,\n"
RUN = "".join(f"{k / 10},{k / 50},0,{k / 90},{k % 3},2\n" for k in range(9))
FILES = {
    "a.csv": LOG,
    "b.csv": LOG.replace("0,", "3,"),
    "r.toml": TOML,
    "7_metadata.csv": METADATA,
    "7_run-01.csv": RUN,
}
WORDS = (
    "-1", "0", "1", "9", "1e308", "5e-324", "1_0", "٣", "nan", "inf", "9" * 400, "9" * 5000, "true", '"', "'", "[", "]",
    "[" * 5000, "=", "#", ",", ";", "\t", "\n", "\r", "\0", "\x1b[31m", "\ufeff", "ü", "\u2028", "x" * 300, "", " ",
    "--", "-", "/", ".", "a.csv", "r.toml", "matched", "nowhere/x.toml", "x=y", "t", "left", "ticks", "ros2", "ms",
    "16", "-h",
)  # fmt: skip
READ = "calibrate a.csv b.csv --robot r.toml --time 1 --left left --right 3 --x x --y y --theta theta --header"
COMMAND_LINES = (
    "", "--help", "--version", READ, "robots list", "experiment",
    f"{READ} --time-unit ms --angle-unit deg --position-unit cm --anyway --export ros2",
    f"{READ} --wheel-unit ticks --counter-bits 16 --ticks-per-revolution 64 --output new.toml --start truth",
    f"{READ} --no-headings --reverse-left --delimiter , --wheels increments --method least_squares",
    "explain ct_bot --tolerance 0.1 --rate 5 --latency 0.1 --speed 1 --yaw-rate 2 --json",
    "film r.toml --believed r.toml ct_bot --maneuver spin --camera both --size 320 240 --fps 9 --output a.webp",
    "film ct_bot --strobe --times 4 --friction 0.5 --output a.png", "film r.toml --still 1 --output a.png",
    "robots show r.toml", "robots mjcf r.toml new.xml", "sample lab --seed 3",
    "experiment radius_compensation --robot r.toml --speed-ratio 0.9 --speed 1 --seconds 5 --odometry-rate 5",
    "experiment mismatched_radii --output out --robot matched --distance 5 --speed 1 --side 2",
    "experiment integrators --robot matched --radius 1 --speed 1", "experiment physics_floor --random 3 --seed 2",
)  # fmt: skip


def some_value(rng: random.Random, usual: Any) -> Any:
    """A value: as it should be, a number, an array, or rubbish."""
    kind = rng.random()
    if usual is not None and kind < 0.7:
        return usual
    if kind < 0.9:
        shape = rng.choices((0, 1, 2, 2, 3, 3, 4), k=rng.choice((0, 0, 1, 1, 2, 2, 3)))
        numbers = rng.choices(rng.choice((NUMBERS[:9], NUMBERS[:13])), k=int(np.prod(shape)))
        return np.reshape(numbers, shape) if shape else rng.choice(NUMBERS)
    return rng.choice(RUBBISH)


def damaged(rng: random.Random, parts: Sequence[str]) -> list[str]:
    """A list with some of its items replaced, left out, doubled or joined by others."""
    parts = list(parts)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        at, other = rng.randrange(len(parts) + 1), rng.randrange(len(parts) + 1)
        parts[at : at + rng.choice((0, 1, 1))] = rng.choice(([rng.choice(WORDS)], parts[other : other + 1], []))
    return parts
