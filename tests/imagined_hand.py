"""The iCub's right hand before its eyes, small and coarse, for tests of what learns from images."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.camera import Camera
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

BETA = np.deg2rad([5.0, 4.0, 3.0, -2.0, 3.0, -7.0, 3.0])
"""Offsets of the right arm, rad."""


@cache
def hand() -> Surface:
    """Hand and forearm with few faces."""
    return Surface.of(icub.nominal_icub(), ("r_hand", "r_forearm"), 150)


@cache
def eyes() -> tuple[Camera, Camera]:
    """Both eyes at half size."""
    fov = 2 * np.arctan(320 / 2 / 257.34)
    left, right = (
        Camera.from_fov(eye, eye, 160, 120, fov) for eye in (icub.LEFT_EYE, icub.RIGHT_EYE)
    )
    return left, right


def posture(step: float = 0.0) -> Array:
    """(n_joints,) readings with the hand in view; `step` 0 to 1 moves all joints of the arm."""
    body = icub.bare_icub()
    q = np.clip(np.zeros(len(body.joints)), body.lower, body.upper)
    arm = np.deg2rad([-55.0, 42, 59, 55, -12, -46, -3]) + step * np.deg2rad(
        [8, -6, 8, -6, 15, 10, 8]
    )
    head = np.deg2rad([-20.0, -20.0])
    for name, angle in zip((*icub.RIGHT_ARM, "neck_pitch", "neck_yaw"), [*arm, *head], strict=True):
        q[body.joint_index(name)] = angle
    return q


def shifted(q: Array, beta: Array) -> Array:
    """Readings with the offsets of the right arm added."""
    body, there = icub.bare_icub(), q.copy()
    there[[body.joint_index(name) for name in icub.RIGHT_ARM]] += beta
    return there


def masks(q: Array, beta: Array = BETA) -> Images:
    """What both eyes see of an arm that is off by beta."""
    poses = piece_poses(icub.nominal_icub(), shifted(q, beta), eyes(), hand().frames)[0]
    pictures = tuple(silhouette(hand(), T, eye) for T, eye in zip(poses, eyes(), strict=True))
    return Images(0.0, q, eyes(), pictures)
