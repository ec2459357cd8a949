"""Inflation: by how much the error that an estimate states is too small.

The samples of a cluster (a moment, a stretch of time, a corner of the workspace) may share an
error. Then their scores do not cancel as independent ones would: `estimation.pulls` has kappa, for
the places where the robot is to be right.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation import pulls
from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

BLOCKS = 10
"""Stretches of time, and at most this many corners of the workspace: few enough that a slow error
fills one, enough that they can be averaged."""


def inflation(scores: Scores, J: Array) -> float:
    """kappa, the largest over the ways in which samples may belong together; 1 or more.

    Args:
        scores: of a fit.
        J: (n, 3, P) slope of a place at the postures that count, in units of the prior.
    """
    if not scores.A.shape[1]:
        return 1.0
    one_by_one = kappa(scores, J, scores.moment, 1.0)
    in_time = kappa(scores, J, blocks_of_time(scores), 0.5)
    in_posture = kappa(scores, J, corners(scores), 0.5)
    return max(1.0, one_by_one, in_time, in_posture)


def blocks_of_time(scores: Scores, n: int = BLOCKS) -> Ints:
    """(n_samples,) stretch of the recording, equally many moments each."""
    n = min(n, scores.n_moments)
    return np.asarray(scores.moment * n // scores.n_moments)


def corners(scores: Scores, depth: int = 3) -> Ints:
    """(n_samples,) cell of the postures, cut `depth` times at the median of the widest joint."""
    _, first, back = np.unique(scores.moment, return_index=True, return_inverse=True)
    q = scores.q[first]
    cells = [np.arange(len(q))]
    for _ in range(depth):
        cells = [half for cell in cells for half in _halved(q, cell)]
    label = np.empty(len(q), dtype=np.int64)
    for i, cell in enumerate(cells):
        label[cell] = i
    return np.asarray(label[back.ravel()])


def _halved(q: Array, cell: Ints) -> tuple[Ints, Ints]:
    widest = int(np.argmax(np.ptp(q[cell], axis=0))) if len(cell) else 0
    order = cell[np.argsort(q[cell, widest], kind="stable")]
    return order[: len(order) // 2], order[len(order) // 2 :]


def kappa(scores: Scores, J: Array, labels: Ints, power: float) -> float:
    """kappa for one way of clustering.

    Args:
        scores: of a fit.
        J: (n, 3, P) as in `inflation`.
        labels: (n_samples,) number of each sample's cluster.
        power: p.
    """
    pulled = moved_by(scores, labels, power)
    return pulls.kappa(J.reshape(-1, J.shape[2]), pulled, scores.root, scores.precision)


def moved_by(scores: Scores, labels: Ints, power: float) -> Array:
    """(n_clusters, P) C g_c: how far each cluster pulls the variables."""
    B, owner = scores.A @ scores.root, labels[scores.sample]
    return pulls.pulls(B, scores.z, owner, scores.root, power)
