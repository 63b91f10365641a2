"""Wheels slip: does the mouse sensor see it?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.report import Bound, Report, plots
from diffdrive_mj.sensors.optical_flow import FlowSensor, count_error_covariance, lever_arm

WHEELS, MOUSE = "wheel odometry", "mouse sensor"
PATCH = dd.Patch(x=(0.2, 1.2), y=(-1.0, 1.0), friction=0.1)
LEFT_PATCH = dd.Patch(x=(0.2, 1.2), y=(0.0, 1.0), friction=0.1)


@dataclass(frozen=True)
class Drive:
    """A drive and what its two odometries made of it."""

    truth: np.ndarray
    believed: dict[str, np.ndarray]

    def drift(self, name: str) -> dd.metrics.Drift:
        """How far one of them is off."""
        return dd.metrics.drift(self.truth, self.believed[name])


def run(mounting: float = 0.015, counts_per_inch: float = 400.0, drives: int = 600, seed: int = 0) -> Report:
    """Wheels slip: does the mouse sensor see it?

    Args:
        mounting: of the sensor, ahead of the axle [m].
        counts_per_inch: its resolution.
        drives: with random counter phases.
        seed: of the phases.
    """
    rng = np.random.default_rng(seed)
    robot = dd.Robot.load("matched")
    sensor = FlowSensor(x=mounting, counts_per_metre=counts_per_inch / 0.0254)
    ideal = {name: measure(robot, sensor, name) for name in ("straight", "square", "spin", "arc")}
    slip = {
        "both": drive(robot, sensor, rng, dd.World(patches=(PATCH,))),
        "one": drive(robot, sensor, rng, dd.World(patches=(LEFT_PATCH,))),
    }
    lifted = lift_off(robot, sensor, rng)
    measured_rms, predicted_rms = quantisation(robot, sensor, rng, drives)
    arm = calibrated(robot, sensor)

    wheels_off = float(slip["both"].drift(WHEELS).max_position)
    mouse_off = float(slip["both"].drift(MOUSE).max_position)
    creep = creep_law(sensor)
    bounds = [
        *(
            Bound(f"{name}: mouse sensor, before it counts / distance", ideal[name]["position"], 50, "ppm")
            for name in ("straight", "square", "spin")
        ),
        *(
            Bound(f"{name}: 000's formula against the site's motion / distance", values["formula"], 20, "ppm")
            for name, values in ideal.items()
        ),
        Bound("arc: creep law off by", 100 * abs(ideal["arc"]["heading"] / creep - 1), 20, "%"),
        Bound("slippery patch: wheel odometry off by", 1e3 * wheels_off, 100, "mm", at_least=True),
        Bound("slippery patch: mouse sensor / wheel odometry", 100 * mouse_off / wheels_off, 1, "%"),
        Bound("counting: heading, predicted RMS off by", 100 * abs(measured_rms[0] / predicted_rms[0] - 1), 10, "%"),
        Bound("counting: position, predicted RMS off by", 100 * abs(measured_rms[1] / predicted_rms[1] - 1), 10, "%"),
        Bound("lever arm from a spin off by", 1e6 * float(np.hypot(arm[0] - sensor.x, arm[1])), 1, "um"),
        Bound(
            "one wheel slips: the mouse sensor fails too", float(slip["one"].drift(MOUSE).max_position), 0.1, "m", True
        ),
        Bound("lifted off: the mouse sensor fails", float(lifted.drift(MOUSE).max_position), 0.1, "m", True),
        Bound(
            "lifted off: wheel odometry / distance", 1e6 * float(lifted.drift(WHEELS).max_position_per_metre), 5, "ppm"
        ),
    ]
    rows = [[name, v["position"], v["heading"], v["formula"]] for name, v in ideal.items()]
    header = ["ideal floor", "mouse pose [ppm of distance]", "heading [ppm of angle]", "000's formula [ppm]"]
    slips = [
        [name, *(1e3 * float(done.drift(who).max_position) for who in (WHEELS, MOUSE))]
        for name, done in (("both wheels slip", slip["both"]), ("one wheel slips", slip["one"]), ("lifted off", lifted))
    ]
    table = "\n\n".join(
        [report.table(header, rows), report.table(["largest error", f"{WHEELS} [mm]", f"{MOUSE} [mm]"], slips)]
    )
    finding = (
        f"Speeding up at 4 m/s^2 across a floor of friction 0.1, the wheels count {1e3 * wheels_off:.0f} mm that the "
        f"robot never went;\nthe mouse sensor is off by {1e3 * mouse_off:.2g} mm. With one wheel on it the robot "
        f"slides sideways, which one sensor takes for\na turn. {counts_per_inch:g} counts per inch leave "
        f"{1e3 * measured_rms[1]:.2g} mm RMS after a square of 1 m ({1e3 * predicted_rms[1]:.2g} predicted)."
    )
    title = (
        f"Both wheels slip: {1e3 * wheels_off:.0f} mm of drift, the mouse sensor sees it to {1e3 * mouse_off:.2g} mm"
    )
    made, axes = plots.figure(title, columns=3, size=(16, 5.2))
    draw(axes, slip, lifted)
    metrics = {
        "ideal": ideal,
        "creep_law_ppm": creep,
        "counting_rms": {"heading_rad": measured_rms[0], "position_m": measured_rms[1]},
        "counting_rms_predicted": {"heading_rad": predicted_rms[0], "position_m": predicted_rms[1]},
        "counts_per_turn": 2 * np.pi * mounting * sensor.counts_per_metre,
        "lever_arm_m": arm,
    }
    return Report("Wheels slip: does the mouse sensor see it?", finding, table, bounds, metrics, {"optical_flow": made})


def measure(robot: dd.Robot, sensor: FlowSensor, name: str) -> dict[str, float]:
    """The sensor's pose and 000's formula against the ideal physics [ppm]."""
    options = {"square": {"side": 2.0}, "arc": {"distance": 10.0}}.get(name, {})
    commands = getattr(dd.maneuvers, name)(robot, **options)
    recording = dd.simulate(robot, commands, sample_rate=1 / dd.Physics().timestep, flow_sensor=sensor)
    truth = recording.truth
    judged = dd.metrics.drift(truth, dd.odometry.accumulate(sensor.from_flow(recording.flow)))
    turned = float(np.abs(np.diff(truth[:, 2])).sum())
    distance = turned * robot.track_width / 2 if name == "spin" else float(judged.distance)
    # 000's formula, fed the true motion of every step, its slide to the side included.
    formula = np.cumsum(sensor.displacement(dd.se2.log(dd.se2.between(truth[:-1], truth[1:]))), axis=0)
    return {
        "position": 1e6 * float(judged.max_position) / distance,
        "heading": 1e6 * float(judged.max_heading) / max(turned, 1.0),
        "formula": 1e6 * float(np.abs(formula - recording.flow[1:]).max()) / distance,
    }


def creep_law(sensor: FlowSensor) -> float:
    """The relative heading error on the arc [ppm].

    A turning robot creeps sideways by v omega dt (1/2 - 1/damping), which the sensor takes for a turn about its lever
    arm.
    """
    physics, speed = dd.Physics(), 1.35
    return 1e6 * abs(speed * physics.timestep * (0.5 - 1 / physics.friction_damping) / sensor.x)


def drive(robot: dd.Robot, sensor: FlowSensor, rng: np.random.Generator, world: dd.World) -> Drive:
    """Speed up at 4 m/s^2 across the patch."""
    commands = dd.maneuvers.straight(robot, distance=4.0, speed=2.0, ramp=0.5)
    recording = dd.simulate(robot, commands, world=world, physics=dd.Physics.sliding(), flow_sensor=sensor)
    return believed(recording, robot, sensor, rng)


def lift_off(robot: dd.Robot, sensor: FlowSensor, rng: np.random.Generator) -> Drive:
    """A figure eight on which the sensor loses the floor for a second."""
    recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot), flow_sensor=sensor)
    lost = (recording.t > 5.0) & (recording.t < 6.0)
    return believed(recording, robot, sensor, rng, lost)


def believed(
    recording: dd.Recording,
    robot: dd.Robot,
    sensor: FlowSensor,
    rng: np.random.Generator,
    lifted: np.ndarray | None = None,
) -> Drive:
    counts = sensor.counts(recording.flow, phase=rng.random(2), lifted=lifted)
    estimates = {
        WHEELS: recording.odometry(robot),
        MOUSE: dd.odometry.accumulate(sensor.from_counts(counts)),
    }
    return Drive(recording.truth, estimates)


def quantisation(
    robot: dd.Robot, sensor: FlowSensor, rng: np.random.Generator, drives: int
) -> tuple[tuple[float, float], tuple[float, float]]:
    """RMS of the final heading [rad] and position error [m] over random counter phases, measured and predicted."""
    recording = dd.simulate(robot, dd.maneuvers.square(robot, side=1.0), sample_rate=20.0, flow_sensor=sensor)
    flow = recording.flow
    counts = sensor.counts(np.broadcast_to(flow, (drives, *flow.shape)), phase=rng.random((drives, 2)))
    exact = dd.odometry.accumulate(sensor.from_flow(flow))[-1]
    ends = dd.odometry.accumulate(sensor.from_counts(counts))[:, -1]
    error = ends - exact
    measured = (float(np.sqrt(np.mean(error[:, 2] ** 2))), float(np.sqrt(np.mean(error[:, 0] ** 2 + error[:, 1] ** 2))))

    # A heading error turns what is driven meanwhile: dp = sum of J d_i e_i, with the count errors' covariance.
    sideways = flow[:, 1] * sensor.counts_per_metre
    covariance = count_error_covariance(sideways) / (sensor.counts_per_metre * sensor.x) ** 2
    path = recording.truth[:, :2]
    weights = np.zeros_like(path)
    weights[:-1] += np.diff(path, axis=0) / 2
    weights[1:] += np.diff(path, axis=0) / 2
    position = np.sqrt(np.einsum("ik,ij,jk->", weights, covariance, weights))
    end = count_error_covariance(sideways[-1:])[0, 0] / (sensor.counts_per_metre * sensor.x) ** 2
    return measured, (float(np.sqrt(end)), float(position))


def calibrated(robot: dd.Robot, sensor: FlowSensor) -> np.ndarray:
    """The lever arm (x, y) [m] that a spin of three turns tells."""
    recording = dd.simulate(robot, dd.maneuvers.spin(robot), flow_sensor=sensor)
    return lever_arm(recording.flow[-1], recording.truth[-1, 2])


def draw(axes, slip: dict[str, Drive], lifted: Drive) -> None:
    both, one = slip["both"], slip["one"]
    along = both.drift(WHEELS).travelled
    plots.errors(axes[0], along, {name: both.drift(name).position_error for name in (WHEELS, MOUSE)})
    axes[0].axvspan(*PATCH.x, color="0.88", zorder=0)
    axes[0].annotate("friction 0.1", (sum(PATCH.x) / 2, 40), ha="center", color="0.35")
    axes[0].set_title("Both wheels on the patch", loc="left", fontsize=11)
    plots.paths(axes[1], one.truth, one.believed)
    (left, right), (low, high) = LEFT_PATCH.x, (0.0, 1.0)
    axes[1].fill([left, right, right, left], [low, low, high, high], color="0.88", zorder=0)
    axes[1].set_title("One wheel on it: the robot slides sideways", loc="left", fontsize=11)
    plots.paths(axes[2], lifted.truth, lifted.believed)
    axes[2].set_title("The reverse: the sensor loses the floor for 1 s", loc="left", fontsize=11)


if __name__ == "__main__":
    report.main(run)
