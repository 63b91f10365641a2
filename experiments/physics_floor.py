"""How exact is the simulator itself? Odometry with the true parameters against physics made in many ways."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.kinematics import belief_matrix, body_twist
from diffdrive_mj.physics.tilt import level_twin, resting_tilt
from diffdrive_mj.report import Bound, Report, plots


@dataclass(frozen=True)
class Standard:
    """A maneuver that the ideal physics is held to, with its bounds.

    Args:
        commands: for a robot.
        position: largest position error / distance driven [ppm]; of the wheels' path for the spin.
        heading: largest heading error / angle turned [ppm]; where nothing turns, the error itself [microradians].
    """

    commands: Callable[[dd.Robot], dd.Commands]
    position: float
    heading: float


def constant_arc(robot: dd.Robot, rates: tuple[float, float] = (12.0, 15.0), distance: float = 10.0) -> dd.Commands:
    """Constant wheel rates [rad/s] over a distance [m]."""
    return dd.maneuvers.constant_rates(rates, distance / float(body_twist(rates, robot)[0]))


STANDARDS = {
    "straight": Standard(dd.maneuvers.straight, 1, 2),
    "arc": Standard(constant_arc, 5, 3),
    "square": Standard(dd.maneuvers.square, 1, 3),
    "square, clockwise": Standard(lambda robot: dd.maneuvers.square(robot, clockwise=True), 1, 3),
    "spin": Standard(dd.maneuvers.spin, 1, 3),
    "figure eight": Standard(dd.maneuvers.figure_eight, 5, 3),
}

DEFAULTS = "as delivered"
CARELESS = "careless: MuJoCo's defaults, cylinders"
TILTED = "rigid axle, which tilts"
VARIANTS = {
    CARELESS: dd.Physics.mujoco_defaults(),
    "default contacts, which sink": dd.Physics(contact_time=10, contact_impedance=(0.9, 0.95), friction_damping=None),
    "integrator implicitfast": dd.Physics(integrator="implicitfast"),
    "cylinder wheels": dd.Physics(wheel_shape="cylinder"),
    "friction damping left to MuJoCo": dd.Physics(friction_damping=None),
    "friction damping 1.6": dd.Physics(friction_damping=1.6),
    "friction damping 1.98": dd.Physics(friction_damping=1.98),
    "impedance 0.999": dd.Physics(contact_impedance=(0.999, 0.999)),
    "time step 5 ms": dd.Physics(timestep=0.005),
    "time step 1 ms": dd.Physics(timestep=0.001),
}


def run() -> Report:
    """How exact is the simulator itself?"""
    level = dd.Robot.load("mismatched")
    rigid = level.replace(axle="rigid")
    results = {label: measure(level, physics) for label, physics in VARIANTS.items()}
    results["its level twin believed"] = measure(rigid, dd.Physics(), level_twin(rigid))
    results[TILTED] = measure(rigid, dd.Physics())
    results["equal wheels, as delivered"] = measure(dd.Robot.load("matched"), dd.Physics())
    results[DEFAULTS] = measure(level, dd.Physics())

    bounds = [
        bound
        for label in (DEFAULTS, "equal wheels, as delivered")
        for name, standard in STANDARDS.items()
        for bound in (
            Bound(f"{label}, {name}: position", results[label][name][0], standard.position, "ppm"),
            Bound(f"{label}, {name}: heading", results[label][name][1], standard.heading, "ppm or urad"),
        )
    ]
    tilted = 1e6 * (belief_matrix(rigid, level_twin(rigid))[1, 1] - 1)
    spun = results[TILTED]["spin"][1]
    bounds.append(Bound("rigid axle, spin: predicted heading error off by", abs(spun - tilted), 5, "ppm"))
    worst = max(position for position, _ in results[DEFAULTS].values())
    careless = max(position for position, _ in results[CARELESS].values())
    finding = (
        f"As delivered, odometry with the true parameters agrees with the physics within {worst:.2g} ppm; "
        f"made carelessly, within {careless / 1e4:.1f} %.\nOn a rigid axle a robot with k = 0.91 tilts by "
        f"{np.degrees(resting_tilt(rigid).roll):.2f} degrees: {spun:.0f} ppm of a spin's angle, "
        f"{tilted:.0f} predicted."
    )
    header = ["position [ppm of distance]", *STANDARDS]
    rows = [[label, *(position for position, _ in by.values())] for label, by in results.items()]
    heads = [[label, *(heading for _, heading in by.values())] for label, by in results.items()]
    table = "\n\n".join(
        [report.table(header, rows), report.table(["heading [ppm of angle, straight: urad]", *STANDARDS], heads)]
    )
    title = f"Physics as delivered agrees with odometry to {worst:.1g} ppm; made carelessly, to {careless / 1e4:.1f} %"
    made, ax = plots.figure(title, size=(11, 6.4))
    draw(ax, results)
    metrics = {
        "position_ppm": {label: {name: p for name, (p, _) in by.items()} for label, by in results.items()},
        "heading_ppm": {label: {name: h for name, (_, h) in by.items()} for label, by in results.items()},
    }
    return Report(run.__doc__, finding, table, bounds, metrics, {"physics_floor": made})


def measure(robot: dd.Robot, physics: dd.Physics, belief: dd.Robot | None = None) -> dict[str, tuple[float, float]]:
    """Position [ppm of the distance] and heading errors [ppm of the angle, or microradians], by maneuver."""
    names, result = list(STANDARDS), {}
    for pair in zip(names[::2], names[1::2], strict=True):  # of like duration: each goes to a core of its own
        commands = [STANDARDS[name].commands(robot) for name in pair]
        longest = max(command.duration for command in commands)
        recording = dd.simulate(robot, [command.extended(longest) for command in commands], physics=physics)
        for name, drive in zip(pair, recording.runs, strict=True):
            result[name] = judge(drive, belief or robot)
    return result


def judge(drive: dd.Recording, robot: dd.Robot) -> tuple[float, float]:
    drift = drive.drift(robot)
    turned = float(np.abs(np.diff(drive.truth[:, 2])).sum())
    spinning = drift.distance < 0.1 * turned * robot.track_width
    driven = turned * robot.track_width / 2 if spinning else float(drift.distance)
    # A drive without a turn has no angle to compare with: its error counts as it is.
    return 1e6 * float(drift.max_position) / driven, 1e6 * float(drift.max_heading) / (turned if turned > 0.1 else 1.0)


def draw(ax, results) -> None:
    """A row for each way to make the physics, a mark for each maneuver, errors to the right."""
    labels = list(results)
    for place, name in enumerate(STANDARDS):
        values = [max(results[label][name][0], 1e-3) for label in labels]
        look = plots.style(place) | {"linestyle": "none", "markersize": 8, "markerfacecolor": "none"}
        ax.plot(values, range(len(labels)), label=name, **look)
    ax.axvspan(1e-3, 1, color="0.93", zorder=0)
    ax.axvline(1, color="0.4", linewidth=1)
    ax.annotate(
        "1 ppm: a millimetre in a kilometre", (1, 1.01), xycoords=("data", "axes fraction"), ha="center", color="0.35"
    )
    ax.set_yticks(range(len(labels)), labels)
    ax.get_yticklabels()[-1].set_fontweight("bold")
    ax.set(xscale="log", xlim=(8e-4, 1e5), xlabel="largest position error [ppm of the distance driven]")
    ax.grid(visible=True, color="0.9")
    ax.legend(loc="center right", fontsize=9, title="maneuver")


if __name__ == "__main__":
    report.main(run)
