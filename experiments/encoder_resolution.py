"""How many ticks, how fast, how late?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.report import Bound, Report, plots
from diffdrive_mj.sensors.encoder import Encoder

TICKS = 2 ** np.arange(4, 17)
RATES = np.array([5, 10, 20, 50, 100, 200, 500, 1000])
LATENESS = np.array([0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100]) * 1e-3
LENGTH, SPEED, YAW_RATE = 16.0, 0.5, 1.0
RECORDED, STANDING = 1000, 0.5
# Parts of the first side and of the first turn at full speed, however late the readings.
SIDE, TURN = (2.5, 7.5), (10.78, 11.02)
# So fine that being late is an encoder's only fault, and so slow that there is room for the largest jitter.
FINE, SLOW, JITTERS = 2.0**24, 20.0, LATENESS[:8]


@dataclass(frozen=True)
class Errors:
    """What one encoder does to a drive, over the random phases of its counters.

    Attributes:
        far: of the position where the robot is farthest from its start (N,) [m].
        end: of the position at the end (N,) [m].
        heading: at the end (N,) [rad].
        law: RMS of `far` as predicted [m].
        heading_law: RMS of `heading` as predicted [rad].
    """

    far: np.ndarray
    end: np.ndarray
    heading: np.ndarray
    law: float
    heading_law: float


def run(samples: int = 80_000, seed: int = 0) -> Report:
    """How many ticks, how fast, how late?

    Args:
        samples: to try one encoder on at one rate; more of them are more random phases.
        seed: of phases and jitter.
    """
    rng = np.random.default_rng(seed)
    robot = dd.Robot.load("mismatched")
    square = drive(robot, dd.maneuvers.square(robot, side=LENGTH / 4, speed=SPEED, yaw_rate=YAW_RATE))
    slalom = drive(robot, dd.maneuvers.slalom(robot, waves=LENGTH / 4, speed=SPEED))
    drives = {"square": square, "slalom": slalom}
    tried = {
        name: [[quantised(done, ticks, rate, rng, samples) for rate in RATES] for ticks in TICKS]
        for name, done in drives.items()
    }
    sampling = {name: np.array([sampling_error(done, rate) for rate in RATES]) for name, done in drives.items()}
    latency = np.array([lateness(square, rng, latency=value) for value in LATENESS])
    jitter = np.array([lateness(square, rng, jitter=value, runs=64) for value in JITTERS])

    far = {name: np.array([[rms(errors.far) for errors in row] for row in rows]) for name, rows in tried.items()}
    end = np.array([[rms(errors.end) for errors in row] for row in tried["square"]])
    law = {name: np.array([row[0].law for row in rows]) for name, rows in tried.items()}
    # The law goes as 1 / ticks: so many, and quantisation is as large as the sampling error.
    worth = TICKS[0] * law["slalom"][0] / sampling["slalom"]

    bounds = [
        *laws(tried, sampling),
        Bound("square, back at the start / farthest corner", rms(end / far["square"]), 0.2),
        Bound("square, 5 Hz: sampling error", 1e6 * float(sampling["square"][0]), 20, "um"),
        Bound("slalom: order of the sampling error off 2 by", abs(order(sampling["slalom"]) - 2), 0.05),
        Bound("latency, moving: v tau off by", off(latency[:, 0], SPEED * LATENESS), 0.5, "%"),
        Bound("latency, turning: omega tau off by", off(latency[:, 1], YAW_RATE * LATENESS), 0.5, "%"),
        Bound("jitter, moving: v jitter / sqrt(3) off by", off(jitter[:, 0], SPEED * JITTERS / np.sqrt(3)), 3, "%"),
        Bound("latency and jitter, at rest", 1e6 * float(max(latency[:, 2].max(), jitter[:, 2].max())), 5, "um"),
    ]
    rolled = 1e3 * Encoder(ticks_per_revolution=1, sample_rate=1).distance_per_tick(robot)[0]
    quantised_rows = [
        [str(n), rolled / n, *(1e3 * x for x in (law["square"][i], *far["square"][i, [0, 3, 7]], end[i, 3]))]
        for i, n in enumerate(TICKS)
        if i % 2 == 0
    ]
    sampled_rows = [
        [f"{rate} Hz", 1e3 * sampling["square"][i], 1e3 * sampling["slalom"][i], worth[i]]
        for i, rate in enumerate(RATES)
    ]
    late_rows = [
        [f"{1e3 * value:g} ms", *(1e3 * x for x in (latency[i, 0], jitter[i, 0], latency[i, 2], jitter[i, 2]))]
        for i, value in enumerate(JITTERS)
        if i in (0, 3, 6)
    ]
    corner = ["ticks a turn: far corner [mm]", "a tick", "predicted", "5 Hz", "50 Hz", "1 kHz", "back at start, 50 Hz"]
    rate_header = ["no ticks: farthest point [mm]", "square", "slalom", "ticks worth having on the slalom"]
    late_header = ["late by [mm]", "latency, moving", "jitter, moving", "latency, at rest", "jitter, at rest"]
    table = "\n\n".join(
        report.table(header, rows)
        for header, rows in ((corner, quantised_rows), (rate_header, sampled_rows), (late_header, late_rows))
    )
    thousand, ten_ms = int(np.argmax(TICKS == 1024)), int(np.argmax(LATENESS == 0.01))
    corner_mm, late_mm = 1e3 * law["square"][thousand], 1e3 * latency[ten_ms, 0]
    share = worth[0] / RATES[0] ** 2
    hidden = rms(end / far["square"])
    finding = (
        f"Ticks turn the whole path once, by the phases in which the counters start: 1024 a turn are\n"
        f"{corner_mm:.2g} mm RMS at the far corner of a square of {LENGTH / 4:g} m, at any rate, and {hidden:.2f} of "
        f"that back at the start.\nThe rate counts where the curvature varies: on a slalom at {SPEED:g} m/s more than "
        f"{share:.2g} (rate / Hz)^2 ticks a turn\ngain nothing. 10 ms of latency are {late_mm:.2g} mm while it moves, "
        f"nothing at rest."
    )
    title = (
        f"1024 ticks: {corner_mm:.1f} mm at the far corner, at any rate.   Slalom: up to {share:.0f} (rate / Hz)² "
        f"ticks pay.   10 ms late: {late_mm:.0f} mm, while it moves"
    )
    made, axes = plots.figure(title, columns=3, size=(16.5, 5.6))
    draw_ticks(axes[0], far["square"], end, law["square"], sampling["square"])
    draw_rates(axes[1], far["slalom"], law["slalom"], sampling["slalom"], share)
    draw_lateness(axes[2], latency, jitter)
    metrics = {
        "ticks_per_revolution": TICKS,
        "rates_hz": RATES,
        "farthest_position_error_rms_m": far,
        "predicted_quantisation_rms_m": law,
        "square_final_position_error_rms_m": end,
        "sampling_error_m": sampling,
        "ticks_worth_having_on_the_slalom": worth,
        "latency": {"s": LATENESS, "moving_m": latency[:, 0], "turning_rad": latency[:, 1], "resting_m": latency[:, 2]},
        "jitter": {"s": JITTERS, "moving_rms_m": jitter[:, 0], "resting_m": jitter[:, 2]},
    }
    return Report(run.__doc__.splitlines()[0], finding, table, bounds, metrics, {"encoder_resolution": made})


def drive(robot: dd.Robot, commands: dd.Commands) -> dd.Recording:
    """Stand for a while, so that the first reading knows the pose however late it is, then drive."""
    standing = np.zeros((round(STANDING / commands.period), 2))
    delayed = dd.Commands(commands.period, np.concatenate([standing, commands.wheel_rates]))
    return dd.simulate(robot, delayed, physics=dd.Physics(timestep=1 / RECORDED), sample_rate=RECORDED)


def error(recording: dd.Recording, encoder: Encoder, rng: np.random.Generator, runs: int) -> tuple[np.ndarray, ...]:
    """The times of the readings (T,) [s], the true poses then (T, 3), and the errors of the odometry (runs, T, 3).

    The phases are random and evenly spread over the square of the two wheels' (a shifted lattice of the plastic
    number), so that a few runs tell the RMS.
    """
    phase = (np.arange(runs)[:, None] * (0.7548776662466927, 0.5698402909980532) + rng.random(2)) % 1
    readings = encoder.read(recording.t, recording.wheel_angles, rng, phase=phase)
    truth = recording.truth[np.round(RECORDED * readings.t).astype(int)]
    believed = dd.odometry.integrate(encoder.to_angles(readings.counts), recording.robot, start=recording.truth[0])
    return readings.t, truth, believed - truth


def quantised(recording: dd.Recording, ticks: int, rate: int, rng: np.random.Generator, samples: int) -> Errors:
    """An encoder that rounds, tried with random phases, and the laws of its errors.

    With d = tick_angle r, the wheels' readings are off by d (q - q_0), where q is uniform over a tick and q_0 its
    value at the start. On the way q averages out, and what stays is the heading error of q_0:
    D sqrt(d_l^2 + d_r^2) / (sqrt(12) b) at a distance D from the start. At the end, the wheel has moved by a whole
    number of ticks and a fraction f, so that q - q_0 has the variance f (1 - f).
    """
    encoder = Encoder(ticks_per_revolution=ticks, sample_rate=rate)
    runs = int(np.clip(samples / (rate * recording.t[-1]), 8, 400))
    _, truth, off_by = error(recording, encoder, rng, runs)
    away, position = np.hypot(*truth[:, :2].T), np.hypot(off_by[..., 0], off_by[..., 1])
    turns = encoder.heading_per_tick(recording.robot)
    fraction = recording.wheel_angles[-1] / encoder.tick_angle % 1
    return Errors(
        far=position[:, away.argmax()],
        end=position[:, -1],
        heading=off_by[:, -1, 2],
        law=away.max() * np.hypot(*turns) / np.sqrt(12),
        heading_law=float(np.sqrt((turns**2 * fraction * (1 - fraction)).sum())),
    )


def sampling_error(recording: dd.Recording, rate: int) -> float:
    """The position error of exact wheel angles where the robot is farthest from its start [m]."""
    seen = recording.at_rate(float(rate))
    far = np.hypot(*seen.truth[:, :2].T).argmax()
    return float(seen.drift(seen.robot).position_error[far])


def lateness(recording: dd.Recording, rng: np.random.Generator, runs: int = 1, **late: float) -> tuple[float, ...]:
    """RMS errors of encoders that are late.

    Returns:
        Of the position [m] on the first side, of the heading [rad] in the first turn, of the position [m] at the end,
        at rest.
    """
    encoder = Encoder(ticks_per_revolution=FINE, sample_rate=SLOW, **late)
    t, _, off_by = error(recording, encoder, rng, runs)
    position = np.hypot(off_by[..., 0], off_by[..., 1])
    moving, turning = ((t > first) & (t < last) for first, last in (SIDE, TURN))
    return rms(position[:, moving]), rms(off_by[:, turning, 2]), rms(position[:, -1])


def laws(tried: dict[str, list[list[Errors]]], sampling: dict[str, np.ndarray]) -> list[Bound]:
    """How far the errors of all encoders together, each over its law, are off 1."""
    over = {
        name: [
            np.concatenate([row[i].far / np.hypot(row[i].law, sampling[name][i]) for row in rows])
            for i in range(len(RATES))
        ]
        for name, rows in tried.items()
    }
    every = [errors for rows in tried.values() for row in rows for errors in row]
    heading = np.concatenate([errors.heading / errors.heading_law for errors in every])
    worst = max(abs(rms(ratios) - 1) for ratios in over["square"])
    whole = {name: abs(rms(np.concatenate(ratios)) - 1) for name, ratios in over.items()}
    return [
        Bound("square, far corner: law of quantisation off by", 100 * whole["square"], 5, "%"),
        Bound("square, far corner, at the worst rate: off by", 100 * worst, 15, "%"),
        Bound("slalom, farthest point: quantisation and sampling off by", 100 * whole["slalom"], 5, "%"),
        Bound("heading at the end: law of quantisation off by", 100 * abs(rms(heading) - 1), 5, "%"),
    ]


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def off(values: np.ndarray, predicted: np.ndarray) -> float:
    """The largest deviation [%]."""
    return 100 * float(np.abs(values / predicted - 1).max())


def order(values: np.ndarray) -> float:
    """The slope of the error against the interval, up to 100 Hz, above the physics' floor."""
    used = RATES <= 100
    return float(-np.polyfit(np.log(RATES[used]), np.log(values[used]), 1)[0])


def draw_ticks(ax, far, end, law, sampling) -> None:
    shown = {
        "far corner, read at 5 Hz": far[:, 0],
        "far corner, read at 1 kHz": far[:, -1],
        "back at the start, read at 50 Hz": end[:, 3],
    }
    plots.convergence(
        ax, TICKS, shown, predicted={"law": law}, xlabel="ticks per wheel turn", ylabel="position error, RMS [mm]"
    )
    ax.axhline(1e3 * sampling[0], color="0.5", linewidth=1)
    name(ax, "far corner, exact wheel angles, read at 5 Hz", (TICKS[0], 1e3 * sampling[0]), (0, 4))
    ax.set_xscale("log", base=2)
    ax.set_xticks(TICKS[::2], [str(n) for n in TICKS[::2]])
    finish(ax, "How many? Square of 4 m: the rate does not matter")


def draw_rates(ax, far, law, sampling, share) -> None:
    chosen = [int(np.argmax(n == TICKS)) for n in (1024, 8192, 65536)]
    plots.convergence(
        ax,
        RATES,
        {f"{TICKS[i]} ticks": far[i] for i in chosen} | {"exact wheel angles": sampling},
        predicted={str(i): np.full(len(RATES), law[i]) for i in chosen},
        xlabel="rate of the readings [Hz]",
        ylabel="",
    )
    enough = np.sqrt(TICKS[chosen] / share)
    ax.plot(enough, 1e3 * law[chosen], "o", markersize=15, markerfacecolor="none", markeredgecolor="black", zorder=5)
    for rate, error in zip(enough, 1e3 * law[chosen], strict=True):
        name(ax, f"{rate:.2g} Hz are enough", (rate, error), (8, 10))
    ax.set_xticks(RATES, [str(rate) for rate in RATES])
    finish(ax, "How fast? Slalom: from the circle on, only more ticks help")


def draw_lateness(ax, latency, jitter) -> None:
    late, shaken = 1e3 * LATENESS, 1e3 * JITTERS
    ax.plot(late, 1e3 * latency[:, 0], label="latency, moving", **plots.style(0))
    ax.plot(shaken, 1e3 * jitter[:, 0], label="jitter, moving", **plots.style(1))
    ax.plot(late, 1e3 * latency[:, 2], label="latency, at rest: the physics' own error", **plots.style(2))
    ax.plot(late, SPEED * late, label="predicted", **plots.PREDICTION)
    ax.plot(shaken, SPEED * shaken / np.sqrt(3), **plots.PREDICTION)
    ax.set(xscale="log", yscale="log", xlabel="latency, half-width of the jitter [ms]")
    ax.set_xticks(late[::3], [f"{value:g}" for value in late[::3]])
    finish(ax, f"How late? At {SPEED:g} m/s, with nearly exact wheel angles", "upper left")


def name(ax, text: str, place: tuple[float, float], offset: tuple[float, float]) -> None:
    ax.annotate(text, place, xytext=offset, textcoords="offset points", color="0.3", fontsize=9)


def finish(ax, title: str, legend: str = "upper right") -> None:
    ax.set_ylim(1e-4, 1e3)
    ax.grid(visible=True, color="0.9")
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    ax.legend(loc=legend, fontsize=9)
    ax.set_title(title, loc="left", fontsize=11)


if __name__ == "__main__":
    report.main(run)
