"""What does the bidirectional square reveal, and when does it mislead?"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._files import folder_with
from diffdrive_mj.calibration import Calibration, jung_chung, umbmark
from diffdrive_mj.calibration._square import corrected
from diffdrive_mj.calibration._square_drives import LARGEST_MISMATCH, return_errors
from diffdrive_mj.judging.bumps import bump_angle, over_bumps
from diffdrive_mj.judging.optiodom import FOLDERS
from diffdrive_mj.judging.published_squares import PUBLISHED, SquareFigures, umbmark_figures
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.judging.square_trials import Trial, median_gain, trial
from diffdrive_mj.report import Bound, Replay, Report, chance, figures, marks, plots

# Sides in track widths, and how far they are bent: side |1 - radius ratio| / track [rad].
# The robots that drive them have a track of 0.99 times what is believed.
SIDES, MISMATCHES = (2.5, 5.0, 10.0), (0.05, 0.10, 0.15, 0.22, 0.29, 0.35, 0.45)
AS_PUBLISHED, EXACT = "published, 1 round", "exact angles, composed, 3 rounds"
METHODS: dict[str, Callable[..., Calibration]] = {
    AS_PUBLISHED: partial(umbmark, update="published", forms="both", rounds=1),
    "first order, composed, 3 rounds": partial(umbmark, forms="both"),
    EXACT: umbmark,
}
MANY = 16  # runs in each direction, which show the scatter of any number of them
# Bumps under the right wheel: their height in wheel radii, their spacing in sides, and on which side they begin.
BUMPS, HEIGHT, SPACING, FLOORS = 10, 0.1, 1 / 80, {"bumps on the first side": 0.0, "bumps on the second side": 1.0}
REAL = ["real robot [mm]", "track", "right diameter", "left diameter", "E before", "E after"]
LEFT_OUT = "real robot: left out, since --data names no folder of its recordings"
Trials = Mapping[str, Sequence[Trial]]  # by method
Misled = Mapping[tuple[str, str], tuple[float, float]]


def run(
    robot: str = "matched",
    side: float = 4.0,
    radius_ratio: float = 0.995,
    track_error: float = 0.01,
    runs: int = 5,
    position_noise: float = 1e-3,
    heading_noise: float = 1e-3,
    seed: int = 0,
    data: str = "",
) -> Report:
    """Drive squares in both directions, in physics, and calibrate on them with UMBmark and its variants.

    Args:
        robot: a preset's name, or a TOML file; its mean radius and track width are kept.
        side: of the square of the noisy runs [m].
        radius_ratio: of the true robot; the believed one takes its wheels for equal.
        track_error: by what part the believed track is too wide.
        runs: in each direction.
        position_noise: of the measured poses [m].
        heading_noise: of the measured poses [rad].
        seed: of the noise and of the encoder's phases.
        data: folder of the OptiOdom recordings; without it the real robot is left out.
    """
    folder = folder_with("data", data, [FOLDERS[name] for name in PUBLISHED]) if data else None
    rng, runs = np.random.default_rng(checks.whole("seed", seed, least=0)), checks.whole("runs", runs, least=1)
    tracker = dd.Tracker(position_noise=position_noise, heading_noise=heading_noise)
    loaded = dd.Robot.load(robot)
    base = corrected(loaded, 1.0, loaded.track_width)
    believed = base.replace(track_width=base.track_width * (1 + checks.number("track_error", track_error)))
    true = corrected(base, checks.positive("radius_ratio", radius_ratio), base.track_width)
    squares, grid = drive_all(base, believed, true, checks.positive("side", side))
    measured, many = (repeated(squares, tracker, count, rng) for count in (runs, MANY))
    found, scatter = umbmark(measured, believed, side=side), umbmark(many, believed, side=side)
    tried = trials(grid, base)
    rounds = {update: oscillation(grid[5.0, 0.05], base, update) for update in ("published", "composed")}
    misled = bumps(squares, true, believed, side)
    real = {name: umbmark_figures(folder, name) for name in PUBLISHED} if folder else {}
    before, after = (1e3 * found.details[f"E_max_{when}"] for when in ("before", "after"))
    title = (
        f"The square takes E_max from {before:.0f} to {after:.1f} mm.\n"
        f"Where its sides bend by more than {LARGEST_MISMATCH:g} rad it would mislead, and is refused"
    )
    finding = (
        f"{title}.\nIt reveals the radius ratio and the track, not the mean radius. It also misleads with the "
        f"published update from\nwheels believed unequal, and on bumps: {BUMPS} of a tenth of the radius under "
        f"one wheel put the radius ratio up to {-1e6 * min(off for off, _ in misled.values()):.0f} ppm off."
    )
    bounds = noise_claims(true, found, scatter, runs) + method_claims(tried, rounds)
    bounds += bump_claims(misled, believed, true, side)
    for name, one in real.items():
        off = one.digits_off(PUBLISHED[name][0])
        bounds.append(Bound(f"real robot, {name}: off what is published by", off, 1, "digits"))
    metrics = {
        "radius_ratio_track_m": {"found": found.values, "std": found.std},
        "E_max_mm": {"before": before, "after": after},
        "improvement": {name: [(one.bent, one.gain) for one in of] for name, of in tried.items()},
        "refused": sorted({one.refusal for of in tried.values() for one in of if one.refusal}),
        "ratio_after_rounds": rounds,
        "bumps": {f"{floor}, {method}": value for (floor, method), value in misled.items()},
        "real_robot_mm": {name: vars(one) for name, one in real.items()},
    }
    picture = {"umbmark": figure(title, measured, believed, found.calibrated, tried)}
    beliefs = {"before calibration": believed, "calibrated": found.calibrated}
    replays = [
        Replay.of(f"The square, {way}", square, beliefs)
        for way, square in zip(("counter-clockwise", "clockwise"), squares, strict=True)
    ]
    return Report(__doc__, finding, table(tried, rounds, misled, real), bounds, metrics, picture, replays)


def drive_all(
    base: dd.Robot, believed: dd.Robot, true: dd.Robot, side: float
) -> tuple[list[dd.Recording], dict[tuple[float, float], list[dd.Drive]]]:
    """In the physics, in both directions: the true robot on its square, and robots of every mismatch on every side."""
    keys, track = [(tracks, mismatch) for tracks in SIDES for mismatch in MISMATCHES], base.track_width
    cases = [(believed, true, side)]
    cases += [(base, corrected(base, 1 - bent / tracks, 0.99 * track), tracks * track) for tracks, bent in keys]
    commands = [
        dd.maneuvers.square(driver, side=length, speed=min(length / 4, 1.0), yaw_rate=2.0, clockwise=clockwise)
        for driver, _, length in cases
        for clockwise in (False, True)
    ]
    longest, robots = max(each.duration for each in commands), [robot for _, robot, _ in cases for _ in range(2)]
    recording = simulate_rolling(
        robots, [each.extended(longest) for each in commands], sample_rate=20.0, physics=dd.Physics.fast()
    )
    drives = dd.sensors.measure(recording)
    return list(recording.runs[:2]), {key: drives[2 * i + 2 : 2 * i + 4] for i, key in enumerate(keys)}


def repeated(
    squares: Sequence[dd.Recording], tracker: dd.Tracker, runs: int, rng: np.random.Generator
) -> list[dd.Drive]:
    """The squares measured again and again: poses with noise, wheel angles in whole ticks."""
    encoder, again = dd.Encoder(squares[0].robot, sample_rate=20.0), range(runs)
    return [dd.sensors.measure(s, encoder=encoder, tracker=tracker, seed=rng) for s in squares for _ in again]


def trials(grid: Mapping[tuple[float, float], list[dd.Drive]], base: dd.Robot) -> Trials:
    """Every method on every square."""
    found: dict[str, list[Trial]] = {name: [] for name in METHODS}
    for (tracks, bent), drives in grid.items():
        for name, method in METHODS.items():
            found[name].append(trial(method, drives, base, side=tracks * base.track_width, bent=bent))
    return found


def oscillation(drives: list[dd.Drive], base: dd.Robot, update: str) -> list[float]:
    """The radius ratios of one correction after another, for the better or the worse, from wheels believed unequal."""
    robots, side = [corrected(base, 0.975, base.track_width)], SIDES[1] * base.track_width
    for _ in range(6):
        robots.append(METHODS[AS_PUBLISHED](drives, robots[-1], side=side, update=update, anyway=True).calibrated)
    return [robot.radius_ratio for robot in robots]


def bumps(squares: Sequence[dd.Recording], true: dd.Robot, believed: dd.Robot, side: float) -> Misled:
    """How far off runs over bumps put the radius ratio, and the E_max [m] that it leaves on the even floor."""
    even, twin, found = [dd.sensors.measure(square) for square in squares], dd.tilt.level_twin(true), {}
    height, spacing = HEIGHT * twin.right_radius, SPACING * side
    for floor, sides in FLOORS.items():
        rough = [over_bumps(d, twin, height=height, first=sides * side, spacing=spacing, count=BUMPS) for d in even]
        for reading, method in (("positions", umbmark), ("headings", jung_chung)):
            result = method(rough, believed, side=side)
            ends = return_errors(even, result.calibrated)[:, :2]
            found[floor, reading] = float(result.values[0]) / twin.radius_ratio - 1, float(np.hypot(*ends.T).max())
    return found


def noise_claims(true: dd.Robot, found: Calibration, scatter: Calibration, runs: int) -> list[Bound]:
    """The parameters, and what is left of E_max, are as good as the scatter of the runs lets them be."""
    twin, left, unit = dd.tilt.level_twin(true), scatter.residuals.reshape(2, MANY, 2), "standard deviations"
    off = np.abs(found.values - (twin.radius_ratio, twin.track_width)) / (scatter.std * np.sqrt(MANY / runs))
    remains = found.details["E_max_after"] / float(np.sqrt(left.var(axis=1, ddof=1).mean() / runs))
    values = {"radius ratio, track off by": float(off.max()), "E_max left": remains}
    return [Bound(f"with noise: {name}", value, chance.sigmas(2 * (MANY - 1)), unit) for name, value in values.items()]


def method_claims(tried: Trials, rounds: Mapping[str, list[float]]) -> list[Bound]:
    """Exact angles and three rounds leave little; bent sides alone are refused; the published update swings."""
    exact = [one.gain for one in tried[EXACT] if not one.refusal]
    wrong = [one for of in tried.values() for one in of if bool(one.refusal) is (one.bent <= LARGEST_MISMATCH)]
    truth = 1 - MISMATCHES[0] / SIDES[1]
    swing = float(np.abs(np.diff(rounds["published"])).min() / abs(truth - rounds["published"][0]))
    return [
        Bound("within the limit: E_max down, median", float(np.median(exact)), 1000, "times", at_least=True),
        Bound("within the limit: E_max down, worst", min(exact), 300, "times", at_least=True),
        Bound("squares answered above the limit, or refused within it", len(wrong), 0),
        Bound("published update, wheels believed unequal: swings on / its first error", swing, 1, at_least=True),
        Bound("composed update, the same: ends off by", 1e6 * abs(rounds["composed"][-1] - truth), 100, "ppm"),
    ]


def bump_claims(misled: Misled, believed: dd.Robot, true: dd.Robot, side: float) -> list[Bound]:
    """Bumps under one wheel pass for a smaller wheel, in positions the more the farther out they lie."""
    lost, track, bounds = BUMPS * true.right_radius * bump_angle(1.0, HEIGHT), true.track_width, []
    # To first order in what the bumps turn, in how far sides bend, and in what four corners turn too much.
    corners = 2 * math.pi * abs(believed.track_width - track)
    small = (lost + 1.5 * side * abs(1 - true.radius_ratio) + corners) / track
    for (floor, reading), (off, _) in misled.items():
        far = FLOORS[floor] + SPACING * BUMPS / 2
        out, allowed = (1.0, 1.0) if reading == "headings" else (far, 100 * small)
        off_by = 100 * abs(4 * side * off / lost + out)
        bounds.append(Bound(f"{floor}, {reading}: off what bumps do by", off_by, allowed, "%"))
    return bounds


def table(tried: Trials, rounds: Mapping[str, list[float]], misled: Misled, real: Mapping[str, SquareFigures]) -> str:
    medians = {name: [median_gain(of, bent) for bent in MISMATCHES] for name, of in tried.items()}
    gains = [[name, *("refused" if math.isnan(gain) else gain for gain in row)] for name, row in medians.items()]
    refusals = [one.refusal for of in tried.values() for one in of if one.refusal]
    floors = [[*key, 1e6 * off, 1e3 * left] for key, (off, left) in misled.items()]
    parts = [
        report.table(["E_max down, times; sides bent by [rad]", *map(str, MISMATCHES)], gains),
        f"refused: {len(refusals)} times of {sum(map(len, tried.values()))}, such as\n{max(refusals, default='none')}",
        report.table(["radius ratio after rounds", *map(str, range(7))], [[name, *r] for name, r in rounds.items()]),
        report.table(["calibrated on", "reading", "ratio off by [ppm]", "E_max on the even floor [mm]"], floors),
        report.table(REAL, [[name, *vars(one).values()] for name, one in real.items()]) if real else LEFT_OUT,
    ]
    return "\n\n".join(parts)


def figure(title: str, drives: Sequence[dd.Drive], believed: dd.Robot, calibrated: dd.Robot, tried: Trials) -> Figure:
    """Where the truth ends beside odometry, before and after, and what a calibration is worth."""
    made, (left, right) = plots.figure(title, columns=2, size=(figures.WIDTH, 4.8))
    before, after = (1e3 * return_errors(drives, robot)[:, :2] for robot in (believed, calibrated))
    for i, (way, ends) in enumerate(zip(("counter-clockwise", "clockwise"), np.split(before, 2), strict=True)):
        center, look = ends.mean(axis=0), plots.style(i) | {"linestyle": "none", "markerfacecolor": "white"}
        left.plot(*ends.T, label=f"believed, {way}: {np.hypot(*center):.0f} mm", **look)
        left.annotate("", center, (0, 0), arrowprops={"arrowstyle": "->", "color": "0.4"})
    left.plot(*after.T, "x", color="black", label="calibrated, both")
    left.margins(0.35)
    left.locator_params(nbins=6)
    left.set_aspect("equal", adjustable="datalim")
    left.set(xlabel="truth ends ahead of odometry by [mm]", ylabel="to the left of it by [mm]")
    for i, (name, of) in enumerate(tried.items()):
        look, shown = plots.style(2 + i), [one for one in of if not one.refusal]
        at = sorted({one.bent for one in shown})
        right.plot([one.bent for one in shown], [one.gain for one in shown], **look | {"linestyle": "none"})
        right.plot(at, [median_gain(of, bent) for bent in at], label=name, **look | {"marker": ""})
    right.axvspan(LARGEST_MISMATCH, MISMATCHES[-1], color="0.9", zorder=0)
    marks.note(right, "refused", ((LARGEST_MISMATCH + MISMATCHES[-1]) / 2, 1e4), horizontalalignment="center")
    right.set(xlabel="sides bent by: side |1 - ratio| / track [rad]", ylabel="E_max before / after")
    right.set(yscale="log", ylim=(1, 1e8), xlim=(0, MISMATCHES[-1]))
    plots.panel(left, "Return errors of the square")
    plots.panel(right, f"Sides of {SIDES[0]:g} to {SIDES[-1]:g} track widths")
    plots.legend_below(made, plots.tidy(left), plots.tidy(right), columns=3)
    return made


if __name__ == "__main__":
    report.main(run)
