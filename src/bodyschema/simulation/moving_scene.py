"""A robot that moves before a camera, filmed with its encoders, and the truth about every cell.

The picture that carries the time t shows the robot as it was at t - delay, which no method is told.
The camera is not calibrated, pictures are noisy, and other things move as they like (`stage`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.simulation import stage
from bodyschema.simulation.acting_robots import (
    CAMERA,
    RobotName,
    RobotOnStage,
    five_joint_arm,
    humanoid,
)
from bodyschema.simulation.film import HEIGHT, WIDTH, Film
from bodyschema.simulation.pixel_speed import pixel_speeds
from bodyschema.simulation.random_motions import (
    RATE,
    Motions,
    draw_motions,
    with_confirmation,
)

Array = NDArray[np.float64]
Carried = Literal["nothing", "rod", "sleeve"]

LEAST_DELAY, MOST_DELAY = 0.02, 0.12
"""s between a pose and the time stamp of its picture."""
LEAST_LAG, MOST_LAG = 0.5, 1.0
"""s by which an imitator is late."""
ENCODER_NOISE = 5e-5
"""rad, standard deviation of a reading."""
LABEL_EVERY = 5
"""Frames between two frames whose pixels are labelled."""
FAR_AWAY = (0.0, 0.0, -50.0)
"""m: where a thing is that is not there."""


@dataclass(frozen=True)
class MovingScene:
    """What is filmed; the same settings give the same film."""

    robot: RobotName = "arm"
    distractor: stage.Distractor = "none"
    seed: int = 0
    """Of stage, camera, posture, motion and noise."""
    motions: int = 15
    confirm: bool = False
    """Whether each motion is made back and once more: the confirming motion."""
    head_moves: bool = False
    """Whether the joints that carry the camera take part in the motions."""
    carried: Carried = "nothing"
    taken: int = 0
    """Number of motions before the rod is in the hand or the sleeve on the arm."""
    released: int | None = None
    """Number of motions after which the rod stays behind, hanging where it is; None for never."""
    noise: float = 4.0
    """Standard deviation of a pixel's grey value, of 255."""

    def __post_init__(self) -> None:
        if self.motions < 1:
            raise InputError(f"a film shows at least one motion, not {self.motions}.")
        if self.noise < 0:
            raise InputError("noise is a standard deviation; give 0 or more.")


class Studio:
    """A scene in MuJoCo, ready to be filmed."""

    def __init__(self, scene: MovingScene) -> None:
        """Build it.

        Raises:
            MissingExtraError: MuJoCo, icub-models or trimesh is not installed.
        """
        try:
            import mujoco
        except ImportError:
            raise MissingExtraError("mujoco", "sim", "a simulated scene") from None
        self.scene, self._mujoco = scene, mujoco
        # Robot and motion do not depend on what else is there.
        rng = np.random.default_rng([scene.seed, 0])
        self.robot = _robot(mujoco, scene, rng)
        self.joints = (*self.robot.arm, *self.robot.head)
        self.motions = self._motions(rng)
        self.delay = rng.uniform(LEAST_DELAY, MOST_DELAY)
        self._movers = self._furnish(rng)
        self._model: Any = self.robot.spec.compile()
        self._data: Any = mujoco.MjData(self._model)
        self._columns = [self._model.joint(name).qposadr[0] for name in self.joints]
        self._shapes = _shapes_of(self._model, self.robot.moving)
        self._thing = _shapes_of(self._model, ("thing",))
        self._renderer: Any = None

    def _motions(self, rng: np.random.Generator) -> Motions:
        robot = self.robot
        home = np.array([robot.home.get(name, 0.0) for name in self.joints])
        drawn = draw_motions(home, self.scene.motions, robot.reach, rng)
        if not self.scene.head_moves:
            drawn.turn[:, len(robot.arm) :] = 0.0
        if not self.scene.confirm:
            return drawn
        return with_confirmation(drawn, np.random.default_rng([self.scene.seed, 5]))

    def film(self) -> Film:
        """All frames.

        Raises:
            InputError: MuJoCo cannot draw here.
        """
        scene, rng = self.scene, np.random.default_rng([self.scene.seed, 2])
        time = np.arange(int(self.motions.seconds * RATE)) / RATE
        truth, lag = self.motions.at(time - self.delay), rng.uniform(LEAST_LAG, MOST_LAG)
        before = self.motions.at(time - self.delay - lag)
        moves = stage.movements(scene.distractor, time, before, self.robot.far, rng)
        labelled = np.arange(0, len(time), LABEL_EVERY)
        pictures = np.empty((len(time), HEIGHT, WIDTH), dtype=np.uint8)
        body = np.empty((len(labelled), HEIGHT, WIDTH), dtype=bool)
        thing = np.empty_like(body)
        here = np.hstack([truth, moves])
        for i in range(len(time)):
            # Where nothing has moved, the picture before is this one but for its noise.
            if i == 0 or scene.carried != "nothing" or (here[i] != here[i - 1]).any():
                self._pose(truth[i], moves[i], time[i])
                clean = self._draw() @ np.array([0.299, 0.587, 0.114])
            noisy = clean + scene.noise * rng.standard_normal(clean.shape, dtype=np.float32)
            pictures[i] = np.clip(np.rint(noisy), 0, 255)
            if i % LABEL_EVERY == 0:
                shapes = self._shapes_seen()
                body[i // LABEL_EVERY] = np.isin(shapes, self._shapes)
                thing[i // LABEL_EVERY] = np.isin(shapes, self._thing)
        q = self.motions.at(time)
        q = q + ENCODER_NOISE * np.random.default_rng([scene.seed, 3]).normal(size=q.shape)
        self._pose(self.motions.home, np.zeros(moves.shape[1]), 0.0)
        return Film(
            joints=self.joints, head=self.robot.head, time=time, q=q, pictures=pictures,
            motion_end=self.motions.end, delay_s=self.delay, labelled=labelled, body=body,
            thing=thing, speed=self._speeds(),
        )  # fmt: skip

    def _furnish(self, rng: np.random.Generator) -> tuple[str, ...]:
        """Room, movers and the thing to carry; the names of the movers' joints."""
        robot, scene, mujoco = self.robot, self.scene, self._mujoco
        spec = robot.spec
        spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
        spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
        spec.visual.map.znear, spec.stat.extent = 0.01, 1.0
        patterns = [material.name for material in spec.materials]
        there = stage.add_room(spec, mujoco, robot.T_world_cam, robot.far, patterns, rng)
        thing = spec.worldbody.add_body(name="thing", mocap=True, pos=FAR_AWAY)
        capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
        if scene.carried == "sleeve":
            _, begin, end, radius = robot.sleeve
            ends, wide = [begin, 0, 0, end, 0, 0], radius
        else:
            ends, wide = robot.rod.ravel().tolist(), robot.rod_radius
        thing.add_geom(type=capsule, fromto=ends, size=[wide, 0, 0], material=patterns[7],
                       contype=0, conaffinity=0)  # fmt: skip
        own = np.random.default_rng([scene.seed, 1])
        return stage.add_movers(there, mujoco, scene.distractor, robot.far, patterns, own)

    def _pose(self, q: Array, moves: Array, time: float) -> None:
        """Place robot, movers and the thing as they are at a time."""
        data, model = self._data, self._model
        for name, angle in self.robot.home.items():
            data.qpos[model.joint(name).qposadr[0]] = angle
        data.qpos[self._columns] = q
        for name, place in zip(self._movers, moves, strict=True):
            data.qpos[model.joint(name).qposadr[0]] = place
        self._mujoco.mj_kinematics(model, data)
        self._carry(time)
        self._mujoco.mj_kinematics(model, data)
        self._mujoco.mj_comPos(model, data)
        self._mujoco.mj_camlight(model, data)

    def _carry(self, time: float) -> None:
        """Put the thing where the robot carries it, or leave it where it was released."""
        scene = self.scene
        if scene.carried == "nothing" or time < self._moment(scene.taken):
            return
        if scene.released is not None and time >= self._moment(scene.released):
            return
        holder = self.robot.sleeve[0] if scene.carried == "sleeve" else self.robot.hand
        self._data.mocap_pos[0] = self._data.body(holder).xpos
        self._data.mocap_quat[0] = self._data.body(holder).xquat

    def _moment(self, motions: int) -> float:
        """s, in the rest after that many motions."""
        return 0.0 if motions == 0 else float(self.motions.end[motions - 1]) + self.delay + 0.1

    def _draw(self) -> NDArray[np.float32]:
        """(HEIGHT, WIDTH, 3) of what the camera sees now."""
        renderer = self._drawing()
        renderer.disable_segmentation_rendering()
        renderer.update_scene(self._data, camera=CAMERA)
        return np.asarray(renderer.render(), dtype=np.float32)

    def _shapes_seen(self) -> NDArray[np.int32]:
        """(HEIGHT, WIDTH) number of the shape in each pixel, -1 for none."""
        renderer = self._drawing()
        renderer.enable_segmentation_rendering()
        renderer.update_scene(self._data, camera=CAMERA)
        return np.asarray(renderer.render()[..., 0])

    def _speeds(self) -> Array:
        """(J, HEIGHT, WIDTH) pixels/rad of what is seen of the robot now."""
        shapes, renderer = self._shapes_seen(), self._drawing()
        renderer.disable_segmentation_rendering()
        renderer.enable_depth_rendering()
        renderer.update_scene(self._data, camera=CAMERA)
        depth = np.asarray(renderer.render(), dtype=np.float64)
        renderer.disable_depth_rendering()
        shown = np.isin(shapes, self._shapes)
        body = np.where(shown, self._model.geom_bodyid[shapes], -1)
        return pixel_speeds(self._mujoco, self._model, self._data, CAMERA, self.joints, body, depth)

    def _drawing(self) -> Any:
        """The renderer, made at the first frame."""
        if self._renderer is None:
            try:
                self._renderer = self._mujoco.Renderer(self._model, HEIGHT, WIDTH)
            except Exception as error:  # every way to OpenGL has errors of its own
                raise InputError(
                    f"MuJoCo cannot draw here ({error}); install OpenGL's EGL or OSMesa and set "
                    "MUJOCO_GL to egl or osmesa."
                ) from None
        return self._renderer


def _robot(mujoco: Any, scene: MovingScene, rng: np.random.Generator) -> RobotOnStage:
    looks = np.random.default_rng([scene.seed, 4])
    if scene.robot == "arm":
        return five_joint_arm(mujoco, lambda spec: stage.add_patterns(spec, mujoco, looks), rng)
    return humanoid(mujoco, lambda spec: stage.add_patterns(spec, mujoco, looks), rng)


def _shapes_of(model: Any, bodies: tuple[str, ...]) -> NDArray[np.int64]:
    """Numbers of the shapes of some bodies."""
    ids = [model.body(name).id for name in bodies]
    return np.flatnonzero(np.isin(model.geom_bodyid, ids))
