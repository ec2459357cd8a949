"""Where the camera may be, from corners on carried things, when nothing or little is known.

From nothing: in the paper's relation R c + r_o - R_h r_k - p = 0 everything but R is linear, and a
search over all rotations finds what fits (`rotation_search`). After a turn of a camera that was
known: corners that were seen before and after are known in the world, and a rigid motion takes
what the camera sees of them to where they are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.corner_rows import CornerRows, places, predicted, triangulated
from bodyschema.learners.hand_eye.rotation_search import search
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]

SETS, SET, LONGEST, KEPT, BEST = 24, 3, 30, 2, 6
"""Small sets of corners that a start from nothing tries, corners in each, drawn from so many that
lived longest; minima that are kept of each set, and starts that are kept of all."""
BRIDGES, ROUNDS, NEAR = 4, 10, 3.0
"""Corners that carry a turn over at least, rounds, and times the median distance that counts."""


def started(rows: CornerRows, stereo: Stereo) -> Array:
    """(n, 4, 4) camera poses from nothing, the likeliest first; none while there are few corners.

    A corner that is not on its carrier spoils what it takes part in; some of the small sets are
    without one. What is likely is judged by the middle of all residuals, which half of the corners
    cannot spoil.
    """
    names, _, which = rows.grouped()
    if len(names) <= SET:
        return np.zeros((0, 4, 4))
    long = np.argsort(-np.bincount(which), kind="stable")[:LONGEST]
    rng = np.random.default_rng(0)
    sets = [np.arange(len(names))]
    sets += [rng.choice(long, SET, replace=False) for _ in range(SETS)]
    found = [one for chosen in sets for one in _searched(rows.only(np.isin(which, chosen)), stereo)]
    misfit = []
    for one in found:
        place = places(rows, one[None], stereo)[which]
        e = rows.seen - predicted(rows, one[None], place, stereo)[0]
        misfit.append(float(np.median(np.abs(e[:, :2]))))
    return np.array(found)[np.argsort(misfit, kind="stable")[:BEST]]


def _searched(rows: CornerRows, stereo: Stereo) -> list[Array]:
    """The best minima over all rotations; nearness counts, as errors of depth grow with z^2."""
    _, first, _ = rows.grouped()
    c, T = triangulated(rows.seen, stereo), rows.T_world_carrier
    A = np.zeros((len(rows), 3, 16))
    for i in range(3):
        for j in range(3):
            A[:, i, 3 * j + i] = c[:, j]
        A[:, i, 9 + i] = 1.0
    A[:, :, 12:15], A[:, :, 15] = -T[:, :3, :3], -T[:, :3, 3]
    A /= c[:, 2, None, None] ** 2
    D = np.add.reduceat(np.swapaxes(A, 1, 2) @ A, first)
    return [one.T_world_cam for one in search(D)[:KEPT]]


def bridged(rows: CornerRows, T_world_cam: Array, stereo: Stereo) -> Array | None:
    """(4, 4) the second camera, from corners that both have seen; None when they are too few.

    Args:
        rows: by camera 0, which is known, and camera 1.
        T_world_cam: (4, 4) of camera 0.
        stereo: the lens of both.
    """
    both = np.intersect1d(rows.corner[rows.camera == 0], rows.corner[rows.camera == 1])
    if len(both) < BRIDGES:
        return None
    rows = rows.only(np.isin(rows.corner, both))
    place = places(rows.only(rows.camera == 0), T_world_cam[None], stereo)
    later = rows.only(rows.camera == 1)
    T = later.T_world_carrier
    on = place[np.searchsorted(both, later.corner)]
    world = np.einsum("nij,nj->ni", T[:, :3, :3], on) + T[:, :3, 3]
    seen = triangulated(later.seen, stereo)
    weight = np.ones(len(seen))
    for _ in range(ROUNDS):
        pose = _rigid(seen, world, weight)
        away = np.linalg.norm(seen @ pose[:3, :3].T + pose[:3, 3] - world, axis=1)
        weight = (away < NEAR * np.median(away) + 1e-9).astype(float)
    return pose


def _rigid(a: Array, b: Array, weight: Array) -> Array:
    """(4, 4) that takes points a (n, 3) to b best (Kabsch 1976)."""
    share = weight / weight.sum()
    A, B = a - share @ a, b - share @ b
    U, _, Vt = np.linalg.svd((B * share[:, None]).T @ A)
    D = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(U @ Vt)))])
    R = U @ D @ Vt
    return lie.transform(R, share @ b - R @ (share @ a))
