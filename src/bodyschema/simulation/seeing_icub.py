"""An iCub that is commanded and that looks at itself: MuJoCo moves, lights and renders it.

The encoders report theta = theta_true - beta. Two eyes of 320x240 pixels, 68 mm apart, look at the
room before the face (`icub`). Against a plain background the picture is a mask: those pixels whose
ray meets one of the visible links first. In the cluttered scene it is an image in colours: textured
walls and boxes, two lamps with shadows, and a robot in grey.

Bodies have no weight here, so nothing swings or sags: a command places the joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.model.camera import Camera
from bodyschema.model.meshes import triangles_of
from bodyschema.senses.images import Images, Picture
from bodyschema.simulation import clutter, eyes, icub
from bodyschema.simulation.real_robot import bare_description

Array = NDArray[np.float64]
Scene = Literal["plain", "cluttered"]

SEEN_LINKS = ("r_hand", "r_wrist_1", "r_forearm")
"""What a mask shows, unless told otherwise."""

LEFT_LINKS = ("l_hand", "l_wrist_1", "l_forearm")
"""The same of the other arm."""

NEAREST = 0.01
"""m; what is nearer to an eye is not drawn."""

GREY = (0.62, 0.62, 0.66, 1.0)
"""Colour of the robot."""


class SeeingIcub:
    """The robot; see `acting.robot.Robot`."""

    def __init__(
        self,
        offsets: Mapping[str, float],
        scene: Scene = "plain",
        links: Sequence[str] = SEEN_LINKS,
    ) -> None:
        """Build it, standing at zero or as near to it as its joints allow.

        Args:
            offsets: true joint angle minus encoder reading, rad; 0 where not named.
            scene: what is behind the robot, and so what its pictures are.
            links: those that a mask shows.

        Raises:
            InputError: no such joint or link.
            MissingExtraError: MuJoCo, icub-models or trimesh is not installed.
        """
        self._body = body = icub.bare_icub()
        self.joints = body.joints
        for name in offsets:
            if name not in body.joints:
                raise InputError(f"no joint '{name}' to be off{did_you_mean(name, body.joints)}")
        self._low, self._high = body.lower, body.upper
        self._offset = np.array([offsets.get(name, 0.0) for name in body.joints])
        self._scene = scene
        self._mujoco, self._model = _mujoco(), _model(scene)
        self._data: Any = self._mujoco.MjData(self._model)
        self._columns = [self._model.joint(name).qposadr[0] for name in body.joints]
        self._shown = self._shapes(links)
        self._renderer: Any = None
        self._drawn: dict[tuple[str, bool], NDArray[Any]] = {}
        self._frames = 0
        self.command(np.clip(np.zeros(len(body.joints)), body.lower, body.upper))

    def read(self) -> Array:
        """(n_joints,) encoder readings, rad."""
        return self._q.copy()

    def command(self, q: ArrayLike) -> None:
        """Go to these readings, (n_joints,).

        Raises:
            InputError: beyond the range of a joint, or not one number for each; nothing moves then.
        """
        posture = np.array(q, dtype=np.float64)
        if posture.shape != self._low.shape or not np.isfinite(posture).all():
            raise InputError(f"expected {len(self.joints)} joint positions, got {q!r}.")
        beyond = np.flatnonzero((posture < self._low - 1e-9) | (posture > self._high + 1e-9))
        if len(beyond):
            j = int(beyond[0])
            raise InputError(
                f"joint '{self.joints[j]}' was sent to {posture[j]:.3f}, beyond its range of "
                f"{self._low[j]:.3f} to {self._high[j]:.3f}; the robot did not move."
            )
        self._q = posture
        self._drawn.clear()
        self._data.qpos[self._columns] = posture + self._offset
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_comPos(self._model, self._data)
        self._mujoco.mj_camlight(self._model, self._data)

    def true_pose(self, seen_from: str, seen: str) -> Array:
        """T_a_b (4, 4) as it truly is."""
        T = [
            lie.transform(self._data.body(name).xmat.reshape(3, 3), self._data.body(name).xpos)
            for name in (seen_from, seen)
        ]
        return np.asarray(lie.inverse(T[0]) @ T[1])

    def look(self, links: Sequence[str] | None = None) -> Images:
        """What both eyes see now; the time is the number of looks before.

        Args:
            links: those that masks show this time; those that were named at first when None.
        """
        cameras, shown = stereo_eyes(), self._shown if links is None else self._shapes(links)
        pictures = tuple(self._picture(camera.frame, shown) for camera in cameras)
        self._frames += 1
        return Images(float(self._frames - 1), self.read(), cameras, pictures)

    def hidden_share(self) -> float:
        """Share of what both eyes see of the robot that belongs to links a mask leaves out."""
        ids = np.stack([self._geoms(camera.frame) for camera in stereo_eyes()])
        robot = (ids >= 0) & (self._model.geom_group[ids] != clutter.GROUP)
        other = robot & ~np.isin(ids, self._shown)
        return float(other.sum() / max(int(robot.sum()), 1))

    def _shapes(self, links: Sequence[str]) -> NDArray[np.int64]:
        """Numbers of the shapes of some links."""
        frames = [self._body.frames[self._body.frame_index(name)] for name in links]
        bodies = [self._model.body(frame).id for frame in frames]
        return np.flatnonzero(np.isin(self._model.geom_bodyid, bodies))

    def _picture(self, eye: str, shown: NDArray[np.int64]) -> Picture:
        if self._scene == "plain":
            return np.isin(self._geoms(eye), shown)
        return self._image(eye, False).copy()

    def _geoms(self, eye: str) -> NDArray[np.int32]:
        """Number of the shape in each pixel, -1 for none, (height, width)."""
        return np.asarray(self._image(eye, True)[..., 0])

    def _image(self, eye: str, segmented: bool) -> NDArray[Any]:
        """What an eye sees in this posture; drawn once, however many links are asked for."""
        if (eye, segmented) not in self._drawn:
            renderer = self._drawing()
            if segmented:
                renderer.enable_segmentation_rendering()
            else:
                renderer.disable_segmentation_rendering()
            renderer.update_scene(self._data, camera=eye)
            self._drawn[eye, segmented] = np.asarray(renderer.render()).copy()
        return self._drawn[eye, segmented]

    def _drawing(self) -> Any:
        """The renderer, made at the first look: a robot that only moves needs no graphics."""
        if self._renderer is None:
            try:
                self._renderer = self._mujoco.Renderer(self._model, eyes.HEIGHT, eyes.WIDTH)
            except Exception as error:  # every way to OpenGL has errors of its own
                raise InputError(
                    f"MuJoCo cannot draw here ({error}); install OpenGL's EGL or OSMesa and set "
                    "MUJOCO_GL to egl or osmesa."
                ) from None
        return self._renderer


def stereo_eyes() -> tuple[Camera, Camera]:
    """Both cameras as they are built."""
    fov = 2 * np.arctan(eyes.WIDTH / 2 / eyes.FOCAL_LENGTH)
    left, right = (
        Camera.from_fov(eye, eye, eyes.WIDTH, eyes.HEIGHT, fov)
        for eye in (icub.LEFT_EYE, icub.RIGHT_EYE)
    )
    return left, right


@cache
def _model(scene: Scene) -> Any:
    """The compiled robot, its meshes read once a process."""
    mujoco = _mujoco()
    body = icub.bare_icub()
    urdf = bare_description(icub.urdf_path().read_bytes(), icub.nominal_frames())
    spec = mujoco.MjSpec.from_string(urdf)
    spec.compiler.discardvisual = False
    spec.visual.map.znear, spec.stat.extent = NEAREST, 1.0
    spec.visual.quality.offsamples = 0  # a pixel of a mask is either the robot or not
    spec.visual.global_.offwidth, spec.visual.global_.offheight = eyes.WIDTH, eyes.HEIGHT
    for i, visual in enumerate(body.visuals):
        V, F = triangles_of(visual)
        shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.add_mesh(name=f"mesh_{i}", uservert=V.ravel(), userface=F.ravel(), inertia=shell)
        spec.body(visual.frame).add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"mesh_{i}", rgba=GREY,
            contype=0, conaffinity=0, mass=0,
        )  # fmt: skip
    fovy = float(2 * np.rad2deg(np.arctan(eyes.HEIGHT / 2 / eyes.FOCAL_LENGTH)))
    for eye in (icub.LEFT_EYE, icub.RIGHT_EYE):
        spec.body(eye).add_camera(name=eye, quat=[0, 1, 0, 0], fovy=fovy)  # looks along +z
    if scene == "cluttered":
        clutter.add_clutter(spec, mujoco)
    return spec.compile()


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("mujoco", "sim", "the simulated robot") from None
    return mujoco
