"""What does the odometry believe when it takes unequal wheels for equal, and what with the true radii?"""

from __future__ import annotations

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.kinematics import belief_matrix
from diffdrive_mj.report import Bound, Report, plots

EQUAL, MEAN, TRUE = "both wheels as the left", "both at the mean radius", "true radii"


def run(distance: float = 15.0, speed: float = 1.5, side: float = 4.0) -> Report:
    """What does the odometry believe when it takes unequal wheels for equal, and what with the true radii?

    Args:
        distance: of the straight drive [m].
        speed: on it [m/s].
        side: of the square [m].
    """
    robot = dd.Robot.load("mismatched")
    beliefs = {
        EQUAL: robot.replace(right_radius=robot.left_radius),
        MEAN: robot.replace(left_radius=robot.mean_radius, right_radius=robot.mean_radius),
        TRUE: robot,
    }
    straight = dd.simulate(robot, dd.maneuvers.straight(robot, speed=speed, distance=distance))
    square = dd.simulate(robot, dd.maneuvers.square(robot, side=side))
    on_line = {label: straight.drift(belief) for label, belief in beliefs.items()}
    along = straight.truth[:, 0]
    predicted = {label: growth(along, belief, robot) for label, belief in beliefs.items() if label != TRUE}
    around = {label: square.drift(belief) for label, belief in beliefs.items()}

    off = {label: relative(on_line[label].position_error, law) for label, law in predicted.items()}
    turn = {label: float(belief_matrix(belief, robot)[1, 0]) for label, belief in beliefs.items()}
    bounds = [
        Bound("true radii, straight: largest error / distance", ppm(on_line[TRUE]), 1, "ppm"),
        Bound("true radii, square: largest error / distance", ppm(around[TRUE]), 1, "ppm"),
        *(Bound(f"{label}: the growth law is off by", 100 * value, 0.1, "%") for label, value in off.items()),
        Bound(
            "taken for equal, straight: the error shows", float(on_line[EQUAL].max_position), 1.0, "m", at_least=True
        ),
    ]
    rows = [
        [
            label,
            turn[label],
            float(on_line[label].final_position),
            float(np.degrees(on_line[label].final_heading)),
            float(around[label].final_position),
            ppm(on_line[label]),
        ]
        for label in beliefs
    ]
    header = ["belief", "turn [rad/m]", "straight: end [m]", "heading [deg]", "square: end [m]", "straight [ppm]"]
    end, turned = on_line[EQUAL].final_position, np.degrees(on_line[EQUAL].final_heading)
    finding = (
        f"Taking the wheels for equal turns a straight {distance:g} m into an arc: {end:.1f} m and {turned:.0f} "
        f"degrees (wrapped) off at its end.\nThe mean radius changes little, since it is the ratio of the radii that "
        f"turns the path; the true radii leave {1e6 * on_line[TRUE].max_position:.1f} um."
    )
    title = f"Unequal wheels believed equal: {end:.0f} m of drift in {distance:g} m; with the true radii, micrometres"
    made, axes = plots.figure(title, columns=3, size=(16, 5.2))
    for ax, recording, name in zip(
        axes, (straight, square), (f"Straight, {distance:g} m", f"Square, {side:g} m a side"), strict=False
    ):
        plots.paths(ax, recording.truth, {label: recording.odometry(belief) for label, belief in beliefs.items()})
        ax.set_title(name, loc="left", fontsize=11)
    axes[1].get_legend().remove()
    far = along > 0.1
    shown = {label: drift.position_error[far] for label, drift in on_line.items()}
    laws = {label: law[far] for label, law in predicted.items()}
    plots.errors(
        axes[2], along[far], shown, predicted=laws, ylabel="position error [m]", scale=1, log=True, name_ends=False
    )
    axes[2].set(ylim=(1e-8, 1e2), xscale="log")
    axes[2].annotate("grows with the square\nof the distance", (1.0, 2e-2), color="0.35", fontsize=10)
    axes[2].set_title("Straight: error against distance", loc="left", fontsize=11)
    metrics = {
        "turn_believed_rad_per_m": turn,
        "straight": {label: summary(drift) for label, drift in on_line.items()},
        "square": {label: summary(drift) for label, drift in around.items()},
    }
    pictures = {"mismatched_radii": made}
    return Report(run.__doc__.splitlines()[0], finding, report.table(header, rows), bounds, metrics, pictures)


def growth(along: np.ndarray, belief: dd.Robot, robot: dd.Robot) -> np.ndarray:
    """The position error after a straight line of length s: |exp(M (s, 0)) - (s, 0)| with the belief matrix M.

    It grows as M_21 s^2 / 2 while the angle is small, and goes on around a circle.
    """
    arc = np.outer(along, belief_matrix(belief, robot)[:, 0])
    end = dd.se2.exp(np.insert(arc, 1, 0.0, axis=-1))
    return np.hypot(end[:, 0] - along, end[:, 1])


def relative(measured: np.ndarray, law: np.ndarray) -> float:
    return float(np.abs(measured - law).max() / law.max())


def ppm(drift: dd.metrics.Drift) -> float:
    return 1e6 * float(drift.max_position_per_metre)


def summary(drift: dd.metrics.Drift) -> dict[str, float]:
    return {
        "max_position_m": float(drift.max_position),
        "final_position_m": float(drift.final_position),
        "final_heading_rad": float(drift.final_heading),
    }


if __name__ == "__main__":
    report.main(run)
