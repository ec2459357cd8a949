"""The iCub's right hand, wrist and forearm before its own eyes, for tests and benchmarks."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.camera import Camera
from bodyschema.simulation import icub, world
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

LINKS = ("r_hand", "r_wrist_1", "r_forearm")
BUDGET = {"r_forearm": 618, "r_wrist_1": 200}
"""The hand keeps all of its 364 faces: 1182 in all."""


@cache
def arm(decimated: bool = True) -> Surface:
    """The three links as believed."""
    return Surface.of(icub.nominal_icub(), LINKS, BUDGET if decimated else 0)


def eyes(width: int = 320, height: int = 240) -> list[Camera]:
    """Both eyes, with the same view at any size."""
    fov = 2 * np.arctan(320 / 2 / 257.34)
    names = (icub.LEFT_EYE, icub.RIGHT_EYE)
    return [Camera.from_fov(name, name, width, height, fov) for name in names]


@cache
def readings(n: int, seed: int = 0) -> Array:
    """Postures (n, n_joints) in which both eyes see the hand at working distance."""
    return world.simulate(world.Simulation(n_samples=n, seed=seed)).q


def views(n: int, seed: int = 0) -> Array:
    """T_cam_piece (n, 2, 3, 4, 4) of those postures."""
    return piece_poses(icub.nominal_icub(), readings(n, seed), eyes(), arm().frames)


def hypotheses(n: int, seed: int = 0, posture: int = 4) -> Array:
    """T_cam_piece (n, 2, 3, 4, 4) of one posture with arm offsets of 3 deg; the first has none."""
    body = icub.nominal_icub()
    q = np.tile(readings(20)[posture], (n, 1))
    columns = [body.joint_index(joint) for joint in icub.RIGHT_ARM]
    offsets = np.deg2rad(3) * np.random.default_rng(seed).normal(size=(n, len(columns)))
    offsets[0] = 0
    q[:, columns] += offsets
    return piece_poses(body, q, eyes(), arm().frames)


def beside_the_eye(n: int, seed: int = 1) -> list[Array]:
    """T_cam_piece (3, 4, 4) of arms moved so that the forearm passes the left eye's optical centre.

    Of n draws those are kept in which it reaches behind the eye and into the view.
    """
    rng, kept = np.random.default_rng(seed), []
    surface, camera = arm(False), eyes()[0]
    forearm = surface.vertices[surface.vo[2] :]
    for T in views(n, seed)[:, 0]:
        beside = [rng.choice([-1, 1]) * rng.uniform(0.02, 0.08), rng.uniform(-0.05, 0.05), 0]
        moved = T.copy()
        moved[:, :3, 3] += beside - (T[2, :3, :3] @ rng.choice(forearm) + T[2, :3, 3])
        p = forearm @ moved[2, :3, :3].T + moved[2, :3, 3]
        u, v = camera.project(p[p[:, 2] > 0.01]).T
        inside = (u > 0) & (u < camera.width) & (v > 0) & (v < camera.height)
        if p[:, 2].min() < 0 and np.count_nonzero(inside) > 20:
            kept.append(moved)
    return kept
