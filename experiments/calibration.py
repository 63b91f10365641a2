"""Which method recovers the robot best, with how much driving? And on a real robot's logs?"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.calibration.paths import from_fixes, least_squares
from diffdrive_mj.calibration.squares import jung_chung, umbmark
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.metrics import Drift, stacked
from diffdrive_mj.report import Bound, Report, plots

BELIEVED = dd.Robot.load("matched")
FIELDS = ("left_radius", "right_radius", "track_width")
SIDE = 1.0
LENGTHS = (5.0, 10.0, 20.0)
TICKS = (64, 256, 1024, 4096)
TRUTH_NOISE = 1e-3
# So many robots stand for all of them where a sweep would take too long.
SOME = 8
METHODS = {
    "least squares": lambda drive: least_squares([drive], BELIEVED, turning_gain=False),
    "fixes without headings": lambda drive: from_fixes([drive], BELIEVED),
}


def run(robots: int = 200, data: str = "", seed: int = 0) -> Report:
    """Which method recovers the robot best, with how much driving? And on a real robot's logs?

    Args:
        robots: random ones, radii and track within 10 % of the believed.
        data: folder of the OptiOdom logs; without it the real robot is left out.
        seed: of the robots and of the noise.
    """
    rng = np.random.default_rng(seed)
    true = [
        BELIEVED.replace(**{field: getattr(BELIEVED, field) * (1 + rng.uniform(-0.1, 0.1)) for field in FIELDS})
        for _ in range(robots)
    ]
    physics = dd.Physics(timestep=0.005)
    runs = dd.simulate(true, mixed(BELIEVED), physics=physics, sample_rate=200.0).runs
    held_out = dd.simulate(true[:SOME], dd.maneuvers.square(BELIEVED, side=2.0), physics=physics, sample_rate=50.0)

    exact = together(METHODS["least squares"], [logged(run, rng, truth_rate=200) for run in runs])
    errors = np.array([relative(found, robot) for found, robot in zip(exact, true, strict=True)])
    noisy = together(METHODS["least squares"], [logged(run, rng, noise=TRUTH_NOISE) for run in runs])
    rough = np.array([relative(found, robot) for found, robot in zip(noisy, true, strict=True)])
    stated = np.array([found.std / vector(robot) for found, robot in zip(noisy, true, strict=True)])
    covered = float((np.abs(rough) < 2 * stated).mean())
    slow = np.array([relative(fit(run, rng, rate=20), run.robot) for run in runs[:SOME]])

    by_length = sweep_lengths(runs[:SOME], held_out, rng)
    squares = bidirectional(true[:SOME], physics, rng)
    by_ticks = {
        ticks: percentile([relative(fit(run, rng, ticks=ticks), run.robot) for run in runs[:SOME]]) for ticks in TICKS
    }
    worst = np.percentile(np.abs(errors), 95, axis=0)

    bounds = [
        Bound("exact truth: left radius, 95th percentile", 1e6 * float(worst[0]), 20, "ppm"),
        Bound("exact truth: right radius, 95th percentile", 1e6 * float(worst[1]), 20, "ppm"),
        Bound("exact truth: track width, 95th percentile", 1e6 * float(worst[2]), 50, "ppm"),
        Bound("1 mm, 1 mrad truth at 20 Hz: within 2 sigma, off 95 % by", 100 * abs(covered - 0.95), 3, "%"),
    ]
    rows: list[list[object]] = [
        ["4096 ticks at 200 Hz, exact truth at 200 Hz", *(1e6 * worst)],
        ["the same, encoder at 20 Hz", *(1e6 * np.percentile(np.abs(slow), 95, axis=0))],
        ["truth at 20 Hz with 1 mm and 1 mrad", *(1e6 * np.percentile(np.abs(rough), 95, axis=0))],
        *(
            [f"{name}, {length:g} m", 1e6 * value, "", ""]
            for name, by in by_length.items()
            for length, (value, _) in by.items()
        ),
    ]
    rows += [
        [
            f"{name}, squares of {SIDE:g} m ({len(off)} of {SOME} answered)",
            "ratio:",
            *(1e6 * np.percentile(off, 95, axis=0)),
        ]
        for name, off in squares.items()
    ]
    header = ["errors, 95th percentile", "left radius [ppm]", "right radius [ppm]", "track width [ppm]"]
    tables = [report.table(header, rows)]
    finding = (
        f"20 m of mixed driving recover the radii within {1e6 * worst[:2].max():.1f} ppm and the track within "
        f"{1e6 * worst[2]:.1f} ppm (95 % of {robots} robots).\nWith a truth of 1 mm and 1 mrad, {100 * covered:.1f} % "
        "of the errors lie within the stated two sigma."
    )
    real = real_robot(Path(data)) if data else None
    if real:
        bounds += real["bounds"]
        tables.append(real["table"])
        finding += "\n" + real["finding"]
    else:
        finding += "\nThe real robot was left out: --data names the folder of its logs."
    title = f"20 m of driving recover the robot within {1e6 * worst.max():.0f} ppm"
    made, axes = plots.figure(title, columns=3 if real else 2, size=(16.5 if real else 11.5, 5.0))
    draw(axes, by_length, by_ticks)
    if real:
        draw_real(axes[2], real["scores"])
    metrics = {
        "exact_p95": worst,
        "slow_encoder_p95": np.percentile(np.abs(slow), 95, axis=0),
        "noisy_p95": np.percentile(np.abs(rough), 95, axis=0),
        "within_two_sigma": covered,
        "by_length": by_length,
        "by_ticks": by_ticks,
        "squares_ratio_and_track": squares,
        "real": real["scores"] if real else None,
    }
    question = "Which method recovers the robot best, with how much driving? And on a real robot's logs?"
    return Report(question, finding, "\n\n".join(tables), bounds, metrics, {"calibration": made})


def mixed(robot: dd.Robot) -> dd.Commands:
    """20 m of straight lines, turns on the spot and arcs, both ways, each from rest to rest."""
    legs = [
        Segment(2, 0, 3), Segment(0, math.pi / 2, 1.5), Segment(2.5, 2.5, 4), Segment(2.5, -2.5, 4),
        Segment(0, -2 * math.pi / 3, 2), Segment(1.5, 0, 2.5), Segment(3, -4, 5), Segment(0, math.pi, 3),
        Segment(3, 4, 5), Segment(2, 0, 3), Segment(0, -math.pi / 2, 1.5), Segment(3.5, 1, 5),
    ]  # fmt: skip
    return sequence(robot, [[leg] for leg in legs])


def together(work, items: list) -> list:
    """The results of some work on items, on both cores as far as numpy lets them."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(work, items))


def fit(run: dd.Recording, rng: np.random.Generator, method: str = "least squares", **options):
    """Calibrate a robot from what its encoders and its tracker say."""
    return METHODS[method](logged(run, rng, **options))


def logged(
    run: dd.Recording,
    rng: np.random.Generator,
    *,
    ticks: int = 4096,
    rate: int = 200,
    truth_rate: int = 20,
    noise: float = 0.0,
    metres: float = math.inf,
) -> Drive:
    """What the encoders and the tracker say of a run, as finely, as often and as far as asked."""
    far = np.searchsorted(dd.metrics.travelled(run.truth), metres)
    encoder = dd.Encoder(ticks_per_revolution=ticks, sample_rate=rate)
    tracker = dd.Tracker(sample_rate=truth_rate, position_noise=noise, heading_noise=noise)
    driven = run.during(0.0, run.t[min(far, len(run.t) - 1)])
    return dd.sensors.measure(driven, encoder=encoder, tracker=tracker, seed=rng)


def bidirectional(true: list[dd.Robot], physics: dd.Physics, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Relative errors of the radius ratio and of the track over the mean radius, from one square each way round.

    The mean radius cannot be seen on squares; robots whose squares are too bent are refused and left out.
    """
    commands = [dd.maneuvers.square(BELIEVED, side=SIDE, clockwise=way) for way in (False, True)]
    recording = dd.simulate([robot for robot in true for _ in commands], commands * len(true), physics=physics)
    result: dict[str, list[np.ndarray]] = {"UMBmark": [], "Jung and Chung": []}
    tracker = dd.Tracker(position_noise=TRUTH_NOISE, heading_noise=TRUTH_NOISE)
    measured = dd.sensors.measure(recording, tracker=tracker, seed=rng)
    for i, robot in enumerate(true):
        drives = measured[2 * i : 2 * i + 2]
        for name, method in (("UMBmark", umbmark), ("Jung and Chung", jung_chung)):
            try:
                found = method(drives, BELIEVED, side=SIDE).calibrated
            except InvalidValue:
                continue
            ratio = found.radius_ratio / robot.radius_ratio - 1
            track = (found.track_width / found.mean_radius) / (robot.track_width / robot.mean_radius) - 1
            result[name].append(np.abs([ratio, track]))
    return {name: np.array(off) for name, off in result.items() if off}


def vector(robot: dd.Robot) -> np.ndarray:
    return np.array([getattr(robot, field) for field in FIELDS])


def relative(found: dd.calibration.Calibration, robot: dd.Robot) -> np.ndarray:
    return found.values[:3] / vector(robot) - 1


def percentile(errors: list[np.ndarray]) -> float:
    """The 95th percentile of the largest of the three relative errors."""
    return float(np.percentile(np.abs(errors).max(axis=1), 95))


def sweep_lengths(runs, held_out, rng) -> dict[str, dict[float, tuple[float, float]]]:
    """By method and metres of driving: the parameters' relative error, the final error on another drive [m]."""
    result: dict[str, dict[float, tuple[float, float]]] = {}
    for method in METHODS:
        result[method] = {}
        for metres in LENGTHS:
            found = [fit(run, rng, noise=TRUTH_NOISE, metres=metres, method=method) for run in runs]
            ends = [run.drift(one.calibrated).final_position for run, one in zip(held_out.runs, found, strict=True)]
            errors = percentile([relative(one, run.robot) for one, run in zip(found, runs, strict=True)])
            result[method][metres] = (errors, float(np.percentile(ends, 95)))
    return result


# The recordings of the real robot, and which of them are fitted together.
CIRCLES, SQUARES = "circular/250620202104", ("square/230620202042", "square/230620202317")
LARGE, FREE = "square/231220200040", "free/030120210001"


def real_robot(folder: Path) -> dict:
    """The OptiOdom robot: fitted on some recordings, judged on all; started at the truth, positions fitted."""
    from diffdrive_mj.logs import read_optiodom

    nominal = dd.Robot.load("optiodom")
    groups = {name: read_optiodom(folder / name) for name in (CIRCLES, *SQUARES, LARGE, FREE)}

    def fitted(*names: str, gain: bool = False) -> dd.Robot:
        drives = [drive for name in names for drive in groups[name]]
        # The marker headings jitter by 9 mrad, which positions do not: these decide.
        return least_squares(drives, nominal, start="truth", headings=False, turning_gain=gain).calibrated

    robots = {
        "nominal": nominal,
        "fitted on the circles": fitted(CIRCLES),
        "on circles and small squares": fitted(CIRCLES, *SQUARES),
        "the same, with the turning gain": fitted(CIRCLES, *SQUARES, gain=True),
    }
    drifts = {label: {name: drift(drives, robot) for name, drives in groups.items()} for label, robot in robots.items()}
    circles = drifts["fitted on the circles"][CIRCLES]
    free = {label: by[FREE].final_position_rms for label, by in drifts.items()}
    cases = [(name, gain) for name in groups for gain in (False, True)]

    def left_over(case: tuple[str, bool]) -> float:
        name, gain = case
        return drift(groups[name], fitted(*[n for n in groups if n != name], gain=gain)).final_position_rms

    left = together(left_over, cases)
    unseen = {name: (left[2 * i], left[2 * i + 1]) for i, name in enumerate(groups)}
    helped = [name for name, (three, four) in unseen.items() if four < three]
    # The circles and the small squares were driven within three days; the others half a year later and more.
    same_days = {
        name: [drift(groups[name], fitted(CIRCLES, other, gain=gain)).final_position_rms for gain in (False, True)]
        for name, other in (SQUARES, SQUARES[::-1])
    }
    kept = max(four / three for three, four in same_days.values())
    bounds = [
        Bound(
            "real, fitted on circles: largest final error there", 1e3 * float(circles.final_position.max()), 9.15, "mm"
        ),
        Bound("real, fitted on circles: largest error on the way", 1e3 * float(circles.max_position.max()), 22.0, "mm"),
        Bound(
            "real, joint fit: final RMS on the free drives / nominal",
            free["on circles and small squares"] / free["nominal"],
            0.5,
        ),
        Bound("real, turning gain: error left on an unseen square of the same days", kept, 0.6),
        Bound("real, turning gain: recordings outside the fit that it helps", len(helped), 3, "of 5", at_least=True),
    ]
    rows = [[label, *(1e3 * by[name].final_position_rms for name in groups)] for label, by in drifts.items()]
    rows += [
        ["fitted on all the others", *(1e3 * unseen[name][0] for name in groups)],
        ["the same, with the turning gain", *(1e3 * unseen[name][1] for name in groups)],
    ]
    rows += [
        [label, "", *(1e3 * same_days[name][gain] for name in SQUARES), "", ""]
        for gain, label in enumerate(
            ("fitted on circles and the other small square", "the same, with the turning gain")
        )
    ]
    header = ["real robot: final position RMS [mm]", "circles", "square a", "square b", "large square", "free"]
    finding = (
        f"On the real robot a fit on the circles leaves {1e3 * circles.final_position.max():.1f} mm at the end and "
        f"{1e3 * circles.max_position.max():.1f} mm on the way there (published: 9.15 and 22.0);\na joint fit takes "
        f"the free drives from {1e3 * free['nominal']:.1f} to {1e3 * free['on circles and small squares']:.1f} mm. The "
        f"turning gain helps {len(helped)} of 5 recordings left out of the fit, squares of the same days most."
    )
    scores = {label: {name: by[name].final_position_rms for name in groups} for label, by in drifts.items()}
    return {"bounds": bounds, "table": report.table(header, rows), "finding": finding, "scores": scores}


def drift(drives: list[Drive], robot: dd.Robot) -> Drift:
    return stacked(drive.drift(robot) for drive in drives)


def draw(axes, by_length, by_ticks) -> None:
    for place, (method, by) in enumerate(by_length.items()):
        lengths = list(by)
        axes[0].plot(
            lengths, [1e6 * by[n][0] for n in lengths], label=f"{method}: parameters [ppm]", **plots.style(place)
        )
        look = plots.style(place) | {"markerfacecolor": "white"}
        axes[0].plot(lengths, [1e6 * by[n][1] for n in lengths], label=f"{method}: held-out square [um]", **look)
    axes[0].set(xscale="log", yscale="log", xlabel="calibration driving [m]", ylabel="error, 95th percentile")
    axes[0].set_xticks(LENGTHS, [f"{n:g}" for n in LENGTHS])
    axes[0].minorticks_off()
    axes[0].set_title("More driving, truth of 1 mm and 1 mrad", loc="left", fontsize=11)
    axes[1].plot(list(by_ticks), [1e6 * value for value in by_ticks.values()], label="least squares", **plots.style(0))
    axes[1].set(
        xscale="log", yscale="log", xlabel="ticks per revolution", ylabel="parameters' error, 95th percentile [ppm]"
    )
    axes[1].set_xticks(TICKS, [str(n) for n in TICKS])
    axes[1].minorticks_off()
    axes[1].set_title("Finer encoders, exact truth, 20 m", loc="left", fontsize=11)
    for ax in axes[:2]:
        ax.grid(visible=True, color="0.9")
        ax.legend(fontsize=9)


def draw_real(ax, scores) -> None:
    names = ["circles", "square a", "square b", "large square", "free"]
    width = 0.8 / len(scores)
    hatches = ("", "//", "..", "xx")
    for place, (label, by) in enumerate(scores.items()):
        at = np.arange(len(names)) + (place - (len(scores) - 1) / 2) * width
        color = plots.STYLES[place]["color"]
        ax.bar(
            at,
            [1e3 * value for value in by.values()],
            width,
            label=label,
            color=color,
            hatch=hatches[place],
            edgecolor="white",
        )
    ax.set_xticks(range(len(names)), names)
    ax.set(ylabel="final position error, RMS [mm]")
    ax.legend(fontsize=8)
    ax.set_title("A real robot: OptiOdom's logs", loc="left", fontsize=11)


if __name__ == "__main__":
    report.main(run)
