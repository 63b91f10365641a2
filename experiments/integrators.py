"""Euler, midpoint, exact arc: how far off is each at which rate, on a circle and where the curvature varies?

[Greek notes]: the midpoint, chord taken for the arc. [ct-Sim], [Behnke], [Odometrie wiki 2016]: the exact arc, and
Lucas's advice of at most 10 degrees of heading a step. On a circle all steps are wrong by one factor and one angle, so
that the errors of Euler and midpoint have a closed form at any rate; elsewhere they have an order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._text import quantity
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.closed_forms import arc, arc_as_printed, icc_update
from diffdrive_mj.judging.full_speed import SteadyArc, steady_arc
from diffdrive_mj.judging.rolling import gentle_ramp, simulate_rolling
from diffdrive_mj.judging.standards import ANY_FLOOR
from diffdrive_mj.odometry import METHODS, TEN_DEGREES
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Replay, Report, marks, plots

RATES = np.array([1, 2, 4, 5, 8, 10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000])
SECONDS, SETTLING, TEN_HERTZ = 10.0, 2.0, 10.0
START = (0.0, 0.0, np.radians(60))
CIRCLE, SLALOM = "circle", "slalom"
ORDERS = {"euler": 1, "midpoint": 2, "arc": 2}
# Where the leading order decides: the largest turn of a step [rad], the fewest steps, and how far errors are above the
# floor of the physics.
LEADING, STEPS, ABOVE = {"euler": 0.065, "midpoint": 0.2, "arc": 0.2}, 50, 30.0

Run = dd.Recording[dd.Robot, dd.Commands]


@dataclass(frozen=True)
class Path:
    """Ten seconds at full speed.

    Attributes:
        length: [m].
        yaw_rate: the largest [rad/s].
        errors: largest position errors at each of `RATES`, by method [m].
    """

    length: float
    yaw_rate: float
    errors: dict[str, np.ndarray]


def run(robot: str = "matched", radius: float = 1.0, speed: float = 1.0) -> Report:
    """Drive a circle and a slalom, and compute odometry at every rate.

    Args:
        robot: a preset's name, or a TOML file.
        radius: of the circle; the sharpest bend of the slalom has 0.81 of it [m].
        speed: [m/s].
    """
    true = dd.Robot.load(robot)
    circle, slalom = drive(true, checks.positive("radius", radius), checks.positive("speed", speed))
    paths = {CIRCLE: judge(circle), SLALOM: judge(slalom)}
    found = orders(paths[SLALOM])
    laws = circle_laws(circle)
    steady = steady_arc(circle, level_twin(true))
    answer = finding(paths)
    return Report(
        question=__doc__,
        finding=answer,
        table=table(paths, laws, found),
        bounds=[*claims(paths, laws, found, steady), *closed_forms(steady)],
        metrics={
            "rates_hz": RATES,
            "largest_position_error_m": {name: path.errors for name, path in paths.items()},
            "circle_laws_m": laws,
            "slalom_orders": found,
        },
        pictures={"integrators": figure(answer.splitlines()[0], paths, laws, found)},
        replays=[replay(name, run) for name, run in ((CIRCLE, circle), (SLALOM, slalom))],
    )


def drive(robot: dd.Robot, radius: float, speed: float) -> list[Run]:
    """Both drives in physics, at every millisecond, with some time for the servos to catch up."""
    twin, ramp, step = level_twin(robot), gentle_ramp(robot, speed), 1 / float(RATES[-1])
    begin = ramp + SETTLING
    t = step * np.arange(checks.samples("ramp", begin + SECONDS, step) + 1)
    along = speed * np.where(t < ramp, t**2 / (2 * ramp), t - ramp / 2)
    headings = (along / radius, np.pi / 4 * np.sin(np.pi / 2 * along / radius))
    motions = [np.diff(np.stack([along, heading], axis=-1), axis=0) / step for heading in headings]
    commands = [dd.Commands(step, dd.kinematics.wheel_rates(motion, twin)) for motion in motions]
    fine, rate = dd.Physics(timestep=step), float(RATES[-1])
    runs = simulate_rolling([robot] * 2, commands, physics=fine, sample_rate=rate, start=START).runs
    return [run.during(begin, begin + SECONDS) for run in runs]


def judge(recording: Run) -> Path:
    """The errors of every method at every rate, at the samples of the rate itself."""
    twin, seen = level_twin(recording.robot), [recording.at_rate(float(rate)) for rate in RATES]
    turns = np.abs(np.diff(recording.at_rate(100.0).truth[:, 2]))
    return Path(
        length=float(recording.drift(twin).distance),
        yaw_rate=100 * float(turns.max()),
        errors={m: np.array([float(run.drift(twin, m).max_position) for run in seen]) for m in METHODS},
    )


def replay(name: str, recording: Run) -> Replay:
    """What every method makes of a drive at 10 Hz."""
    seen, twin = recording.at_rate(TEN_HERTZ), level_twin(recording.robot)
    beliefs = {str(method): seen.odometry(twin, method) for method in METHODS}
    return Replay(f"The {name} at {TEN_HERTZ:g} Hz", seen.t, seen.truth, beliefs, twin)


def circle_laws(circle: Run) -> dict[str, np.ndarray]:
    """What the methods are off by on a circle [m]; nan where a step turns by more than 3 rad.

    With x half of a step's turn, the true chord is sinc(x) of the step and lies x ahead of the heading at its start.
    The midpoint method makes the circle larger by x / sin x, Euler turns it back by x as well; at a distance D from the
    start they are off by D |x / sin x - 1| and D |exp(-i x) x / sin x - 1|.
    """
    elapsed = float(circle.t[-1] - circle.t[0])
    x = np.abs(circle.truth[-1, 2] - circle.truth[0, 2]) / elapsed / RATES / 2
    x = np.where(x < 1.5, x, np.nan)
    farthest = np.array([np.abs(complex_path(circle.at_rate(float(rate)))).max() for rate in RATES])
    return {
        "euler": farthest * np.abs(np.exp(-1j * x) * x / np.sin(x) - 1),
        "midpoint": farthest * np.abs(x / np.sin(x) - 1),
        "arc": np.zeros(len(RATES)),
    }


def complex_path(recording: Run) -> np.ndarray:
    """The places relative to the first, as complex numbers."""
    return (recording.truth[:, :2] - recording.truth[0, :2]) @ (1, 1j)


def orders(slalom: Path) -> dict[str, float]:
    """By method, the slope of error against interval where the leading order decides, if three rates show it."""
    found, turns = {}, slalom.yaw_rate / RATES
    for method, errors in slalom.errors.items():
        far = errors > ABOVE * 1e-6 * ANY_FLOOR * slalom.length
        shown = far & (turns < LEADING[method]) & (RATES * SECONDS >= STEPS)
        if shown.sum() >= 3:
            found[method] = float(-np.polyfit(np.log(RATES[shown]), np.log(errors[shown]), 1)[0])
    if not found:
        raise InvalidValue(
            f"speed / radius: a yaw rate of {slalom.yaw_rate:.2g} rad/s leaves less than three of the rates from 1 to "
            "1000 Hz to see an order at; drive faster, or a smaller circle"
        )
    return found


def claims(
    paths: dict[str, Path], laws: dict[str, np.ndarray], found: dict[str, float], steady: SteadyArc
) -> list[Bound]:
    """On the circle the laws at every rate, on the slalom the orders."""
    circle = paths[CIRCLE]
    off = {m: 1e6 * float(np.nanmax(np.abs(circle.errors[m] - law))) / circle.length for m, law in laws.items()}
    allowed = ANY_FLOOR + steady.unsteady
    return [
        *(
            Bound(f"{m}, circle, any rate: off its law by", value, allowed, "ppm of the path")
            for m, value in off.items()
        ),
        *(Bound(f"{m}, slalom: order off {ORDERS[m]} by", abs(seen - ORDERS[m]), 0.05) for m, seen in found.items()),
    ]


def closed_forms(steady: SteadyArc) -> list[Bound]:
    """The documents' formulas for a constant twist, on a circle with a start heading, which one of them leaves out."""
    truth, elapsed = steady.recording.truth, steady.recording.t - steady.recording.t[0]
    stride = round((len(elapsed) - 1) / elapsed[-1] / TEN_HERTZ)
    at_ten = [truth[0]]
    while len(at_ten) < len(truth[::stride]):
        at_ten.append(icc_update(at_ten[-1], steady.twist, 1 / TEN_HERTZ))
    length, allowed = steady.speed * float(elapsed[-1]), ANY_FLOOR + steady.unsteady
    drift = dd.metrics.drift
    printed = drift(truth, arc_as_printed(truth[0], steady.twist, elapsed)).position_error
    # Without its start heading the arc is turned back about its start.
    law = np.hypot(*(truth - truth[0])[:, :2].T) * 2 * abs(np.sin(truth[0, 2] / 2))
    off = {
        "[Behnke], ICC at 10 Hz: off by": float(drift(truth[::stride], np.array(at_ten)).max_position),
        "[Odometrie wiki 2016], with its start heading: off by": float(
            drift(truth, arc(truth[0], steady.twist, elapsed)).max_position
        ),
        "[Odometrie wiki 2016], as printed: turned back by its start heading, to": float(np.abs(printed - law).max()),
    }
    return [Bound(name, 1e6 * value / length, allowed, "ppm of the path") for name, value in off.items()]


def finding(paths: dict[str, Path]) -> str:
    """The answer; its first line is the picture's title."""
    circle, slalom, ten = paths[CIRCLE], paths[SLALOM], int(np.argmax(RATES == TEN_HERTZ))
    euler, midpoint, exact = (quantity(circle.errors[method][ten], "m") for method in METHODS)
    bent = quantity(slalom.errors["arc"][ten], "m")
    advice = circle.yaw_rate / TEN_DEGREES
    return (
        f"{circle.length:.3g} m of circle at 10 Hz: Euler is {euler} off, midpoint {midpoint}, the arc {exact}\n"
        f"Where the curvature varies inside a step the arc is of second order too: {bent} on the slalom at 10 Hz.\n"
        f"On the circle 10 degrees a step lie at {advice:.2g} Hz, where the midpoint's chord is "
        f"{100 * TEN_DEGREES**2 / 24:.2f} % too long."
    )


def table(paths: dict[str, Path], laws: dict[str, np.ndarray], found: dict[str, float]) -> str:
    """Errors at four rates, and the orders."""
    shown = [int(np.argmax(rate == RATES)) for rate in (1, 10, 100, 1000)]
    rows: list[list[object]] = []
    for name, path in paths.items():
        for method, errors in path.errors.items():
            seen = "law" if name == CIRCLE else f"{found[method]:.3f}" if method in found else "not seen"
            rows.append([f"{name}, {method}", *(1e3 * float(errors[k]) for k in shown), seen])
    rows += [[f"circle, {method}: law", *(1e3 * float(laws[method][k]) for k in shown), ""] for method in METHODS[:2]]
    return report.table(["path, method", *(f"{RATES[k]} Hz [mm]" for k in shown), "order"], rows)


def figure(title: str, paths: dict[str, Path], laws: dict[str, np.ndarray], found: dict[str, float]) -> Figure:
    """The errors against the rate, on both paths."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.7))
    plots.convergence(left, RATES, paths[CIRCLE].errors, predicted={m: laws[m] for m in ("euler", "midpoint")})
    plots.panel(left, "Constant curvature (circle)")
    plots.convergence(right, RATES, paths[SLALOM].errors, orders=found)
    plots.panel(right, "Varying curvature (slalom)")
    every = 1e3 * np.array([errors for path in paths.values() for errors in path.errors.values()])
    for ax, path in ((left, paths[CIRCLE]), (right, paths[SLALOM])):
        ax.set_ylim(every.min() / 30, 30 * every.max())
        mark_advice(ax, path.yaw_rate / TEN_DEGREES)
    return made


def mark_advice(ax: Axes, rate: float) -> None:
    """Where 10 degrees a step lie."""
    ax.axvline(rate, color="0.5", linewidth=1, zorder=0)
    ax.set_xlim(0.7 * min(RATES[0], rate), 1.4 * RATES[-1])
    marks.note(ax, f"10 degrees a step\n({rate:.2g} Hz)", (rate, ax.get_ylim()[0]), (5, 4))


if __name__ == "__main__":
    report.main(run)
