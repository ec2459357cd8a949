"""Whiteness: do neighbours in time, or in posture, err alike?

The residuals of neighbouring moments, summed as products, against the same sums when the moments
are shuffled. Their mean and spread under shuffling are known, so a few hundred shuffles tell a
small chance: t = (sum - mean) / spread, p its upper normal tail. Noise has no neighbours; a lag, a
link that bends, a slow sensor do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SHUFFLES = 400
MOST = 600
"""Moments, evenly spaced runs of them where there are more: all products are held at once."""

FEWEST = 8


def whiteness(scores: Scores, seed: int = 0) -> tuple[float, float]:
    """p-values of neighbours in time and in posture, the smallest of all senses, times these."""
    by_time, by_posture = [1.0], [1.0]
    begin = 0
    for i, sense in enumerate(scores.senses):
        mine = slice(begin, begin + len(sense))
        begin += len(sense)
        r, moment, q = _of_moments(scores, i, mine)
        if len(r) < FEWEST:
            continue
        rng = np.random.default_rng(seed)
        by_time.append(_chance(r, _next(moment), rng))
        by_posture.append(_chance(r, _nearest(q), rng))
    n = len(scores.senses)
    return min(1.0, n * min(by_time)), min(1.0, n * min(by_posture))


def _of_moments(scores: Scores, sense: int, mine: slice) -> tuple[Array, Ints, Array]:
    """Mean residual of each moment of a sense in units of its own spread, in order; moments, q."""
    d = len(scores.senses[sense].covariance)
    numbers = np.isin(scores.sample, np.arange(mine.start, mine.stop))
    z = scores.z[numbers].reshape(-1, d)
    moment, back, count = np.unique(scores.moment[mine], return_inverse=True, return_counts=True)
    total = np.zeros((len(moment), d))
    np.add.at(total, back.ravel(), z)
    q = np.zeros((len(moment), scores.q.shape[1]))
    np.add.at(q, back.ravel(), scores.q[mine])
    r, q = total / np.sqrt(count)[:, None], q / count[:, None]
    if len(r) > MOST:
        r, moment, q = r[:MOST], moment[:MOST], q[:MOST]
    # One wild moment must not carry the sum.
    length = np.linalg.norm(r, axis=1, keepdims=True)
    typical = np.median(length) if len(length) else 1.0
    return r / np.maximum(length / max(3 * typical, 1e-300), 1.0), moment, q


def _next(moment: Ints) -> Callable[[Array], Array]:
    return lambda gram: np.diagonal(gram, 1)


def _nearest(q: Array) -> Callable[[Array], Array]:
    reach = np.ptp(q, axis=0)
    u = q / np.where(reach > 0, reach, 1.0)
    gap = np.sum((u[:, None] - u[None]) ** 2, axis=2)
    np.fill_diagonal(gap, np.inf)
    nearest = np.argmin(gap, axis=1)
    return lambda gram: gram[np.arange(len(gram)), nearest]


def _chance(r: Array, pairs: Callable[[Array], Array], rng: np.random.Generator) -> float:
    gram = r @ r.T
    there = float(np.sum(pairs(gram)))
    shuffled = []
    for _ in range(SHUFFLES):
        order = rng.permutation(len(gram))
        shuffled.append(float(np.sum(pairs(gram[np.ix_(order, order)]))))
    spread = float(np.std(shuffled))
    return float(ndtr(-(there - np.mean(shuffled)) / spread)) if spread > 0 else 1.0
