"""The scene in MuJoCo: copies of the robot that have no physics, the floor, the light, and lines on the floor."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array
from diffdrive_mj.physics.model import model_spec
from diffdrive_mj.report.filming._ground import Bar, Colour, Field, Flat, Shape
from diffdrive_mj.report.filming._scene import Rgb, Scene
from diffdrive_mj.report.filming._trails import Piece, piece, pieces
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics

_PALE, _DARK = (0.985, 0.985, 0.98), (0.925, 0.93, 0.94)
_MARK = (0.97, 0.97, 0.95, 1.0)  # of wheels and nose: orange is the ghost's
# A ghost: how much of it is there; a bit smaller than the robot, so that it is not seen where the two coincide; and the
# glow on the floor around it, which is seen then.
_THROUGH, _SMALLER, _GLOW = 0.55, 0.985, 0.45
# The sun: along the view, to its right, up; and the shadows, which are thin shapes on the floor.
_LIGHT, _SHADE, _THIN = np.array([0.35, 0.5, -1.0]) / math.hypot(0.35, 0.5, 1.0), (0.50, 0.51, 0.53, 1.0), 1e-4
# Samples for each pixel, against jagged edges.
_SAMPLES = 4


class Stage:
    """A scene that can be drawn frame by frame; the only place where OpenGL is used."""

    def __init__(self, scene: Scene, smooth: int) -> None:
        """Build the model and the renderer.

        Args:
            scene: to be drawn.
            smooth: how often finer it is drawn than its size.
        """
        self._scene, (width, height) = scene, (smooth * side for side in scene.size)
        self._model = _model(scene, (width, height))
        self._data = mujoco.MjData(self._model)
        self._trails = [(trail, pieces(trail.points, trail.width, trail.height)) for trail in scene.trails]
        lines = sum(len(driven) + 1 for _, driven in self._trails) + len(scene.links) + len(scene.actors)
        self._renderer = mujoco.Renderer(self._model, height, width, max_geom=lines + 2 * self._model.ngeom + 100)
        self._target = scene.view.target()

    def frame(self, k: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """Draw one frame (height, width, 3)."""
        self._pose(k)
        view, drawn = self._scene.view, self._renderer.scene
        camera = mujoco.MjvCamera()
        camera.lookat, camera.distance = self._target[k], view.distance[k]
        camera.azimuth, camera.elevation = view.azimuth[k], view.elevation[k]
        self._renderer.update_scene(self._data, camera)
        sun = self._shine(view.azimuth[k])
        for geom in drawn.geoms[: drawn.ngeom]:
            if self._casts_shadow(geom):
                self._shadow(geom, sun)
        for actor in self._scene.actors:
            if actor.ghost is not None:
                self._glow(actor.poses[k], (*actor.ghost, _GLOW * (1 - float(actor.apart[k]))))
        for link in self._scene.links:
            self._draw(piece(link.ends[k, 0], link.ends[k, 1], link.width, link.height), link.colour)
        for trail, driven in self._trails:
            whole = max(int(np.searchsorted(trail.times, self._scene.times[k], side="right")) - 1, 0)
            for part in [*driven[:whole], piece(trail.points[whole], trail.tips[k], trail.width, trail.height)]:
                self._draw(part, trail.colour)
        return self._renderer.render()

    def _pose(self, k: int) -> None:
        each = len(self._data.qpos) // len(self._scene.actors)
        qpos, rest = self._data.qpos.reshape(-1, each), self._model.qpos0.reshape(-1, each)
        for here, still, actor in zip(qpos, rest, self._scene.actors, strict=True):
            x, y, theta = actor.poses[k].tolist()
            turned = np.empty(4)
            mujoco.mju_mulQuat(turned, (math.cos(theta / 2), 0, 0, math.sin(theta / 2)), still[3:7])
            height = still[2]
            if actor.stance is not None:
                height, turned = actor.stance[k, 0], actor.stance[k, 1:] / np.linalg.norm(actor.stance[k, 1:])
            here[:3], here[3:7], here[7:9] = (x, y, height), turned, actor.wheel_angles[k]
            if self._scene.robot.skids:
                here[9:11] = actor.wheel_angles[k]
            elif actor.fork is not None:
                here[9] = actor.fork[k]  # the angle of the caster's wheel is not recorded
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def _shine(self, azimuth: float) -> Array:
        """Let the sun shine over the camera's left shoulder: in which direction."""
        a = math.radians(float(azimuth))
        sun = np.array([(math.cos(a), math.sin(a), 0), (math.sin(a), -math.cos(a), 0), (0, 0, 1)]).T @ _LIGHT
        for light in self._renderer.scene.lights[: self._renderer.scene.nlight]:
            if not light.headlight:
                light.dir = sun
        return sun

    def _casts_shadow(self, geom: mujoco.MjvGeom) -> bool:
        of_robot = geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and self._model.geom_bodyid[geom.objid] > 0
        return bool(of_robot and geom.rgba[3] == 1)

    def _shadow(self, geom: mujoco.MjvGeom, sun: Array) -> None:
        """Lay a shape along the sun's rays onto the floor, which costs far less than MuJoCo's shadows."""
        along = np.eye(3)
        along[:, 2] -= (1 - _THIN) * sun / sun[2]
        centre = along @ geom.pos + (0, 0, self._scene.levels[1] + self._scene.shade)
        self._add(geom.type, geom.size, centre, (along @ geom.mat).ravel(), _SHADE).size = geom.size

    def _glow(self, pose: Array, colour: Colour) -> None:
        """A disc on the floor around a ghost at the robot's own place, which would not be seen otherwise."""
        x, y, theta = pose.tolist()
        robot = self._scene.robot
        middle = 0.0 if robot.skids else (robot.caster.x + math.copysign(robot.mean_radius, -robot.caster.x)) / 2
        centre = np.array([x + middle * math.cos(theta), y + middle * math.sin(theta), self._scene.levels[1]])
        radius = 0.6 * math.hypot(robot.track_width + 2 * robot.tyres.width, 2 * abs(middle - robot.caster.x))
        self._add(mujoco.mjtGeom.mjGEOM_CYLINDER, (radius, 0.004 * radius, 0), centre, np.eye(3).ravel(), colour)

    def _draw(self, part: Piece, colour: Rgb) -> None:
        centre = part.centre + np.array((0, 0, self._scene.levels[1]))
        self._add(mujoco.mjtGeom.mjGEOM_BOX, part.half, centre, part.axes, (*colour, 1.0))

    def _add(self, kind: mujoco.mjtGeom, size: ArrayLike, centre: Array, axes: Array, colour: Colour) -> mujoco.MjvGeom:
        drawn = self._renderer.scene
        geom = drawn.geoms[drawn.ngeom]
        mujoco.mjv_initGeom(geom, kind, np.array(size), centre, axes, colour)
        geom.emission, geom.specular = 0.35, 0
        drawn.ngeom += 1
        return geom


def _model(scene: Scene, size: tuple[int, int]) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    looks = spec.visual
    looks.global_.offwidth, looks.global_.offheight = size
    looks.global_.fovy = scene.view.fovy
    looks.quality.offsamples = _SAMPLES
    looks.headlight.ambient, looks.headlight.diffuse = (0.46, 0.46, 0.46), (0.14, 0.14, 0.14)
    looks.headlight.specular = (0, 0, 0)
    reach = float(scene.view.distance.max()) * math.tan(math.radians(scene.view.fovy / 2))
    spec.stat.extent = reach * max(1.0, size[0] / size[1])
    looks.map.znear, looks.map.zfar = 0.02, 30
    _floor(spec, scene.square, scene.levels[0])
    for k, shape in enumerate(scene.ground):
        _shape(spec, f"shape{k}", shape)
    for k, actor in enumerate(scene.actors):
        copy = _copy(scene.robot, actor.ghost)
        spec.attach(copy, prefix=f"{k}_", frame=spec.worldbody.add_frame())
    return spec.compile()


def _floor(spec: mujoco.MjSpec, square: float, height: float) -> None:
    # No sky: every camera looks down so far that the floor fills its picture.
    spec.add_texture(
        name="squares",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        width=256,
        height=256,
        rgb1=_PALE,
        rgb2=_DARK,
    )
    floor = spec.add_material(name="squares", texuniform=True, texrepeat=(0.5 / square, 0.5 / square), specular=0)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "squares"
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name="floor", type=plane, size=(0, 0, 1), pos=(0, 0, height), material="squares")
    spec.worldbody.add_light(
        name="sun", type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=False, diffuse=(0.45, 0.45, 0.44)
    )


def _shape(spec: mujoco.MjSpec, name: str, shape: Shape) -> None:
    geom = spec.worldbody.add_geom(name=name, rgba=shape.colour)
    match shape:
        case Flat():
            geom.type, geom.pos, geom.size = mujoco.mjtGeom.mjGEOM_BOX, shape.centre, shape.half
        case Bar():
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CAPSULE, (shape.radius, 0, 0)
            geom.fromto = np.ravel(shape.ends)
        case Field():
            low, rise = float(shape.heights.min()), max(float(np.ptp(shape.heights)), 1e-6)  # it may be level
            spec.add_hfield(
                name=name,
                nrow=shape.heights.shape[0],
                ncol=shape.heights.shape[1],
                size=(*shape.half, rise, rise),
                userdata=((shape.heights - low) / rise).ravel().tolist(),
            )
            geom.type, geom.hfieldname, geom.pos = mujoco.mjtGeom.mjGEOM_HFIELD, name, (*shape.centre, low)


def _copy(robot: Robot, ghost: Rgb | None) -> mujoco.MjSpec:
    """The robot as it looks, without lamps, camera, motors, contacts, and the shapes that only the physics sees."""
    spec = model_spec(robot, Physics())
    plain = mujoco.MjSpec().option  # nothing is solved here, and MuJoCo warns where copies differ from the scene
    for name in ("timestep", "integrator", "cone", "impratio", "tolerance", "disableflags"):
        setattr(spec.option, name, getattr(plain, name))
    unseen = [geom for geom in spec.geoms if geom.name == "floor" or geom.group == 3]
    for part in [*spec.lights, *spec.cameras, *spec.pairs, *spec.actuators, *spec.sensors, *spec.equalities, *unseen]:
        spec.delete(part)
    spec.material("mark").rgba = _MARK
    if ghost is not None:
        for part in [geom for geom in spec.geoms if geom.name.endswith("_hub")]:
            spec.delete(part)  # what is inside only blurs it
        spec.add_material(name="ghost", rgba=(*ghost, _THROUGH), emission=0.25, specular=0.1)
        for geom in spec.geoms:
            geom.material = "ghost"
            geom.pos, geom.size = _SMALLER * np.array(geom.pos), _SMALLER * np.array(geom.size)
        spec.site("axle").rgba = (0, 0, 0, 0)
    return spec
