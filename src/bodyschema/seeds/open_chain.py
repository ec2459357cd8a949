"""Open chain: what one sense saw, and the kinematics between the parents of its two frames.

Both frames count as unknown, so that their placements explain nothing away: what is left over is
the fault of the joints, of the description, or of how the recording was declared.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.kinematics import path_between, relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds.frame_fits import Batch
from bodyschema.seeds.pixel_poses import seen_poses
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

LEAST = 6
"""Samples without which nothing can be said."""

PICTURES = 200
"""Pictures of a board that are looked at: each costs a small fit."""


@dataclass(frozen=True)
class OpenChain:
    """A sense between two frames that hang anywhere on their parents."""

    body: Body
    label: str
    """Of the sense."""
    left: str
    """Frame that carries the one that looks."""
    right: str
    """Frame that carries the one that is seen."""
    q: Array
    """(n, n_joints) readings, in the order of the recording."""
    p: Array
    """(n, 3) m."""
    Q: Array | None
    """(n, 3, 3); None for points."""
    pictured: bool = False
    """Whether the poses are of a board in pictures, which have no layout of their own."""

    @classmethod
    def of(cls, body: Body, sense: Sense, most: int | None = None) -> Self | None:
        """Of a sense that has points or poses, or shows the pose of a board; None for others.

        Args:
            body: with the frames and parts of the sense.
            sense: what was seen.
            most: samples, evenly spaced; all when None.
        """
        poses = _poses(body, sense, most or PICTURES) if isinstance(sense, Pixels) else sense
        if not isinstance(poses, Points | Poses) or len(poses) < LEAST:
            return None
        if most is not None and len(poses) > most:
            poses = poses.take(np.linspace(0, len(poses) - 1, most).astype(int))
        left, right = _carrier(body, sense.seen_from), _carrier(body, sense.seen)
        if not len(path_between(body, left, right)[0]):
            return None
        if isinstance(poses, Points):
            return cls(body, sense.label, left, right, poses.q, poses.position, None)
        p, Q = poses.pose[:, :3, 3], poses.pose[:, :3, :3]
        return cls(body, sense.label, left, right, poses.q, p, Q, isinstance(sense, Pixels))

    @classmethod
    def all_of(
        cls, body: Body, senses: Sequence[Sense], most: int | None = None
    ) -> tuple[Self, ...]:
        """Of all senses that have one."""
        found = (cls.of(body, sense, most) for sense in senses)
        return tuple(chain for chain in found if chain is not None)

    def kinematics(self, q: Array) -> Array:
        """(*batch, 4, 4) between the parents at readings (*batch, n_joints)."""
        return relative_pose(self.body, q, self.left, self.right)

    def batch(self, q: Array) -> Batch:
        """What was seen at other readings, (h, n, n_joints)."""
        h = len(q)
        p = np.broadcast_to(self.p, (h, *self.p.shape))
        Q = None if self.Q is None else np.broadcast_to(self.Q, (h, *self.Q.shape))
        return Batch(self.kinematics(q), p, Q)


def _carrier(body: Body, frame: str) -> str:
    """The frame that carries a fixed one; the frame itself where a joint moves it."""
    node = body.frame_index(frame)
    fixed = body.driver[node] < 0 and body.parent[node] >= 0
    return body.frames[body.parent[node]] if fixed else frame


def _poses(body: Body, sense: Pixels, most: int) -> Poses | None:
    """Poses of a board in at most so many pictures."""
    stamps = np.stack([sense.time, sense.rows])
    _, picture = np.unique(stamps, axis=1, return_inverse=True)
    count = int(picture.max(initial=-1)) + 1
    if count > most:
        kept = np.linspace(0, count - 1, most).astype(int)
        sense = sense.take(np.isin(picture.ravel(), kept))
    try:
        return seen_poses(body, sense)
    except (InputError, np.linalg.LinAlgError):
        return None


def moved(chains: Collection[OpenChain]) -> tuple[int, ...]:
    """Columns of the joints between the ends of any chain."""
    between: set[int] = set()
    for chain in chains:
        path, _ = path_between(chain.body, chain.left, chain.right)
        between |= {int(chain.body.driver[k]) for k in path if chain.body.driver[k] >= 0}
    return tuple(sorted(between))
