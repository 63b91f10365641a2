"""What is there for the eye alone: the wheels' discs and marks, the nose, the caster's leg, the camera and its lamp.

No number here reaches the physics; the shapes that it reads are set by `model`.
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.robot import Robot

# The track of the reference robot [m], at which the camera and the lamp stand as the file has them.
_REFERENCE = 0.4


def dress(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Fit the looks of `models/diffdrive.xml` to the shapes that a robot already has.

    Args:
        spec: with the robot's own chassis and caster.
        robot: that it is.
    """
    chassis, caster = spec.geom("chassis"), spec.geom("caster")
    middle, half = np.array(chassis.pos), np.array(chassis.size)
    nose = spec.geom("nose")  # a bar along the front half of the roof that juts out over the front
    nose.pos = middle + half * (0.57, 0, 0.85)
    nose.size = half * (0.45, 0.1, 0.2)

    radius, height = float(caster.size[0]), float(caster.pos[2])
    top = max(float(middle[2] - half[2]), height + 1.2 * radius)
    leg = spec.geom("caster_leg")
    leg.pos = (caster.pos[0], caster.pos[1], (height + top) / 2)
    leg.size = (1.1 * radius, (top - height) / 2, 0)

    for side, wheel in (("left", robot.left_radius), ("right", robot.right_radius)):
        edge = robot.tyres.width / 2
        spec.geom(f"{side}_disc").size = (wheel, edge, 0)
        spec.geom(f"{side}_hub").size = (0.65 * wheel, edge + 0.006 * wheel, 0)
        spoke = spec.geom(f"{side}_spoke")  # from the hub to the rim on one side, so that whole turns can be counted
        spoke.pos = (0, 0, 0.46 * wheel)
        spoke.size = (0.1 * wheel, edge + 0.012 * wheel, 0.46 * wheel)

    spec.site("axle").size[0] = 0.08 * robot.mean_radius
    scale = max(robot.track_width, *(2 * half)) / _REFERENCE
    for looking in (spec.camera("follow"), spec.light("lamp")):
        looking.pos = scale * np.array(looking.pos)
