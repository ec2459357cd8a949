"""Innovations made ready for tests: in units of the noise, without memory, source by source.

With r the correlation of residuals from one moment to the next, sources that were good in both get
e' = (e_t - r e_t-1) / sqrt(1 - r^2), and J' alike. The squared innovation of a source is
q = e'^T (1 + J' P J'^T)^-1 e', chi-square while the belief with covariance P is right.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import GaussianBelief, WhiteInnovation
from bodyschema.estimation.stream_noise import outlier_limit
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

WORTH_WHITENING = 0.05
"""Correlations below it are left alone."""


class Tested(NamedTuple):
    """One moment's innovations, ready for the tests."""

    e: Array
    """(m,) of the sources that are no outliers."""
    J: Array
    """(m, k)."""
    squared: list[tuple[float, int]]
    """q and number of rows of every source."""
    spread: float
    """tr J P J^T over the number of rows: the belief's share in the innovations."""
    kept: WhiteInnovation
    """The sources that are no outliers, before whitening in time; the next moment needs it."""


def prepare(raw: WhiteInnovation, before: WhiteInnovation | None, belief: GaussianBelief) -> Tested:
    """Level, whiten, and measure one moment's innovations.

    Args:
        raw: of this moment.
        before: `kept` of the moment before; None at first.
        belief: whose innovation it is.
    """
    root, P = np.sqrt(belief.level), belief.doubt
    level = WhiteInnovation(raw.e / root, raw.J / root, raw.source)
    white = in_time(level, before, belief.noise.correlation)
    e, J, source = level.e, level.J, level.source
    q, spread = np.empty(len(e)), np.empty(len(e))
    _source_squares(white.e, white.J, source, P, q, spread)
    squared, kept, first = [], np.ones(len(e), dtype=np.bool_), 0
    while first < len(e):
        d = int(np.count_nonzero(source == source[first]))
        squared.append((float(q[first]), d))
        kept[first : first + d] = q[first] <= outlier_limit(d)
        first += d
    now_kept = WhiteInnovation(e[kept], J[kept], source[kept])
    share = float(spread.sum()) / max(len(e), 1)
    return Tested(white.e[kept], white.J[kept], squared, share, now_kept)


def in_time(now: WhiteInnovation, before: WhiteInnovation | None, r: float) -> WhiteInnovation:
    """Without what the moment before already told, for sources that both have."""
    if before is None or r <= WORTH_WHITENING:
        return now
    e, J, source = now.e.copy(), now.J.copy(), now.source
    for k in np.unique(np.intersect1d(source, before.source)):
        rows, then = source == k, before.source == k
        e[rows] = (now.e[rows] - r * before.e[then]) / np.sqrt(1 - r * r)
        J[rows] = (now.J[rows] - r * before.J[then]) / np.sqrt(1 - r * r)
    return WhiteInnovation(e, J, source)


@kernel
def _source_squares(
    e: Array, J: Array, source: NDArray[np.int64], P: Array, q: Array, spread: Array
) -> None:
    """q of each row's source, and the diagonal of J P J^T; rows of a source are neighbours."""
    m, first = e.shape[0], 0
    while first < m:
        end = first
        while end < m and source[end] == source[first]:
            end += 1
        part = np.ascontiguousarray(J[first:end])
        S = part @ P @ part.T
        for i in range(end - first):
            spread[first + i] = S[i, i]
            S[i, i] += 1.0
        q[first:end] = e[first:end] @ np.linalg.solve(S, np.ascontiguousarray(e[first:end]))
        first = end
