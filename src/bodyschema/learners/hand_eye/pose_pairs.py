"""Pose pairs: A_i X = Y B_i for full poses, refined with the noise's own shape.

A_i is known from the robot, B_i was seen, X and Y are the two transforms that nobody measured. With
the prediction P_i = Y^-1 A_i X and a scale s (1 unless the camera is monocular), the residual is

    r_i = ( p(B_i) - s p(P_i),  log(R(B_i) R(P_i)^T) )                     position m, rotation rad

or the same with both B_i and P_i inverted: a camera's noise is simplest in the camera's own frame,
and nobody says at which end of B that frame is. The likelihood decides.

X and Y move by twists in their own frames, X <- X exp(d_X), so P <- exp(-d_Y) P exp(d_X). Noise is
a mixture: a share 1 - e of the pairs is Gaussian with any covariance S, the share e is as wide as
everything that was seen (W). Expectation-maximisation alternates

    w_i = (1 - e) N(r_i; 0, S) / ((1 - e) N(r_i; 0, S) + e N(r_i; 0, W))
    H = sum w_i J_i^T S^-1 J_i,    d = -(H + Q)^-1 (sum w_i J_i^T S^-1 r_i + prior)
    S = sum w_i r_i r_i^T / (sum w_i - p / 6),     e = 1 - sum w_i / n

S is drawn towards equal axes by the weight of `SHRINKAGE` samples. Q is a weak prior: the
translation of X is about `REACH`, so that what no motion shows stays of the size of a robot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie

Array = NDArray[np.float64]

REACH = 0.5
"""m: how far an eye may be from the hand that carries it."""

SHRINKAGE = 10.0
ROUNDS = 60
LARGEST_TURN = 0.3
"""rad a step."""

FEWEST_INLIERS = 8
SETTLED = 1e-3
"""Share of its own uncertainty that the last step may move."""

TINY = np.diag([1e-18] * 6)


@dataclass(frozen=True)
class PairFit:
    """One fit of X, Y and the noise to pose pairs."""

    X: Array
    """(4, 4)."""
    Y: Array
    """(4, 4)."""
    scale: float
    inverted: bool
    """Whether the residual is that of B^-1."""
    noise: Array
    """(6, 6) S, covariance of the residual of a good pair."""
    outliers: float
    """e, share of bad pairs."""
    weights: Array
    """(n,) w, probability of each pair to be good."""
    information: Array
    """(p, p) H: six of X, six of Y, and with a free scale its logarithm."""
    likelihood: float
    """Logarithm of the likelihood of all residuals."""


def residual(A: Array, B: Array, fit: PairFit) -> tuple[Array, Array]:
    """r (n, 6), and the predicted pose that it was taken against (n, 4, 4)."""
    P = lie.inverse(fit.Y) @ A @ fit.X
    T = B
    if fit.inverted:
        T, P = lie.inverse(B), lie.inverse(P)
    position = T[:, :3, 3] - fit.scale * P[:, :3, 3]
    turned = lie.log_so3(T[:, :3, :3] @ np.swapaxes(P[:, :3, :3], 1, 2))
    return np.concatenate([position, turned], axis=1), P


def jacobian(P: Array, fit: PairFit, free_scale: bool) -> Array:
    """Derivative of the residual with respect to (d_X, d_Y, log s), (n, 6, 12 or 13).

    Rotations are differentiated at small residuals, where log is the identity.
    """
    R, p = P[:, :3, :3], P[:, :3, 3]
    inside, outside = np.zeros((len(P), 6, 6)), np.zeros((len(P), 6, 6))
    inside[:, :3, :3] = inside[:, 3:, 3:] = R
    outside[:, :3, :3] = outside[:, 3:, 3:] = np.eye(3)
    outside[:, :3, 3:] = -lie.skew(p)
    by_X, by_Y = (outside, -inside) if fit.inverted else (-inside, outside)
    J = np.concatenate([by_X, by_Y], axis=2)
    J[:, :3] *= fit.scale
    if not free_scale:
        return J
    by_scale = np.zeros((len(P), 6, 1))
    by_scale[:, :3, 0] = -fit.scale * p
    return np.concatenate([J, by_scale], axis=2)


def refine(A: Array, B: Array, X: Array, Y: Array, inverted: bool, free_scale: bool) -> PairFit:
    """The likeliest fit near a start.

    Args:
        A: (n, 4, 4) poses known from the robot.
        B: (n, 4, 4) poses seen.
        X: (4, 4) start.
        Y: (4, 4) start.
        inverted: take the residual of B^-1.
        free_scale: the translations of B have one unknown scale.
    """
    size = 13 if free_scale else 12
    fit = PairFit(
        X, Y, 1.0, inverted, np.eye(6), 0.1, np.ones(len(A)), np.zeros((size, size)), -np.inf
    )
    r, P = residual(A, B, fit)
    wide = _isotropic(4 * np.cov(r.T, bias=True) + np.diag([1e-4] * 3 + [1e-3] * 3))
    fit = replace(fit, noise=_typical(r))
    for _ in range(ROUNDS):
        L = np.linalg.cholesky(fit.noise)
        J = np.linalg.solve(L, jacobian(P, fit, free_scale))
        z = np.linalg.solve(L, r.T).T
        w, likelihood = _weigh(r, fit, wide)
        H = np.einsum("n,nij,nik->jk", w, J, J)
        step = _step(H, np.einsum("n,nij,ni->j", w, J, z), fit)
        fit = _moved(replace(fit, weights=w, information=H, likelihood=likelihood), step)
        r, P = residual(A, B, fit)
        if w.sum() < FEWEST_INLIERS * min(1.0, len(A) / 12):
            return replace(fit, likelihood=-np.inf)
        freedom = max(w.sum() - size / 6, 1.0)
        S = np.einsum("n,ni,nj->ij", w, r, r) / freedom
        share = SHRINKAGE / (freedom + SHRINKAGE)
        noise = (1 - share) * S + share * _isotropic(S) + TINY
        fit = replace(fit, noise=noise, outliers=float(np.clip(1 - w.mean(), 1e-3, 0.7)))
        if float(step @ H @ step) < SETTLED**2 * size:
            break
    return fit


def _weigh(r: Array, fit: PairFit, wide: Array) -> tuple[Array, float]:
    good = np.log1p(-fit.outliers) + _log_normal(r, fit.noise)
    bad = np.log(fit.outliers) + _log_normal(r, wide)
    both = np.logaddexp(good, bad)
    return np.asarray(np.exp(good - both)), float(both.sum())


def _step(H: Array, g: Array, fit: PairFit) -> Array:
    """Gauss-Newton step under the weak prior on the translation of X."""
    Q, pull = np.zeros_like(H), np.zeros(len(H))
    Q[:3, :3] = np.eye(3) / REACH**2
    pull[:3] = fit.X[:3, :3].T @ fit.X[:3, 3] / REACH**2
    step = -np.linalg.solve(H + Q + 1e-9 * np.diag(np.diag(H)), g + pull)
    turn = max(float(np.linalg.norm(step[3:6])), float(np.linalg.norm(step[9:12])))
    return np.asarray(step * min(1.0, LARGEST_TURN / max(turn, 1e-300)))


def _moved(fit: PairFit, step: Array) -> PairFit:
    X = fit.X @ lie.transform(lie.exp_so3(step[3:6]), step[:3])
    Y = fit.Y @ lie.transform(lie.exp_so3(step[9:12]), step[6:9])
    scale = fit.scale * float(np.exp(np.clip(step[12], -0.5, 0.5))) if len(step) > 12 else 1.0
    return replace(fit, X=X, Y=Y, scale=scale)


def _typical(r: Array) -> Array:
    """First S, from the best 30 % of the pairs (for unit noise |r|^2 < 1.424 so often)."""
    position = np.quantile(np.sum(r[:, :3] ** 2, axis=1), 0.3) / 1.424
    turned = np.quantile(np.sum(r[:, 3:] ** 2, axis=1), 0.3) / 1.424
    return np.diag([position] * 3 + [turned] * 3) + TINY


def _isotropic(S: Array) -> Array:
    """The same size without preferred axes."""
    position, turned = np.trace(S[:3, :3]) / 3, np.trace(S[3:, 3:]) / 3
    return np.asarray(np.diag([position] * 3 + [turned] * 3))


def _log_normal(r: Array, S: Array) -> Array:
    L = np.linalg.cholesky(S)
    z = np.linalg.solve(L, r.T)
    constant = np.log(np.diag(L)).sum() + 3 * np.log(2 * np.pi)
    return np.asarray(-0.5 * np.sum(z**2, axis=0) - constant)
