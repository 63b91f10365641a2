"""Which effect of the real world costs how much odometry?

A robot drives one square of 2 m, slowly, once for each thing that is less than ideal about its floor or its parts, in
sizes that are usual. Odometry computes with the robot's own numbers, then with those that a calibration finds on the
same square driven the other way round: what that takes out is a matter of parameters, what it leaves is the floor's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.effects import Outcome, outcome, usual_effects
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Replay, Report, plots
from diffdrive_mj.report.figures import WIDTH, figure, legend_below

# What is smaller is drawn here [ppm of the way]; from where on an effect is worth a word.
LEAST, WORTH = 0.1, 10.0
# Effects that odometry notices in full, or that do not reach it, by the beginning of their names, and the largest cost
# of each [ppm]: the floor of the physics; of slopes with the default impedance ratio; of a ball its softer contact.
HARMLESS = {"nothing": 1.0, "slope": 2.0, "carpet": 1.0, "payload": 1.0, "swivel": 1.0, "right motor": 1.0, "ball": 5.0}
# What costs much without an event: what pitches the robot, which odometry takes for wheels that turn, and cylinders,
# whose contacts jump between their edges.
UNNAMED = ("floor uneven", "leaning", "cylinder")


def run(robot: str = "turtlebot3_burger", side: float = 2.0, speed: float = 0.2) -> Report:
    """Drive the square with each effect, and rank them by what they cost.

    Args:
        robot: a preset's name, or a TOML file.
        side: of the square [m].
        speed: along its sides [m/s].
    """
    true = dd.Robot.load(robot)
    found = [outcome(effect, side=side, speed=speed) for effect in usual_effects(true)]
    if found[0].recording is None:
        raise InvalidValue(found[0].nominal.events[0])
    ranked = sorted(found, key=lambda one: -_rank(one))
    text = finding(true, ranked)
    return Report(
        question=__doc__,
        finding=text,
        table=table(ranked),
        bounds=claims(ranked),
        metrics={
            found.effect.name: {
                "position_ppm": None if found.recording is None else found.nominal.position,
                "calibrated_ppm": None if found.calibrated is None else found.calibrated.position,
                "events": list(found.nominal.events),
            }
            for found in ranked
        },
        pictures={"realistic_worlds": ranking(text.splitlines()[0], ranked)},
        replays=[
            Replay.of(found.effect.name, found.recording, {"its own numbers": level_twin(true)})
            for found in ranked[:1]
            if found.recording is not None
        ],
    )


def _rank(found: Outcome) -> float:
    """What cannot be driven comes first."""
    return math.inf if found.recording is None else found.nominal.position


def _digits(value: float) -> str:
    """Three digits without an exponent."""
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def claims(ranked: Sequence[Outcome]) -> list[Bound]:
    """What odometry notices in full costs nothing; a softer tyre is another radius; what else costs more says so."""
    bounds = [
        Bound(found.effect.name, found.nominal.position, limit, "ppm")
        for found in ranked
        for beginning, limit in HARMLESS.items()
        if found.effect.name.startswith(beginning) and not found.nominal.events
    ]
    for found in ranked:
        if found.effect.name.startswith("tyres") and found.calibrated is not None and not found.nominal.events:
            share = found.calibrated.position / found.nominal.position
            bounds.append(Bound("soft tyres after calibration, share of what they cost", share, 0.1))
    silent = [
        found.calibrated.position
        for found in ranked
        if found.calibrated and not found.nominal.events and not found.effect.name.startswith(UNNAMED)
    ]
    return [
        *bounds,
        Bound(
            "largest other cost that no calibration takes out and no event names",
            max(silent, default=0.0),
            1000.0,
            "ppm",
        ),
    ]


def table(ranked: Sequence[Outcome]) -> str:
    """What each effect costs, the costliest first."""
    rows = [
        [
            found.effect.name,
            "not driven" if found.recording is None else _digits(found.nominal.position),
            "" if found.calibrated is None else _digits(found.calibrated.position),
            found.nominal.events[0].partition(": ")[2] if found.nominal.events else "",
        ]
        for found in ranked
    ]
    return report.table(["position off [ppm of the way]", "own numbers", "calibrated", "what happened"], rows)


def finding(true: dd.Robot, ranked: Sequence[Outcome]) -> str:
    """The answer; its first line is the picture's title."""
    driven = [found for found in ranked if found.recording is not None]
    cured = [
        found.effect.name
        for found in driven
        if found.calibrated and found.calibrated.position < 0.1 * found.nominal.position > WORTH
    ]
    effects = [found for found in driven if not found.effect.name.startswith("nothing")]  # that is the ideal drive
    costliest, cheap = effects[0], sum(found.nominal.position < WORTH for found in effects)
    taken_out = f"A calibration takes out nine tenths of: {'; '.join(cured)}." if cured else "A calibration cures none."
    return (
        f"What costs {true.name} most: {costliest.effect.name}, {1e-3 * costliest.nominal.position:.2g} mm a metre\n"
        f"{cheap} of {len(effects)} cost less than {WORTH:g} ppm. {taken_out}"
    )


def ranking(title: str, ranked: Sequence[Outcome]) -> Figure:
    """What each effect costs with the robot's own numbers and after a calibration, the costliest at the top."""
    made, ax = figure(title, size=(WIDTH, 0.32 * len(ranked) + 1.6))
    driven = [found for found in ranked if found.recording is not None]
    for index, label in enumerate(("the robot's own numbers", "calibrated on the same square the other way round")):
        costs = [found.calibrated if index else found.nominal for found in driven]
        look = {**plots.style(index), "linestyle": "none", "markersize": 7}
        ax.plot(
            [max(cost.position, LEAST) if cost else math.nan for cost in costs],
            [row + 0.15 * (2 * index - 1) for row in range(len(driven))],
            label=label,
            **look,
        )
    ax.set_yticks(range(len(driven)), [found.effect.name for found in driven])
    ax.invert_yaxis()
    ax.set(xscale="log", xlabel=f"largest position error [ppm of the way]; less than {LEAST:g} is drawn there")
    plots.tidy(ax)
    legend_below(made, ax)
    return made


if __name__ == "__main__":
    report.main(run)
