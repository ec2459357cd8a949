"""A seen point that is fixed to a link: R_i y + t_i = X p_i, with X or y or both unknown.

R_i, t_i is the robot's own kinematics, y the point on its link, X places the frame that it is seen
from, p_i is the point as seen. Under weights w, of sum 1, each of the two is a closed form of the
other (Kabsch 1976 for X; a mean for y),

    M = sum w (R_i y + t_i)(p_i - p)^T      R_X = nearest rotation to M,  t_X = R y + t - R_X p
    y = sum w R_i^T (X p_i - t_i)

R, t, p without an index being means. Both are linear in sums that know neither X nor y, so that
after one pass over the samples every turn costs the same, however many samples there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointSums:
    """Weighted means over the samples; R_ab stands for entries of R_i."""

    R: Array
    """(3, 3) mean R_i."""
    t: Array
    """(3,) mean t_i."""
    p: Array
    """(3,) mean p_i."""
    turned: Array
    """(3,) mean R_i^T t_i."""
    with_place: Array
    """(3, 3) mean t_i p_i^T."""
    with_turn: Array
    """(9, 3) mean R_ab p_c, rows a, c and columns b."""

    @classmethod
    def of(cls, K: Array, p: Array, weights: Array) -> Self:
        """One pass over the samples.

        Args:
            K: (n, 4, 4) R_i, t_i.
            p: (n, 3) points as seen.
            weights: (n,).
        """
        w = weights / weights.sum()
        R, t = K[:, :3, :3], K[:, :3, 3]
        weighted = w[:, None] * p
        return cls(
            R=np.tensordot(w, R, 1),
            t=w @ t,
            p=w @ p,
            turned=np.einsum("n,nab,na->b", w, R, t),
            with_place=t.T @ weighted,
            with_turn=np.tensordot(R, weighted, (0, 0)).transpose(0, 2, 1).reshape(9, 3),
        )

    def frame(self, y: Array) -> tuple[Array, Array]:
        """R_X, (3, 3), and t_X, (3,), for a point y, (3,), on its link."""
        there = self.R @ y + self.t
        M = (self.with_turn @ y).reshape(3, 3) + self.with_place - np.outer(there, self.p)
        R_X = lie.nearest_rotation(M)
        return R_X, there - R_X @ self.p

    def point(self, R_X: Array, t_X: Array) -> Array:
        """y, (3,), for the frame that R_X and t_X place."""
        return np.asarray(R_X.ravel() @ self.with_turn + t_X @ self.R - self.turned)
