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
    root, r, P = np.sqrt(belief.level), belief.noise.correlation, belief.doubt
    e, J, source = raw.e / root, raw.J / root, raw.source
    white_e, white_J = e, J
    if before is not None and r > WORTH_WHITENING:
        white_e, white_J = e.copy(), J.copy()
        for k in np.unique(np.intersect1d(source, before.source)):
            now, then = source == k, before.source == k
            white_e[now] = (e[now] - r * before.e[then]) / np.sqrt(1 - r * r)
            white_J[now] = (J[now] - r * before.J[then]) / np.sqrt(1 - r * r)
    q, spread = np.empty(len(e)), np.empty(len(e))
    _source_squares(white_e, white_J, source, P, q, spread)
    squared, kept, first = [], np.ones(len(e), dtype=np.bool_), 0
    while first < len(e):
        d = int(np.count_nonzero(source == source[first]))
        squared.append((float(q[first]), d))
        kept[first : first + d] = q[first] <= outlier_limit(d)
        first += d
    now_kept = WhiteInnovation(e[kept], J[kept], source[kept])
    share = float(spread.sum()) / max(len(e), 1)
    return Tested(white_e[kept], white_J[kept], squared, share, now_kept)


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
