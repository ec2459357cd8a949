"""How the cells' flow follows from the joints' motion: Bayesian regression in closed form.

Between two frames the joints turn by x (J,) and a cell that shows the body moves by

    y = K x + noise,    K (2, J) pixels/rad, the visual Jacobian of the cell,

for x taken at the right time: each candidate lag l has its own x and its own belief about K. With
the prior K ~ N(0, s^2 E) and noise in units of the least that flow can have, the belief after some
frames is held in the sums

    A = E / s^2 + sum x x^T (J, J),   B = sum x y^T (J, 2),   E[K] = (A^-1 B)^T,

of which A is the same for all cells. A motion adds its own sums; between motions A and B fade
towards the prior, since the posture changes and what is held may be let go:
A <- f A + (1 - f) E / s^2, B <- f B. The energy of a motion that K explains, beyond what earlier
motions foretold, and the price of explaining it are

    e = tr(B1^T A1^-1 B1) - tr(B0^T A0^-1 B0),    price = ln det A1 - ln det A0   (two image axes),

with 0 before the motion and 1 after it. As each motion is weighed with the belief from the motions
before it, the sum over motions is a test on motions that were left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


SMOOTH = 5.0
"""Frames of flow that count as one."""
NEEDED = 3.0
"""nats of evidence that a joint has, to be named as the one that moves a cell furthest."""


@dataclass(frozen=True)
class MotionSums:
    """What is kept of frames, for L lags, J joints and N cells."""

    A: Array
    """(L, J, J)."""
    B: Array
    """(L, J, 2 N), the two image axes of a cell side by side."""
    energy: Array
    """(N,) sum of squared flow."""
    frames: float
    """Number of frames."""

    def add(self, x: Array, y: Array, keep: float = 1.0) -> MotionSums:
        """One more frame: joints' motion at each lag (L, J), flow (N, 2), in units of noise.

        `keep` below 1 lets the energy of earlier frames fade.
        """
        A = self.A + x[:, :, None] * x[:, None, :]
        B = self.B + x[:, :, None] * y.ravel()
        return MotionSums(A, B, keep * self.energy + np.sum(y * y, axis=1), keep * self.frames + 1)


def empty(lags: int, joints: int, cells: int) -> MotionSums:
    """Nothing seen."""
    A, B = np.zeros((lags, joints, joints)), np.zeros((lags, joints, 2 * cells))
    return MotionSums(A, B, np.zeros(cells), 0.0)


def faded(belief: MotionSums, keep: float) -> MotionSums:
    """The belief before the next motion."""
    return MotionSums(keep * belief.A, keep * belief.B, keep * belief.energy, keep * belief.frames)


def joined(belief: MotionSums, motion: MotionSums) -> MotionSums:
    """The belief with a motion in it."""
    return MotionSums(
        belief.A + motion.A, belief.B + motion.B, belief.energy + motion.energy,
        belief.frames + motion.frames,
    )  # fmt: skip


@dataclass(frozen=True)
class Explained:
    """What a set of joints explains of a motion at one lag."""

    energy: Array
    """(N,) e."""
    price: float
    foretold: Array
    """(N,) energy of the motion as earlier motions foretell it."""
    doubt: Array
    """(N,) what the belief's uncertainty adds to that energy: its expected error."""


def explained(
    before: MotionSums, after: MotionSums, lag: int, joints: Ints, precision: float
) -> Explained:
    """Energy explained by some joints, the others taken to move nothing.

    Args:
        before: belief without the motion, faded.
        after: the same with it.
        lag: number of the lag.
        joints: their columns.
        precision: 1 / s^2.
    """
    N, square = len(before.energy), np.ix_(joints, joints)
    if len(joints) == 0:
        return Explained(np.zeros(N), 0.0, np.zeros(N), np.zeros(N))
    prior = precision * np.eye(len(joints))
    A0, A1 = before.A[lag][square] + prior, after.A[lag][square] + prior
    B0, B1 = before.B[lag][joints], after.B[lag][joints]
    K0, K1 = np.linalg.solve(A0, B0), np.linalg.solve(A1, B1)
    energy = _by_cell(B1 * K1) - _by_cell(B0 * K0)
    moved = A1 - A0
    foretold = _by_cell(K0 * (moved @ K0))
    price = float(np.linalg.slogdet(A1)[1] - np.linalg.slogdet(A0)[1])
    spread = 2 * float(np.trace(np.linalg.solve(A0, moved)))
    return Explained(energy, price, foretold, spread * _variance(before, B0, K0))


def jacobians(belief: MotionSums, lag: int, precision: float) -> tuple[Array, Array]:
    """E[K] (N, 2, J) pixels/rad, and the covariance (J, J) of its rows in units of noise."""
    J = belief.A.shape[1]
    A = belief.A[lag] + precision * np.eye(J)
    K = np.linalg.solve(A, belief.B[lag])
    return K.reshape(J, -1, 2).transpose(1, 2, 0), np.linalg.solve(A, np.eye(J))


def joint_evidence(belief: MotionSums, lag: int, K: Array, V: Array) -> Array:
    """(J, N) nats by which each joint is needed to explain a cell: half its squared z-score.

    The noise is what K leaves of the cell's energy, at least the least noise; flow is smooth in
    time, so that SMOOTH frames count as one.
    """
    by_joint = K.transpose(2, 0, 1).reshape(K.shape[2], -1)
    variance = _variance(belief, belief.B[lag], by_joint)
    squares = np.sum(K * K, axis=1).T
    return np.asarray(squares / (2 * np.diag(V)[:, None] * variance))


def furthest(K: Array, evidence: Array) -> Ints:
    """(N,) the joint that moves each cell furthest, of those with enough evidence.

    Args:
        K: (N, 2, J) pixels/rad.
        evidence: (J, N) nats; where no joint has enough, the one with most is named.
    """
    speed = np.where(evidence > NEEDED, np.hypot(K[:, 0], K[:, 1]).T, 0.0)
    clear = speed.any(axis=0)
    return np.asarray(np.where(clear, speed.argmax(axis=0), evidence.argmax(axis=0)))


def _variance(belief: MotionSums, B: Array, K: Array) -> Array:
    """(N,) of a moment's flow: what K (J, 2 N) leaves of the energy, at least the least noise.

    Flow is smooth in time, so that SMOOTH frames count as one.
    """
    left = belief.energy - _by_cell(B * K)
    return np.asarray(SMOOTH * np.maximum(left / max(2 * belief.frames, 1.0), 1.0))


def _by_cell(products: Array) -> Array:
    """(J, 2 N) -> (N,) sums."""
    return np.asarray(products.sum(axis=0).reshape(-1, 2).sum(axis=1))
