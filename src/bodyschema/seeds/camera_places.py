"""Where a camera may stand that nobody has placed, from masks of a moving body.

For a rotation R of the parent into the camera, the body of posture k, its points P with centroid
c_k, stands along the ray rho_k (unit) of its mask's centroid, as far away as the mask is small:

    d_k = f s_k / r_k,    s_k^2 = mean |R (P - c_k)|^2 - (rho_k . R (P - c_k))^2

f the focal length (px), r_k the root mean square distance of the mask's pixels from their centroid.
So every posture alone places the camera, and the right rotation places it alike in all:

    t = mean_k t_k,    t_k = d_k rho_k - R c_k,    score = rms |t_k - t| / mean d_k

ROTATIONS of the whole of SO(3) are tried. Those with the least score are imagined as silhouettes
(`image_seeds`), and the best are kept, none near a better one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds.image_seeds import coarse, scored, spread_out
from bodyschema.senses.images import Images
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

ROTATIONS = 8192
"""A quarter of a radian from one to the next, about."""

IMAGINED, POSTURES = 256, 4
"""Places that are imagined as silhouettes, and in how many postures."""

POINTS = 400
"""Of the surface, that stand for the body."""

APART = 0.4
"""rad; of two places whose rotations are nearer to each other the better is kept."""


@dataclass(frozen=True)
class _Seen:
    """What the masks of all postures say."""

    ray: Array
    """(n, 3) rho_k."""
    size: Array
    """(n,) r_k / f."""


def camera_places(
    surface: Surface, body: Body, camera: str, frames: Sequence[Images], n: int = 4, seed: int = 0
) -> list[Array]:
    """Placements (4, 4) T_parent_camera in the frame that carries the camera, the best first.

    Args:
        surface: the visible body.
        body: as modelled; where it has the camera does not matter.
        camera: its name and frame.
        frames: masks of several postures.
        n: at most how many.
        seed: of the rotations.

    Raises:
        InputError: there are no masks, or the body shows in fewer than two.
    """
    mine = [_alone(seen, camera) for seen in frames]
    mine = [seen for seen in mine if seen.masked and seen.pictures[0].any()]
    if len(mine) < 2:
        raise InputError(
            f"camera '{camera}' can be placed from nothing by masks that show the body in two "
            'postures or more; give masks, or say roughly where it is (known = "roughly").'
        )
    parent = body.frames[body.parent[body.frame_index(camera)]]
    P = _points(surface, body, parent, np.array([seen.q for seen in mine]))
    found = _places(P, _seen(mine), seed)
    bodies = [body.with_placement(camera, lie.inverse(T)) for T in found]
    few = [coarse(mine[i]) for i in spread_out(np.array([seen.q for seen in mine]), POSTURES)]
    order = np.argsort(-scored(surface, bodies, few), kind="stable")
    kept = list[Array]()
    for i in order:
        turns = [np.linalg.norm(lie.log_so3(found[i][:3, :3] @ T[:3, :3].T)) for T in kept]
        if len(kept) < n and min(turns, default=np.inf) > APART:
            kept.append(found[i])
    return [lie.inverse(T) for T in kept]


def _alone(seen: Images, camera: str) -> Images:
    """What one camera saw."""
    k = [one.frame for one in seen.cameras].index(camera)
    return replace(seen, cameras=(seen.cameras[k],), pictures=(seen.pictures[k],))


def _points(surface: Surface, body: Body, parent: str, q: Array) -> Array:
    """(n_postures, n_points, 3) m, centres of faces by their area, in the parent."""
    corners = surface.vertices[surface.faces]
    area = np.linalg.norm(np.cross(*np.diff(corners, axis=1).swapaxes(0, 1)), axis=1)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(area), POINTS, p=area / area.sum())
    piece = np.searchsorted(surface.fo, chosen, side="right") - 1
    X = corners[chosen].mean(axis=1)
    out = np.zeros((len(q), POINTS, 3))
    for k, frame in enumerate(surface.frames):
        T = relative_pose(body, q, parent, frame)
        mine = piece == k
        out[:, mine] = X[mine] @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3]
    return out


def _seen(frames: Sequence[Images]) -> _Seen:
    ray, size = [], []
    for seen in frames:
        f_x, f_y, c_x, c_y = seen.cameras[0].intrinsics
        rows, columns = np.nonzero(seen.pictures[0])
        plane = np.stack([(columns - c_x) / f_x, (rows - c_y) / f_y], axis=1)
        middle = plane.mean(axis=0)
        rho = np.append(middle, 1.0)
        ray.append(rho / np.linalg.norm(rho))
        size.append(np.sqrt(np.mean(np.sum((plane - middle) ** 2, axis=1))))
    return _Seen(np.array(ray), np.array(size))


def _places(P: Array, seen: _Seen, seed: int) -> list[Array]:
    """T_camera_parent (4, 4) that place the body alike in all postures, the best first."""
    R = _rotations(seed)
    c = P.mean(axis=1)
    S = np.einsum("kni,knj->kij", P - c[:, None], P - c[:, None]) / P.shape[1]
    across = np.einsum("rij,ki->rkj", R, seen.ray)  # rho in the parent's axes
    s2 = np.trace(S, axis1=1, axis2=2) - np.einsum("rki,kij,rkj->rk", across, S, across)
    d = np.sqrt(np.maximum(s2, 1e-12)) / seen.size
    t = d[..., None] * seen.ray - np.einsum("rij,kj->rki", R, c)
    middle = t.mean(axis=1)
    score = np.sqrt(np.mean(np.sum((t - middle[:, None]) ** 2, axis=2), axis=1)) / d.mean(axis=1)
    best = np.argsort(score, kind="stable")[:IMAGINED]
    return [lie.transform(R[i], middle[i]) for i in best]


def _rotations(seed: int) -> Array:
    """(ROTATIONS, 3, 3), even over SO(3) (Shoemake 1992)."""
    from scipy.stats import qmc  # here: it takes most of a second to import

    u = qmc.Sobol(3, rng=np.random.default_rng(seed)).random(ROTATIONS)
    a, b = np.sqrt(1 - u[:, 0]), np.sqrt(u[:, 0])
    s, t = 2 * np.pi * u[:, 1], 2 * np.pi * u[:, 2]
    x, y, z, w = a * np.sin(s), a * np.cos(s), b * np.sin(t), b * np.cos(t)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1),
        ],
        axis=1,
    )
