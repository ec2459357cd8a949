"""The five-joint arm filmed by a rectified pair of cameras.

First the wrist waggles alone, so that the hand can be found as what moves; then all joints but the
last swing slowly and turn the hand about two axes, from which hand and eye are learned. Cameras and
encoders share one clock.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.learners.hand_eye.stereo_points import Stereo
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import katana, stage
from bodyschema.simulation.acting_robots import CAMERA, five_joint_arm
from bodyschema.simulation.random_motions import RATE

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

RIGHT = "right_eye"
REACH = np.array([0.35, 0.25, 0.35, 0.45, 0.0])
"""rad either way of home, swings of the second part; the last joint is held."""
WRIST, WAGGLE = 3, 0.08
"""Number of the joint that waggles alone, and rad either way."""
PIXEL_NOISE = 0.35
"""px: what to expect of a corner that is followed."""
LINKS = ("wrist", "roll")
"""Frames of what the wrist moves; while the last joint is held they are one hand."""


@dataclass(frozen=True)
class StereoMoment:
    """One moment of the film."""

    time: float
    """s"""
    q: Array
    """(5,) rad."""
    T_world_hand: Array
    """(4, 4) of the hand, by the arm's kinematics."""
    left: Grey
    """(480, 640)."""
    right: Grey
    """(480, 640)."""


class StereoFilm:
    """An arm, a room and two cameras, ready to be filmed."""

    def __init__(self, seed: int | Sequence[int], noise: float = 2.0) -> None:
        """Build the scene.

        Args:
            seed: of room, cameras, motion and noise.
            noise: standard deviation of a pixel's grey value, of 255.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        try:
            import mujoco
        except ImportError:
            raise MissingExtraError("mujoco", "sim", "a simulated scene") from None
        rng = np.random.default_rng(seed)
        self._noise, self._rng, self._mujoco = noise, rng, mujoco
        self.stereo: Stereo = katana.stereo(PIXEL_NOISE)
        robot = five_joint_arm(mujoco, lambda spec: stage.add_patterns(spec, mujoco, rng), rng)
        self._robot, self.T_world_cam, self.joints = robot, robot.T_world_cam, robot.arm
        self.home = np.array([robot.home[name] for name in robot.arm])
        spec = robot.spec
        patterns = [material.name for material in spec.materials]
        stage.add_room(spec, mujoco, robot.T_world_cam, robot.far, patterns, rng)
        self._furnish(spec, patterns)
        _add_right_eye(spec, self.stereo)
        self._model: Any = spec.compile()
        self._data: Any = mujoco.MjData(self._model)
        self._columns = [self._model.joint(name).qposadr[0] for name in self.joints]
        hand = [self._model.body(name).id for name in LINKS]
        self._hand = np.flatnonzero(np.isin(self._model.geom_bodyid, hand))
        self._renderer: Any = None

    def _furnish(self, spec: Any, patterns: Sequence[str]) -> None:
        """What else is in the scene, for films that have more."""

    def waggle(self, seconds: float) -> Iterator[StereoMoment]:
        """Only the wrist moves, to and fro about home once a second: what moves is the hand."""
        time = np.arange(int(seconds * RATE)) / RATE
        q = np.repeat(self.home[None], len(time), axis=0)
        q[:, WRIST] += WAGGLE * np.sin(2 * np.pi * time)
        return self._moments(time, q)

    def swings(self, seconds: float) -> Iterator[StereoMoment]:
        """Sums of two slow sines a joint, from home."""
        time = np.arange(int(seconds * RATE)) / RATE
        return self._moments(time, self._swings(time))

    def _swings(self, time: Array) -> Array:
        """(n, 5) rad at times (n,)."""
        rate = self._rng.uniform(0.08, 0.3, (2, 5))
        begin = np.minimum(time / 2, 1)[:, None]
        swing = sum(np.sin(2 * np.pi * time[:, None] * f) for f in rate)
        return np.asarray(self.home + begin * REACH * swing / 2)

    def _moments(self, time: Array, q: Array) -> Iterator[StereoMoment]:
        poses = relative_pose(katana.katana(), q, "base", LINKS[-1])
        for t, posture, pose in zip(time, q, poses, strict=True):
            yield self._moment(float(t), posture, pose)

    def _moment(self, time: float, posture: Array, pose: Array) -> StereoMoment:
        """Both pictures of one posture, with the hand's pose (4, 4)."""
        self._data.qpos[self._columns] = posture
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_comPos(self._model, self._data)
        self._mujoco.mj_camlight(self._model, self._data)
        return StereoMoment(time, posture, pose, self._picture(CAMERA), self._picture(RIGHT))

    def hand(self) -> NDArray[np.bool_]:
        """(480, 640) pixels of the left image that truly show the hand at this moment."""
        renderer = self._drawing()
        renderer.enable_segmentation_rendering()
        renderer.update_scene(self._data, camera=CAMERA)
        return np.asarray(np.isin(renderer.render()[..., 0], self._hand))

    def _picture(self, camera: str) -> Grey:
        renderer = self._drawing()
        renderer.disable_segmentation_rendering()
        renderer.update_scene(self._data, camera=camera)
        clean = renderer.render() @ np.array([0.299, 0.587, 0.114], dtype=np.float32)
        noisy = clean + self._noise * self._rng.standard_normal(clean.shape, dtype=np.float32)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), dtype=np.uint8)

    def _drawing(self) -> Any:
        """The renderer, made at the first frame."""
        if self._renderer is None:
            width, height = katana.IMAGE
            try:
                self._renderer = self._mujoco.Renderer(self._model, height, width)
            except Exception as error:  # every way to OpenGL has errors of its own
                raise InputError(
                    f"MuJoCo cannot draw here ({error}); install OpenGL's EGL or OSMesa and set "
                    "MUJOCO_GL to egl or osmesa."
                ) from None
        return self._renderer


def _add_right_eye(spec: Any, stereo: Stereo) -> None:
    """Give the left camera the pair's lens, and a sister beside it."""
    width, height = katana.IMAGE
    left = spec.camera(CAMERA)
    left.fovy = float(2 * np.rad2deg(np.arctan(height / 2 / stereo.focal)))
    beside = np.array(left.pos) + np.array([stereo.baseline, 0.0, 0.0])
    spec.body("head_top").add_camera(name=RIGHT, pos=beside, quat=left.quat, fovy=left.fovy)
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
    spec.visual.map.znear, spec.stat.extent = 0.01, 1.0
