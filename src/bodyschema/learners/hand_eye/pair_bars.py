"""How far a fit of pose pairs may be off: kappa, and how many pairs there really are.

The fit takes what is left over to be independent noise. What hangs together (frames of one posture,
a stretch of time, postures near one another) tells less, and what is thought of the noise of a few
pairs comes from themselves. So the covariance is kappa C, see `estimation.pulls`, for the largest
kappa over pairs, postures (also left out one by one), stretches of time and neighbourhoods of
postures, never below 1.

G postures leave 3 (G - 2) degrees of freedom each to the noise of positions and of rotations, of
which their ratio takes half a posture's: with a noise that is learned from so few, lengths are
those of an F distribution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation import pulls
from bodyschema.learners.hand_eye.pose_pairs import PairFit, jacobian, residual

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SAME = 1e-3
"""rad and m: poses of a hand that are no farther apart are one posture; encoders jitter by a tenth
of it, and a hand that is moved on purpose goes farther."""

STRETCHES = 10
"""Of time, and neighbourhoods of postures."""

ARM = 0.3
"""m: length that turns a rotation into a distance where poses are compared."""


@dataclass(frozen=True)
class Linear:
    """A fit of pairs as the linear problem that it is near its end."""

    z: Array
    """(n, 6) whitened and weighted residuals."""
    J: Array
    """(n, 6, p) their slopes."""
    prior: Array
    """(p, p) information of the prior."""
    posture: Ints
    """(n,) number of the posture of each pair, from 0."""
    A: Array
    """(n, 4, 4) poses of the hand."""
    row: Ints
    """(n,) place of each pair in the lists that were given; copies are left out."""
    weights: Array
    """(n,) of each pair: probability to be good times what it is worth."""
    noise: Array
    """(6, 6) S."""

    @property
    def place(self) -> Array:
        """(n, 6) of the hand: position, m, and rotation vector times an arm's length."""
        turn = lie.log_so3(self.A[0, :3, :3].T @ self.A[:, :3, :3])
        return np.hstack([self.A[:, :3, 3], ARM * turn])

    def whitened(self, effect: Array) -> Array:
        """An effect on the residuals, (n, 6, k), as the rows of J are."""
        L = np.linalg.cholesky(self.noise)
        return np.asarray(np.linalg.solve(L, effect) * np.sqrt(self.weights)[:, None, None])

    @property
    def covariance(self) -> Array:
        """C, (p, p)."""
        H = np.einsum("nij,nik->jk", self.J, self.J) + self.prior
        scale = 1 / np.sqrt(np.diag(H))
        C = np.linalg.inv(H * np.outer(scale, scale)) * np.outer(scale, scale)
        return np.asarray((C + C.T) / 2)


def linear(
    A: Array,
    B: Array,
    fit: PairFit,
    free_scale: bool,
    twists: Array | None,
    prior: Array,
    worth: Array | None = None,
) -> Linear:
    """Pairs in the order of their rows, round their fit; arguments as in `pose_pairs`."""
    r, P = residual(A, B, fit)
    L = np.linalg.cholesky(fit.noise)
    weights = fit.weights * (1.0 if worth is None else worth)
    root = np.sqrt(weights)[:, None]
    z = np.linalg.solve(L, r.T).T * root
    J = np.linalg.solve(L, jacobian(P, fit, free_scale, twists)) * root[..., None]
    return Linear(z, J, prior, postures(A), A, np.arange(len(A)), weights, fit.noise)


def postures(A: Array, same: float = SAME) -> Ints:
    """Number of the posture of each pose of the hand (n, 4, 4), from 0 in order of their rows."""
    label = np.full(len(A), -1, dtype=np.int64)
    # Rotations that are an angle t apart differ by sqrt(8) sin(t / 2), and no entry by more.
    flat = np.hstack([A[:, :3, 3], A[:, :3, :3].reshape(-1, 9) / np.sqrt(2)])
    left, count = np.arange(len(A)), 0
    while len(left):
        d = np.abs(flat[left] - flat[left[0]])
        same_one = (d[:, :3].max(axis=1) <= same) & (np.linalg.norm(d[:, 3:], axis=1) <= same)
        label[left[same_one]] = count
        left, count = left[~same_one], count + 1
    return label


def kappa(problem: Linear, wanted: Array) -> float:
    """By how much the variance of what is wanted exceeds that of the fit, 1 or more.

    Args:
        problem: the fit.
        wanted: (d, p) P.
    """
    n = len(problem.z)
    rows, stretches = np.arange(n), np.arange(n) * STRETCHES // n
    cuts = [(rows, 0.5), (problem.posture, 0.5), (problem.posture, 1.0)]
    if n > 2 * STRETCHES:
        cuts += [(stretches, 0.5), (neighbourhoods(problem.place), 0.5)]
    root: Array = np.linalg.cholesky(problem.covariance).astype(np.float64)
    B, z = problem.J.reshape(-1, len(root)) @ root, problem.z.ravel()
    owners = [(np.repeat(cluster, problem.z.shape[1]), power) for cluster, power in cuts]
    pulled = [pulls.pulls(B, z, owner, root, power) for owner, power in owners]
    precision = np.diag(problem.prior)
    return max(1.0, *(pulls.kappa(wanted, pull, root, precision) for pull in pulled))


def neighbourhoods(place: Array, count: int = STRETCHES) -> Ints:
    """Clusters of near places (n, d), (n,): farthest seeds first, then the nearest seed."""
    away = np.linalg.norm(place - np.median(place, axis=0), axis=1)
    seeds = [int(np.argmax(away))]
    near = np.linalg.norm(place - place[seeds[0]], axis=1)
    while len(seeds) < min(count, len(place)):
        seeds.append(int(np.argmax(near)))
        near = np.minimum(near, np.linalg.norm(place - place[seeds[-1]], axis=1))
    apart = np.linalg.norm(place[:, None] - place[seeds], axis=2)
    return np.asarray(np.argmin(apart, axis=1))


def freedom(weights: Array, posture: Ints) -> float:
    """Degrees of freedom of the noise: good postures, less what two frames take of them.

    Args:
        weights: (n,) probability of each pair to be good.
        posture: (n,) of each pair.
    """
    good = np.zeros(int(posture.max(initial=-1)) + 1)
    np.maximum.at(good, posture, weights)
    return max(3.0 * (float(good.sum()) - 2.5), 1.0)
