"""How late the stamps of a stream are, from nothing: the lag at which the body explains it best.

    c(lag) = sum over components of log median |residual|,

with the unknown frames placed in closed form, at joint readings of lag earlier. Zeros that are a
few degrees off add a little everywhere; a wrong lag adds the way that the body went meanwhile, so
that c has one deep valley unless the motion repeats itself. The grid is as fine as the joints are
fast, then golden sections go down the lowest valleys. What is left is for a part "clock", which the
final fit frees together with all else.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.problem import Problem

Array = NDArray[np.float64]

STRIDE = 0.15
"""rad or m: from one lag of the grid to the next the fastest joint moves by no more, usually."""

MOST = 161
"""Lags of the grid."""

SHARED = 0.6
"""Of the samples that the best shared lag has, so many every lag must have to be compared."""

TOLERANCE = 0.01
"""s; what is left the fit finds."""

VALLEYS = 4

GOLDEN = (np.sqrt(5) - 1) / 2


def stream_lag(
    problem_at: Callable[[float], Problem], middle: float, largest: float, speed: float
) -> float:
    """The lag at which the body explains the stream best, s.

    Args:
        problem_at: the problem with the stream's samples at a lag.
        middle: s, round which is searched.
        largest: s, so far to both sides.
        speed: rad/s or m/s of the fastest joint, usually.
    """
    step = max(STRIDE / max(speed, 1e-9), 2 * largest / (MOST - 1))
    half = max(int(np.ceil(largest / step)), 1)
    lags = middle + largest * np.arange(-half, half + 1) / half
    costs, counts = np.array([_cost(problem_at(lag)) for lag in lags]).T
    costs[counts < SHARED * counts.max()] = np.inf
    ends = np.concatenate([lags[:1], lags, lags[-1:]])
    found = [
        _valley(lambda lag: _cost(problem_at(lag))[0], float(ends[k]), float(ends[k + 2]))
        for k in _lowest(costs)
    ]
    return min(found)[1]


def _lowest(costs: Array) -> list[int]:
    """The lowest minima of the grid, which may be too coarse to tell which valley is deepest."""
    around = np.concatenate([[np.inf], costs, [np.inf]])
    minima = np.flatnonzero((costs <= around[:-2]) & (costs <= around[2:]) & np.isfinite(costs))
    order = minima[np.argsort(costs[minima], kind="stable")]
    return [int(k) for k in order[:VALLEYS]]


def _valley(cost: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """(cost, lag) of the lowest point between two ends, by golden sections."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_a, at_b = cost(a), cost(b)
    while high - low > TOLERANCE:
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - GOLDEN * (high - low)
            at_a = cost(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + GOLDEN * (high - low)
            at_b = cost(b)
    return min((at_a, a), (at_b, b))


def _cost(problem: Problem) -> tuple[float, int]:
    """c, and the number of samples."""
    senses = [sense for sense in problem.senses if len(sense)]
    if not senses:
        return np.inf, 0
    cost = 0.0
    for sense in senses:
        r = sense.residual(problem.begun)
        for _, _, columns in sense.components:
            cost += float(np.log(np.median(np.linalg.norm(r[:, columns], axis=1)) + 1e-12))
    return cost, sum(map(len, senses))
