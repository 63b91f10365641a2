"""Euler, midpoint, exact arc against the rate: orders of convergence, the 10 degree advice, 10 Hz."""

from __future__ import annotations

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.estimation.closed_forms import arc, arc_as_printed, icc_update
from diffdrive_mj.odometry import METHODS, TEN_DEGREES, Method
from diffdrive_mj.report import Bound, Report, plots

RATES = np.array([1, 2, 4, 5, 8, 10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000])
# The ten seconds at full speed: speeding up, the wheels do not keep their ratio.
CRUISE = (2.0, 12.0)
PATHS = {"constant curvature (circle of 1 m)": "circle", "varying curvature (slalom)": "slalom"}


def run() -> Report:
    """Euler, midpoint, exact arc against the rate: orders of convergence, the 10 degree advice, 10 Hz."""
    robot = dd.Robot.load("matched")
    fine = dd.Physics(timestep=0.001)
    drives = {
        "circle": dd.maneuvers.arc(robot, radius=1.0, distance=13.0, speed=1.0, period=0.001),
        "slalom": dd.maneuvers.slalom(robot, speed=1.0, waves=3.25, wavelength=4.0, period=0.001),
    }
    recordings = {
        name: dd.simulate(robot, commands, physics=fine, sample_rate=1000).during(*CRUISE)
        for name, commands in drives.items()
    }
    errors = {name: sweep(recording, robot) for name, recording in recordings.items()}
    orders = {name: {method: order(values) for method, values in by.items()} for name, by in errors.items()}
    yaw_rate = {name: sharpest_turn(recording) for name, recording in recordings.items()}
    advice = {name: rate / TEN_DEGREES for name, rate in yaw_rate.items()}
    chord = midpoint_law(recordings["circle"])

    slalom = orders["slalom"]
    above_floor = chord > 20 * errors["circle"]["arc"]
    chord_off = np.abs(errors["circle"]["midpoint"] / chord - 1)[above_floor].max()
    turned = headed(robot)
    bounds = [
        Bound("002, ICC at 10 Hz: largest error / distance", 1e6 * turned["icc"], 5, "ppm"),
        Bound("003 with its start heading: largest error / distance", 1e6 * turned["right"], 5, "ppm"),
        Bound("003 as printed: off by, of the distance", turned["printed"], 0.5, "", at_least=True),
        *(Bound(f"euler, {name}: order off 1 by", abs(orders[name]["euler"] - 1), 0.05) for name in orders),
        *(Bound(f"midpoint, {name}: order off 2 by", abs(orders[name]["midpoint"] - 2), 0.05) for name in orders),
        Bound("exact arc, slalom: order off 2 by", abs(slalom["arc"] - 2), 0.05),
        Bound("exact arc, circle, any rate: largest error", 1e6 * float(errors["circle"]["arc"].max()), 10, "um"),
        Bound("midpoint, circle: chord law off by", 100 * float(chord_off), 2, "%"),
    ]
    at = {rate: int(np.argmax(rate == RATES)) for rate in (1, 10, 100, 1000)}
    rows = [
        [f"{name}, {method}", *(1e3 * float(values[i]) for i in at.values()), orders[name][method]]
        for name, by in errors.items()
        for method, values in by.items()
    ]
    rows = [[*row[:-1], "exact" if row[0] == "circle, arc" else row[-1]] for row in rows]
    header = ["path, method", *(f"{rate} Hz [mm]" for rate in at), "order"]
    ten = {method: f"{1e3 * values[at[10]]:.3g} mm" for method, values in errors["circle"].items()}
    finding = (
        f"At 10 Hz on a circle of 1 m, after 10 m at 1 m/s: euler {ten['euler']}, midpoint {ten['midpoint']}, "
        f"exact arc {ten['arc']}.\n10 degrees a step lie at {advice['circle']:.1f} Hz there, where the midpoint's "
        f"chord is {100 * TEN_DEGREES**2 / 24:.2f} % too long.\nWhere the curvature varies between two samples "
        f"the exact arc is of order {slalom['arc']:.2f} too."
    )
    title = f"10 m of circle at 10 Hz: Euler is {ten['euler']} off, midpoint {ten['midpoint']}, the arc {ten['arc']}"
    made, axes = plots.figure(title, columns=3, size=(17, 5.2))
    for ax, (label, name) in zip(axes[:2], PATHS.items(), strict=True):
        shown = {method: slope for method, slope in orders[name].items() if (name, method) != ("circle", "arc")}
        predicted = {"midpoint": chord} if name == "circle" else None
        plots.convergence(ax, RATES, errors[name], orders=shown, predicted=predicted)
        ax.axvline(advice[name], color="0.5", linewidth=1)
        ax.annotate(
            f"10 degrees a step\n({advice[name]:.1f} Hz)",
            (advice[name], 0.97),
            xycoords=("data", "axes fraction"),
            xytext=(4, 0),
            textcoords="offset points",
            va="top",
            color="0.35",
            fontsize=9,
        )
        ax.set_title(label, loc="left", fontsize=11)
        ax.set_ylim(1e-4, 3e3)
    plots.paths(
        axes[2], turned["truth"], {"003 as printed": turned["as_printed"], "002, 003 put right": turned["put_right"]}
    )
    axes[2].set_title("003 leaves the start heading out of its arcs", loc="left", fontsize=11)
    metrics = {
        "closed_forms": {name: turned[name] for name in ("icc", "right", "printed")},
        "rates_hz": RATES,
        "largest_position_error_m": errors,
        "orders": orders,
        "rate_of_ten_degrees_hz": advice,
        "midpoint_law_circle_m": chord,
    }
    return Report(run.__doc__, finding, report.table(header, rows), bounds, metrics, {"integrators": made})


def headed(robot: dd.Robot) -> dict:
    """002's and 003's closed forms against physics on a circle that starts with a heading of 60 degrees.

    The forms are for a constant twist, so that they start at the pose at full speed; wheel rates as commanded.
    """
    start = (0.0, 0.0, np.radians(60))
    recording = dd.simulate(robot, dd.maneuvers.arc(robot, radius=2.0, distance=9.0, speed=1.0), start=start)
    kept = (recording.t >= CRUISE[0] - 1e-9) & (recording.t <= 8.0)
    truth, t = recording.truth[kept], recording.t[kept] - CRUISE[0]
    twist = np.array([1.0, 0.5])
    put_right, as_printed = (form(truth[0], twist, t) for form in (arc, arc_as_printed))
    ten_hertz = [truth[0]]
    while len(ten_hertz) < len(t[::10]):
        ten_hertz.append(icc_update(ten_hertz[-1], twist, 0.1))
    distance = float(t[-1])
    off = {
        "icc": np.hypot(*(np.array(ten_hertz) - truth[::10])[:, :2].T).max() / distance,
        "right": np.hypot(*(put_right - truth)[:, :2].T).max() / distance,
        "printed": np.hypot(*(as_printed - truth)[:, :2].T).max() / distance,
    }
    return {**off, "truth": truth, "put_right": put_right, "as_printed": as_printed}


def sweep(recording: dd.Recording, robot: dd.Robot) -> dict[str, np.ndarray]:
    """The largest position error [m] at every rate, by method; judged at the samples of the rate itself."""
    seen = [recording.at_rate(float(rate)) for rate in RATES]
    return {method: np.array([largest(sampled, robot, method) for sampled in seen]) for method in METHODS}


def largest(recording: dd.Recording, robot: dd.Robot, method: Method) -> float:
    return float(recording.drift(robot, method).max_position)


def order(values: np.ndarray) -> float:
    """The slope of error against interval between 20 and 100 Hz, above the physics' floor and below coarse steps."""
    used = (RATES >= 20) & (RATES <= 100)
    return float(-np.polyfit(np.log(RATES[used]), np.log(values[used]), 1)[0])


def sharpest_turn(recording: dd.Recording) -> float:
    """The largest yaw rate [rad/s], over 10 ms."""
    turned = recording.at_rate(100.0)
    return float(np.abs(np.diff(turned.truth[:, 2])).max() / 0.01)


def midpoint_law(recording: dd.Recording) -> np.ndarray:
    """What the midpoint method errs by on a circle [m], by rate: its chords are longer by (x / sin x), x = dtheta / 2.

    The belief is the true circle enlarged, so that the error is (x / sin x - 1) times the distance from the start; for
    small steps dtheta^2 / 24 of it.
    """
    result = []
    for rate in RATES:
        sampled = recording.at_rate(float(rate))
        half = np.abs(np.diff(sampled.truth[:, 2])).max() / 2
        away = np.hypot(*(sampled.truth[:, :2] - sampled.truth[0, :2]).T).max()
        result.append((half / np.sin(half) - 1) * away)
    return np.array(result)


if __name__ == "__main__":
    report.main(run)
