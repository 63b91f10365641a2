"""What does the odometry believe when it takes unequal wheels for equal, and what with the true radii?

The same physical robot drives a line and a square; its odometry believes both wheels to be like the left one, both to
have the mean radius, and the true radii. What a wrong belief makes of a path follows from the belief matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj._text import quantity
from diffdrive_mj.judging.beliefs import believed_path
from diffdrive_mj.judging.rolling import gentle_ramp, simulate_rolling
from diffdrive_mj.judging.standards import ANY_FLOOR
from diffdrive_mj.kinematics import belief_matrix
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Replay, Report, marks, plots

EQUAL, MEAN, TRUE = "both wheels as the left", "both at the mean radius", "true radii"
DRIVES = ("straight", "square")


@dataclass(frozen=True)
class Belief:
    """What one belief makes of the drives.

    Attributes:
        turn: that it sees in a straight metre [rad].
        paths: as believed, by drive (T, 3).
        drifts: how far off they are.
        predicted: the drifts that the belief matrix predicts.
        law_off: how far the believed paths are off the predicted ones [ppm of the distance].
    """

    turn: float
    paths: dict[str, np.ndarray]
    drifts: dict[str, dd.metrics.Drift]
    predicted: dict[str, dd.metrics.Drift]
    law_off: dict[str, float]


def run(robot: str = "mismatched", distance: float = 15.0, speed: float = 1.5, side: float = 4.0) -> Report:
    """Drive, and let three beliefs judge.

    Args:
        robot: a preset's name, or a TOML file.
        distance: of the straight drive [m].
        speed: on it [m/s].
        side: of the square [m].
    """
    true = dd.Robot.load(robot)
    twin = level_twin(true)
    line = dd.maneuvers.straight(twin, speed=speed, distance=distance, ramp=gentle_ramp(true, speed))
    square = dd.maneuvers.square(twin, side=side)
    truths = {name: simulate_rolling(true, drive) for name, drive in zip(DRIVES, (line, square), strict=True)}
    beliefs = {
        EQUAL: twin.replace(right_radius=twin.left_radius),
        MEAN: twin.replace(left_radius=twin.mean_radius, right_radius=twin.mean_radius),
        TRUE: twin,
    }
    seen = {label: judge(truths, belief, twin) for label, belief in beliefs.items()}
    answer = finding(seen)
    return Report(
        question=__doc__,
        finding=answer,
        table=table(seen),
        bounds=claims(seen),
        metrics={label: metrics(belief) for label, belief in seen.items()},
        pictures={"mismatched_radii": figure(answer.splitlines()[0], truths, seen)},
        replays=[Replay.of(f"The {name}", truths[name], beliefs, twin) for name in reversed(DRIVES)],
    )


def judge(truths: dict[str, dd.Recording[dd.Robot, dd.Commands]], belief: dd.Robot, twin: dd.Robot) -> Belief:
    """Compare a belief with the truth, and with what the belief matrix predicts of it."""
    paths = {name: recording.odometry(belief) for name, recording in truths.items()}
    laws = {name: believed_path(recording.truth, belief, twin) for name, recording in truths.items()}
    drifts = {name: recording.drift(belief) for name, recording in truths.items()}
    gaps = {name: float(np.hypot(*(paths[name] - laws[name])[:, :2].T).max()) for name in DRIVES}
    return Belief(
        turn=float(belief_matrix(belief, twin)[1, 0]),
        paths=paths,
        drifts=drifts,
        predicted={name: dd.metrics.drift(truths[name].truth, law) for name, law in laws.items()},
        law_off={name: 1e6 * gap / float(drifts[name].distance) for name, gap in gaps.items()},
    )


def claims(seen: dict[str, Belief]) -> list[Bound]:
    """Every belief errs as the law says, up to the floor of the physics; the true radii by the floor alone."""
    return [
        *(
            Bound(f"true radii, {name}: largest error", 1e6 * float(drift.max_position_per_metre), ANY_FLOOR, "ppm")
            for name, drift in seen[TRUE].drifts.items()
        ),
        *(
            # The floor in position and the floor in heading, which the law's path takes in too.
            Bound(f"{label}, {name}: off the predicted path by", belief.law_off[name], 2 * ANY_FLOOR, "ppm")
            for label, belief in seen.items()
            if label != TRUE
            for name in DRIVES
        ),
    ]


def finding(seen: dict[str, Belief]) -> str:
    """The answer; its first line is the picture's title."""
    equal, mean, true = (seen[label].drifts["straight"] for label in (EQUAL, MEAN, TRUE))
    lost, middle, kept = (quantity(float(drift.max_position), "m") for drift in (equal, mean, true))
    return (
        f"Both wheels taken for the left one: {lost} off over {float(equal.distance):.3g} m; true radii: {kept}\n"
        f"The mean radius leaves {middle}: it is the ratio of the radii that turns the path, by "
        f"{np.degrees(seen[EQUAL].turn):.3g} degrees a metre."
    )


def table(seen: dict[str, Belief]) -> str:
    """The errors at the end of both drives."""
    rows = [
        [
            label,
            float(np.degrees(belief.turn)),
            *(float(belief.drifts[name].final_position) for name in DRIVES),
            float(np.degrees(belief.drifts["straight"].final_heading)),
            1e6 * float(belief.drifts["straight"].max_position_per_metre),
        ]
        for label, belief in seen.items()
    ]
    header = ["belief", "turn [deg/m]", "straight: end [m]", "square: end [m]", "heading [deg]", "straight [ppm]"]
    return report.table(header, rows)


def metrics(belief: Belief) -> dict[str, object]:
    """The numbers for `metrics.json`."""
    ends = {
        name: {
            "max_position_m": float(drift.max_position),
            "final_position_m": float(drift.final_position),
            "final_heading_rad": float(drift.final_heading),
        }
        for name, drift in belief.drifts.items()
    }
    return {"turn_believed_rad_per_m": belief.turn, **ends}


def figure(title: str, truths: dict[str, dd.Recording[dd.Robot, dd.Commands]], seen: dict[str, Belief]) -> Figure:
    """The square as believed, and how the error grows along the line."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.7))
    plots.paths(left, truths["square"].truth, {label: belief.paths["square"] for label, belief in seen.items()})
    plots.panel(left, "A square, as driven and as believed")
    draw_growth(right, seen)
    plots.legend_below(made, left, right, columns=6)
    return made


def draw_growth(ax: Axes, seen: dict[str, Belief]) -> None:
    """The error on the line against the distance, both logarithmic, with the law."""
    along = seen[TRUE].drifts["straight"].travelled
    far = along > 0.01 * along[-1]
    errors = {label: belief.drifts["straight"].position_error[far] for label, belief in seen.items()}
    laws = {label: belief.predicted["straight"].position_error[far] for label, belief in seen.items() if label != TRUE}
    plots.errors(
        ax, along[far], errors, predicted=laws, ylabel="position error [m]", scale=1, log=True, name_ends=False
    )
    ax.set(xscale="log", ylim=(1e-10, 1e3))
    if seen[EQUAL].turn:
        # Half-way between the wrong beliefs and the true one, where no curve is.
        nearest = min(float(values.min()) for label, values in errors.items() if label != TRUE)
        place = (np.sqrt(along[far][0] * along[-1]), np.sqrt(nearest * errors[TRUE].max()))
        marks.note(ax, "wrong radii: as the square of the distance", place, ha="center", va="center")
    plots.panel(ax, "The line: error against distance")


if __name__ == "__main__":
    report.main(run)
