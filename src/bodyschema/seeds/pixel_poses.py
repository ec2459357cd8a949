"""Poses of a target from pictures: one for each picture with four of its points or more.

The pixels are straightened to rays (a, b) first, so a picture is a plane at z = 1.

    flat target      H = [r1 r2 t] maps its plane to the picture: 8 numbers from 4 points (Zhang
                     2000), and the mirrored pose, which a small or distant target fits as well
    other target     P = [R t] from 6 points, as 12 numbers up to scale

Both are linear and need no guess; a few Levenberg-Marquardt steps on the distances in the picture
then make the best of each. `starts` takes the poses for K Y = X T, which places camera and target.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.lie import nearest_rotation
from bodyschema.model.lens import straight_rays
from bodyschema.model.tree import Body
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.poses import Poses

Array = NDArray[np.float64]

LEAST, LEAST_SOLID = 4, 6
"""Points of a flat target and of any other one that a picture must show."""

PICTURES = 3
"""Poses that K Y = X T needs for two unknown frames."""

SLIM, FLAT = 1e-3, 1e-2
"""Extent over the largest: points thinner in two directions are a line, in one a plane."""

STEPS = 10

BEHIND = 10.0
"""Error, in units of the plane z = 1, of a point that a pose puts behind the camera."""


def seen_poses(body: Body, sense: Pixels) -> Poses | None:
    """What a camera's pictures say of a target's pose; None when too few show enough of it.

    Args:
        body: has the lens and the scale.
        sense: samples that share time and row are of one picture.
    """
    rays = straight_rays(sense.lens_of(body), sense.observed)
    points = sense.points(body)
    _, first, picture = np.unique(
        np.stack([sense.time, sense.rows]), axis=1, return_index=True, return_inverse=True
    )
    found, kept = [], []
    for k, sample in enumerate(first):
        mine = np.flatnonzero(picture.ravel() == k)
        T = pose_of_points(points[mine], rays[mine])
        if T is not None:
            found.append(T)
            kept.append(sample)
    if len(found) < PICTURES:
        return None
    rate = None if sense.rate is None else sense.rate[kept]
    return Poses.make(
        sense.q[kept], np.array(found), sense.seen_from, sense.seen, time=sense.time[kept],
        rows=sense.rows[kept], clock=sense.clock, rate=rate,
    )  # fmt: skip


def pose_of_points(points: Array, rays: Array) -> Array | None:
    """T_camera_target that puts points on rays, (4, 4); None when they are too few for one.

    Args:
        points: (m, 3) m.
        rays: (m, 2) straightened, at z = 1.
    """
    guesses = pose_guesses(points, rays)
    fitted = [_refined(T, points, rays) for T in guesses]
    return min(fitted, key=lambda T: _squares(T, points, rays)) if fitted else None


def pose_guesses(points: Array, rays: Array) -> list[Array]:
    """The linear poses before any refinement."""
    if len(points) < LEAST:
        return []
    centre = points.mean(axis=0)
    _, extent, axes = np.linalg.svd(points - centre, full_matrices=True)
    if extent[1] < SLIM * extent[0]:
        return []
    axes = axes * np.array([[1.0], [1.0], [np.linalg.det(axes)]])
    T_local_target = lie.transform(axes, -axes @ centre)
    local = (points - centre) @ axes.T
    if len(points) >= LEAST_SOLID and extent[2] > FLAT * extent[0]:
        return [_of_solid(local, rays) @ T_local_target]
    flat = _of_plane(local[:, :2], rays)
    return [T @ T_local_target for T in (flat, _mirrored(flat))]


def image_error(T: Array, points: Array, rays: Array) -> Array:
    """How far from their rays a pose puts the points, (m, 2) at z = 1."""
    p = points @ T[:3, :3].T + T[:3, 3]
    ahead = p[:, 2:] > 1e-3
    return np.where(ahead, p[:, :2] / np.where(ahead, p[:, 2:], 1.0) - rays, BEHIND)


def _of_plane(plane: Array, rays: Array) -> Array:
    """Pose of a plane, its points (m, 2) round zero, from the homography to the picture."""
    h = _linear_map(plane, rays)
    h *= 1.0 if h[2, 2] >= 0 else -1.0
    size = np.linalg.norm(h[:, :2], axis=0).mean()
    first, second = (h[:, :2] / size).T
    R = nearest_rotation(np.stack([first, second, np.cross(first, second)], axis=1))
    return lie.transform(R, h[:, 2] / size)


def _of_solid(local: Array, rays: Array) -> Array:
    """Pose of points (m, 3) that lie in no plane."""
    P = _linear_map(local, rays)
    P *= 1.0 if np.linalg.det(P[:, :3]) >= 0 else -1.0
    size = np.linalg.svd(P[:, :3], compute_uv=False).mean()
    return lie.transform(nearest_rotation(P[:, :3]), P[:, 3] / size)


def _linear_map(source: Array, rays: Array) -> Array:
    """The (3, k + 1) matrix M, up to scale, with M (source, 1) along (rays, 1): (m, k), (m, 2)."""
    m, k = source.shape
    ends = np.hstack([source, np.ones((m, 1))])
    rows = np.zeros((2, m, 3, k + 1))
    for axis in range(2):
        rows[axis, :, axis] = ends
        rows[axis, :, 2] = -rays[:, axis, None] * ends
    return np.asarray(np.linalg.svd(rows.reshape(2 * m, -1))[2][-1].reshape(3, k + 1))


def _mirrored(T: Array) -> Array:
    """The pose of a plane whose normal is mirrored at the line of sight to its centre."""
    sight = T[:3, 3] / np.linalg.norm(T[:3, 3])
    R = lie.exp_so3(np.pi * sight) @ T[:3, :3] @ np.diag([-1.0, -1.0, 1.0])
    return lie.transform(R, T[:3, 3])


def _refined(T: Array, points: Array, rays: Array) -> Array:
    """A pose after a few steps on the sum of squares in the picture."""
    damping, squares = 1e-3, _squares(T, points, rays)
    for _ in range(STEPS):
        arm = points @ T[:3, :3].T
        p = arm + T[:3, 3]
        plane = p[:, :2] / p[:, 2:]
        ahead = np.concatenate([np.tile(np.eye(2), (len(p), 1, 1)), -plane[..., None]], axis=2)
        ahead /= p[:, 2, None, None]
        J = np.concatenate([ahead, -ahead @ lie.skew(arm)], axis=2).reshape(-1, 6)
        H, g = J.T @ J, J.T @ (plane - rays).ravel()
        step = -np.linalg.solve(H + damping * np.diag(np.diag(H)) + 1e-12 * np.eye(6), g)
        there = lie.transform(lie.exp_so3(step[3:]) @ T[:3, :3], T[:3, 3] + step[:3])
        lower = _squares(there, points, rays)
        if lower < squares:
            T, squares, damping = there, lower, damping / 10
        else:
            damping *= 10
    return T


def _squares(T: Array, points: Array, rays: Array) -> float:
    return float(np.sum(image_error(T, points, rays) ** 2))
