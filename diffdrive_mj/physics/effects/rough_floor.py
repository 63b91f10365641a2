"""A rough floor."""

from __future__ import annotations

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects._terrain import record_all_contacts, touch
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


def lay(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Lay the world's rough floor as a heightfield with its level circle at zero, and lower the floor to its edge.

    Args:
        spec: with all that touches the floor.
        robot: that will drive there.
        world: its rough floor.
        physics: its contacts.

    Example:
        >>> from diffdrive_mj.physics.model import compile_model
        >>> world = World(rough={"x": (-1, 3), "y": (-1, 1), "rms": 0.002, "wavelength": 0.2})
        >>> model = compile_model(Robot.load("ct_bot"), world=world)
        >>> print(model.hfield_size[0, :2], model.geom("floor").pos[2] == -world.rough.depth)
        [2. 1.] True
    """
    if world.rough is None:
        return
    x, y, z = world.rough.grid
    low, high = float(z.min()), float(z.max())
    spec.add_hfield(
        name="rough",
        nrow=len(y),
        ncol=len(x),
        size=((x[-1] - x[0]) / 2, (y[-1] - y[0]) / 2, high - low, high - low),
        userdata=((z - low) / (high - low)).ravel().tolist(),
    )
    spec.worldbody.add_geom(
        name="rough",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="rough",
        pos=((x[-1] + x[0]) / 2, (y[-1] + y[0]) / 2, low),
        material="floor",
    )
    spec.geom("floor").pos = (0, 0, low)
    touch(spec, physics, "rough")
    record_all_contacts(spec)
