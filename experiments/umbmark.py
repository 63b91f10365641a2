"""What does the bidirectional square reveal, and when does it mislead?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj.calibration._square import corrected
from diffdrive_mj.calibration._square_drives import LARGEST_MISMATCH, return_errors
from diffdrive_mj.calibration.squares import jung_chung, umbmark
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs import optiodom_robot, read_optiodom
from diffdrive_mj.report import Bound, Report, plots

SIDES = (1.0, 2.0, 4.0)
MISMATCHES = (0.05, 0.10, 0.15, 0.20, 0.25, 0.29, 0.35, 0.45)
METHODS = {
    "published, 1 round": {"update": "published", "forms": "both", "rounds": 1},
    "first order, composed, 3 rounds": {"forms": "both"},
    "exact angles, composed, 3 rounds": {},
}
BUMPS, BUMP_HEIGHT = 10, 0.010
FIRST, SECOND = "bumps as the first side starts", "bumps as the second side starts"

# Sousa et al. 2022: track [m], right and left diameter [m], largest final error before and after [mm], side [m].
PUBLISHED = {
    "230620202042": (0.20146, 0.08395, 0.08405, 33.26, 7.16, 0.75),
    "230620202317": (0.20122, 0.08395, 0.08405, 33.46, 7.43, 0.75),
    "231220200040": (0.20170, 0.08398, 0.08402, 113.89, 37.81, 1.70),
}


def run(
    side: float = 4.0,
    radius_ratio: float = 0.995,
    track_error: float = 0.01,
    runs: int = 5,
    position_noise: float = 1e-3,
    heading_noise: float = 1e-3,
    seed: int = 0,
    data: str = "",
) -> Report:
    """What does the bidirectional square reveal, and when does it mislead?

    Args:
        side: of the square of the noisy runs [m].
        radius_ratio: of the true robot; the believed one takes its wheels for equal.
        track_error: by what part the believed track is too wide.
        runs: each way round.
        position_noise: of the measured poses [m].
        heading_noise: of the measured poses [rad].
        seed: of the noise and of the encoder's phases.
        data: folder of the OptiOdom recordings; without it the real robot is left out.
    """
    checks.positive("side", side)
    rng = np.random.default_rng(seed)
    base = dd.Robot.load("matched")
    believed = base.replace(track_width=base.track_width * (1 + track_error))
    true = corrected(base, radius_ratio, base.track_width)
    squares, grid = drive_all(believed, true, side)
    clean = [dd.sensors.measure(square) for square in squares]

    tracker = dd.Tracker(position_noise=position_noise, heading_noise=heading_noise)
    measured = repeat(squares, tracker, runs, rng)
    found = umbmark(measured, believed, side=side)
    off = np.abs(found.values - (radius_ratio, base.track_width)) / found.std
    gains, refused = improvements(grid, believed)
    within = {name: [g for m, g in gain if m <= LARGEST_MISMATCH] for name, gain in gains.items()}
    orders = {name: oscillation(grid[2.0, 0.05], 2.0, name) for name in ("composed", "published")}
    true_2 = 1 - 0.05 * base.track_width / 2.0
    bumpy = bumps(clean, true, believed, side)
    predicted = radius_ratio * (1 - BUMPS * base.mean_radius * bump_angle(base.mean_radius) / (4 * side))
    real = real_rows(Path(data)) if data else []

    e_before, e_after = found.details["E_max_before"], found.details["E_max_after"]
    exact = within["exact angles, composed, 3 rounds"]
    seen = bumpy[FIRST, "headings"]["radius_ratio"]
    swing = np.abs(np.diff(orders["published"])).min() / abs(true_2 - orders["published"][0])
    bounds = [
        Bound("with noise: E_max left", 1e3 * e_after, 3, "mm"),
        Bound("with noise: radius ratio, track off by, in their standard deviations", float(off.max()), 4),
        Bound("ideal floor, within the limit: E_max down, median", float(np.median(exact)), 1000, "times", True),
        Bound("ideal floor, within the limit: E_max down, worst", min(exact), 300, "times", True),
        Bound("above the limit: drives answered", sum(m > LARGEST_MISMATCH for m, _ in gains["published, 1 round"]), 0),
        Bound("above the limit: drives refused", refused, 2 * len(SIDES), "", True),
        Bound("published update, wheels believed unequal: swings on / its first error", float(swing), 1, "", True),
        Bound("composed update, the same: ends off by", 1e6 * abs(orders["composed"][-1] - true_2), 100, "ppm"),
        Bound(
            "bumps on the first side: headings mislead as predicted, off by",
            100 * abs((seen - radius_ratio) / (predicted - radius_ratio) - 1),
            1,
            "%",
        ),
        Bound(
            "bumps on the first side: positions misled by",
            1e6 * abs(bumpy[FIRST, "positions"]["radius_ratio"] - radius_ratio),
            400,
            "ppm",
        ),
        Bound(
            "bumps on the second side: positions misled by",
            1e6 * abs(bumpy[SECOND, "positions"]["radius_ratio"] - radius_ratio),
            1000,
            "ppm",
            True,
        ),
        *(
            Bound(f"real robot {row[0]}: off the published figures by", row[-1], 1, "of their last digits")
            for row in real
        ),
    ]
    rows = [
        [name, *(float(np.median([g for m, g in gain if abs(m - at) < 1e-9])) for at in MISMATCHES[:6])]
        for name, gain in gains.items()
    ]
    header = ["E_max down, times; mismatch", *(f"{m:g}" for m in MISMATCHES[:6])]
    bumped = [
        [floor, method, 1e6 * (value["radius_ratio"] - radius_ratio), 1e3 * value["E_max"]]
        for (floor, method), value in bumpy.items()
    ]
    tables = [
        report.table(header, rows),
        report.table(
            ["calibrated with", "reading", "radius ratio off by [ppm]", "E_max left on the even floor [mm]"], bumped
        ),
    ]
    if real:
        columns = [
            "real robot",
            "track [mm]",
            "right [mm]",
            "left [mm]",
            "before [mm]",
            "after [mm]",
            "worst off [digits]",
        ]
        tables.append(report.table(columns, real))
    else:
        tables.append("real robot: left out, --data names no folder of recordings")
    ppm = 1e6 * abs(predicted / radius_ratio - 1)
    finding = (
        f"{runs} runs each way with {1e3 * position_noise:g} mm, {1e3 * heading_noise:g} mrad and rounded ticks bring "
        f"E_max from {1e3 * e_before:.0f} to {1e3 * e_after:.1f} mm:\nthe square reveals the radius ratio and the "
        "track, not the mean radius. It misleads where its sides are bent\n(refused above side |1 - ratio| / track = "
        f"{LARGEST_MISMATCH}), with the published update from wheels believed unequal, and on bumps:\n"
        f"{BUMPS} of {1e3 * BUMP_HEIGHT:g} mm pass for wheels {ppm:.0f} ppm apart."
    )
    change = f"{1e3 * e_before:.0f} mm down to {1e3 * e_after:.1f} mm"
    title = f"The square brings {change}, unless its sides are bent or a wheel crosses bumps"
    made, axes = plots.figure(title, columns=2, rows=2, size=(13.5, 10.2))
    draw_returns(axes[0, 0], measured, believed, found.calibrated)
    draw_improvement(axes[0, 1], gains)
    draw_oscillation(axes[1, 0], orders, true_2)
    draw_bumps(axes[1, 1], bumpy, radius_ratio, predicted)
    metrics = {
        "radius_ratio": found.values[0],
        "track_width_m": found.values[1],
        "std": found.std,
        "E_max_before_m": e_before,
        "E_max_after_m": e_after,
        "improvement": {name: [[m, g] for m, g in gain] for name, gain in gains.items()},
        "ratio_after_rounds": orders,
        "bumps": {f"{floor}, {method}": value for (floor, method), value in bumpy.items()},
        "real": real,
    }
    return Report(run.__doc__.splitlines()[0], finding, "\n\n".join(tables), bounds, metrics, {"umbmark": made})


def drive_all(
    believed: dd.Robot, true: dd.Robot, side: float
) -> tuple[list[dd.Recording], dict[tuple[float, float], list[Drive]]]:
    """In the physics, both ways round: the true robot on its square, and robots of every mismatch on every side."""
    cases = [(side, true)]
    keys = [(length, mismatch) for length in SIDES for mismatch in MISMATCHES]
    for length, mismatch in keys:
        cases.append((length, corrected(true, 1 - mismatch * true.track_width / length, true.track_width)))
    commands = [
        # Every square takes the same time, so that all of them run together.
        dd.maneuvers.square(believed, side=length, speed=length / 4, yaw_rate=2.0, clockwise=clockwise)
        for length, _ in cases
        for clockwise in (False, True)
    ]
    recording = dd.simulate([robot for _, robot in cases for _ in range(2)], commands, sample_rate=20.0)
    drives = dd.sensors.measure(recording)
    return list(recording.runs[:2]), {key: drives[2 * i + 2 : 2 * i + 4] for i, key in enumerate(keys)}


def repeat(squares: list[dd.Recording], tracker: dd.Tracker, runs: int, rng: np.random.Generator) -> list[Drive]:
    """The squares measured again and again: poses with noise, wheel angles in whole ticks."""
    result = []
    for square, way in zip(squares, ("counter-clockwise", "clockwise"), strict=True):
        encoder = dd.Encoder.of(square.robot, sample_rate=20.0)
        for number in range(runs):
            measured = dd.sensors.measure(square, encoder=encoder, tracker=tracker, seed=rng)
            result.append(replace(measured, name=f"{way} {number + 1}"))
    return result


def improvements(
    grid: dict[tuple[float, float], list[Drive]], believed: dd.Robot
) -> tuple[dict[str, list[tuple[float, float]]], int]:
    """By method, the mismatch and how many times smaller E_max becomes; and how many squares were refused."""
    gains: dict[str, list[tuple[float, float]]] = {name: [] for name in METHODS}
    refused = 0
    for (side, mismatch), drives in grid.items():
        for name, options in METHODS.items():
            try:
                result = umbmark(drives, believed, side=side, **options)
            except InvalidValue:
                refused += name == "exact angles, composed, 3 rounds"
                continue
            gains[name].append((mismatch, result.details["E_max_before"] / result.details["E_max_after"]))
    return gains, refused


def oscillation(drives: list[Drive], side: float, update: str, start: float = 0.975, rounds: int = 6) -> list[float]:
    """The radius ratios that one correction after another arrives at, from wheels believed unequal."""
    believed = corrected(dd.Robot.load("matched"), start, 0.4)
    ratios = [start]
    for _ in range(rounds):
        believed = umbmark(drives, believed, side=side, update=update, forms="both", rounds=1).calibrated
        ratios.append(believed.radius_ratio)
    return ratios


def bump_angle(radius: float) -> float:
    """How much further than on the flat a wheel turns over a thin bump [rad].

    It swings over the bump's edge by twice the angle at which it meets it, and gets ahead by the chord alone.
    """
    meeting = np.arccos(1 - BUMP_HEIGHT / radius)
    return float(2 * (meeting - np.sin(meeting)))


def bumps(
    drives: list[Drive], true: dd.Robot, believed: dd.Robot, side: float
) -> dict[tuple[str, str], dict[str, float]]:
    """What is found, and what it is worth on the even floor, where every run crosses bumps with its right wheel.

    The bumps are a model: the wheels turn as they did in the physics, and the right one gets less far.
    """
    found = {}
    floors = {"an even floor": None, FIRST: 0.0, SECOND: side}
    for floor, place in floors.items():
        crossed = drives if place is None else [over_bumps(drive, true, place) for drive in drives]
        for reading, method in (("positions", umbmark), ("headings", jung_chung)):
            result = method(crossed, believed, side=side)
            ends = return_errors(drives, result.calibrated)[:, :2]
            found[floor, reading] = {"radius_ratio": float(result.values[0]), "E_max": float(np.hypot(*ends.T).max())}
    return found


def over_bumps(drive: Drive, robot: dd.Robot, place: float) -> Drive:
    """The drive if the right wheel had met bumps every 5 cm from a place along the path on [m]."""
    distance = np.append(
        0.0, np.cumsum(np.abs(dd.kinematics.body_twist(np.diff(drive.wheel_angles, axis=0), robot)[:, 0]))
    )
    crossed = np.clip((distance - place) / 0.05, 0, BUMPS)
    rolled = drive.wheel_angles.copy()
    rolled[:, 1] -= bump_angle(robot.right_radius) * crossed
    return Drive(drive.t, drive.wheel_angles, dd.odometry.integrate(rolled, robot), name=drive.name)


def real_rows(folder: Path) -> list[list[object]]:
    """The published figures of a real robot, found again: by x alone, in one round, with the published update."""
    rows: list[list[object]] = []
    for name, (*published, side) in PUBLISHED.items():
        recording = folder / "square" / name
        result = umbmark(
            read_optiodom(recording), optiodom_robot(recording), side=side, update="published", forms="x", rounds=1
        )
        robot = result.calibrated
        lengths = [robot.track_width, 2 * robot.right_radius, 2 * robot.left_radius]
        errors = [1e3 * float(judged.final_position.max()) for judged in (result.before, result.after)]
        digits = np.array([1e-5] * 3 + [1e-2] * 2)
        worst = float(np.max(np.abs(np.array(lengths + errors) - published) / digits))
        rows.append([name, *(1e3 * length for length in lengths), *errors, worst])
    return rows


def draw_returns(ax, drives: list[Drive], believed: dd.Robot, calibrated: dd.Robot) -> None:
    half = len(drives) // 2
    looks = [("counter-clockwise, believed", "o", "white"), ("clockwise, believed", "s", "white")]
    for i, (label, marker, face) in enumerate(looks):
        ends = 1e3 * return_errors(drives[i * half : (i + 1) * half], believed)[:, :2]
        center = ends.mean(axis=0)
        ax.plot(*ends.T, marker, color=plots.STYLES[i]["color"], markerfacecolor=face, label=label)
        ax.annotate("", center, (0, 0), arrowprops={"arrowstyle": "->", "color": "0.4"})
        ax.annotate(f"{np.hypot(*center):.0f} mm", center / 2, xytext=(12, -2), textcoords="offset points", color="0.3")
    ends = 1e3 * return_errors(drives, calibrated)[:, :2]
    ax.plot(*ends.T, "x", color="black", label="both, calibrated")
    ax.set(xlabel="truth ends ahead of odometry by [mm]", ylabel="to the left of it by [mm]")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.15)
    ax.grid(visible=True, color="0.9")
    ax.legend(fontsize=9)
    ax.set_title("Return errors: two centroids tell two parameters", loc="left", fontsize=11)


def draw_improvement(ax, gains: dict[str, list[tuple[float, float]]]) -> None:
    for place, (name, gain) in enumerate(gains.items()):
        mismatch, times = np.array(gain).T
        at = np.unique(mismatch)
        look = plots.style(place)
        ax.plot(mismatch, times, **look | {"linestyle": "none"})
        ax.plot(at, [np.median(times[mismatch == m]) for m in at], label=name, **look | {"marker": "none"})
    ax.axvspan(LARGEST_MISMATCH, MISMATCHES[-1], color="0.88", zorder=0)
    ax.annotate("refused", (0.375, 0.4), xycoords=("data", "axes fraction"), ha="center", color="0.3", fontsize=12)
    ax.set(
        yscale="log",
        ylim=(1, 1e8),
        xlabel="mismatch: side |1 - ratio| / track",
        ylabel="E_max becomes smaller by a factor of",
    )
    ax.set_xlim(0, MISMATCHES[-1])
    ax.grid(visible=True, color="0.9")
    ax.legend(fontsize=9, loc="upper right")
    sides = ", ".join(f"{side:g}" for side in SIDES)
    ax.set_title(f"Ideal floor, sides of {sides} m: what counts is the bend", loc="left", fontsize=11)


def draw_oscillation(ax, orders: dict[str, list[float]], true: float) -> None:
    for place, (name, ratios) in enumerate(orders.items()):
        ax.plot(range(len(ratios)), ratios, label=f"{name} update", **plots.style(1 - place))
    ax.axhline(true, label="truth", **plots.PREDICTION)
    ax.set(xlabel="corrections, each from what the one before found", ylabel="radius ratio believed")
    ax.grid(visible=True, color="0.9")
    ax.legend(fontsize=9)
    ax.set_title("From wheels believed unequal: the published update swings", loc="left", fontsize=11)


def draw_bumps(ax, bumpy: dict[tuple[str, str], dict[str, float]], ratio: float, predicted: float) -> None:
    floors = list(dict.fromkeys(floor for floor, _ in bumpy))
    for place, (method, hatch, face) in enumerate((("positions", "", "0.85"), ("headings", "////", "white"))):
        values = [1e3 * bumpy[floor, method]["E_max"] for floor in floors]
        bars = ax.bar(
            np.arange(len(floors)) + 0.38 * (place - 0.5),
            values,
            0.36,
            color=face,
            edgecolor="black",
            hatch=hatch,
            label=f"by {method}",
        )
        off = [round(1e6 * (bumpy[floor, method]["radius_ratio"] - ratio)) for floor in floors]
        labels = [f"{value:.1f} mm\n{ppm} ppm" for value, ppm in zip(values, off, strict=True)]
        ax.bar_label(bars, labels, padding=2, fontsize=8)
    ax.set_xticks(range(len(floors)), [floor.replace(" as ", "\nas ") for floor in floors])
    ax.set_ylabel("E_max left on the even floor [mm]")
    ax.margins(y=0.2)
    ax.legend(fontsize=9, loc="upper left")
    said = f"{BUMPS} bumps pass for {1e6 * (predicted - ratio):+.0f} ppm of radius ratio (predicted)"
    ax.set_title(said, loc="left", fontsize=11)


if __name__ == "__main__":
    report.main(run)
