"""Whether a part of what the hand carries has jumped: a tool that slipped, and nothing else.

For each corner the place on the hand is known from its older rows; the newest rows say where it is
now. A slip shows as several corners that are elsewhere by the same rigid motion while the others
stand. Corners of the forearm, or of the wall, that were taken for the hand's move as well, but in
one frame or the other they stand: a jump counts only if the corner jumped on the hand *and* in the
world.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.corner_rows import CornerRows, triangulated
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

RECENT = 2
"""Newest rows of a corner that say where it is now."""
OLD = 4
"""Rows before those that a corner must have."""
JUMP, SCATTERS = 0.004, 4.0
"""m, and times a corner's own scatter, from which it has jumped."""
JUST, SUDDEN = 3, 0.6
"""Rows before the newest, and share of the jump that must have come since them: what creeps away is
no jump, but a corner of something else."""
LEAST, SHARE = 4, 0.15
"""Corners, and share of those in view, that must have jumped."""
RIGID = 0.003
"""m by which corners that jumped may differ from one rigid motion."""


@dataclass(frozen=True)
class Jump:
    """Corners that moved together."""

    name: Ints
    """(n,) of those that jumped."""
    share: float
    """Of the corners in view."""
    shift: Array
    """(3,) m, their mean on the hand."""

    @property
    def length(self) -> float:
        """m."""
        return float(np.linalg.norm(self.shift))


def found(rows: CornerRows, now: int, T_world_cam: Array, stereo: Stereo, span: int) -> Jump | None:
    """What has jumped on the hand, if anything.

    Args:
        rows: of corners that are believed to be on the hand, by one camera pose.
        now: number of the newest moment.
        T_world_cam: (4, 4).
        stereo: the lens.
        span: moments between two rows.
    """
    live = np.unique(rows.corner[rows.moment >= now - RECENT * span])
    rows = rows.only(np.isin(rows.corner, live))
    names, _, which = rows.grouped()
    size = np.bincount(which, minlength=len(names))
    long = size >= OLD + RECENT
    if long.sum() < LEAST:
        return None
    c = triangulated(rows.seen, stereo)
    world = c @ T_world_cam[:3, :3].T + T_world_cam[:3, 3]
    T = lie.inverse(rows.T_world_carrier)
    hand = np.einsum("nij,nj->ni", T[:, :3, :3], world) + T[:, :3, 3]
    before, after, lately = (np.empty((len(names), 3)) for _ in range(3))
    scatter, moved_world = np.empty(len(names)), np.zeros(len(names))
    for k in np.flatnonzero(long):
        mine = which == k
        on, seen = hand[mine], world[mine]
        old = on[:-RECENT]
        before[k], after[k] = np.median(old, axis=0), on[-RECENT:].mean(axis=0)
        lately[k] = old[-JUST:].mean(axis=0)
        scatter[k] = np.sqrt(np.median(np.sum((old - before[k]) ** 2, axis=1)))
        moved_world[k] = np.linalg.norm(
            seen[-RECENT:].mean(axis=0) - seen[-RECENT - 2 : -RECENT].mean(axis=0)
        )
    names, before, after = names[long], before[long], after[long]
    far = np.linalg.norm(after - before, axis=1)
    sudden = np.linalg.norm(after - lately[long], axis=1) > SUDDEN * far
    jumped = (
        (far > np.maximum(JUMP, SCATTERS * scatter[long])) & (moved_world[long] > JUMP / 4) & sudden
    )
    if jumped.sum() < LEAST or jumped.mean() <= SHARE:
        return None
    together = _as_one(before[jumped], after[jumped])
    if together.sum() < LEAST:
        return None
    shift = (after - before)[jumped][together].mean(axis=0)
    return Jump(names[jumped][together], float(together.sum() / len(names)), shift)


def _as_one(before: Array, after: Array) -> Flags:
    """(n,) the largest set of points that one rigid motion moves.

    Grown from points that moved alike, as in a slip; or from neighbours, as in a turn, and then
    one more must agree: three points fit nearly any motion.
    """
    best, shift = np.zeros(len(before), dtype=bool), after - before
    for k in range(len(before)):
        alike = _grown(np.linalg.norm(shift - shift[k], axis=1) < 2 * RIGID, before, after)
        nearest = np.argsort(np.linalg.norm(before - before[k], axis=1), kind="stable")[:3]
        turned = _grown(np.isin(np.arange(len(before)), nearest), before, after)
        if turned.sum() <= LEAST:
            turned = alike
        best = max(best, alike, turned, key=np.count_nonzero)
    return best


def _grown(first: Flags, before: Array, after: Array) -> Flags:
    """(n,) points that follow the rigid motion of the first few."""
    for _ in range(3):
        if first.sum() < 3:
            break
        R, t = _rigid(before[first], after[first])
        first = np.linalg.norm(before @ R.T + t - after, axis=1) < RIGID
    return first


def _rigid(a: Array, b: Array) -> tuple[Array, Array]:
    """Rotation and shift that take points a to b best (Kabsch)."""
    A, B = a - a.mean(axis=0), b - b.mean(axis=0)
    U, _, Vt = np.linalg.svd(B.T @ A)
    D = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(U @ Vt)))])
    R = U @ D @ Vt
    return R, b.mean(axis=0) - R @ a.mean(axis=0)
