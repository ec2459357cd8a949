"""Pose pairs: A_i X = Y B_i for full poses, refined with the noise's own shape.

A_i is known from the robot, B_i was seen, X and Y are the two transforms that nobody measured. With
the prediction P_i = Y^-1 A_i X and a scale s (1 unless the camera is monocular), the residual is

    r_i = ( p(B_i) - s p(P_i),  log(R(B_i) R(P_i)^T) )                     position m, rotation rad

or the same with both B_i and P_i inverted: a camera's noise is simplest in the camera's own frame,
and nobody says at which end of B that frame is. The likelihood decides.

X and Y move by twists in their own frames, X <- X exp(d_X), so P <- exp(-d_Y) P exp(d_X). A lag
makes A a function of it: a hand that moves by the twist xi in its own frame moves P as X does by

    X^-1 exp(xi) X = exp(Ad xi),    Ad xi = (R_X^T (v + w x p_X),  R_X^T w)

so its column is that of d_X times Ad xi, and lag and frames are fitted in one. Noise is a mixture:
a share 1 - e of the pairs is Gaussian with any covariance S, the share e is as wide as everything
that was seen (W). Expectation-maximisation alternates

    w_i = (1 - e) N(r_i; 0, S) / ((1 - e) N(r_i; 0, S) + e N(r_i; 0, W))
    H = sum w_i J_i^T S^-1 J_i,    d = -(H + Q)^-1 (sum w_i J_i^T S^-1 r_i + prior)
    S = sum w_i r_i r_i^T / (sum w_i - p / 6),     e = 1 - sum w_i / n

where each w_i is multiplied by what the pair is worth (`worth`): frames of one posture share what
the eye gets wrong there. With rho the correlation that the residuals show, m frames are worth as
much as m / (1 + (m - 1) rho) that are independent.

With fewer than `JUDGED` pairs e is 0: nothing could tell which of them is the bad one, and the few
that are left explain themselves. S is drawn towards equal axes by the weight of `SHRINKAGE`
samples, and the levels of positions and rotations towards each other by that of `TIED`: with three
pairs, turned a little, all positions could be explained to nothing. Q is a weak prior: the
translation of X is about `REACH`, so that what no motion shows stays of the size of a robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie

Array = NDArray[np.float64]
Moving = Callable[[float], tuple[Array, Array]]
"""Poses (n, 4, 4) of the hand at a lag (s), and their twists a second in its own frame, (n, 6)."""

REACH = 0.5
"""m: how far an eye may be from the hand that carries it."""

SHRINKAGE = 10.0
TIED, LEVER = 4.0, 0.5
"""Samples by whose weight the level of positions is drawn towards a rotation's at a lever, as a
share of the spread of positions: an eye that turns by so much errs there by as much."""

ROUNDS = 60
LARGEST_TURN = 0.3
"""rad a step."""

LARGEST_DELAY = 0.2
"""s a step."""

FEWEST_INLIERS = 8
JUDGED = 6
"""Pairs from which one of them may be called bad."""

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
    """(p, p) H: six of X, six of Y, with a free scale its logarithm, with streams the lag."""
    likelihood: float
    """Logarithm of the likelihood of all residuals."""
    lag: float = 0.0
    """s; stays where it is unless the hand is `Moving`."""


def residual(A: Array, B: Array, fit: PairFit) -> tuple[Array, Array]:
    """r (n, 6), and the predicted pose that it was taken against (n, 4, 4)."""
    P = lie.inverse(fit.Y) @ A @ fit.X
    T = B
    if fit.inverted:
        T, P = lie.inverse(B), lie.inverse(P)
    position = T[:, :3, 3] - fit.scale * P[:, :3, 3]
    turned = lie.log_so3(T[:, :3, :3] @ np.swapaxes(P[:, :3, :3], 1, 2))
    return np.concatenate([position, turned], axis=1), P


def jacobian(P: Array, fit: PairFit, free_scale: bool, twists: Array | None = None) -> Array:
    """Derivative of the residual with respect to (d_X, d_Y, log s, lag), (n, 6, 12 to 14).

    Rotations are differentiated at small residuals, where log is the identity.

    Args:
        P: (n, 4, 4) that the residual was taken against.
        fit: where.
        free_scale: with a column for the scale.
        twists: (n, 6) of the hand a second, for a column of the lag.
    """
    R, p = P[:, :3, :3], P[:, :3, 3]
    inside, outside = np.zeros((len(P), 6, 6)), np.zeros((len(P), 6, 6))
    inside[:, :3, :3] = inside[:, 3:, 3:] = R
    outside[:, :3, :3] = outside[:, 3:, 3:] = np.eye(3)
    outside[:, :3, 3:] = -lie.skew(p)
    by_X, by_Y = (outside, -inside) if fit.inverted else (-inside, outside)
    J = np.concatenate([by_X, by_Y], axis=2)
    J[:, :3] *= fit.scale
    columns = [J]
    if free_scale:
        by_scale = np.zeros((len(P), 6, 1))
        by_scale[:, :3, 0] = -fit.scale * p
        columns.append(by_scale)
    if twists is not None:
        columns.append(J[:, :, :6] @ carried(twists, fit.X)[..., None])
    return np.concatenate(columns, axis=2)


def carried(twists: Array, X: Array) -> Array:
    """Twists (n, 6) of a hand as twists in the own frame of what sits on it at X."""
    v, w = twists[:, :3], twists[:, 3:]
    return np.hstack([(v + np.cross(w, X[:3, 3])) @ X[:3, :3], w @ X[:3, :3]])


def refine(
    A: Array,
    B: Array,
    X: Array,
    Y: Array,
    inverted: bool,
    free_scale: bool,
    moving: Moving | None = None,
    lag: float = 0.0,
    worth: Array | None = None,
) -> PairFit:
    """The likeliest fit near a start.

    Args:
        A: (n, 4, 4) poses known from the robot.
        B: (n, 4, 4) poses seen.
        X: (4, 4) start.
        Y: (4, 4) start.
        inverted: take the residual of B^-1.
        free_scale: the translations of B have one unknown scale.
        moving: A at any lag, which then is fitted too; None for pairs.
        lag: s, start.
        worth: (n,) of each pair, in independent ones; 1 when None.
    """
    u = np.ones(len(A)) if worth is None else worth
    size = 12 + free_scale + (moving is not None)
    share = 0.1 if len(A) >= JUDGED else 0.0
    empty = np.zeros((size, size))
    fit = PairFit(X, Y, 1.0, inverted, np.eye(6), share, np.ones(len(A)), empty, -np.inf, lag)
    twists = None if moving is None else moving(lag)[1]
    r, P = residual(A, B, fit)
    wide = _isotropic(4 * np.cov(r.T, bias=True) + np.diag([1e-4] * 3 + [1e-3] * 3))
    fit = replace(fit, noise=_typical(r))
    lever = LEVER * max(float(np.sqrt(np.trace(np.cov(P[:, :3, 3].T, bias=True)))), 1e-6)
    for _ in range(ROUNDS):
        L = np.linalg.cholesky(fit.noise)
        J = np.linalg.solve(L, jacobian(P, fit, free_scale, twists))
        z = np.linalg.solve(L, r.T).T
        w, likelihood = _weigh(r, fit, wide, u)
        H = np.einsum("n,nij,nik->jk", u * w, J, J)
        step = _step(H, np.einsum("n,nij,ni->j", u * w, J, z), fit)
        fit = replace(fit, weights=w, information=H, likelihood=likelihood)
        fit = _moved(fit, step, free_scale, moving is not None)
        if moving is not None:
            A, twists = moving(fit.lag)
        r, P = residual(A, B, fit)
        if w.sum() < _fewest(len(A)):
            return replace(fit, likelihood=-np.inf)
        freedom = max(float(u @ w) - size / 6, 1.0)
        S = np.einsum("n,ni,nj->ij", u * w, r, r) / freedom
        share = SHRINKAGE / (freedom + SHRINKAGE)
        noise = _tied((1 - share) * S + share * _isotropic(S), freedom, lever) + TINY
        bad = float(np.clip(1 - w.mean(), 1e-3, 0.7)) if len(A) >= JUDGED else 0.0
        fit = replace(fit, noise=noise, outliers=bad)
        if float(step @ H @ step) < SETTLED**2 * size:
            break
    return fit


def _fewest(n: int) -> float:
    """Good pairs that n must leave: as few as two explain themselves."""
    return max(FEWEST_INLIERS * min(1.0, n / 12), min(n, JUDGED) - 1.0)


def worth(r: Array, weights: Array, posture: NDArray[np.int64]) -> Array:
    """What each pair is worth beside the others of its posture, (n,), between 1 / m and 1.

    Within a posture X and Y do not matter, so what differs there is noise alone; what is left over
    all, less the share that X and Y took of the postures, is noise and what is shared.

    Args:
        r: (n, 6) residuals.
        weights: (n,) probability to be good.
        posture: (n,) number of the posture, from 0.
    """
    good = weights > 0.5
    count = np.bincount(posture[good], minlength=int(posture.max()) + 1)
    many, n, groups = int(np.sum(np.maximum(count - 1, 0))), int(good.sum()), int(np.sum(count > 0))
    if not many or groups < 3:
        return np.asarray(1.0 / np.maximum(count, 1)[posture])
    mean = np.zeros((len(count), 6))
    np.add.at(mean, posture[good], r[good])
    mean /= np.maximum(count, 1)[:, None]
    within = np.sum((r[good] - mean[posture[good]]) ** 2, axis=0) / many
    # Twelve numbers of six a posture are taken by X and Y.
    total = np.sum(r[good] ** 2, axis=0) / (n * max(1 - 2 / groups, 1 / groups))
    rho = float(np.clip(1 - np.median(within / np.maximum(total, 1e-300)), 0.0, 1.0))
    return np.asarray(1 / (1 + (np.maximum(count, 1)[posture] - 1) * rho))


def _weigh(r: Array, fit: PairFit, wide: Array, u: Array) -> tuple[Array, float]:
    good = np.log1p(-fit.outliers) + _log_normal(r, fit.noise)
    if not fit.outliers:
        return np.ones(len(r)), float(u @ good)
    bad = np.log(fit.outliers) + _log_normal(r, wide)
    both = np.logaddexp(good, bad)
    return np.asarray(np.exp(good - both)), float(u @ both)


def _step(H: Array, g: Array, fit: PairFit) -> Array:
    """Gauss-Newton step under the weak prior on the translation of X."""
    Q, pull = np.zeros_like(H), np.zeros(len(H))
    Q[:3, :3] = np.eye(3) / REACH**2
    pull[:3] = fit.X[:3, :3].T @ fit.X[:3, 3] / REACH**2
    step = -np.linalg.solve(H + Q + 1e-9 * np.diag(np.diag(H)), g + pull)
    turn = max(float(np.linalg.norm(step[3:6])), float(np.linalg.norm(step[9:12])))
    return np.asarray(step * min(1.0, LARGEST_TURN / max(turn, 1e-300)))


def _moved(fit: PairFit, step: Array, free_scale: bool, late: bool) -> PairFit:
    X = fit.X @ lie.transform(lie.exp_so3(step[3:6]), step[:3])
    Y = fit.Y @ lie.transform(lie.exp_so3(step[9:12]), step[6:9])
    scale = fit.scale * float(np.exp(np.clip(step[12], -0.5, 0.5))) if free_scale else 1.0
    lag = fit.lag + (float(np.clip(step[-1], -LARGEST_DELAY, LARGEST_DELAY)) if late else 0.0)
    return replace(fit, X=X, Y=Y, scale=scale, lag=lag)


def _typical(r: Array) -> Array:
    """First S, from the best 30 % of the pairs (for unit noise |r|^2 < 1.424 so often)."""
    position = np.quantile(np.sum(r[:, :3] ** 2, axis=1), 0.3) / 1.424
    turned = np.quantile(np.sum(r[:, 3:] ** 2, axis=1), 0.3) / 1.424
    return np.diag([position] * 3 + [turned] * 3) + TINY


def _isotropic(S: Array) -> Array:
    """The same size without preferred axes."""
    position, turned = np.trace(S[:3, :3]) / 3, np.trace(S[3:, 3:]) / 3
    return np.asarray(np.diag([position] * 3 + [turned] * 3))


def _tied(S: Array, freedom: float, lever: float) -> Array:
    """S with the levels of positions and rotations drawn towards each other at a lever, m."""
    share = TIED / (freedom + TIED)
    levels = np.maximum([np.trace(S[:3, :3]) / lever**2, np.trace(S[3:, 3:])], 1e-18)
    drawn = (1 - share) * levels + share * np.sqrt(levels.prod())
    by = np.repeat(np.sqrt(drawn / levels), 3)
    return np.asarray(S * np.outer(by, by))


def _log_normal(r: Array, S: Array) -> Array:
    L = np.linalg.cholesky(S)
    z = np.linalg.solve(L, r.T)
    constant = np.log(np.diag(L)).sum() + 3 * np.log(2 * np.pi)
    return np.asarray(-0.5 * np.sum(z**2, axis=0) - constant)
