"""What stands before a camera besides the robot: a room, and things that move by themselves.

All of it is placed in the optical frame that the camera has at the start (x right, y down, z
forward), scaled with the distance of the robot, so that every robot can act on the same stage.

    always    two pendulums that swing and two boxes that slide to and fro with pauses
    lagged    two arms of two links that repeat the robot's motion some time later
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Distractor = Literal["none", "always", "lagged"]

PATTERNS = 16
"""Random textures; the first half is coarse, for things small or near, the others are fine."""
COARSE, FINE = 12, 96
"""Marks along the side of a texture."""
STAND_STILL = 0.4
"""Share of the time that a sliding box rests."""
PASSIVE = {"contype": 0, "conaffinity": 0, "mass": 0.01}


def add_patterns(spec: Any, mujoco: Any, rng: np.random.Generator) -> list[str]:
    """Materials with random marks in random greys; their names."""
    names = []
    for i in range(PATTERNS):
        name, light = f"pattern_{i}", rng.uniform(0.5, 0.9)
        wide = COARSE if i < PATTERNS // 2 else FINE
        dark = light * rng.uniform(0.2, 0.5)
        spec.add_texture(
            name=name, type=mujoco.mjtTexture.mjTEXTURE_CUBE,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, rgb1=[light] * 3, rgb2=[light] * 3,
            width=wide, height=wide, random=0.2, mark=mujoco.mjtMark.mjMARK_RANDOM,
            markrgb=[dark] * 3,
        )  # fmt: skip
        material = spec.add_material(name=name)
        textures = [""] * int(mujoco.mjtTextureRole.mjNTEXROLE)
        textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = name
        material.textures = textures
        names.append(name)
    return names


def add_room(
    spec: Any, mujoco: Any, T_world_cam: Array, far: float, patterns: list[str],
    rng: np.random.Generator,
) -> Any:  # fmt: skip
    """Add wall, boxes and a lamp; the robot works `far` m away. Returns the stage."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, T_world_cam[:3, :3].ravel())
    stage = spec.worldbody.add_body(name="stage", pos=T_world_cam[:3, 3], quat=quat)
    box = mujoco.mjtGeom.mjGEOM_BOX
    for i, x in enumerate((-1.5, 0.0, 1.5)):  # tiles: a texture is stretched over its whole shape
        for j, y in enumerate((-1.0, 1.0)):
            stage.add_geom(
                type=box, size=far * np.array([0.75, 1.0, 0.02]), pos=far * np.array([x, y, 2.2]),
                material=patterns[-1 - i - 3 * j], **PASSIVE,
            )  # fmt: skip
    for _ in range(12):
        place = rng.uniform([-1.4, -1.0, 1.7], [1.4, 1.0, 2.1])
        stage.add_geom(
            type=box, size=far * rng.uniform(0.05, 0.2, 3), pos=far * place,
            euler=rng.uniform(-90, 90, 3), material=str(rng.choice(patterns[: PATTERNS // 2])),
            **PASSIVE,
        )  # fmt: skip
    stage.add_light(
        pos=far * np.array([-0.5, -1.5, 0.0]), dir=[0.3, 0.8, 0.7], castshadow=False,
        diffuse=[0.7, 0.7, 0.7], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
    )  # fmt: skip
    return stage


def add_movers(
    stage: Any, mujoco: Any, kind: Distractor, far: float, patterns: list[str],
    rng: np.random.Generator,
) -> tuple[str, ...]:  # fmt: skip
    """Add what moves by itself; the names of its joints."""
    sides = rng.permutation([-1.0, 1.0])
    if kind == "none":
        return ()
    if kind == "lagged":
        return tuple(
            joint for i, side in enumerate(sides)
            for joint in _add_imitator(stage, mujoco, i, side, far, patterns, rng)
        )  # fmt: skip
    names = [_add_pendulum(stage, mujoco, i, s, far, patterns, rng) for i, s in enumerate(sides)]
    names += [_add_slider(stage, mujoco, i, s, far, patterns, rng) for i, s in enumerate(sides)]
    return tuple(names)


def movements(
    kind: Distractor, time: Array, q: Array, far: float, rng: np.random.Generator
) -> Array:
    """(n, n_movers) positions of the movers' joints.

    Args:
        kind: of distractor.
        time: (n,) s.
        q: (n, J) rad, what an imitator repeats: the robot's posture some time before.
        far: m, scale of the stage.
        rng: of frequencies, pauses and gains.
    """
    if kind == "none":
        return np.empty((len(time), 0))
    if kind == "lagged":
        mix = rng.normal(size=(q.shape[1], 4))
        mix *= np.where(np.abs(mix) < 0.4, np.sign(mix) * 0.4 / np.abs(mix), 1.0)
        return np.asarray((q - q[0]) @ mix)
    swings = [
        rng.uniform(0.3, 0.5) * np.sin(2 * np.pi * (rng.uniform(0.3, 0.9) * time + rng.uniform()))
        for _ in range(2)
    ]
    slides = [_to_and_fro(time, 0.25 * far, rng) for _ in range(2)]
    return np.column_stack([*swings, *slides])


def _to_and_fro(time: Array, width: float, rng: np.random.Generator) -> Array:
    """Steps of random length between random places, with rests between them."""
    moments, places = [0.0], [0.0]
    while moments[-1] < time[-1]:
        rests = rng.uniform() < STAND_STILL
        moments.append(moments[-1] + rng.uniform(0.3, 1.2))
        places.append(places[-1] if rests else rng.uniform(-width / 2, width / 2))
    return np.asarray(np.interp(time, moments, places))


def _add_pendulum(
    stage: Any, mujoco: Any, i: int, side: float, far: float, patterns: list[str],
    rng: np.random.Generator,
) -> str:  # fmt: skip
    name = f"pendulum_{i}"
    place = [side * rng.uniform(0.55, 0.8), rng.uniform(-0.6, -0.3), 1.5]
    body = stage.add_body(name=name, pos=far * np.array(place))
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    size = far * np.array([0.1, 0.3, 0.02])
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=[0, size[1], 0],
        material=str(rng.choice(patterns[: PATTERNS // 2])), **PASSIVE,
    )  # fmt: skip
    return name


def _add_slider(
    stage: Any, mujoco: Any, i: int, side: float, far: float, patterns: list[str],
    rng: np.random.Generator,
) -> str:  # fmt: skip
    name = f"slider_{i}"
    place = [side * rng.uniform(0.5, 0.8), rng.uniform(0.35, 0.55), 1.6]
    body = stage.add_body(name=name, pos=far * np.array(place))
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=far * np.array([0.12, 0.12, 0.05]),
        material=str(rng.choice(patterns[: PATTERNS // 2])), **PASSIVE,
    )  # fmt: skip
    return name


def _add_imitator(
    stage: Any, mujoco: Any, i: int, side: float, far: float, patterns: list[str],
    rng: np.random.Generator,
) -> tuple[str, str]:  # fmt: skip
    names = (f"upper_{i}", f"lower_{i}")
    place = [side * rng.uniform(0.6, 0.8), rng.uniform(-0.4, 0.0), 1.5]
    capsule, size = mujoco.mjtGeom.mjGEOM_CAPSULE, far * np.array([0.08, 0.17, 0.0])
    body, below = stage, far * np.array(place)
    for name in names:
        body = body.add_body(name=name, pos=below)
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        body.add_geom(
            type=capsule, size=size, pos=[0, size[1], 0], quat=[0.7071068, 0.7071068, 0, 0],
            material=str(rng.choice(patterns[: PATTERNS // 2])), **PASSIVE,
        )  # fmt: skip
        below = np.array([0.0, 2 * size[1], 0.0])
    return names
