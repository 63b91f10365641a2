"""Of the final error, how much is slip, sampling, quantisation, wrong parameters?

One drive is replayed with each cause switched on and off. The parts are Shapley values: whatever the causes do
together, the parts add up to the error, and where all are small each part is nearly what its cause does alone. What
slip does is also read in the physics, where the tyres touch the floor, and compared.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import plots, report
from diffdrive_mj._text import quantity
from diffdrive_mj._text import table as text_table
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.estimation.attribution import RATIO, REST, SCALE, SLIP, TRACK, Attribution, attribute
from diffdrive_mj.estimation.sensitivities import misjudged
from diffdrive_mj.judging import optiodom
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Replay, Report
from diffdrive_mj.report.attributions import attributed
from diffdrive_mj.report.figures import WIDTH, figure, legend_below

RATE, RECORDED = 10.0, 500.0
PARAMETERS = (SCALE, RATIO, TRACK)
SMALL = 0.003  # of the distance: the largest sum of what the causes do alone for which the parts are judged by it


@dataclass(frozen=True)
class Mixes:
    """How well parts agree with what their causes do alone, over random mixes of causes.

    Attributes:
        judged: how many mixes were small enough.
        sum_off: how far the parts are off the error, the largest [m].
        worst: the largest difference between a part and its cause alone, over what is allowed.
    """

    judged: int
    sum_off: float
    worst: float


def run(robot: str = "mismatched", mixes: int = 60, friction: float = 0.05, data: str = "", seed: int = 0) -> Report:
    """Drive a square over a slippery patch, and split what its odometry is off at the end.

    Args:
        robot: a preset's name, or a TOML file.
        mixes: random mixes of small causes on a square and a slalom, to try the method.
        friction: of the patch before the first corner.
        data: folder of the OptiOdom logs; without it the real robot is left out.
        seed: of the mixes and of the counters' phases.
    """
    logs = optiodom.read_recordings(data) if data else None
    driven = dd.Robot.load(robot)
    true = level_twin(driven)  # a tilted axle rolls on other radii, which is no slip
    checks.whole("mixes", mixes, least=1)
    world = slippery(driven, checks.positive("friction", friction))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)  # that the wheel slips is the point
        slid = dd.simulate(driven, dd.maneuvers.square(true, side=2.0), world=world, sample_rate=RECORDED, slip=True)
    slid = replace(slid, robot=true)
    encoder = dd.Encoder(true, sample_rate=RATE, latency=0.01)
    found = attribute(
        slid, misjudged(true, scale=1.001, ratio=1.0005, track=1.002), encoder=encoder,
        start_error=(0.002, 0.0, 0.002), seed=seed,
    )  # fmt: skip
    tried = try_mixes(true, mixes, np.random.default_rng(seed))
    report = Report(
        question=__doc__,
        finding=finding(found, tried),
        table=str(found).partition("\n\n")[2],
        bounds=claims(found, slid, tried),
        metrics={
            **found.as_dict(),
            "slip_apart_mm": 1e3 * slip_apart(found),
            "mixes_judged": tried.judged,
            "mixes_worst": tried.worst,
        },
        pictures={"error_attribution": attributed(found)},
        replays=[Replay.of("The square", slid, {"true parameters": true}, true)],
    )
    return report if logs is None else with_real(report, logs)


def slippery(robot: dd.Robot, friction: float) -> dd.World:
    """A patch under the left wheel alone before the first corner, where the robot brakes."""
    half = robot.track_width / 2
    return dd.World(patches=(dd.Patch(x=(1.7, 1.9), y=(0.5 * half, 1.5 * half), friction=friction),))


def try_mixes(true: dd.Robot, count: int, rng: np.random.Generator) -> Mixes:
    """Compare parts with what their causes do alone, for random causes, halved until they are small."""
    drives = [
        dd.simulate(true, maneuver(true), sample_rate=RECORDED)
        for maneuver in (dd.maneuvers.square, dd.maneuvers.slalom)
    ]
    judged, sum_off, worst = 0, 0.0, 0.0
    for k in range(count):
        size, ticks = np.exp(rng.uniform(np.log((1e-5, 60)), np.log((3e-3, 20_000))))
        off = rng.normal(size=4)
        for smaller in 2.0 ** np.arange(8):
            scale, ratio, track = 1 + size / smaller * off[:3]
            encoder = dd.Encoder(ticks_per_revolution=float(smaller * ticks), sample_rate=RATE)
            found = attribute(
                drives[k % 2], misjudged(true, scale=scale, ratio=ratio, track=track), encoder=encoder,
                start_error=(0.0, 0.0, size / smaller * off[3]), seed=k,
            )  # fmt: skip
            sum_off = max(sum_off, _gap(found))
            alone = float(np.hypot(found.alone[:, 0], found.alone[:, 1]).sum())
            if alone < SMALL * found.distance:
                judged += 1
                allowed = max(0.02 * alone, encoder.tick_angle * true.mean_radius / 2)
                apart = np.hypot(*(found.parts - found.alone)[:, :2].T).max()
                worst = max(worst, float(apart) / allowed)
                break
    return Mixes(judged, sum_off, worst)


def with_real(report: Report, logs: Mapping[str, Sequence[dd.Drive]]) -> Report:
    """The report with the final errors of a real robot, its odometry nominal and its reference fitted elsewhere."""
    found = optiodom.explained(logs)
    reference = {name: [each.alone[each.causes.index(REST)] for each in of] for name, of in found.items()}
    rows = {name: medians(of) for name, of in found.items()}
    rest = float(np.median([np.hypot(*error[:2]) for errors in reference.values() for error in errors]))
    off = float(np.median([np.hypot(*each.error[:2]) for of in found.values() for each in of]))
    title = (
        f"A real robot's odometry ends {1e3 * off:.0f} mm off as nominal (median);\n"
        f"radii and track as its other recordings show them leave {1e3 * rest:.0f} mm"
    )
    gap = max(float(np.abs(each.parts.sum(axis=0) - each.error).max()) for of in found.values() for each in of)
    header = ["recording, median [mm]", "drives", "all", *PARAMETERS, REST]
    shown = [[name, len(found[name]), *(round(1e3 * size, 2) for size in row.values())] for name, row in rows.items()]
    return replace(
        report,
        finding=f"{report.finding}\n{title}.",
        table=f"{report.table}\n\n{text_table(header, shown)}",
        bounds=[*report.bounds, Bound("real robot, parts against the error", 1e9 * gap, 1.0, "nm")],
        metrics={**report.metrics, "real_medians_m": rows},
        pictures={**report.pictures, "error_attribution_real_robot": real_figure(title, rows)},
    )


def medians(found: Sequence[Attribution]) -> dict[str, float]:
    """The median size of the final error, and of each part [m]."""
    parts = {cause: [each.sizes[each.causes.index(cause)] for each in found] for cause in (*PARAMETERS, REST)}
    sizes = {"all": [np.hypot(*each.error[:2]) for each in found], **parts}
    return {name: float(np.median(values)) for name, values in sizes.items()}


def real_figure(title: str, rows: Mapping[str, Mapping[str, float]]) -> Figure:
    """Bars of the parts, side by side for each recording."""
    made, ax = figure(title, size=(WIDTH, 4.2))
    places = np.arange(len(rows))
    for k, cause in enumerate((*PARAMETERS, REST)):
        look = {"color": plots.style(k)["color"]} if cause != REST else {"color": "0.6"}
        ax.bar(places + 0.2 * (k - 1.5), [1e3 * row[cause] for row in rows.values()], 0.2, label=cause, **look)
    errors = [1e3 * row["all"] for row in rows.values()]
    ax.hlines(errors, places - 0.4, places + 0.4, color="black", linewidth=1.5, label="the error")
    ax.set(xticks=places, xticklabels=rows, ylabel="at the end, median [mm]")
    plots.tidy(ax).grid(visible=False, axis="x")
    ax.legend()
    legend_below(made, ax, columns=5)
    return made


def slip_apart(found: Attribution) -> float:
    """How far what slip does alone is from what the contacts say of it [m]."""
    assert found.slip is not None
    return float(np.hypot(*(found.alone[found.causes.index(SLIP)] - found.slip)[:2]))


def claims(found: Attribution, slid: dd.Recording[dd.Robot, dd.Commands], tried: Mixes) -> list[Bound]:
    """The parts add up; slip alone is what true parameters leave and contacts show; small causes keep to themselves."""
    slip = found.alone[found.causes.index(SLIP)]
    off = slid.odometry(slid.robot)[-1] - slid.truth[-1]
    apart_at_most = 1e-3 * float(np.hypot(*slip[:2])) + 1e-9 * found.distance
    return [
        Bound("parts against the error, all drives", 1e9 * max(tried.sum_off, _gap(found)), 1.0, "nm"),
        Bound("slip alone against the true robot's own odometry", 1e9 * float(np.abs(slip - off).max()), 1.0, "nm"),
        # A robot that slides hops and leans a little, and a lean that turns with it is no slip: 0.4 per mille at most.
        Bound("slip alone against the contacts", 1e6 * slip_apart(found), 1e6 * apart_at_most, "um"),
        Bound("mixes of small causes that were judged", tried.judged, 1, at_least=True),
        Bound("parts against causes alone, share of what is allowed", tried.worst, 1.0),
    ]


def _gap(found: Attribution) -> float:
    return float(np.abs(found.parts.sum(axis=0) - found.error).max())


def finding(found: Attribution, tried: Mixes) -> str:
    """The answer; its first line is the picture's title."""
    slip = found.sizes[found.causes.index(SLIP)]
    return (
        f"{found.title}\n"
        f"The slippery patch has {quantity(float(slip), 'm')} of it; what the contacts say of the slip agrees within "
        f"{quantity(slip_apart(found), 'm')}. Over {tried.judged} mixes of small causes a part "
        f"differs from what its cause does alone by at most {100 * tried.worst:.0f} % of what is allowed."
    )


if __name__ == "__main__":
    report.main(run)
