"""How exact is the simulator itself?

Odometry with the true parameters is driven against the physics: on the standard maneuvers, with one choice of the
solver changed at a time; on robots and drives that nobody chose; and with time steps ever smaller, since Euler's rule
alone must come to what the midpoint rule gives at once.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging import standards
from diffdrive_mj.judging.random_drives import Case, Outcome, outcome, random_cases
from diffdrive_mj.judging.standards import PRESETS, STANDARD_MANEUVERS, Residual, residual, standard_residuals
from diffdrive_mj.kinematics import belief_matrix
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Report, marks, plots

LEVEL = dd.Robot.load("mismatched")
RIGID = LEVEL.replace(axle="rigid")
CYLINDRICAL = LEVEL.replace(tyres={"shape": "cylinder"})
_HABIT = dd.Physics.mujoco_defaults()
DEFAULTS, FAST, HABIT, CYLINDERS = "as delivered", "fast: 5 ms", "MuJoCo's defaults", "cylinder wheels"
TILT_KNOWN, TILTED = "rigid axle, level twin known", "rigid axle, tilt not known"
VARIANTS = {
    DEFAULTS: dd.Physics(),
    "time step 1 ms": dd.Physics(timestep=0.001),
    FAST: dd.Physics.fast(),
    "contacts not balanced": dd.Physics(balanced_contacts=False, settle_time=0.3),
    "impedance 0.999": dd.Physics(contact_impedance=(0.999, 0.999)),
    "friction damping 1.995": dd.Physics(friction_damping=1.995),
    "the engine's own pose": dd.Physics(truth="engine"),
    "friction damping left to MuJoCo": dd.Physics(friction_damping=None, truth="engine"),
    "integrator implicitfast": dd.Physics(integrator="implicitfast", truth="engine"),
    CYLINDERS: dd.Physics(),  # of another robot
    "default contacts, which sink": dataclasses.replace(_HABIT, integrator="Euler", cone="elliptic", tolerance=1e-10),
    HABIT: _HABIT,
}
STEPS = np.array([2.0, 1.0, 0.5, 0.25])  # [ms]
CONVERGING = {name: STANDARD_MANEUVERS[name] for name in ("arc", "figure eight")} | {"slalom": dd.maneuvers.slalom}
# Of the random drives that keep their grip: the median error [ppm], the share warned of needlessly.
RANDOM_MEDIAN, NEEDLESS = 0.05, 0.02

Residuals = dict[str, Residual]  # by maneuver


@dataclass(frozen=True)
class Measured:
    """All that is measured, errors in ppm.

    Attributes:
        rows: the standard maneuvers, by robot and physics.
        engine: the residual of the engine's own pose at `STEPS`, by maneuver.
        midpoint: that of the midpoint rule at the first of them.
        outcomes: of the random drives.
    """

    rows: dict[str, Residuals]
    engine: dict[str, np.ndarray]
    midpoint: dict[str, float]
    outcomes: list[Outcome]

    @property
    def keepers(self) -> np.ndarray:
        """Position errors of the random drives that keep their grip."""
        return np.array([outcome.position for outcome in self.outcomes if outcome.keeps_grip])

    @property
    def limits(self) -> dict[str, float]:
        """Where `engine` goes as the steps go to zero, extrapolated from the last two."""
        return {name: float(2 * by_step[-1] - by_step[-2]) for name, by_step in self.engine.items()}

    def worst(self, *labels: str) -> float:
        """The largest position error in some rows."""
        return max(left.position for label in labels for left in self.rows[label].values())


def run(random: int = 60, seed: int = 0) -> Report:
    """Drive and judge.

    Args:
        random: number of random robots and drives.
        seed: of them.
    """
    measured = measure(random_cases(checks.whole("random", random), seed))
    if not len(measured.keepers):
        raise InvalidValue(f"random = {random}: none of the drives keeps its grip; more of them will do")
    answer = finding(measured)
    return Report(
        question=__doc__,
        finding=answer,
        table=table(measured),
        bounds=claims(measured),
        metrics=metrics(measured),
        pictures={"physics_floor": figure(answer.splitlines()[0], measured)},
    )


def measure(cases: list[Case]) -> Measured:
    """Simulate everything."""
    rows = {
        label: standard_residuals(CYLINDRICAL if label in (CYLINDERS, HABIT) else LEVEL, physics)
        for label, physics in VARIANTS.items()
    }
    rows[TILT_KNOWN] = standard_residuals(RIGID, believed=level_twin(RIGID))
    rows[TILTED] = standard_residuals(RIGID)
    for name in PRESETS:
        for kind in (DEFAULTS, FAST):
            done = rows[kind] if name == LEVEL.name else standard_residuals(dd.Robot.load(name), VARIANTS[kind])
            rows[f"{name}, {kind}"] = done
    engine = [dd.Physics(timestep=step / 1e3, truth="engine") for step in STEPS]
    return Measured(
        rows=rows,
        engine={name: np.array([at_every_step(LEVEL, name, physics) for physics in engine]) for name in CONVERGING},
        midpoint={name: at_every_step(LEVEL, name, dd.Physics()) for name in CONVERGING},
        outcomes=[outcome(case) for case in cases],
    )


def at_every_step(robot: dd.Robot, maneuver: str, physics: dd.Physics) -> float:
    """The residual in position [ppm], judged at every time step."""
    recording = dd.simulate(robot, CONVERGING[maneuver](robot), physics=physics, sample_rate=1 / physics.timestep)
    return residual(recording, robot).position


def claims(measured: Measured) -> list[Bound]:
    """The bounds of the physics; those of a share of the random drives allow for three sigma of chance."""
    bounds = []
    for kind, allowed in ((DEFAULTS, standards.POSITION_FLOOR), (FAST, standards.FAST_POSITION_FLOOR)):
        for label in (f"{name}, {kind}" for name in PRESETS):
            turned = max(left.heading for left in measured.rows[label].values())
            bounds.append(Bound(f"{label}: position error", measured.worst(label), allowed, "ppm of the distance"))
            bounds.append(Bound(f"{label}: heading error", turned, standards.HEADING_FLOOR, "ppm of the angle"))
    predicted = 1e6 * float(belief_matrix(RIGID, level_twin(RIGID))[1, 1] - 1)
    tilt = abs(measured.rows[TILTED]["spin"].heading - predicted)
    bounds.append(Bound("rigid axle, spin: heading error as predicted, off by", tilt, 0.5, "ppm"))
    for name, limit in measured.limits.items():
        halved = np.abs(measured.engine[name][:-1] / measured.engine[name][1:] / 2 - 1).max()
        bounds.append(Bound(f"engine's pose, {name}: halves with the step, off by", 100 * float(halved), 0.5, "%"))
        apart = abs(limit - measured.midpoint[name])
        bounds.append(Bound(f"engine's pose, {name}: limit and midpoint rule apart by", apart, 0.2, "ppm"))
    keepers = [outcome for outcome in measured.outcomes if outcome.keeps_grip]
    needless = float(np.mean([outcome.flagged for outcome in keepers]))
    most, floor = float(measured.keepers.max()), standards.ANY_FLOOR
    silent = sum(outcome.position > floor and not outcome.flagged for outcome in measured.outcomes)
    above, chance = float(np.mean(measured.keepers > RANDOM_MEDIAN)), 3 / np.sqrt(len(keepers))
    most_needless = NEEDLESS + chance * np.sqrt(NEEDLESS * (1 - NEEDLESS))
    return [
        *bounds,
        Bound("random drives that keep their grip: position error", most, floor, "ppm"),
        Bound(f"random drives, above {RANDOM_MEDIAN} ppm", 100 * above, 50 * (1 + chance), "%"),
        Bound(f"random drives above {floor:g} ppm without a warning", silent, 0),
        Bound("random drives, warned of needlessly", 100 * needless, 100 * most_needless, "%"),
    ]


def finding(measured: Measured) -> str:
    """The answer; its first line is the picture's title."""
    floor, habit = measured.worst(*(f"{name}, {DEFAULTS}" for name in PRESETS)), measured.worst(HABIT) / 1e4
    kept, (engine, limit) = measured.keepers, (measured.engine["arc"][0], measured.limits["arc"])
    return (
        f"Physics as delivered agrees with odometry to {floor:.2g} ppm, MuJoCo's defaults to {habit:.1f} %\n"
        f"Of {len(measured.outcomes)} random robots and drives {len(kept)} keep their grip: they agree within "
        f"{kept.max():.2g} ppm, {np.median(kept):.2g} in the median.\nOn an arc the engine's own pose is off by "
        f"{engine:.1f} ppm, and by half with every half of the step; its limit is {limit:.3f} ppm,\nwhere the midpoint "
        f"rule is at {measured.midpoint['arc']:.3f} ppm with steps of 2 ms."
    )


def table(measured: Measured) -> str:
    """Positions, headings, convergence."""
    position, heading = (
        [[label, *(getattr(left, field) for left in row.values())] for label, row in measured.rows.items()]
        for field in ("position", "heading")
    )
    engine = [[name, *found, measured.limits[name], measured.midpoint[name]] for name, found in measured.engine.items()]
    steps = (*(f"{step:g} ms" for step in STEPS), "limit", "midpoint rule, 2 ms")
    return "\n\n".join(
        [
            report.table(["position [ppm of the distance]", *STANDARD_MANEUVERS], position),
            report.table(["heading [ppm of the angle; straight: urad]", *STANDARD_MANEUVERS], heading),
            report.table(["the engine's own pose [ppm]", *steps], engine),
        ]
    )


def metrics(measured: Measured) -> dict[str, object]:
    """The numbers for `metrics.json`."""
    return {
        "standard_ppm": {label: {n: vars(left) for n, left in row.items()} for label, row in measured.rows.items()},
        "step_ms": STEPS,
        "engine_position_ppm": measured.engine,
        "engine_limit_ppm": measured.limits,
        "midpoint_position_ppm": measured.midpoint,
        "random_position_ppm": measured.keepers,
    }


def figure(title: str, measured: Measured) -> Figure:
    """What each choice is worth, and how the engine's own pose converges."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 5.2), widths=(1.7, 1))
    draw_choices(left, measured)
    draw_convergence(right, measured)
    plots.legend_below(made, left, columns=7)
    return made


def draw_choices(ax: Axes, measured: Measured) -> None:
    """A row for each way to make the physics, sorted, a mark for each maneuver."""
    labels = sorted((*VARIANTS, TILT_KNOWN, TILTED), key=lambda label: -measured.worst(label))
    for index, name in enumerate(STANDARD_MANEUVERS):
        values = [max(measured.rows[label][name].position, 1e-4) for label in labels]
        look = plots.style(index) | {"linestyle": "none", "markersize": 6.5, "markerfacecolor": "none"}
        ax.plot(values, range(len(labels)), label=name, **look)
    ax.plot(measured.keepers, np.full(len(measured.keepers), len(labels)), "|", color="0.4", label="random drive")
    ax.axvspan(1e-4, standards.POSITION_FLOOR, color="0.93", zorder=0)
    ax.axvline(standards.POSITION_FLOOR, color="0.4", linewidth=1)
    ax.set_yticks(range(len(labels) + 1), [*labels, "random robots and drives"])
    ax.get_yticklabels()[labels.index(DEFAULTS)].set_fontweight("bold")
    ax.set(xscale="log", xlim=(6e-5, 4e4), xlabel="largest position error [ppm of the distance]")
    plots.panel(plots.tidy(ax), f"k = 0.91, one choice changed (grey: below {standards.POSITION_FLOOR} ppm)")


def draw_convergence(ax: Axes, measured: Measured) -> None:
    """The engine's own residual against the step, extrapolated to zero, and the midpoint rule's."""
    looks = {"arc": plots.style(1), "figure eight": plots.style(5), "slalom": plots.style(3)}  # as on the left
    for name, look in looks.items():
        by_step = measured.engine[name]
        ax.plot([0, STEPS[0]], [measured.limits[name], by_step[0]], color=look["color"], linewidth=0.9, linestyle=":")
        ax.plot(STEPS, by_step, **look)
        ax.plot(STEPS[0], measured.midpoint[name], **look | {"markersize": 9, "markerfacecolor": "none"})
    marks.note(ax, "arc", (STEPS[0], measured.engine["arc"][0]), (-8, 0), ha="right")
    marks.note(ax, "slalom,\nfigure eight", (STEPS[0], measured.engine["slalom"][0]), (0, 8), ha="right")
    most = max(measured.midpoint.values())
    marks.note(ax, f"midpoint rule:\n{most:.1g} ppm at most", (STEPS[0], 0), (-12, 6), ha="right")
    ax.set(xlabel="time step [ms]", ylabel="position error [ppm]", xlim=(0, 2.15), ylim=(-8, 275))
    plots.panel(plots.tidy(ax), "The engine's own pose")


if __name__ == "__main__":
    report.main(run)
