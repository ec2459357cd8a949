"""Target: where a robot is to be right, and what moves it there.

Unless it is said otherwise that is the place of what was seen, looked at from what saw it, over the
box of joint readings that was recorded: nobody can vouch for what lies beyond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import PoseDerivatives, relative_pose, relative_pose_derivatives
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

POSTURES = 200
"""Drawn from the box: the 95th of a hundred is known to a few percent."""


@dataclass(frozen=True)
class Target:
    """The place of a frame, seen from another, over some postures."""

    seen_from: str
    seen: str
    q: Array
    """(n, n_joints)."""

    def slopes(self, estimate: Estimate) -> PoseDerivatives:
        """Pose (n, 4, 4) and its derivatives by the estimate's variables and by the joints."""
        return relative_pose_derivatives(
            estimate.reference, estimate.variables, estimate.x, self.q, self.seen_from, self.seen
        )

    def between(self, one: Estimate, other: Estimate) -> float:
        """95 % of the distances between the places that two estimates say, m."""
        a, b = (relative_pose(e.body, self.q, self.seen_from, self.seen) for e in (one, other))
        return length_95(a[:, :3, 3] - b[:, :3, 3])

    @cached_property
    def pair(self) -> tuple[str, str]:
        """Both frames."""
        return self.seen_from, self.seen


def targets(senses: Sequence[Sense], seed: int, pairs: Sequence[tuple[str, str]]) -> list[Target]:
    """A target for each pair of frames, over the box of readings that the senses recorded.

    Args:
        senses: what was seen.
        seed: of the postures.
        pairs: of frames that matter.
    """
    q = np.concatenate([sense.q for sense in senses])
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(q.min(axis=0), q.max(axis=0), size=(POSTURES, q.shape[1]))
    return [Target(a, b, drawn) for a, b in dict.fromkeys(pairs)]


def length_95(vectors: Array) -> float:
    """Length below which 95 % of (n, 3) vectors stay."""
    return float(np.quantile(np.linalg.norm(vectors, axis=-1), 0.95)) if len(vectors) else 0.0
