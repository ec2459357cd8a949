"""Where the robot's frames are in the postures that were recorded, before and after."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST = 60
"""Postures that a page holds, evenly spaced: each costs 3 kB for a humanoid."""


@dataclass(frozen=True)
class Recorded:
    """Postures, each with the row that it stands in."""

    q: Array
    """(n, n_joints) rad, m."""
    rows: Ints
    """(n,) -1 where nothing was recorded."""

    @classmethod
    def by(cls, senses: Sequence[Sense], body: Body, outliers: Collection[int] = ()) -> Recorded:
        """Evenly spaced rows of what was seen; the middle of all joints where nothing was.

        Args:
            senses: what was seen, maybe without a sample.
            body: whose joints they are of.
            outliers: rows that are left out, unless there are no others.
        """
        rows = np.concatenate([np.empty(0, dtype=np.int64), *(sense.rows for sense in senses)])
        if not len(rows):
            finite = np.isfinite(body.lower) & np.isfinite(body.upper)
            low, high = (np.where(finite, limit, 0.0) for limit in (body.lower, body.upper))
            return cls(np.clip(0.0, low, high)[None], np.array([-1]))
        q = np.concatenate([sense.q for sense in senses])
        good = ~np.isin(rows, list(outliers))
        return cls.even(q[good], rows[good]) if good.any() else cls.even(q, rows)

    @classmethod
    def even(cls, q: Array, rows: Ints) -> Recorded:
        """Evenly spaced ones of many, each row once.

        Args:
            q: (n, n_joints), at least one.
            rows: (n,).
        """
        single, first = np.unique(rows, return_index=True)
        kept = np.unique(np.linspace(0, len(single) - 1, min(MOST, len(single))).astype(int))
        return cls(q[first[kept]], single[kept])


@dataclass(frozen=True)
class Moving:
    """Poses of the frames that are drawn, in the root frame."""

    frames: tuple[str, ...]
    parent: tuple[int, ...]
    """The nearest drawn frame above each; -1 for the root."""
    joint: tuple[bool, ...]
    """Whether a joint carries the frame."""
    corrected: tuple[bool, ...]
    """Whether it belongs to the robot, whose joints are corrected, and hangs on no frame that was
    estimated itself, which has no "before" worth the name."""
    before: Array
    """(n, n_frames, 4, 4) of the body as modelled."""
    after: Array
    """The same of the corrected body."""

    @classmethod
    def of(
        cls, estimate: Estimate, q: Array, wanted: Collection[str], placed: Collection[str]
    ) -> Moving:
        """Joints, the frames that are wanted, and all between those and the root.

        Args:
            estimate: the belief.
            q: (n, n_joints) postures.
            wanted: names of frames.
            placed: frames that were estimated.
        """
        body = estimate.body
        kept = {0, *np.flatnonzero(body.driver >= 0).tolist()}
        kept |= {body.frame_index(name) for name in wanted}
        order = sorted(kept)
        above = [_nearest(body, k, order) for k in order]
        free = [_below(body, k, placed) for k in order]
        before, after = (frame_poses(b, q)[:, order] for b in (estimate.reference, body))
        return cls(
            tuple(body.frames[k] for k in order),
            tuple(above),
            tuple(bool(body.driver[k] >= 0) for k in order),
            tuple(not one for one in free),
            before,
            after,
        )

    @property
    def size(self) -> float:
        """m: the largest side of the box round all drawn frames."""
        return max(float(np.ptp(self.after[..., :3, 3], axis=(0, 1)).max()), 0.05)

    @property
    def shift(self) -> tuple[float, str]:
        """m, by which the correction moves the robot's frame that moves most; and that frame."""
        moved = np.linalg.norm((self.after - self.before)[..., :3, 3], axis=-1).max(axis=0)
        moved = np.where(self.corrected, moved, 0.0)
        k = int(np.argmax(moved))
        return float(moved[k]), self.frames[k]

    def packed(self, poses: Array) -> NDArray[np.float32]:
        """(n, n_frames, 7) place in m and quaternion x y z w."""
        turns = lie.quaternion_xyzw(poses[..., :3, :3])
        return np.concatenate([poses[..., :3, 3], turns], axis=-1).astype(np.float32)


def _nearest(body: Body, k: int, kept: Sequence[int]) -> int:
    """Position among `kept` of the nearest one above frame k."""
    k = int(body.parent[k])
    while k >= 0 and k not in kept:
        k = int(body.parent[k])
    return kept.index(k) if k >= 0 else -1


def _below(body: Body, k: int, placed: Collection[str]) -> bool:
    while k >= 0:
        if body.frames[k] in placed:
            return True
        k = int(body.parent[k])
    return False
