"""A room full of things before the robot: edges and colours that are not its own.

In the frame of the root link the robot looks along -x and down. A table, a wall, boxes and balls
lie behind and below the place where the hand works, so that nothing hides the hand. What lies where
comes from a fixed seed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

GROUP = 1
"""Of shapes that are not the robot; those of the robot are in group 0."""

THINGS = 40
"""Boxes and balls."""

SEED = 7


def add_clutter(spec: Any, mujoco: Any) -> None:
    """Add walls, things and lamps to a MuJoCo specification."""
    rng = np.random.default_rng(SEED)
    materials = [_material(spec, mujoco, rng, i) for i in range(8)]
    room = spec.worldbody
    box, ball = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE
    passive = {"contype": 0, "conaffinity": 0, "mass": 0, "group": GROUP}
    wall, table = [-1.5, 0, 0.3], [-0.7, 0, -0.4]
    room.add_geom(type=box, size=[0.02, 3, 1], pos=wall, material=materials[0], **passive)
    room.add_geom(type=box, size=[0.8, 3, 0.02], pos=table, material=materials[1], **passive)
    for i in range(THINGS):
        place = rng.uniform([-1.2, -0.7, -0.4], [-0.5, 0.7, -0.25])
        room.add_geom(
            type=ball if i % 3 == 0 else box, size=rng.uniform(0.03, 0.1, 3),
            pos=place, euler=rng.uniform(-180, 180, 3), material=rng.choice(materials), **passive,
        )  # fmt: skip
    spec.visual.quality.shadowsize = 512  # the default of 4096 takes most of the time
    for y in (-0.6, 0.5):
        room.add_light(
            pos=[0.2, y, 1.2], dir=[-0.5, -y, -1.0], castshadow=True, diffuse=[0.6, 0.6, 0.6]
        )


def _material(spec: Any, mujoco: Any, rng: np.random.Generator, number: int) -> str:
    """A checked or flat texture with random marks, in random colours; its name."""
    name = f"pattern_{number}"
    kinds = (mujoco.mjtBuiltin.mjBUILTIN_CHECKER, mujoco.mjtBuiltin.mjBUILTIN_FLAT)
    spec.add_texture(
        name=name, type=mujoco.mjtTexture.mjTEXTURE_CUBE, builtin=kinds[number % 2],
        rgb1=rng.uniform(0, 1, 3), rgb2=rng.uniform(0, 1, 3), width=64, height=64,
        mark=mujoco.mjtMark.mjMARK_RANDOM, markrgb=rng.uniform(0, 1, 3), random=0.02,
    )  # fmt: skip
    material = spec.add_material(name=name)
    textures = [""] * int(mujoco.mjtTextureRole.mjNTEXROLE)
    textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = name
    material.textures = textures
    return name
