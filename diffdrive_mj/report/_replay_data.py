"""A replay as the page's scripts read it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.report.replays import MOST, Replay
from diffdrive_mj.robot import Robot


def replay_json(replay: Replay, room: int) -> str | None:
    """A replay as the page's scripts read it, with as many samples as there is room for."""
    most = MOST
    while most >= 20:
        text = in_script(_shown(replay.thinned(most)))
        if len(text) <= room:
            return text
        most = min(int(0.95 * most * room / len(text)), most - 1)
    return None


def in_script(content: Any) -> str:
    """JSON that ends no script element, whatever its strings hold."""
    return (
        json.dumps(content, separators=(",", ":"))
        .replace("<", "\\u003c")
        .replace(">", "\\u003e")
        .replace("&", "\\u0026")
    )


def _shown(replay: Replay) -> dict[str, Any]:
    every = [replay.truth, *replay.beliefs.values()]
    # A hundredth of what thinning lets pass.
    grain = 1e-6 * max(float(np.ptp(path[:, :2], axis=0).max()) for path in every)
    beliefs = []
    for name, path in replay.beliefs.items():
        off = replay.errors(name)
        errors = {"position_error": _digits(off.position_error), "heading_error": _digits(off.heading_error)}
        robot = _outline(replay.believed.get(name, replay.robot))
        beliefs.append({"name": name[:120], **_path(path, grain), **errors, "robot": robot})
    t = _rounded(replay.t, 1e-6 * float(replay.t[-1] - replay.t[0]))
    return {
        "title": replay.title[:120],
        "t": t,
        "truth": _path(replay.truth, grain),
        "robot": _outline(replay.robot),
        "beliefs": beliefs,
    }


def _path(path: Array, grain: float) -> dict[str, list[float]]:
    return {name: _rounded(path[:, k], grain if k < 2 else 1e-5) for k, name in enumerate(("x", "y", "theta"))}


def _rounded(values: Array, grain: float) -> list[float]:
    decimals = int(np.ceil(-np.log10(grain))) if grain > 0 else 6
    return (np.round(values, decimals) + 0.0).tolist()


def _digits(values: Array) -> list[float]:
    """Errors to six digits, of whatever size they are."""
    return [float(f"{value:.6g}") for value in values.tolist()]


def _outline(robot: Robot) -> dict[str, float]:
    return {
        "left_radius": robot.left_radius,
        "right_radius": robot.right_radius,
        "track_width": robot.track_width,
        "tyre_width": robot.tyres.width,
        "caster_x": robot.caster.x,
        "caster_radius": robot.caster.radius,
    }
