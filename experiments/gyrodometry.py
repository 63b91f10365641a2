"""What does a gyro of a stated grade buy: on an ideal floor, over cables, on patches?

A robot drives rounds of a square and stands at every corner. Its wheels give the distance; its turns come from them,
from a gyro, from gyrodometry (Borenstein and Feng 1996), or from a filter that learns the gyro's bias at every stop.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.estimation import heading
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.report import Bound, Replay, Report, chance, plots
from diffdrive_mj.report.chance import Expected
from diffdrive_mj.report.figures import WIDTH, figure, legend_below, panel

CHEAP = "mpu6050"
GRADES = {CHEAP: "hobby", "bmi088": "drone", "adis16495": "tactical"}
IDEAL, TRACK, CABLES, PATCH = "ideal floor", "track 1 % off", "cables", "slippery patch"
WHEELS, ALONE, SWITCHED, FILTERED = "wheels", "gyro alone", "gyrodometry", "filter"
RECORDED, RATE, SPEED, YAW_RATE, RAMP = 100.0, 20.0, 0.5, 1.0, 0.5
# Cables under the right wheel: their height in radii, and how far apart [m]. A patch under the left wheel where
# the robot brakes: its share of the friction that braking needs. Turns that calibrate a gyro's scale, after a rest [s].
HEIGHT, APART, SHARE, TURNS, REST = 0.05, 0.5, 0.7, 10.0, 5.0


@dataclass(frozen=True)
class Floor:
    """A drive on one floor, what the encoder read of it, and the believed robot."""

    recording: dd.Recording
    drive: dd.Drive
    believed: dd.Robot


@dataclass(frozen=True)
class Unit:
    """One gyro of a grade, what is believed of it, and its randomness."""

    true: dd.Gyro
    believed: dd.Gyro
    own: np.random.Generator


@dataclass(frozen=True)
class Paths:
    """What one method makes of one floor with the gyros of one grade.

    Attributes:
        headings: their errors at the end (units,) [rad].
        positions: their errors at the end (units,) [m].
        law: of the heading's error, its size as expected [rad]; nan for the wheels, and where the gyros saturate.
    """

    headings: Array
    positions: Array
    law: float

    @property
    def rms(self) -> tuple[float, float]:
        """Heading [deg] and position [mm]."""
        return float(np.degrees(chance.rms(self.headings))), 1e3 * chance.rms(self.positions)


# By floor, grade and method.
Found = Mapping[str, Mapping[str, Mapping[str, Paths]]]


def run(
    robot: str = "matched", side: float = 2.0, rounds: int = 3, stop: float = 1.5, units: int = 40, seed: int = 0
) -> Report:
    """Drive rounds of a square on four floors, with gyros of three grades.

    Args:
        robot: a preset's name, or a TOML file.
        side: of the square, 1 or more [m].
        rounds: of it.
        stop: how long the robot stands before and after each corner, and twice as long at first, 1 or more [s].
        units: gyros of each grade: noise and the signs of bias and scale error are their own.
        seed: of the randomness.
    """
    true, rng = dd.Robot.load(robot), np.random.default_rng(checks.whole("seed", seed, least=0))
    for name, value, least, unit in (("side", side, 1.0, "m"), ("stop", stop, 1.0, "s")):
        if checks.positive(name, value) < least:
            raise InvalidValue(f"{name} = {value:g} {unit}: must be at least {least:g} {unit}")
    commands = tour(true, side, checks.whole("rounds", rounds), stop)
    floors = floors_of(true, commands, side, rng)
    spin = recorded(true, after_a_rest(dd.maneuvers.spin(true, turns=TURNS, yaw_rate=YAW_RATE), REST))
    gyros = {
        grade: [one_of(grade, spin, rng) for _ in range(checks.whole("units", units, least=2))] for grade in GRADES
    }
    encoder = dd.Encoder(true, sample_rate=RATE)
    found = {
        name: {grade: followed(floor, encoder, batch) for grade, batch in gyros.items()}
        for name, floor in floors.items()
    }
    title, slippery, one = headline(found), floors[PATCH], gyros[CHEAP][0]
    drive = dataclasses.replace(slippery.drive, gyro=read(one, slippery.recording))
    estimate = dd.gyrodometry.filtered(drive, slippery.believed, one.believed)
    paths = {WHEELS: drive.odometry(slippery.believed), FILTERED: estimate.poses}
    return Report(
        question=__doc__,
        finding=f"{title}.\n{details(found, one, float(np.ptp(drive.truth[:, 2])))}",
        table=table(found),
        bounds=claims(found),
        metrics={f"{floor}, {method}": values for floor, method, values in rows(found)},
        pictures={"gyrodometry": picture(title, found)},
        replays=[Replay(PATCH.capitalize(), drive.clock, drive.truth, paths, true)],
    )


def tour(robot: dd.Robot, side: float, rounds: int, stop: float) -> dd.Commands:
    """Rounds of a square, with a stop before and after every turn on the spot."""
    ahead = sequence(robot, [[Segment(side, 0.0, side / SPEED)]], ramp=RAMP, rest=stop)
    corner = sequence(robot, [[Segment(0.0, np.pi / 2, np.pi / 2 / YAW_RATE)]], ramp=RAMP, rest=stop)
    round_trip = np.tile(np.concatenate([ahead.wheel_rates, corner.wheel_rates]), (4 * rounds, 1))
    return after_a_rest(dd.Commands(ahead.period, round_trip), 2 * stop)


def after_a_rest(commands: dd.Commands, rest: float) -> dd.Commands:
    """The same, begun by standing, which shows a gyro's bias."""
    waits = np.zeros((round(rest / commands.period), 2))
    return dd.Commands(commands.period, np.concatenate([waits, commands.wheel_rates]))


def recorded(robot: dd.Robot, commands: dd.Commands, world: dd.World | None = None) -> dd.Recording:
    """The drive, on whose slippery floor wheels are meant to slip."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return dd.simulate(robot, commands, world=world or dd.World(), sample_rate=RECORDED)


def floors_of(robot: dd.Robot, commands: dd.Commands, side: float, rng: np.random.Generator) -> dict[str, Floor]:
    """The same commands on each floor."""
    encoder, twin = dd.Encoder(robot, sample_rate=RATE), dd.tilt.level_twin(robot)
    friction = SHARE * float(contact_forces(robot, acceleration=(-SPEED / RAMP, 0.0)).friction_need.max())
    patch = dd.Patch(x=(side - 0.4, side - 0.05), y=(0.0, robot.track_width), friction=friction)
    even, rough, slippery = (
        Floor(made, dd.sensors.measure(made, encoder=encoder, seed=rng), twin)
        for world in (dd.World(), dd.World(cables=cables(robot, side)), dd.World(patches=(patch,)))
        for made in [recorded(robot, commands, world)]
    )
    wide = dataclasses.replace(even, believed=twin.replace(track_width=1.01 * twin.track_width))
    return {IDEAL: even, TRACK: wide, CABLES: rough, PATCH: slippery}


def cables(robot: dd.Robot, side: float) -> tuple[dd.Cable, ...]:
    """Across the way of the right wheel along each side of the square."""
    height, track = HEIGHT * robot.right_radius, robot.track_width
    corners = [(0.0, 0.0, 0.0), (side, 0.0, np.pi / 2), (side, side, np.pi), (0.0, side, 1.5 * np.pi)]
    ends = [[(along, -0.1 * track, 0.0), (along, -track, 0.0)] for along in np.arange(0.4, side - 0.3, APART)]
    laid = dd.se2.compose(np.reshape(corners, (4, 1, 1, 3)), ends)[..., :2].reshape(-1, 2, 2).round(9)
    return tuple(dd.Cable(x=tuple(x), y=tuple(y), height=height) for x, y in np.swapaxes(laid, 1, 2))


def one_of(grade: str, spin: dd.Recording, rng: np.random.Generator) -> Unit:
    """A gyro whose bias and scale are off by what its grade allows, either way, and whose scale has been calibrated."""
    allowed, own, (by_bias, by_scale) = dd.Gyro.load(grade), rng.spawn(1)[0], rng.choice([-1.0, 1.0], 2)
    true = dataclasses.replace(allowed, bias=by_bias * allowed.bias, scale_error=by_scale * allowed.scale_error)
    scale = dd.gyrodometry.scale_error(dd.sensors.measure(spin, gyro=true, seed=own))
    return Unit(true, dataclasses.replace(allowed, bias=0.0, scale_error=scale), own)


def read(one: Unit, recording: dd.Recording) -> dd.GyroLog:
    """What a gyro reads of a drive."""
    return one.true.read(recording.t, recording.truth, one.own, attitude=recording.attitude)


def followed(floor: Floor, encoder: dd.Encoder, units: Sequence[Unit]) -> dict[str, Paths]:
    """What each method makes of a floor with some gyros, all of them at once."""
    drive, grade = floor.drive, dataclasses.replace(units[0].believed, scale_error=0.0)
    (distance, rolled), dt = body_twist(np.diff(drive.wheel_angles, axis=0), floor.believed).T, np.diff(drive.t)
    logs = [read(one, floor.recording) for one in units]
    raw, seen = (np.stack(values) for values in zip(*(log.turns(drive.t) for log in logs), strict=True))
    raw /= np.array([[one.believed.gain] for one in units])
    still = heading.standing(drive.t, drive.wheel_angles)
    first = np.logical_and.accumulate(still)
    rest, duration = float(dt[first].sum()), float(dt[~first].sum())
    alone = raw - raw[:, first].sum(axis=-1, keepdims=True) / rest * dt
    threshold = heading.switch_threshold(grade, encoder.interval, encoder.heading_per_tick(floor.believed))
    exact = np.diff(np.interp(drive.t, drive.clock, drive.truth[:, 2]))
    below, _ = heading.switched(rolled, exact, dt, threshold)
    scale = grade.drift(2 * np.pi * TURNS / YAW_RATE, REST) / (2 * np.pi * TURNS)
    wheels = np.broadcast_to(rolled, raw.shape)
    found = heading.filtered(raw, dt, still, grade, wheels=wheels, seen=seen, scale_sigma=scale)
    turns = {
        WHEELS: wheels[:1],
        ALONE: np.where(seen, alone, wheels),
        SWITCHED: heading.switched(wheels, np.where(seen, alone, wheels), dt, threshold)[0],
        FILTERED: np.diff(found.heading),
    }
    turned = float(drive.truth[-1, 2] - drive.truth[0, 2])
    laws = {
        WHEELS: np.nan,
        ALONE: float(np.hypot(grade.drift(duration, rest), scale * turned)),
        FILTERED: float(found.sigma[:, -1].mean()),
        SWITCHED: abs(float((below - exact).sum())),
    }
    truth = np.array([np.interp(drive.t[[0, -1]], drive.clock, values) for values in drive.truth.T]).T
    paths = {}
    for name, values in turns.items():
        motion = np.stack([np.broadcast_to(distance, values.shape), values], axis=-1)
        off = dd.odometry.accumulate(motion, start=truth[0])[:, -1] - truth[1]
        paths[name] = Paths(off[:, 2], np.hypot(off[:, 0], off[:, 1]), laws[name] if seen.all() else np.nan)
    return paths


def claims(found: Found) -> list[Bound]:
    """The errors are as large as the gyro's data sheet and the filter say; what each method sees of which floor."""
    whole = {name: [ms for ms in grades.values() if np.isfinite(ms[ALONE].law)] for name, grades in found.items()}
    whole = {name: grades for name, grades in whole.items() if grades}
    stated = [
        chance.rms_bound(f"{name}, {method}", *(Expected(ms[method].headings, ms[method].law) for ms in grades))
        for name, grades in whole.items()
        for method in (ALONE, FILTERED)
    ]
    off = {
        name: max(abs(ms[SWITCHED].rms[0] - np.degrees(ms[SWITCHED].law)) / ms[WHEELS].rms[0] for ms in grades)
        for name, grades in whole.items()
        if name != IDEAL
    }
    hidden = f"{SWITCHED}: off what its threshold hides by"
    return [*stated, *(Bound(f"{name}, {hidden}", 100 * v, 10, "% of the wheels'") for name, v in off.items())]


def headline(found: Found) -> str:
    """The finding; the picture's title."""
    wheels, cheap = ({name: found[name][CHEAP][m].rms[0] for name in found} for m in (WHEELS, FILTERED))
    turned, left = (" or ".join(dict.fromkeys(f"{m[name]:.2g}" for name in (CABLES, PATCH))) for m in (wheels, cheap))
    return (
        f"Cables or slip turn the wheels' heading {turned} degrees off, a hobby gyro leaves {left}.\n"
        f"On an ideal floor it is {wheels[IDEAL]:.2g} degrees by the wheels, {cheap[IDEAL]:.2g} with the gyro"
    )


def details(found: Found, one: Unit, turned: float) -> str:
    """What the title leaves out."""
    slip, drone = found[PATCH][CHEAP], found[IDEAL]["bmi088"][FILTERED].rms[0] / found[IDEAL][CHEAP][FILTERED].rms[0]
    left = [
        100 * found[name][CHEAP][SWITCHED].rms[0] / found[name][CHEAP][WHEELS].rms[0] for name in (PATCH, CABLES, TRACK)
    ]
    scale = np.degrees(abs(one.true.scale_error) * turned)
    return (
        f"Gyrodometry leaves {left[0]:.1f} % of the slip, {left[1]:.0f} % of the cables, and of a wrong track "
        f"{left[2]:.0f} %, which its threshold hides.\nNoise decides, not bias: the drone's gyro, of a twentieth of "
        f"the bias, is {drone:.2g} times as far off. As delivered the hobby gyro's scale would turn it by {scale:.0f} "
        f"degrees: calibrate it on the spot.\nNo gyro sees the distance: of {slip[WHEELS].rms[1]:.0f} mm by slip "
        f"{slip[FILTERED].rms[1]:.0f} stay."
    )


def rows(found: Found) -> Iterator[tuple[str, str, list[float]]]:
    """RMS heading [deg] and position [mm] of each grade, by floor and method."""
    for floor, grades in found.items():
        for method in (WHEELS, ALONE, SWITCHED, FILTERED):
            yield floor, method, [value for grade in grades.values() for value in grade[method].rms]


def table(found: Found) -> str:
    units = (f"{name} {unit}" for name in GRADES.values() for unit in ("[deg]", "[mm]"))
    return report.table(["RMS error at the end", *units], [[f"{f}, {m}", *values] for f, m, values in rows(found)])


def picture(title: str, found: Found) -> Figure:
    """RMS errors of heading and position at the end, a row a floor."""
    made, axes = figure(title, columns=2, size=(WIDTH, 4.4))
    shown = [(CHEAP, WHEELS), (CHEAP, ALONE), (CHEAP, SWITCHED), *((grade, FILTERED) for grade in GRADES)]
    for side, (ax, unit) in enumerate(zip(axes, ("heading [deg]", "position [mm]"), strict=True)):
        for k, (grade, method) in enumerate(shown):
            label = method if method == WHEELS else f"{method}, {GRADES[grade]}"
            values = [found[floor][grade][method].rms[side] for floor in found]
            places = np.arange(len(found)) + 0.11 * (k - 2.5)
            look = plots.style(k)
            ax.plot(values, places, look["marker"], color=look["color"], markersize=8, label=label)
        ax.set(xscale="log", yticks=range(len(found)), yticklabels=list(found), xlabel=f"RMS error at the end: {unit}")
        ax.invert_yaxis()
        for border in np.arange(len(found) - 1) + 0.5:
            ax.axhline(border, color="0.85", linewidth=0.8)
        plots.tidy(ax).grid(visible=False, axis="y")
        panel(ax, ("Heading", "Position")[side])
    axes[1].set_yticklabels([])
    legend_below(made, *axes, columns=3)
    return made


if __name__ == "__main__":
    report.main(run)
