"""A robot's life before its own stereo camera: it waggles, swings for as long as one likes, and
things happen to it.

The five-joint arm holds a rod. First the wrist waggles alone, then all joints but the last swing
slowly. What may happen on the way, each at a time of its own:

    slip    the rod slips through the gripper in `SLIP_TIME`
    swap    another tool is in the hand
    head    the head turns and shifts in `TURN_TIME`
    drop    the hand lets go of the tool, which is gone
    zero    a joint's encoder jumps: it reads another angle than before

The easy film is all patterns, without shadows. The hard one has plain metal on half of the links
and on the tool, a lamp that casts shadows, things that move behind the arm by themselves, a camera
that shakes, and a picture that is the mean over the time that a shutter is open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import katana, stage
from bodyschema.simulation.acting_robots import CAMERA
from bodyschema.simulation.random_motions import RATE
from bodyschema.simulation.stereo_film import (
    LINKS,
    REACH,
    RIGHT,
    WAGGLE,
    WRIST,
    StereoFilm,
    StereoMoment,
)

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Kind = Literal["slip", "swap", "head", "drop", "zero"]

SLIP, SLIP_TIME = 0.042, 0.2
"""m along the rod, and s that it takes."""
TURN, SHIFT, TURN_TIME = np.deg2rad(5.8), 0.066, 0.5
"""rad, m and s of a turn of the head."""
JUMP = np.deg2rad(2.0)
"""rad by which an encoder jumps."""
TOOLS = ("rod", "bar")
"""Names of the two tools, as bodies of the model; the hand holds the first to begin with."""
SHAKE = 0.2
"""px, standard deviation of the shake of a hard film's camera, each way."""
SHUTTER = (0.0, 0.35)
"""Shares of the time between two frames at which a hard film's picture is sampled."""
PLAIN = 0.55
"""Grey of plain metal."""
TOOL_RADIUS = 0.015
"""m, of a handle."""
HEADS = ([0.035, 0.03, 0.03], [0.035, 0.03, 0.0])
"""m, half sizes of the heads: a box, and a cylinder's radius and half height."""
BEYOND = (0.0, 0.0, -50.0)
"""m: where a tool is that is not there."""


@dataclass(frozen=True)
class Happening:
    """Something that happens to the robot."""

    kind: Kind
    time: float
    """s, when it begins."""


class LivingFilm(StereoFilm):
    """An arm with a rod, a room and two cameras, ready to be filmed."""

    def __init__(
        self, seed: int | Sequence[int], seconds: float, happenings: Sequence[Happening] = (),
        hard: bool = False, waggle: float = 3.0, noise: float = 2.0,
    ) -> None:  # fmt: skip
        """Build the scene.

        Args:
            seed: of room, cameras, motion and noise.
            seconds: how long the film is.
            happenings: what happens to the robot.
            hard: with metal, shadows, shake, blur and things that move.
            waggle: s in which the wrist moves alone.
            noise: standard deviation of a pixel's grey value, of 255.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        self._hard, self.happenings = hard, tuple(happenings)
        self._movers: tuple[str, ...] = ()
        super().__init__(seed, noise)
        self._tools = [self._model.body(name).id for name in TOOLS]
        self.time = np.arange(int(seconds * RATE)) / RATE
        self._q = self._motion(waggle)
        drawn = {one.kind: self._rng.normal(size=3) for one in self.happenings}
        self._turn_axis = self._towards(drawn.get("head", np.ones(3)) * [1.0, 1.0, 0.3])
        self._jumps = 1 + int(abs(drawn.get("zero", np.zeros(3))[0]) * 10) % 3
        turns = np.zeros((len(self.time), 3))
        if hard:
            turns[:, :2] = SHAKE / self.stereo.focal * self._rng.normal(size=(len(turns), 2))
        self._shaken = lie.transform(lie.exp_so3(turns), np.zeros(3))
        self._moves = stage.movements(
            "always" if hard else "none", self.time, self._q, self._robot.far, self._rng
        )

    def _furnish(self, spec: Any, patterns: Sequence[str]) -> None:
        """Two tools; in a hard film things that move, metal and shadows."""
        mujoco, far = self._mujoco, self._robot.far
        if self._hard:
            room, looks = spec.body("stage"), list(patterns)
            self._movers = stage.add_movers(room, mujoco, "always", far, looks, self._rng)
        _add_tools(spec, mujoco, self._robot.rod, patterns)
        if self._hard:
            _make_hard(spec, self._robot.moving)

    def moments(self) -> Iterator[StereoMoment]:
        """The film, frame by frame; `q` and `T_world_hand` are what the encoders say."""
        for i, time in enumerate(self.time):
            self._stand(i, float(time))
            left, right = self._pictures(i, float(time))
            read = self._q[i] + JUMP * self._since("zero", time) * np.eye(5)[self._jumps]
            pose = relative_pose(katana.katana(), read, "base", LINKS[-1])
            yield StereoMoment(float(time), read, pose, left, right)

    def camera(self, time: float) -> Array:
        """(4, 4) where the camera truly is."""
        share = _smooth(time, self._when("head"), TURN_TIME)
        R = self.T_world_cam[:3, :3]
        turned = R @ lie.exp_so3(TURN * share * self._turn_axis)
        away = SHIFT * share * (R @ np.cross(self._turn_axis, [0.0, 0.0, 1.0]))
        return lie.transform(turned, self.T_world_cam[:3, 3] + away)

    def T_hand_tool(self, time: float) -> Array:
        """(3,) m by which the rod has truly slipped in the hand."""
        along = _unit(self._robot.rod[1] - self._robot.rod[0])
        return np.asarray(SLIP * _smooth(time, self._when("slip"), SLIP_TIME) * along)

    def holds(self, time: float) -> str | None:
        """Name of the tool in the hand."""
        if self._since("drop", time):
            return None
        return TOOLS[1] if self._since("swap", time) else TOOLS[0]

    def shown(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(480, 640) pixels of the left picture of this moment that show hand, and held tool."""
        renderer = self._drawing()
        renderer.enable_segmentation_rendering()
        renderer.update_scene(self._data, camera=CAMERA)
        shapes = renderer.render()[..., 0]
        renderer.disable_segmentation_rendering()
        body = np.where(shapes >= 0, self._model.geom_bodyid[shapes], -1)
        return np.isin(shapes, self._hand), np.isin(body, self._tools)

    def _motion(self, waggle: float) -> Array:
        """(n, 5) rad: the wrist to and fro once a second, then sums of two slow sines a joint."""
        first = self.time < waggle
        time = self.time[~first] - waggle
        rate = self._rng.uniform(0.08, 0.3, (2, 5))
        swing = sum(np.sin(2 * np.pi * time[:, None] * f) for f in rate)
        q = np.repeat(self.home[None], len(self.time), axis=0)
        q[first, WRIST] += WAGGLE * np.sin(2 * np.pi * self.time[first])
        q[~first] += np.minimum(time / 2, 1)[:, None] * REACH * swing / 2
        return q

    def _towards(self, axis: Array) -> Array:
        """(3,) the axis of a turn, the way round that brings the hand nearer to the middle."""
        T_world_hand = relative_pose(katana.katana(), self.home, "base", LINKS[-1])
        seen = (lie.inverse(self.T_world_cam) @ T_world_hand)[:3, 3]
        forward = _unit(seen) - np.array([0.0, 0.0, 1.0])
        return _unit(axis) * np.sign(np.cross([0.0, 0.0, 1.0], forward) @ axis)

    def _when(self, kind: Kind) -> float:
        return min((one.time for one in self.happenings if one.kind == kind), default=np.inf)

    def _since(self, kind: Kind, time: float) -> bool:
        return bool(time >= self._when(kind))

    def _stand(self, i: int, time: float, open_: float = 0.0) -> None:
        """Place everything as it is at a moment, or a share of a frame before it."""
        data, model = self._data, self._model
        before = self._q[max(i - 1, 0)]
        data.qpos[self._columns] = self._q[i] + open_ * (before - self._q[i])
        for name, place in zip(self._movers, self._moves[i], strict=True):
            data.qpos[model.joint(name).qposadr[0]] = place
        T = self.camera(time) @ self._shaken[i]
        model.body("head").pos = T[:3, 3] - 0.1 * T[:3, 2]
        self._mujoco.mju_mat2Quat(model.body("head").quat, np.ascontiguousarray(T[:3, :3]).ravel())
        self._mujoco.mj_kinematics(model, data)
        held = self.holds(time)
        for name in TOOLS:
            mocap = model.body(name).mocapid[0]
            hand = data.body(LINKS[-1])
            shift = hand.xmat.reshape(3, 3) @ self.T_hand_tool(time)
            data.mocap_pos[mocap] = hand.xpos + shift if name == held else BEYOND
            data.mocap_quat[mocap] = hand.xquat
        self._mujoco.mj_kinematics(model, data)
        self._mujoco.mj_comPos(model, data)
        self._mujoco.mj_camlight(model, data)

    def _pictures(self, i: int, time: float) -> tuple[Grey, Grey]:
        if not self._hard:
            return self._noisy(self._drawn(CAMERA)), self._noisy(self._drawn(RIGHT))
        left: list[NDArray[np.float32]] = []
        right: list[NDArray[np.float32]] = []
        for share in SHUTTER[::-1]:
            self._stand(i, time, share)
            left.append(self._drawn(CAMERA))
            right.append(self._drawn(RIGHT))
        return self._noisy(np.mean(left, axis=0)), self._noisy(np.mean(right, axis=0))

    def _noisy(self, clean: NDArray[Any]) -> Grey:
        noisy = clean + self._noise * self._rng.standard_normal(clean.shape, dtype=np.float32)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), dtype=np.uint8)

    def _drawn(self, camera: str) -> NDArray[np.float32]:
        renderer = self._drawing()
        renderer.update_scene(self._data, camera=camera)
        if self._hard:
            renderer.scene.flags[self._mujoco.mjtRndFlag.mjRND_SHADOW] = 1
        return np.asarray(renderer.render() @ np.array([0.299, 0.587, 0.114], dtype=np.float32))


def _add_tools(spec: Any, mujoco: Any, rod: Array, patterns: Sequence[str]) -> None:
    """Two hammers, a handle and a head each, that lean to different sides and look different."""
    heads = (mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER)
    lean = np.array([[0.0, 0.0, 0.0], [0.02, 0.05, -0.03]])
    for k, (name, kind) in enumerate(zip(TOOLS, heads, strict=True)):
        tool = spec.worldbody.add_body(name=name, mocap=True, pos=BEYOND)
        ends = rod + k * lean
        shapes = (
            {"type": mujoco.mjtGeom.mjGEOM_CAPSULE, "fromto": ends.ravel().tolist(),
             "size": [TOOL_RADIUS, 0, 0]},
            {"type": kind, "pos": ends[1], "size": HEADS[k]},
        )  # fmt: skip
        for look, shape in zip((7 - k, 3 + k), shapes, strict=True):
            tool.add_geom(material=patterns[look], contype=0, conaffinity=0, **shape)


def _make_hard(spec: Any, moving: Sequence[str]) -> None:
    """Plain metal on every second link, on the fingers and on the tools; shadows."""
    metal = spec.add_material(name="metal", rgba=[PLAIN, PLAIN, PLAIN, 1], specular=0.8)
    metal.shininess = 0.6
    plain = (*moving[1::2], TOOLS[0])
    for name in plain:
        for geom in spec.body(name).geoms:
            geom.material = "metal"
    for light in spec.lights:
        light.castshadow = True
    spec.visual.quality.shadowsize = 512


def _smooth(time: float, begin: float, length: float) -> float:
    """From 0 to 1 within a time, by minimum jerk."""
    if np.isinf(begin):
        return 0.0
    x = float(np.clip((time - begin) / length, 0.0, 1.0))
    return x**3 * (10 - 15 * x + 6 * x * x)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
