"""A coordination that is linear in its unknowns, kept as one small matrix; the published learner.

Every sample gives M rows A_t with A_t x = 0 for the unknown x in R^N (Nabeshima and Kuniyoshi,
"A method for sustainable coordination", Eq. 1). All samples together are one N x N matrix,

    C = 1/n sum A_t^T A_t,     S(x) = x^T C x,                                             (Eq. 3)

and the unit vector with the smallest S is the eigenvector v of C's smallest eigenvalue lambda_N
(Eq. 7-12). Where nine entries of x are a rotation's columns, with X the 3 x 3 matrix of those of v,

    R = U diag(1, 1, det U V^T) V^T,  X = U S V^T     the nearest rotation                 (Eq. 18)
    a = gamma^T x / x^T x,            gamma = vec R   the scale                            (Eq. 21)
    SSD = |a R^T X - 1|^2                             how far X is from a rotation.

Identification stops when lambda_N and SSD are small enough; from then on |A_t x|^2 is watched, and
ten samples in a row above 100 lambda_N throw C away and start anew. Where the print leaves a choice
both readings are settings: the scale of x (by Eq. 21, or so that its last entry is 1) and the limit
(100 lambda_N as printed, or 100 a^2 lambda_N, which has the unit of what it is compared with).

This is the paper's method as it stands. Noise in the rows biases it, and its stop rule holds when
the rotation is still 10 degrees off; `hand_eye.points` is what we use.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.learner import in_turn
from bodyschema.lie import nearest_rotation
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]


@kernel
def add_rows(C: Array, A: Array) -> Array:
    """C + A^T A for (N, N) and (M, N); a new array."""
    out = C.copy()
    rows, size = A.shape
    for m in range(rows):
        for i in range(size):
            a = A[m, i]
            if a != 0.0:
                for j in range(size):
                    out[i, j] += a * A[m, j]
    return out


@dataclass(frozen=True)
class Moments:
    """All samples so far: fixed size, whatever their number."""

    total: Array
    """(N, N) sum of A^T A."""
    count: int = 0

    @classmethod
    def empty(cls, unknowns: int) -> Moments:
        """Of no sample."""
        return cls(np.zeros((unknowns, unknowns)))

    def add(self, A: Array) -> Moments:
        """With the rows (M, N) of one more sample."""
        return Moments(add_rows(self.total, A), self.count + 1)

    @property
    def mean(self) -> Array:
        """(N, N) C of the module's text."""
        return self.total / max(self.count, 1)


@dataclass(frozen=True)
class Direction:
    """What the matrix says about x, converged or not."""

    x: Array
    """(N,) scaled."""
    squares: Array
    """(N,) mean squared residual along each eigenvector of C, smallest first."""
    scale: float
    """a: x = a v with |v| = 1."""
    closeness: float
    """SSD; 0 without a rotation among the unknowns, inf where v mirrors."""
    rotation: Array
    """(3, 3) nearest to x's nine entries; identity without."""


@dataclass(frozen=True)
class Relation:
    """State of the published learner."""

    moments: Moments
    x: Array | None = None
    """(N,) while observing; None while identifying."""
    limit: float = np.inf
    """What |A x|^2 may be while observing."""
    above: int = 0
    """Samples in a row above the limit."""


@dataclass(frozen=True)
class Look:
    """What one sample was worth."""

    direction: Direction | None
    """While identifying."""
    error: float = np.nan
    """|A x|^2 while observing."""
    event: Literal["", "identified", "changed"] = ""


@dataclass(frozen=True)
class PaperRelation:
    """The published identify-and-observe learner, for any rows."""

    unknowns: int
    """N."""
    rotation: bool = True
    """Whether x begins with the nine entries of a rotation, column after column."""
    scale: Literal["rotation", "last"] = "rotation"
    """Eq. 21, or the last entry is 1."""
    limit: Literal["literal", "consistent"] = "literal"
    """100 lambda_N, or 100 a^2 lambda_N."""
    smallest: float = 5e-5
    """lambda_N must be below it, in the unit of the rows squared."""
    closest: float = 0.1
    """SSD must be below it."""
    patience: int = 10
    """Samples in a row above the limit that make a change."""
    every: int = field(default=1, kw_only=True)
    """Samples between two decompositions while identifying."""

    def start(self) -> Relation:
        """Nothing seen yet."""
        return Relation(Moments.empty(self.unknowns))

    def step(self, state: Relation, moment: tuple[Array, ...]) -> tuple[Relation, tuple[Look, ...]]:
        """The state after the rows (M, N) of one moment."""
        return in_turn(self._look, state, moment)

    def _look(self, state: Relation, A: Array) -> tuple[Relation, Look]:
        if state.x is None:
            return self._identify(state, A)
        return self._observe(state, state.x, A)

    def _identify(self, state: Relation, A: Array) -> tuple[Relation, Look]:
        moments = state.moments.add(A)
        if moments.count % self.every:
            return Relation(moments), Look(None)
        found = self.solve(moments)
        if found.squares[0] >= self.smallest or found.closeness >= self.closest:
            return Relation(moments), Look(found)
        unit = found.scale**2 if self.limit == "consistent" else 1.0
        limit = 100 * unit * float(found.squares[0])
        return Relation(moments, found.x, limit), Look(found, event="identified")

    def _observe(self, state: Relation, x: Array, A: Array) -> tuple[Relation, Look]:
        error = float(np.sum((A @ x) ** 2))
        above = state.above + 1 if error > state.limit else 0
        if above >= self.patience:
            return self.start(), Look(None, error, "changed")
        return replace(state, above=above), Look(None, error)

    def solve(self, moments: Moments) -> Direction:
        """The smallest direction of the matrix, scaled, with its reliability."""
        squares, vectors = np.linalg.eigh(moments.mean)
        v, squares = vectors[:, 0], np.maximum(squares, 0.0)
        if v[-1] < 0:
            v = -v
        if not self.rotation:
            scale = 1 / v[-1] if v[-1] else np.inf
            return Direction(scale * v, squares, scale, 0.0, np.eye(3))
        X = v[:9].reshape(3, 3).T
        R = nearest_rotation(X)
        a = float(np.sum(R * X) / max(float(np.sum(X * X)), 1e-300))
        mirrored = np.linalg.det(X) <= 0
        closeness = np.inf if mirrored else float(np.sum((a * R.T @ X - np.eye(3)) ** 2))
        scale = a if self.scale == "rotation" or not v[-1] else 1 / float(v[-1])
        return Direction(scale * v, squares, scale, closeness, R)
