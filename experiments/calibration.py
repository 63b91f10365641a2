"""Which method recovers a robot best, with how much driving and how fine an encoder? And on a real robot's logs?

Antonelli et al. 2005 and Censi et al. 2013 (the heading is linear in the wheel angles), refined over whole
trajectories; [Petersen 2013]'s robot, which knows positions but no headings; UMBmark, and Jung and Chung's form of it.
What least squares may be off by follows from the noise of the poses and from the ticks (`judging.accuracy`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.calibration.squares import jung_chung, umbmark
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import CalibrationRefused
from diffdrive_mj.estimation.derivatives import PARAMETERS
from diffdrive_mj.judging import optiodom
from diffdrive_mj.judging.accuracy import Fits, expected_covariance, mixed_drive
from diffdrive_mj.judging.held_out import fitted_on
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.metrics import Drift, travelled
from diffdrive_mj.report import Bound, Replay, Report, chance, plots
from diffdrive_mj.report.chance import Expected

LEAST_SQUARES, FIXES = "least squares", "fixes without headings"
Drifts = Mapping[str, Mapping[str, Drift]]  # by fit and by recording
Case = tuple[str, float, int]  # method, metres, ticks a turn of the wheel
# Of the robots' radii and track; of the squares in track widths, short enough for most of such wheels.
SPREAD, SIDE = 0.1, 2.5
LENGTHS, TICKS = (5.0, 10.0, 20.0), (64, 256, 1024, 4096)
RATE, TRACKER = 50.0, dd.Tracker(sample_rate=10.0, position_noise=1e-3, heading_noise=1e-3)
# The law is of first order in what a tick turns the robot by.
BEYOND = 0.1


def run(robot: str = "matched", robots: int = 20, data: str = "", seed: int = 0) -> Report:
    """Calibrate random robots, and a real one if its logs are there.

    Args:
        robot: a preset's name or a TOML file: the robot as believed.
        robots: number of random ones, radii and track within 10 % of the believed.
        data: folder of the OptiOdom logs; without it the real robot is left out.
        seed: of the robots and of the noise.
    """
    logs = optiodom.read_recordings(data) if data else None
    believed, rng = dd.Robot.load(robot), np.random.default_rng(checks.whole("seed", seed, least=0))
    true = [similar(believed, rng) for _ in range(checks.whole("robots", robots, least=1))]
    fits, squares = sweep(believed, true, rng), on_squares(believed, true, rng)
    fine, coarse = (fits[LEAST_SQUARES, LENGTHS[-1], ticks].rms for ticks in (TICKS[-1], TICKS[0]))
    title = (
        f"{LENGTHS[-1]:g} m of driving show radii and track within {1e6 * fine[0]:.0f} ppm RMS at {TICKS[-1]} ticks a "
        f"turn.\nAt {TICKS[0]} ticks it is {1e6 * coarse[0]:.0f} ppm, and the fit states {1e6 * coarse[2]:.0f}"
    )
    finding = f"{title}.\nTrue poses are known to 1 mm and 1 mrad, ten times a second."
    metrics: dict[str, object] = {
        "rms_found_expected_stated": {", ".join(map(str, case)): found.rms for case, found in fits.items()},
        "squares_ratio_and_track": squares,
    }
    bounds, tables = claims(fits), [table(fits, squares, len(true))]
    pictures = {"calibration": figure(title, fits, squares, 8 * SIDE * believed.track_width)}
    if logs is None:
        finding += " The real robot was left out: --data names the folder of its logs."
    else:
        real = optiodom.drifts(logs)
        nominal, left = (1e3 * pooled(real[label]) for label in (optiodom.NOMINAL, optiodom.UNSEEN))
        title = (
            f"A real robot, judged on recordings outside its fit: {nominal:.0f} mm RMS at the end as nominal,\n"
            f"{left:.0f} mm as fitted on the other recordings"
        )
        bounds, tables, finding = [*bounds, *real_claims(real)], [*tables, real_table(real)], f"{finding}\n{title}."
        metrics["real_final_position_rms_m"] = {
            label: {name: drift.final_position_rms for name, drift in by.items()} for label, by in real.items()
        }
        pictures["calibration_real_robot"] = real_figure(title, real, logs)
    replays = [before_and_after(believed, true[0], seed)]
    return Report(__doc__, finding, "\n\n".join(tables), bounds, metrics, pictures, replays)


def similar(believed: dd.Robot, rng: np.random.Generator) -> dd.Robot:
    """A robot that is not quite the believed one."""
    fields = zip(PARAMETERS[:3], 1 + rng.uniform(-SPREAD, SPREAD, 3), strict=True)
    return believed.replace(**{field: getattr(believed, field) * factor for field, factor in fields})


def sweep(believed: dd.Robot, true: Sequence[dd.Robot], rng: np.random.Generator) -> dict[Case, Fits]:
    """The methods on drives of many lengths, and least squares with many encoders."""
    recording = simulate_rolling(true, mixed_drive(believed), physics=dd.Physics.fast(), sample_rate=RATE)
    cases = [(method, metres, TICKS[-1]) for method in (LEAST_SQUARES, FIXES) for metres in LENGTHS]
    cases += [(LEAST_SQUARES, LENGTHS[-1], ticks) for ticks in TICKS[:-1]]
    return {case: fit(recording.runs, believed, case, rng) for case in cases}


def fit(runs: Sequence[dd.Recording], believed: dd.Robot, case: Case, rng: np.random.Generator) -> Fits:
    """Calibrate each robot from what its encoders and the tracker say of the first metres of its drive."""
    method, metres, ticks = case
    encoder = dd.Encoder(ticks_per_revolution=ticks, sample_rate=RATE)
    ends = [min(int(np.searchsorted(travelled(run.truth), metres)), len(run.t) - 1) for run in runs]
    driven = [run.during(0.0, run.t[end]) for run, end in zip(runs, ends, strict=True)]
    drives = [dd.sensors.measure(run, encoder=encoder, tracker=TRACKER, seed=rng) for run in driven]
    headings = method == LEAST_SQUARES
    found = [least_squares([drive], believed, turning_gain=False, headings=headings) for drive in drives]
    expected = [expected_covariance(run, encoder, TRACKER, headings=headings) for run in driven]
    return Fits.of(found, [run.robot for run in runs], expected)


def before_and_after(believed: dd.Robot, true: dd.Robot, seed: int) -> Replay:
    """A figure eight of the first robot, as it was believed and as calibrated on a drive of 20 m."""
    commands = [mixed_drive(believed), dd.maneuvers.figure_eight(believed, radius=1.0)]
    calibrating, unseen = (
        simulate_rolling(true, each, physics=dd.Physics.fast(), sample_rate=RATE) for each in commands
    )
    encoder = dd.Encoder(ticks_per_revolution=TICKS[-1], sample_rate=RATE)
    drive = dd.sensors.measure(calibrating, encoder=encoder, tracker=TRACKER, seed=seed)
    found = least_squares([drive], believed, turning_gain=False).calibrated
    beliefs = {"before calibration": believed, "calibrated": found}
    return Replay.of("A figure eight that the calibration has not seen", unseen, beliefs)


def on_squares(believed: dd.Robot, true: Sequence[dd.Robot], rng: np.random.Generator) -> dict[str, Array]:
    """Relative errors of radius ratio and track over mean radius (M, 2), of M robots whose squares are not too bent.

    From one square each way round; the mean radius cannot be seen.
    """
    side, each = SIDE * believed.track_width, [robot for robot in true for _ in range(2)]
    commands = [dd.maneuvers.square(believed, side=side, clockwise=way) for way in (False, True)] * len(true)
    recording = simulate_rolling(each, commands, physics=dd.Physics.fast(), sample_rate=RATE)
    encoder = dd.Encoder(ticks_per_revolution=TICKS[-1], sample_rate=RATE)
    drives = dd.sensors.measure(recording, encoder=encoder, tracker=TRACKER, seed=rng)
    result = {}
    for name, method in (("UMBmark", umbmark), ("Jung and Chung", jung_chung)):
        errors = []
        for i, twin in enumerate(map(dd.tilt.level_twin, true)):
            try:
                found = method(drives[2 * i : 2 * i + 2], believed, side=side).calibrated
            except CalibrationRefused:
                continue
            tracks = [robot.track_width / robot.mean_radius for robot in (found, twin)]
            errors.append((found.radius_ratio / twin.radius_ratio - 1, tracks[0] / tracks[1] - 1))
        result[name] = np.array(errors).reshape(-1, 2)
    return result


def claims(fits: Mapping[Case, Fits]) -> list[Bound]:
    """All errors are what the noise of the poses and the ticks leave."""
    groups: dict[str, list[Expected]] = {}
    for (method, _, ticks), found in fits.items():
        name = f"{method}, by length" if ticks == TICKS[-1] else f"{method}, by ticks"
        groups.setdefault(name, []).append(Expected(found.standard, law=1.0))
    return [chance.rms_bound(name, *samples, beyond=BEYOND) for name, samples in groups.items()]


def table(fits: Mapping[Case, Fits], squares: Mapping[str, Array], robots: int) -> str:
    rows: list[list[object]] = [
        [f"{method}, {metres:g} m, {ticks} ticks", *(1e6 * rms for rms in found.rms)]
        for (method, metres, ticks), found in fits.items()
    ]
    answered = [
        [f"{name} ({len(errors)} of {robots} answered)", *(1e6 * chance.rms(part) for part in errors.T)]
        for name, errors in squares.items()
        if len(errors)
    ]
    tables = [report.table(["radii and track, RMS [ppm]", "found", "predicted", "stated by the fit"], rows)]
    if answered:
        tables.append(report.table(["a square each way round, RMS [ppm]", "radius ratio", "track / radius"], answered))
    return "\n\n".join(tables)


def figure(title: str, fits: Mapping[Case, Fits], squares: Mapping[str, Array], metres: float) -> Figure:
    """What a longer drive brings, and what finer ticks bring."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 5.0))
    label = "RMS error of radii and track [ppm]"
    both = {m: np.array([fits[m, length, TICKS[-1]].rms for length in LENGTHS]) for m in (LEAST_SQUARES, FIXES)}
    plots.convergence(
        left, LENGTHS, {method: by[:, 0] for method, by in both.items()},
        predicted={method: by[:, 1] for method, by in both.items()},
        xlabel="driven for the calibration [m]", ylabel=label, scale=1e6,
    )  # fmt: skip
    for index, (name, errors) in enumerate(squares.items(), start=2):
        if len(errors):
            look = plots.style(index) | {"linestyle": "none", "markersize": 8}
            left.plot(metres, 1e6 * chance.rms(errors), label=f"{name}: ratio and track", **look)
    found, predicted, stated = np.array([fits[LEAST_SQUARES, LENGTHS[-1], ticks].rms for ticks in TICKS]).T
    plots.convergence(
        right, TICKS, {LEAST_SQUARES: found}, predicted={LEAST_SQUARES: predicted},
        xlabel="ticks per wheel turn", ylabel=label, scale=1e6,
    )  # fmt: skip
    right.plot(TICKS, 1e6 * stated, label="as the fit states it", **plots.style(5))
    panels = (
        (left, LENGTHS, f"More driving, {TICKS[-1]} ticks a turn"),
        (right, TICKS, f"Finer ticks, {LENGTHS[-1]:g} m"),
    )
    for ax, places, name in panels:
        ax.set_xticks(places, [f"{place:g}" for place in places])
        ax.minorticks_off()
        ax.set_ylim(10, max(3000, ax.get_ylim()[1]))
        plots.panel(ax, name)
    plots.legend_below(made, left, right, columns=3)
    return made


def pooled(drifts: Mapping[str, Drift]) -> float:
    """Root mean square of the final position errors, each recording counted alike [m]."""
    return chance.rms([drift.final_position_rms for drift in drifts.values()])


def real_claims(real: Drifts) -> list[Bound]:
    """The published figures, and what calibration is worth on drives that it has not seen."""
    circles, free = real[optiodom.ON_CIRCLES][optiodom.CIRCLES], optiodom.FREE
    end, way = (1e3 * float(errors.max()) for errors in (circles.final_position, circles.max_position))
    joint, nominal = (real[label][free].final_position_rms for label in (optiodom.ON_SAME_DAYS, optiodom.NOMINAL))

    def gain(plain: str, with_gain: str, *names: str) -> list[float]:
        return [real[with_gain][name].final_position_rms / real[plain][name].final_position_rms for name in names]

    kept = max(gain(optiodom.UNSEEN_DAYS, optiodom.UNSEEN_DAYS_GAIN, optiodom.SQUARE_A, optiodom.SQUARE_B))
    helped = sum(ratio < 1 for ratio in gain(optiodom.UNSEEN, optiodom.UNSEEN_GAIN, *optiodom.FOLDERS))
    return [
        Bound("real, fitted on circles: largest final error there (published)", end, 9.15, "mm"),
        Bound("real, fitted on circles: largest error on the way (published)", way, 22.0, "mm"),
        Bound("real, fitted on the same days: final RMS on the free drives / nominal", joint / nominal, 0.5),
        Bound("real, turning gain: error left on an unseen square of the same days", kept, 0.6),
        Bound("real, turning gain: recordings outside the fit that it helps", helped, 3, "of 5", at_least=True),
    ]


def real_table(real: Drifts) -> str:
    rows = [
        [label, *(1e3 * by[name].final_position_rms if name in by else "" for name in optiodom.FOLDERS)]
        for label, by in real.items()
    ]
    return report.table(["real robot: final position, RMS [mm]", *optiodom.FOLDERS], rows)


def real_figure(title: str, real: Drifts, logs: Mapping[str, Sequence[Drive]]) -> Figure:
    """What is left on each recording by a fit on the others, and a path that the fit has not seen."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.8), widths=(1.3, 1))
    shown = (optiodom.NOMINAL, optiodom.UNSEEN, optiodom.UNSEEN_GAIN)
    for index, label in enumerate(shown):
        heights = [1e3 * drift.final_position_rms for drift in real[label].values()]
        look = {"color": plots.style(index)["color"], "hatch": ("", "//", "..")[index], "edgecolor": "white"}
        left.bar(np.arange(len(heights)) + 0.27 * (index - 1), heights, 0.27, label=label, **look)
    left.set_xticks(range(len(optiodom.FOLDERS)), list(optiodom.FOLDERS))
    left.set(ylabel="final position error, RMS [mm]")
    plots.panel(left, "On each recording")
    drive = logs[optiodom.FREE][0]
    others = fitted_on(logs, optiodom.fit, *(name for name in logs if name != optiodom.FREE))
    beliefs = {optiodom.NOMINAL: dd.Robot.load("optiodom"), optiodom.UNSEEN: others}
    plots.paths(right, drive.truth, {label: drive.odometry(robot) for label, robot in beliefs.items()})
    plots.panel(right, "A free drive")
    plots.legend_below(made, left, right, columns=3)
    return made


if __name__ == "__main__":
    report.main(run)
