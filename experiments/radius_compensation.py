"""Left wheel 9 % slow at 1.5 m/s: where does the robot drift, does r_r = k r_l take it out, for every k?"""

from __future__ import annotations

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.kinematics import belief_matrix, constraint_residuals, radii_for_speed, turning_center, turning_radius
from diffdrive_mj.report import Bound, Report, plots

# Speeding up slowly keeps the dynamics of the servos out of the path: the formulas know kinematics alone.
RAMP = 2.0


def run(speed_ratio: float = 0.91, speed: float = 1.5, seconds: float = 10.0, odometry_rate: float = 10.0) -> Report:
    """Left wheel slow: where does the robot drift, does r_r = k r_l take it out, for every k?

    Args:
        speed_ratio: k = left rate / right rate.
        speed: of the compensated robot [m/s].
        seconds: at full speed.
        odometry_rate: [Hz].
    """
    base = dd.Robot.load("matched")
    right_rate = speed / (speed_ratio * base.left_radius)
    left_radius, right_radius = radii_for_speed(speed, right_rate, speed_ratio)
    compensated = base.replace(name="compensated", left_radius=left_radius, right_radius=right_radius)
    equal = base.replace(name="equal radii")
    commands = dd.maneuvers.constant_rates((speed_ratio * right_rate, right_rate), seconds, ramp=RAMP)
    every_step = 1 / dd.Physics().timestep
    fine = dd.simulate([equal, compensated], commands, sample_rate=every_step)
    slip = constraint_slip(fine)
    drive = fine.at_rate(odometry_rate)
    runs = list(zip(drive.runs, (equal, compensated), strict=True))
    believed = [run.odometry(robot) for run, robot in runs]
    odometry_error = [float(run.drift(robot).max_position_per_metre) for run, robot in runs]

    # The prediction starts where the full speed is reached and the servos have caught up.
    cruise = (fine.t > RAMP + 1.0) & (fine.t < seconds)
    circling, straight = fine.truth[:, cruise]
    twist = dd.kinematics.body_twist((speed_ratio * right_rate, right_rate), equal)
    predicted_radius = float(turning_radius(twist))
    center = turning_center(circling[0], twist)
    ring = np.hypot(*(circling[:, :2] - center).T)
    radius_error = float(np.abs(ring / predicted_radius - 1).max())
    reached = float((straight[-1, 0] - straight[0, 0]) / np.ptp(fine.t[cruise]))

    ratios = np.linspace(0.80, 1.00, 21)
    predicted, equal_ends, compensated_ends, lines = sweep(base, ratios, speed, seconds)
    worst = float(np.abs(equal_ends - predicted).max())

    bounds = [
        Bound("equal radii: distance from the predicted circle / its radius", 1e6 * radius_error, 5, "ppm"),
        Bound("compensated: leaves the line by", 1e3 * float(np.abs(fine.truth[1, :, 1]).max()), 0.1, "mm"),
        Bound("compensated: speed off by", 1e6 * abs(reached / speed - 1), 1, "ppm"),
        Bound("compensated, any k: leaves the line by", 1e3 * float(lines.max()), 0.1, "mm"),
        Bound("equal radii, any k: drift from a standing start off its prediction by", 1e3 * worst, 5, "mm"),
        Bound("slip of the contacts along the wheels", 1e3 * float(slip[..., :2].max()), 0.1, "mm/s"),
        Bound("slip of the contacts sideways", 1e3 * float(slip[..., 2].max()), 0.1, "mm/s"),
        Bound("odometry, true parameters: largest error / distance", 1e6 * max(odometry_error), 5, "ppm"),
    ]
    rows = [
        [f"{k:.2f}", 1e3 * p, 1e3 * e, 1e3 * c]
        for k, p, e, c in zip(ratios, predicted, equal_ends, compensated_ends, strict=True)
        if round(100 * k) % 5 == 0 or abs(k - speed_ratio) < 1e-9
    ]
    header = ["k: end of the drive off by", "predicted [mm]", "equal radii [mm]", "r_r = k r_l [mm]"]
    offset = float(fine.truth[0, -1, 1])
    finding = (
        f"With equal radii the robot circles a point {predicted_radius:.3f} m to its left and ends {offset:.2f} m "
        f"beside the line.\nWith r_l = {1e3 * left_radius:.1f} mm, r_r = k r_l = {1e3 * right_radius:.1f} mm it runs "
        f"{fine.truth[1, -1, 0]:.2f} m straight at {reached:.4f} m/s, within {1e3 * lines.max():.4f} mm for every k."
    )
    slow = f"{100 * (1 - speed_ratio):.0f} % slow"
    title = f"A left wheel {slow} drifts {offset:.1f} m to its side; with r_r = k r_l it drives straight"
    made, (left, right) = plots.figure(title, columns=2, size=(12.5, 5.4))
    draw_paths(left, drive, believed, center, predicted_radius)
    draw_sweep(right, ratios[:-1], equal_ends[:-1], predicted[:-1], compensated_ends[:-1], speed_ratio)
    metrics = {
        "speed_ratio": speed_ratio,
        "predicted_turning_radius_m": predicted_radius,
        "left_radius_m": left_radius,
        "right_radius_m": right_radius,
        "speed_reached_m_per_s": reached,
        "sweep": {"k": ratios, "equal_m": equal_ends, "predicted_m": predicted, "compensated_m": compensated_ends},
    }
    pictures = {"radius_compensation": made}
    return Report(run.__doc__.splitlines()[0], finding, report.table(header, rows), bounds, metrics, pictures)


def constraint_slip(recording: dd.Recording) -> np.ndarray:
    """What 002's constraints leave over in the physics (N, T - 1, 3) [m/s], sizes, from step to step.

    A step's motion over its duration is the velocity of the axle, its wheel increments are the rates: the residual
    is the speed of the contacts over the floor.
    """
    dt = float(recording.t[1] - recording.t[0])
    velocity = dd.se2.log(dd.se2.between(recording.truth[:, :-1], recording.truth[:, 1:])) / dt
    rates = np.diff(recording.wheel_angles, axis=1) / dt
    residuals = [
        constraint_residuals(v, w, robot) for v, w, robot in zip(velocity, rates, recording.robot, strict=True)
    ]
    return np.abs(np.stack(residuals))


def sweep(base: dd.Robot, ratios: np.ndarray, speed: float, seconds: float) -> tuple[np.ndarray, ...]:
    """Drive with every k.

    Returns:
        How far from the end of the straight line the drive ends [m]: predicted for equal radii, simulated with equal
        radii, simulated with the compensation; and how far the last leaves the line at most.
    """
    rates = [(speed / base.left_radius, speed / base.left_radius / k) for k in ratios]
    commands = [dd.maneuvers.constant_rates(rate, seconds, ramp=RAMP) for rate in rates]
    right_radii = [dd.kinematics.compensated_right_radius(base.left_radius, k) for k in ratios]
    compensated = [base.replace(right_radius=radius) for radius in right_radii]
    recording = dd.simulate([base] * len(ratios) + compensated, commands * 2, sample_rate=10.0)
    equal, straight = np.split(recording.truth, 2)
    # The robot with equal radii makes an arc of the same wheel angles of which the compensated one makes the line.
    goal = np.array([speed * seconds, 0.0])
    seen = np.stack([belief_matrix(base, robot) @ goal for robot in compensated])
    arcs = dd.se2.exp(np.insert(seen, 1, 0.0, axis=-1))
    ends = (np.hypot(*(poses[:, :2] - goal).T) for poses in (arcs, equal[:, -1], straight[:, -1]))
    return *ends, np.abs(straight[..., 1]).max(axis=1)


def draw_paths(ax, drive, believed, center, radius) -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    circle = center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    ax.plot(*circle.T, label="predicted circle", **plots.PREDICTION)
    ax.plot(*center, "+", color="black", markersize=12, markeredgewidth=1.5, label="its centre (ICC)")
    ax.plot(*drive.truth[0, :, :2].T, label="truth", **plots.TRUTH)
    ax.plot(*drive.truth[1, :, :2].T, **plots.TRUTH)
    plots.paths(ax, None, {"equal radii, odometry": believed[0], "r_r = k r_l, odometry": believed[1]})
    ax.set_title("Path: the arc that the formulas predict, and the line", loc="left", fontsize=11)
    ax.legend(loc="upper right", fontsize=9)


def draw_sweep(ax, ratios, equal, predicted, compensated, speed_ratio) -> None:
    ax.plot(ratios, 1e3 * predicted, label="equal radii, predicted", **plots.PREDICTION)
    ax.plot(ratios, 1e3 * equal, label="equal radii, simulated", **plots.style(0) | {"linestyle": "none"})
    ax.plot(ratios, 1e3 * compensated, label="r_r = k r_l, simulated", **plots.style(1))
    ax.axvline(speed_ratio, color="0.6", linewidth=0.9)
    ax.annotate(f" k = {speed_ratio:g}", (speed_ratio, 0.02), xycoords=("data", "axes fraction"), color="0.35")
    ax.set(yscale="log", xlabel="speed ratio k = left rate / right rate", ylabel="end of the drive off by [mm]")
    ax.grid(visible=True, color="0.9")
    ax.legend(loc="center right", fontsize=9)
    ax.set_title("For every k: metres become micrometres", loc="left", fontsize=11)


if __name__ == "__main__":
    report.main(run)
