"""Lags that two streams of poses may have to each other, from nothing: t_hand = t_eye + lag.

Between two moments a rigid body turns by one angle, whoever measures it. For moments t_i of the eye
and the rotations R_h of the hand and R_e of the eye,

    c(lag) = mean over (i, j) of log(1 + (d_ij / s)^2),
    d_ij = |log R_h(t_i + lag)^T R_h(t_j + lag)| - |log R_e(t_i)^T R_e(t_j)|

knows neither X nor Y. s is the smallest 40 % quantile of |d| over the lags, as in `pair_starts`.
Angles between moments far apart hold where speeds drown: in slow motion, and in noise. Lags of both
signs are looked at alike, and the lowest minima are fits' starts; periodic motion has several.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rotations = Callable[[Array], Array]
"""Rotations (n, 3, 3) of the hand at moments (n,) s, nan where it was not read."""

MOMENTS, PAIRS = 150, 400
"""Moments of the eye, and pairs of them."""

STEP = 0.02
"""s, between lags that are tried."""

APART = 0.1
"""s: minima nearer than that are one."""

KEPT = 8

PROMISING = 0.3
"""Of the way from the lowest cost to the usual one, up to which a minimum is worth a fit."""

QUANTILE = 0.4

SHARED = 0.5
"""Of the pairs that the best lag shares with the hand's stream, so many a lag must share."""


def likely_lags(
    hand: Rotations, time: Array, R: Array, middle: float, largest: float, seed: int = 0
) -> list[float]:
    """The lowest minima, best first; empty where no angle is shared.

    Args:
        hand: its rotations at any time.
        time: (n,) s of the eye.
        R: (n, 3, 3) that it saw.
        middle: s, lag round which is searched.
        largest: s, so far to both sides.
        seed: of the pairs.
    """
    some = np.unique(np.linspace(0, len(time) - 1, MOMENTS).astype(int))
    rng = np.random.default_rng(seed)
    i, j = rng.integers(0, len(some), (2, PAIRS))
    i, j = i[i != j], j[i != j]
    lags = middle + STEP * np.arange(-round(largest / STEP), round(largest / STEP) + 1)
    turned = hand((time[some] + lags[:, None]).ravel()).reshape(len(lags), len(some), 3, 3)
    d = np.abs(_angle(turned[:, i], turned[:, j]) - _angle(R[some][i], R[some][j]))
    shared = np.isfinite(d).sum(axis=1)
    tried = np.flatnonzero(shared >= max(SHARED * shared.max(), 1))
    if not len(tried):
        return []
    levels = np.nanquantile(d[tried], QUANTILE, axis=1)
    cost = np.full(len(lags), np.inf)
    scale = max(float(levels.min()), 1e-6)
    cost[tried] = np.nanmean(np.log1p((d[tried] / scale) ** 2), axis=1)
    return [float(lags[k]) for k in _lowest(cost)]


def _angle(R: Array, S: Array) -> Array:
    """Angle between rotations, rad, by the Frobenius norm."""
    apart = np.linalg.norm(R - S, axis=(-2, -1))
    return np.asarray(2 * np.arcsin(np.minimum(apart / np.sqrt(8), 1.0)))


def _lowest(cost: Array) -> list[int]:
    """Places of the lowest values that are `APART`."""
    found: list[int] = []
    usual = float(np.median(cost[np.isfinite(cost)]))
    most = (1 - PROMISING) * float(cost.min()) + PROMISING * usual
    for k in np.argsort(cost, kind="stable"):
        if len(found) == KEPT or cost[k] > most:
            break
        near = max(0, k - 1), k + 2
        lowest = cost[k] <= cost[near[0] : near[1]].min()
        if lowest and all(abs(int(k) - other) * STEP >= APART for other in found):
            found.append(int(k))
    return found
