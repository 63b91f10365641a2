"""How closely `diffdrive play` agrees with Python, and how fast it is: python benchmarks/play.py [DRIVES [SEED]].

Random drives within the sliders are stepped by the page's modules in node and by `simulate`; then the page itself is
opened in headless Chromium, without a GPU, while its first drive runs. Needs node, chromium and `npm ci`.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import subprocess
import sys
import threading
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.grip import LARGEST_USE
from diffdrive_mj.play.drives import MANEUVERS, Planned, plan
from diffdrive_mj.play.server import PlayServer, robots_by_name
from diffdrive_mj.play.setting import Setting
from diffdrive_mj.robot import presets

ROOT = Path(__file__).resolve().parent.parent
POSES, FRAMES = ROOT / "tests" / "play" / "poses.mjs", ROOT / "benchmarks" / "play_frames.mjs"
ROBOTS = {name: dd.Robot.load(name) for name in presets()}
CLOSE = 1e-9  # [m], [rad]
# What only a file has, and no slider.
ROBOTS["heavy"] = dd.Robot.load("matched").replace(
    name="heavy", axle="rigid", payload={"mass": 1.5, "x": -0.08, "y": 0.05, "height": 0.15}, servo={"law": "P"}
)


def random_plans(count: int, seed: int, *, widely: bool = False) -> list[Planned]:
    """Drives near the robots' own speeds, of 6 s at most, or as wide as the sliders reach; none is refused."""
    rng, plans = np.random.default_rng(seed), []
    while len(plans) < count:
        opening = Setting.of(ROBOTS[str(rng.choice(list(ROBOTS)))])
        near = ("right_rate", "speed", "left_radius", "right_radius", "track_width")
        drawn = {name: getattr(opening, name) * float(rng.uniform(0.8, 1.2)) for name in near}
        drawn |= {f"believed_{name}": drawn[name] * float(rng.uniform(0.8, 1.2)) for name in near[2:]}
        if widely:
            drawn |= {"right_rate": float(rng.uniform(2.0, 25.0)), "speed": float(rng.uniform(0.05, 2.0))}
        setting = dataclasses.replace(
            opening,
            **drawn,
            maneuver=list(MANEUVERS)[len(plans) % len(MANEUVERS)],
            k=float(rng.uniform(0.8, 1.2)),
            seconds=float(rng.uniform(2.0, 30.0 if widely else 6.0)),
            friction=float(rng.uniform(0.05, 1.2)),
            ticks=float(rng.choice([0, 60, 360, 4096])),
            rate=float(rng.choice([5, 10, 50, 100])),
        )
        with contextlib.suppress(InvalidValue):
            planned = plan(setting, ROBOTS)
            planned.as_json()
            plans.append(planned)
    return plans


def simulated(planned: Planned) -> dd.Recording[dd.Robot, dd.Commands]:
    """The drive in Python."""
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        return dd.simulate(
            planned.true,
            planned.commands,
            world=planned.world,
            physics=planned.physics,
            sample_rate=planned.setting.rate,
            on_fall="record",
        )


def moved(planned: Planned, physics: dd.Physics) -> float:
    """How far a change of the friction's last digits moves Python's own path [m]."""
    nearly = dd.World(friction=planned.world.friction * (1 + 4e-16))
    first, second = (
        simulated(dataclasses.replace(planned, physics=physics, world=world)).truth for world in (planned.world, nearly)
    )
    return float(np.abs(first - second)[:, :2].max())


def samples(answer: dict[str, Any]) -> np.ndarray:
    """What node has written of a drive: time, pose, wheel angles and belief, a row each."""
    return np.array(answer["samples"]).reshape(-1, 9)


def run(script: Path, *arguments: str, given: str = "") -> Any:
    """The JSON that a script prints."""
    done = subprocess.run(["node", script, *arguments], input=given, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def main(count: int = 300, seed: int = 7) -> None:
    """Print the figures."""
    plans = random_plans(count, seed=seed, widely=True)
    answers = run(POSES, given=json.dumps([planned.as_json() for planned in plans]))
    off: dict[str, list[float]] = {"rolling": [], "sliding": []}
    slides = []
    for planned, answer in zip(plans, answers, strict=True):
        recording, page = simulated(planned), samples(answer)
        slid = bool((recording.friction_use > LARGEST_USE).any())
        apart = np.abs(page[:, 1:3] - recording.truth[: len(page), :2]).max()
        off["sliding" if slid else "rolling"].append(float(apart))
        slides += [planned] * slid
    for kind, apart in off.items():
        most, middle, beyond = max(apart), float(np.median(apart)), sum(distance > CLOSE for distance in apart)
        print(
            f"{len(apart)} drives {kind}: true poses at most {most:.1e} m from Python's, median {middle:.1e} m, "
            f"{beyond} beyond {CLOSE:.0e} m"
        )
    for said, physics in (("rolling", dd.Physics()), ("sliding", dd.Physics.sliding())):
        most = max(moved(planned, physics) for planned in slides)
        print(f"these with settings for {said}: 4e-16 of the friction moves Python's path by up to {most:.1e} m")
    faster = sum(answer["time"] for answer in answers) / sum(answer["time"] / answer["faster"] for answer in answers)
    print(f"physics in node: {faster:.0f} times real time")
    with PlayServer(robots_by_name(ROBOTS["matched"]), ROOT / "node_modules") as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for width, seen in run(FRAMES, server.address).items():
            print(
                f"Chromium without a GPU, {width} px wide: {seen['frames']:.0f} frames/s, physics {seen['faster']:.0f} "
                "times real time"
            )
        server.shutdown()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
