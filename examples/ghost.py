"""Draw the pictures at the head of the README: the robot of k = 0.91, and the ghost of where it believes it is.

The left wheel turns at 0.91 of the right one's rate [Behnke], so that a robot with r_r = k r_l drives straight at 1.5
m/s. Odometry takes it for that robot. One that has equal radii instead circles away from its ghost; the compensated one
stays on it. `python examples/ghost.py` writes strobe.png and film.webp into experiments/pictures.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

import diffdrive_mj as dd
from diffdrive_mj.report import plots

K, SPEED = 0.91, 1.5
FOLDER = Path(__file__).parents[1] / "experiments" / "pictures"


def drives():
    """Both robots under the same commands, and what odometry takes them for."""
    equal = dd.Robot.load("matched")
    compensated = equal.replace(right_radius=dd.kinematics.compensated_right_radius(equal.left_radius, K))
    right_rate = SPEED / (K * equal.left_radius)
    commands = dd.maneuvers.constant_rates((K * right_rate, right_rate), 2.2, ramp=1.0)
    runs = dd.simulate([equal, compensated], commands).runs
    return dict(zip(("Equal radii", "r_r = k r_l"), runs, strict=True)), compensated


def error_plot(recordings, believed):
    """How far odometry is off along both drives."""
    figure, ax = plots.figure("", size=(plots.WIDTH, 2.3))
    for index, (title, recording) in enumerate(recordings.items()):
        drift = recording.drift(believed)
        line = plots.style(index) | {"marker": None, "linewidth": 2.5}
        ax.plot(recording.t, drift.position_error, label=title, **line)
        ax.annotate(title, (recording.t[-1], drift.position_error[-1]), (8, -2), textcoords="offset points")
    ax.set(xlabel="time [s]", ylabel="odometry off by [m]", xlim=(0, 1.15 * recording.t[-1]), ylim=(-0.12, None))
    plots.tidy(ax)
    return figure


def main(folder=FOLDER):
    """The strobe picture with its error plot below, and the film."""
    recordings, believed = drives()
    with TemporaryDirectory() as place:
        strobe, errors = Path(place, "strobe.png"), Path(place, "errors.png")
        dd.strobe(recordings, believed, strobe, size=(1600, 760))
        error_plot(recordings, believed).savefig(errors, dpi=1600 / plots.WIDTH)
        parts = [Image.open(path).convert("RGB") for path in (strobe, errors)]
        both = Image.new("RGB", (1600, sum(part.height for part in parts)), "white")
        both.paste(parts[0], (0, 0))
        both.paste(parts[1], (0, parts[0].height))
        both.save(folder / "strobe.png", optimize=True)
    film = dd.film(recordings, believed, folder / "film.webp", camera="oblique", size=(800, 400), fps=20)
    print(f"written: {folder / 'strobe.png'} {film}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
