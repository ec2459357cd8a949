"""Cameras from corners on carried things: the fit, and how sure it is.

All rows at once, Gauss-Newton with Huber's weights; what is left of a corner when its own place is
taken out is S_k, s_k (`corner_rows`). With S = sum S_k + prior the covariance is that of clusters,

    P = S^-1 (sum s_k s_k^T m/(m - 6) + sum_j v_j v_j^T + prior) S^-1

m corners, those that the last camera saw: errors of one corner go on for seconds and grow with how
far its view has turned since its birth, so that rows count for little and corners for much. v_j is
the gradient of an error of `COMMON` px that all rows of a kind may share. Corners of one moment err
alike a little; with n of them in view the variance is 1 + (n - 1) `ALIKE` times as large.

The noise of each kind of row (u, v, disparity) is learnt from the residuals. A corner whose mean
squared residual is far above the others' is not on the carrier that it is said to be on; it is left
out of the fit, and looked at again the next time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.corner_rows import (
    CornerRows,
    CornerSums,
    places,
    predicted,
    summed,
)
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

HUBER = 2.0
"""Standard deviations from which a row weighs less."""
COMMON = np.array([0.05, 0.05, 0.03])
"""px: error that all rows of u, v, and of the disparity, may have in common."""
LEVER = 0.5
"""Share of what all corners pull in some direction that one may make up."""
ALIKE = 0.02
"""Correlation between the errors of two corners at one moment."""
WILD = 20.0
"""Standard deviations that a residual counts for at most in what a corner's noise is."""
STRAY = 9.0
"""Times the median of the corners' mean squared residuals beyond which one is left out."""
LEAST_LEVEL, FIRST_LEVEL = 0.03, np.array([0.5, 0.5, 0.3])
"""px: noise of a row that is never undercut, and that of u, v, d to begin with."""
ROUNDS, SETTLED = 8, 1e-5
"""Steps at most, and the step (rad, m) below which nothing moves any more."""
FEW = 7
"""Corners below which the clusters say nothing."""


@dataclass(frozen=True)
class CameraPrior:
    """What corners that are not kept any more have told about the first camera."""

    T_world_cam: Array
    """(4, 4) round which it is meant; not where it is least, which few corners leave open."""
    S: Array
    """(6, 6) information."""
    s: Array
    """(6,) its gradient there."""
    meat: Array
    """(6, 6) sum of s_k s_k^T."""
    corners: int
    """How many."""

    def about(self, T_world_cam: Array) -> tuple[Array, Array]:
        """Information and gradient at another camera pose."""
        away = twist_between(self.T_world_cam, T_world_cam)
        return self.S, self.s - self.S @ away


@dataclass(frozen=True)
class CornerFit:
    """Cameras, and what they were told by."""

    cameras: Array
    """(C, 4, 4) T_world_cam."""
    covariance: Array
    """(6 C, 6 C) of their twists, linear before angular, each in its own frame."""
    names: Ints
    """(K,) of the corners."""
    place: Array
    """(K, 3) m, on their carriers."""
    place_covariance: Array
    """(K, 3, 3) m^2, the cameras' doubt with it."""
    good: Flags
    """(K,) whether a corner is in the fit."""
    level: Array
    """(3,) px, noise of u, v, disparity."""
    corners: int
    """How many told about the last camera, those in the prior with them."""
    misfit: float
    """px: typical residual of u and v of all rows by the last camera, whatever was left out."""
    cost: float
    """Robust, per row."""
    settled: bool
    """Whether the last step moved nothing."""


def twist_between(a: Array, b: Array) -> Array:
    """(6,) twist that moves the frame a to b, linear before angular, in a."""
    T = lie.inverse(a) @ b
    return np.concatenate([T[:3, 3], np.atleast_1d(lie.log_so3(T[:3, :3]))])


def moved(cameras: Array, twists: Array) -> Array:
    """(C, 4, 4) cameras after twists (6 C,)."""
    xi = twists.reshape(-1, 6)
    return np.asarray(cameras @ lie.transform(lie.exp_so3(xi[:, 3:]), xi[:, :3]))


def fitted(
    rows: CornerRows, cameras: Array, stereo: Stereo, prior: CameraPrior | None = None,
    level: Array = FIRST_LEVEL, rounds: int = ROUNDS,
) -> CornerFit:  # fmt: skip
    """The cameras that explain the rows best, near those given.

    Args:
        rows: where corners were seen; at least one.
        cameras: (C, 4, 4) where to begin.
        stereo: the lens.
        prior: of the first camera.
        level: (3,) px, noise of u, v, disparity to begin with.
        rounds: Gauss-Newton steps at most.
    """
    names, first, which = rows.grouped()
    size, settled = np.bincount(which), False
    place = places(rows, cameras, stereo)
    good = np.ones(len(names), dtype=bool)
    for _ in range(rounds):
        e = rows.seen - predicted(rows, cameras, place[which], stereo)[0]
        level = _level(e[good[which]], level)
        z = np.abs(e) / level
        own = _own(z, first, size)
        good = own < STRAY
        weight = _weights(z, own[which], level)
        sums = _tempered(summed(rows, cameras, place, weight, stereo), good)
        S, s = _whole(sums, good, cameras, prior)
        step = np.asarray(np.linalg.solve(S, s), dtype=np.float64)
        step *= min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-12))
        cameras = moved(cameras, step)
        place = place + sums.shift + sums.back @ step
        if np.abs(step).max() < SETTLED:
            settled = True
            break
    last = rows.camera == len(cameras) - 1
    told = np.bincount(which, last, minlength=len(names)) > 2
    counted = int((good & told).sum()) + (0 if prior is None or len(cameras) > 1 else prior.corners)
    P = _covariance(sums, good, S, prior, rows.moment, counted)
    doubt = np.full((len(place), 3, 3), np.inf)
    if np.isfinite(P).all():
        doubt = sums.spread + sums.back @ P @ np.swapaxes(sums.back, 1, 2)
    cost = float(np.where(z < HUBER, z**2, 2 * HUBER * z - HUBER**2).mean()) * float(level @ level)
    misfit = 1.4826 * float(np.median(np.abs(e[last, :2]))) if last.any() else np.inf
    return CornerFit(cameras, P, names, place, doubt, good, level, counted, misfit, cost, settled)


def absorbed(
    rows: CornerRows, fit: CornerFit, stereo: Stereo, prior: CameraPrior | None
) -> CameraPrior:
    """What rows that are given up have told about the first camera, added to what was known."""
    names, first, which = rows.grouped()
    place = places(rows, fit.cameras, stereo)
    e = rows.seen - predicted(rows, fit.cameras, place[which], stereo)[0]
    z = np.abs(e) / fit.level
    own = _own(z, first, np.bincount(which))
    sums = summed(rows, fit.cameras, place, _weights(z, own[which], fit.level), stereo)
    kept = np.isin(names, fit.names[fit.good])
    S, s = sums.S[kept, :6, :6], sums.s[kept, :6]
    info, meat, count = S.sum(axis=0), s.T @ s, int(kept.sum())
    here = fit.cameras[0]
    if prior is None:
        return CameraPrior(here, info, s.sum(axis=0), meat, count)
    away = twist_between(prior.T_world_cam, here)
    pull = prior.s + s.sum(axis=0) + info @ away
    return CameraPrior(
        prior.T_world_cam, prior.S + info, pull, prior.meat + meat, prior.corners + count
    )


def _level(e: Array, before: Array) -> Array:
    """(3,) px, from the middle of the residuals."""
    if len(e) < 10:
        return before
    return np.maximum(1.4826 * np.median(np.abs(e), axis=0), LEAST_LEVEL)


def _own(z: Array, first: Ints, size: Ints) -> Array:
    """(K,) mean squared residual of each corner over that of most, 1 at least."""
    square = np.add.reduceat((np.minimum(z, WILD) ** 2).sum(axis=1), first)
    square = square / np.maximum(3 * size - 3, 1)
    many = size > 2
    typical = float(np.median(square[many])) if many.any() else 1.0
    return np.asarray(np.maximum(square / max(typical, 1.0), 1.0))


def _weights(z: Array, own: Array, level: Array) -> Array:
    """(N, 3) 1/px^2: Huber's, in units of the corner's own noise."""
    far = z / np.sqrt(own)[:, None]
    return np.asarray(np.minimum(1.0, HUBER / np.maximum(far, 1e-9)) / level**2 / own[:, None])


def _tempered(sums: CornerSums, good: Flags) -> CornerSums:
    """No corner makes up more than a part of what all pull: long ones see too much of one error."""
    share = np.ones(len(good))
    if good.sum() < 2 * FEW:
        return sums
    for _ in range(4):
        s = sums.s[good] * share[good, None]
        M = s.T @ s
        M += 1e-9 * np.trace(M) * np.eye(len(M))
        lever = np.einsum("ki,ki->k", s, np.linalg.solve(M, s.T).T)
        share[good] *= np.minimum(1.0, np.sqrt(LEVER / np.maximum(lever, 1e-9)))
    return replace(sums, S=sums.S * share[:, None, None], s=sums.s * share[:, None])


def _whole(
    sums: CornerSums, good: Flags, cameras: Array, prior: CameraPrior | None
) -> tuple[Array, Array]:
    """Information and gradient of all cameras."""
    S, s = sums.S[good].sum(axis=0), sums.s[good].sum(axis=0)
    if prior is not None:
        more, pull = prior.about(cameras[0])
        S[:6, :6] += more
        s[:6] += pull
    return S + 1e-9 * np.eye(len(S)), s


def _covariance(
    sums: CornerSums, good: Flags, S: Array, prior: CameraPrior | None, moment: Ints, count: int
) -> Array:
    """(6 C, 6 C) see the module's text."""
    s = sums.s[good]
    meat = s.T @ s
    if prior is not None:
        meat[:6, :6] += prior.meat
    if count < FEW:
        return np.full_like(S, np.inf)
    m_over = count / (count - 6)
    in_view = len(moment) / max(len(np.unique(moment)), 1)
    wide = m_over * (1 + max(in_view - 1, 0.0) * ALIKE)
    bias = COMMON[:, None] * sums.bias
    inner = wide * meat + bias.T @ bias
    P = np.linalg.solve(S, np.linalg.solve(S, inner).T)
    return np.asarray((P + P.T) / 2)
