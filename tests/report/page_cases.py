"""Folders of results for pages: good ones, faulty ones, hostile ones."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from PIL import Image

import diffdrive_mj as dd
from diffdrive_mj.report import Bound, Replay, Report, plots
from diffdrive_mj.report.replays import to_json

ROBOT = dd.Robot.load("mismatched")
# What would run, break out or mislead if it were taken for anything but text.
HOSTILE = (
    """</script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">"""
    """'"&amp;<!--]]>\u202egnp\u0000$policy"""
)


def replay(title="A bend", *, back=False) -> Replay:
    """A bend with two beliefs, whose truth no straight line describes."""
    t = np.linspace(0.0, 4.0, 201)
    angles = np.stack([8 * t + 2 * np.sin(t), 10 * t], axis=-1) * (-1 if back else 1)
    wrong = ROBOT.replace(right_radius=ROBOT.left_radius)
    near = ROBOT.replace(track_width=1.001 * ROBOT.track_width)
    paths = {
        name: dd.odometry.integrate(angles, robot) for name, robot in (("equal wheels", wrong), ("nearly right", near))
    }
    return Replay(title, t, dd.odometry.integrate(angles, ROBOT), paths, ROBOT, {"equal wheels": wrong})


def good(folder: Path) -> Path:
    """Two experiments, one of which has a broken bound."""
    figure, ax = plots.figure("A finding")
    ax.plot([0, 1], [0, 1])
    bounds = [Bound("error", 0.2, 1.0, "mm"), Bound("slip", 3.0, 1.0, "ppm"), Bound("grip", 2.0, 1.0, at_least=True)]
    Report(
        "How far off?", "Hardly at all.\nAnd more.", "name  x\n-------\na     1", bounds,
        pictures={"bend": figure}, replays=[replay(), replay("The same backwards", back=True)],
    ).write(folder / "bend", command="diffdrive experiment bend --seed 3", options={"seed": 3})  # fmt: skip
    Report("And this?", "So.", "", [Bound("error", 0.1, 1.0)]).write(folder / "other")
    return folder


def listing(**changes) -> str:
    """A `metrics.json` of the newest version, some of it changed."""
    content = {
        "question": "Why?", "finding": "So.", "table": "", "bounds": [], "pictures": [],
        "provenance": {"command": "x", "options": {}, "versions": {"numpy": "2"}, "date": "2026-01-02T03:04:05+00:00"},
    }  # fmt: skip
    return json.dumps(content | changes)


def faulty(folder: Path) -> Path:
    """Results of which each has a fault of its own, and a good one among them."""
    lists = {
        "half_written": listing()[:60],
        "no_json": "years of work",
        "binary": "\udcff\udcfe",
        "deep": "[" * 100_000,
        "foreign": '{"accuracy": 0.9}',
        "foreign_list": "[1, 2]",
        "old": '{"question": "Old?", "finding": "Yes.", "bounds": [], "pictures": []}',
        "texts": listing(question=1, finding=[], table={}),
        "bounds": listing(
            bounds=[{"name": "kept", "value": 1, "limit": 2}, 3, {}, {"name": 1, "value": 1, "limit": 1}]
        ),
        "no_bounds": listing(bounds="none"),
        "nothing": listing(bounds=[{"name": "nan", "value": None, "limit": 1.0}]),
        "huge_number": listing(bounds=[{"name": "big", "value": 10**400, "limit": 1.0}]),
        "liar": listing(bounds=[{"name": "lie", "value": 5.0, "limit": 1.0, "holds": True}]),
        "no_pictures": listing(pictures="all"),
        "missing_picture": listing(pictures=["gone.png"]),
        "outside": listing(pictures=["../secret.png", "/etc/passwd.png", "a/b.png", "", 3, "x\0.png"]),
        "long_name": listing(question="Is the rest shown?", pictures=["x" * 300 + ".png"]),
        "no_picture": listing(pictures=["text.png"]),
        "huge_picture": listing(pictures=["huge.png"]),
        "no_replays": listing(replays="replays.json"),
        "half_replays": listing(replays="replays.json"),
        "bad_replays": listing(replays="replays.json"),
        "strange_provenance": listing(provenance=[1]),
        "strange_options": listing(provenance={"command": 3, "options": [], "versions": None, "date": {}}),
    }
    for name, text in lists.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "metrics.json").write_bytes(text.encode(errors="surrogateescape"))
    (folder / "umbmark").mkdir()
    (folder / "secret.png").write_bytes(b"secret")
    (folder / "no_picture" / "text.png").write_text("no picture")
    Image.new("1", (9000, 9000)).save(folder / "huge_picture" / "huge.png")
    (folder / "half_replays" / "replays.json").write_text('{"replays": [{"title"')
    (folder / "bad_replays" / "replays.json").write_text('{"replays": [{"robot": {}, "believed": {}}]}')
    (folder / "my_own_things").mkdir()
    Report("Is the rest shown?", "Yes.", "", [Bound("error", 0.1, 1.0)]).write(folder / "whole")
    return folder


def hostile(folder: Path) -> Path:
    """Hostile text wherever a file can hold some."""
    bound = {"name": HOSTILE, "value": 1.0, "limit": 2.0, "unit": HOSTILE, "at_least": False}
    text = listing(
        question=HOSTILE, finding=f"{HOSTILE}\n{HOSTILE}", table=HOSTILE, bounds=[bound], pictures=["ok.png", HOSTILE],
        provenance={
            "command": HOSTILE, "options": {HOSTILE: HOSTILE}, "versions": {HOSTILE: HOSTILE}, "date": HOSTILE,
        },
        replays="replays.json",
    )  # fmt: skip
    place = folder / "<img src=x onerror=window.hacked=1>"
    place.mkdir(parents=True)
    (place / "metrics.json").write_text(text)
    Image.new("RGB", (40, 30), "red").save(place / "ok.png")
    still = np.zeros((2, 3))
    made = Replay(f"{HOSTILE}\ud800", [0.0, 1.0], still, {HOSTILE: still, "other\ud800": still + 1}, ROBOT)
    (place / "replays.json").write_text(to_json([made]))
    return folder
