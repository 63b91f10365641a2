"""How many ticks, how fast, how late?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.maneuvers.legs import RAMP
from diffdrive_mj.report import Bound, Report, chance, figures, plots
from diffdrive_mj.report.chance import Expected
from diffdrive_mj.sensors.counting import end_error, even_phases, wheel_counters

TICKS, RATES = [16, 64, 256, 1024, 4096, 16384, 65536], [5, 10, 25, 50, 125, 250]
RECORDED, STANDING, YAW_RATE, WAVES = 250.0, 0.5, 0.5, 4
# So fine that being late is an encoder's only fault, and so slow that there is room for the largest jitter [s].
FINE, SLOW, LATE, JITTERED = 2.0**24, 10.0, np.array([0.1, 0.3, 1, 3, 10]) * 1e-3, 64
FAR, END, HEADING = "farthest point", "end", "heading at the end"
# What the physics leaves, of the way driven.
FLOOR = 1e-6
# What one encoder leaves, by place; by ticks and rates.
Tried = list[list[dict[str, Expected]]]


def run(
    robot: str = "mismatched", side: float = 4.0, speed: float = 0.5, samples: int = 80_000, seed: int = 0
) -> Report:
    """Drive a square and a slalom, and read the wheels with encoders of many resolutions and rates.

    Args:
        robot: a preset's name, or a TOML file.
        side: of the square, and wavelength of the slalom [m].
        speed: [m/s].
        samples: to try one encoder on at one rate; more of them are more random phases.
        seed: of phases and jitter.
    """
    true, rng = dd.Robot.load(robot), np.random.default_rng(checks.whole("seed", seed, least=0))
    checks.whole("samples", samples, least=1)
    if checks.positive("side", side) < 3 * RAMP * checks.positive("speed", speed):
        raise InvalidValue(f"side = {side:g} m: must be at least {3 * RAMP * speed:g} m to be driven at full speed")
    twin = dd.tilt.level_twin(true)
    square = drive(true, dd.maneuvers.square(twin, side=side, speed=speed, yaw_rate=YAW_RATE))
    slalom = drive(true, dd.maneuvers.slalom(twin, wavelength=side, waves=WAVES, speed=speed))
    both, law = (square, slalom), simple_law(square)
    tried, bent = ([[rounded(one, n, rate, rng, samples) for rate in RATES] for n in TICKS] for one in both)
    sampled = [np.array([sampling_error(one, rate) for rate in RATES]) for one in both]
    # So many ticks, and rounding leaves as much as the rate.
    enough = simple_law(slalom) / sampled[1]
    share, late = float(enough[0] / RATES[0] ** 2), lateness(square, side, speed, rng)
    title = (
        f"1024 ticks: {1e3 * law / 1024:.2g} mm RMS at the far corner of a square of {side:g} m, at any rate.\n"
        f"On a slalom at {speed:g} m/s more than {share:.2g} (rate / Hz)$^2$ ticks gain nothing"
    )
    finding = (
        f"{title.replace('$', '')}.\nThe phases in which the counters start turn the whole path, once; back home "
        f"{1e3 * tried[3][-1][END].rms:.2g} mm are left.\n10 ms late are {10 * speed:.2g} mm on the move, none at rest."
    )
    metrics = {
        "ticks_per_revolution": TICKS,
        "rates_hz": RATES,
        "square_rms": {place: [[each[place].rms for each in row] for row in tried] for place in (FAR, END, HEADING)},
        "slalom_far_rms_m": [[each[FAR].rms for each in row] for row in bent],
        "simple_law_m": law / np.array(TICKS),
        "sampling_error_m": sampled,
        "late": {"s": LATE, **late},
    }
    bounds = rounding_claims(tried, bent, law, twin, side, speed)
    bounds += rate_claims(sampled, true, side, speed) + late_claims(late, square, side, speed)
    pictures = {"encoder_resolution": figure(title, tried, bent, (law, simple_law(slalom)), sampled[1])}
    return Report(__doc__, finding, table(tried, law, sampled, enough, late), bounds, metrics, pictures)


def drive(robot: dd.Robot, commands: dd.Commands) -> dd.Recording:
    """Stand for a while, so that the first reading knows the pose however late it is, then drive."""
    rates = np.pad(commands.wheel_rates, ((round(STANDING / commands.period), 0), (0, 0)))
    return simulate_rolling(robot, dd.Commands(commands.period, rates), sample_rate=RECORDED)


def read(recording: dd.Recording, encoder: dd.Encoder, rng: np.random.Generator, runs: int) -> tuple[Array, Array]:
    """When the robot stamps its readings (K,) [s], and how far its odometry is off then (runs, K, 3)."""
    readings = encoder.read(recording.t, recording.wheel_angles, rng, phase=even_phases(runs, rng))
    angles, twin = encoder.to_angles(readings.counts), dd.tilt.level_twin(recording.robot)
    truth = recording.truth[np.round(RECORDED * readings.t).astype(int)]
    return readings.t, dd.odometry.integrate(angles, twin, start=recording.truth[0]) - truth


def rounded(
    recording: dd.Recording, ticks: int, rate: int, rng: np.random.Generator, samples: int
) -> dict[str, Expected]:
    """An encoder that rounds, tried with random phases, and what is predicted of its errors."""
    encoder, seen = dd.Encoder(ticks_per_revolution=ticks, sample_rate=rate), recording.at_rate(float(rate))
    off = read(recording, encoder, rng, int(np.clip(samples / (rate * recording.t[-1]), 16, 400)))[1]
    twin, result = dd.tilt.level_twin(recording.robot), {}
    for place, count in ((FAR, farthest(seen) + 1), (END, len(seen.t))):
        beside = sampling_error(recording, rate, place)
        law = end_error(seen.truth[:count], wheel_counters(encoder, twin, seen.wheel_angles[:count]))
        position = np.hypot(off[:, count - 1, 0], off[:, count - 1, 1])
        result[place] = Expected(position, math.hypot(law.position, beside), law.position_kurtosis)
    return result | {HEADING: Expected(off[:, -1, 2], law.heading, law.heading_kurtosis)}


def farthest(recording: dd.Recording) -> int:
    """The sample at which the robot is farthest from its start."""
    return int(np.hypot(*(recording.truth[:, :2] - recording.truth[0, :2]).T).argmax())


def simple_law(recording: dd.Recording) -> float:
    """RMS error of an encoder of one tick at the farthest point [m]: D sqrt(d_l^2 + d_r^2) / (sqrt(12) b).

    The wheels' readings are off by d (q - q_0), where q is uniform over a tick of the length d and q_0 its value at
    the start. On the way q averages out, and q_0 stays: it turns the whole path, D away from the start.
    """
    turn = dd.Encoder(ticks_per_revolution=1, sample_rate=1).heading_per_tick(dd.tilt.level_twin(recording.robot))
    away = recording.truth[farthest(recording), :2] - recording.truth[0, :2]
    return float(np.hypot(*away) * np.hypot(*turn) / math.sqrt(12))


def sampling_error(recording: dd.Recording, rate: int, place: str = FAR) -> float:
    """The position error of exact wheel angles at the farthest point, or at the end [m]."""
    seen = recording.at_rate(float(rate))
    off = seen.drift(dd.tilt.level_twin(seen.robot)).position_error
    return float(off[farthest(seen) if place == FAR else -1])


def lateness(square: dd.Recording, side: float, speed: float, rng: np.random.Generator) -> dict[str, Array]:
    """RMS errors (L, 3) by latency and by jitter: moving [m], turning [rad] and at rest [m]."""
    corner = STANDING + RAMP + side / speed
    windows = ((STANDING + 2 * RAMP, corner - RAMP), (corner + 2 * RAMP, corner + math.pi / 2 / YAW_RATE))

    def off_by(runs: int, latency: float, jitter: float) -> list[float]:
        encoder = dd.Encoder(ticks_per_revolution=FINE, sample_rate=SLOW, latency=latency, jitter=jitter)
        t, off = read(square, encoder, rng, runs)
        moving, turning = ((t > first) & (t < last) for first, last in windows)
        position = np.hypot(off[..., 0], off[..., 1])
        return [chance.rms(part) for part in (position[:, moving], off[:, turning, 2], position[:, -1])]

    by_latency, by_jitter = [off_by(1, late, 0.0) for late in LATE], [off_by(JITTERED, 0.0, late) for late in LATE]
    return {"latency": np.array(by_latency), "jitter": np.array(by_jitter)}


def rounding_claims(tried: Tried, bent: Tried, law: float, robot: dd.Robot, side: float, speed: float) -> list[Bound]:
    """All encoders together keep the exact laws, and most the simple one, of `law` for one tick a turn."""
    cells, bounds = [(i, ticks, k, rate) for i, ticks in enumerate(TICKS) for k, rate in enumerate(RATES)], []
    turn, across = 2 * math.pi * robot.mean_radius, robot.track_width / (math.sqrt(2) * side)
    for name, place, rows in (*(("square", place, tried) for place in (FAR, END, HEADING)), ("slalom", FAR, bent)):
        # Back at the start little is left, which the first order says where a reading counts a few ticks.
        few = 4 * turn / speed if place == END else 0.0
        these = [rows[i][k][place] for i, ticks, k, rate in cells if few * rate <= ticks]
        beyond = max(each[HEADING].law for row in rows for each in row) ** 2
        bounds.append(chance.rms_bound(f"{name}, {place}", *these, beyond=beyond))
    # The simple law holds where a side is long, in ticks, in readings and in track widths.
    long = [(ticks, tried[i][k]) for i, ticks, k, rate in cells if min(ticks / turn, rate / speed) * side >= 100]
    off = 100 * float(np.median([abs(ticks * each[FAR].law / law - 1) for ticks, each in long]))
    hidden = float(np.median([each[END].rms / each[FAR].rms for _, each in long]))
    return [
        *bounds,
        Bound("square, farthest point: simple law off the exact one by, median", off, 3 + 50 * across**2, "%"),
        Bound("square, end / farthest point, median", hidden, math.hypot(0.2, across)),
    ]


def rate_claims(sampled: Sequence[Array], robot: dd.Robot, side: float, speed: float) -> list[Bound]:
    """The rate does not matter on the square; on the slalom its error is of second order."""
    bounds = []
    # A reading that covers a stop covers some way and some turn, each gathered in half of it.
    gathered = (0.5 / RATES[0]) ** 2 / 2 / RAMP
    stops = 2 * gathered**2 * speed * YAW_RATE
    allowed = 1e6 * (stops + 2 * FLOOR * side)
    if robot.servo.gains == "matched":  # others turn while they speed up
        bounds.append(Bound("square, 5 Hz: what the rate leaves", 1e6 * sampled[0][0], allowed, "um"))
    # The order shows where a step turns little and leaves more than the physics does.
    turn = math.pi**2 / 2 / side * speed / np.array(RATES)
    used = (turn < 0.2) & (sampled[1] > 3 * FLOOR * WAVES * side)
    if used.sum() > 1:
        slope = np.polyfit(np.log(np.array(RATES)[used]), np.log(sampled[1][used]), 1)[0]
        bounds.append(Bound("slalom: order of what the rate leaves off 2 by", abs(float(slope) + 2), 0.1))
    return bounds


def late_claims(late: Mapping[str, Array], square: dd.Recording, side: float, speed: float) -> list[Bound]:
    """A late reading shows where the robot was: rate of motion times lateness, beyond what the physics leaves."""
    bandwidth, track = square.robot.servo.bandwidth, square.robot.track_width
    settling = 100 * math.exp(-bandwidth * RAMP) / (bandwidth * RAMP)
    chances = 100 * chance.rms_tolerance(JITTERED * SLOW)
    bounds = []
    for name, law, allowed in (("latency", 1.0, 0.0), ("jitter", 1 / math.sqrt(3), chances)):
        for i, (motion, rate, way) in enumerate((("moving", speed, side), ("turning", YAW_RATE, 4 * side / track))):
            predicted = rate * law * LATE
            off = np.fmax(np.abs(late[name][:, i] - predicted) - FLOOR * way, 0.0) / predicted
            bounds.append(Bound(f"{name}, {motion}: off its law by", 100 * off.max(), 0.5 + settling + allowed, "%"))
    rest = max(values[:, 2].max() for values in late.values())
    return [*bounds, Bound("latency and jitter, at rest", 1e6 * float(rest), 1e6 * FLOOR * 4 * side, "um")]


def table(tried: Tried, law: float, sampled: Sequence[Array], enough: Array, late: Mapping[str, Array]) -> str:
    rounding = [
        [str(ticks), *(1e3 * x for x in (law / ticks, row[0][FAR].rms, row[-1][FAR].rms, row[-1][END].rms))]
        for ticks, row in zip(TICKS, tried, strict=True)
    ]
    rates = [[f"{rate} Hz", *row] for rate, *row in zip(RATES, *(1e3 * s for s in sampled), enough, strict=True)]
    times = [[f"{1e3 * t:g} ms", *(1e3 * late[n][i, k] for k in (0, 2) for n in late)] for i, t in enumerate(LATE)]
    headers = (
        ["ticks a turn: square, far corner [mm]", "predicted", "5 Hz", "250 Hz", "back at start, 250 Hz"],
        ["no ticks: farthest point [mm]", "square", "slalom", "ticks worth having there"],
        ["late by [mm]", "latency, moving", "jitter, moving", "latency, at rest", "jitter, at rest"],
    )
    return "\n\n".join(map(report.table, headers, (rounding, rates, times)))


def figure(title: str, tried: Tried, bent: Tried, laws: tuple[float, float], sampled: Array) -> Figure:
    """What rounding leaves on the square, with real robots' encoders, and what the rate leaves on the slalom."""
    made, (left, right) = plots.figure(title, columns=2, size=(figures.WIDTH, 5.0))
    shown = {
        "far corner, read at 5 Hz": [row[0][FAR].rms for row in tried],
        "far corner, read at 250 Hz": [row[-1][FAR].rms for row in tried],
        "back at the start": [row[-1][END].rms for row in tried],
    }
    law, labels = {"law": laws[0] / np.array(TICKS)}, ("ticks per wheel turn", "position error, RMS [mm]")
    plots.convergence(left, TICKS, shown, predicted=law, xlabel=labels[0], ylabel=labels[1])
    real = {64: "c't-Bot: 60", 4096: "TurtleBot3"}
    left.set_xticks(TICKS, [f"{ticks}\n{real.get(ticks, '')}" for ticks in TICKS])
    readings = {}
    for i in (3, 4, 6):
        # Where the law of 1 / ticks meets that of 1 / rate^2.
        enough, law_there = RATES[0] * math.sqrt(sampled[0] * TICKS[i] / laws[1]), 1e3 * laws[1] / TICKS[i]
        readings[f"{TICKS[i]} ticks: {enough:.2g} Hz are enough"] = np.array([each[FAR].rms for each in bent[i]])
        right.plot(enough, law_there, "o", markersize=13, fillstyle="none", color="black")
    readings["exact wheel angles"] = sampled
    plots.convergence(right, RATES, readings, xlabel="rate of the readings [Hz]", ylabel=labels[1])
    right.set_xticks(RATES, [str(rate) for rate in RATES])
    plots.panel(left, "Square: how many?")
    plots.panel(right, "Slalom: how fast? Circled: fast enough")
    every = 1e3 * np.concatenate([*shown.values(), *readings.values()])
    for ax in (left, right):
        ax.set(ylim=(every.min() / 3, 10 * every.max()))
        ax.minorticks_off()
    return made


if __name__ == "__main__":
    report.main(run)
