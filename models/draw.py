"""Draw `models/pictures/robots.png`: MUJOCO_GL=egl python models/draw.py (egl needs no display)."""

from pathlib import Path

import matplotlib as mpl
import mujoco

import diffdrive_mj as dd

mpl.use("agg")

import matplotlib.pyplot as plt

ROBOTS = ("mismatched", "ct_bot", "turtlebot3_burger", "optiodom")
PICTURE = Path(__file__).with_name("pictures") / "robots.png"


def look(robot: dd.Robot, height: int = 480, width: int = 640):
    """The robot at rest, as MuJoCo's viewer shows it at first."""
    model = dd.model.compile_model(robot)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.update_scene(data, camera)
        return renderer.render()


def main() -> None:
    """Two by two, each with its name and size."""
    figure, axes = plt.subplots(2, 2, figsize=(8, 6.4), layout="compressed")
    for ax, name in zip(axes.flat, ROBOTS, strict=True):
        robot = dd.Robot.load(name)
        ax.imshow(look(robot))
        ax.set_title(f"{name}: track {1e3 * robot.track_width:g} mm, {robot.mass:.2g} kg", fontsize=11)
        ax.set_axis_off()
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=100)


if __name__ == "__main__":
    main()
