"""Inflation: by how much the error that an estimate states is too small.

The samples of a cluster (a moment, a stretch of time, a corner of the workspace) may share an
error. Then their scores do not cancel as independent ones would. With A_c, z_c the rows of a
cluster and H_cc = A_c C A_c^T,

    g_c    = A_c^T (1 - H_cc)^-p z_c          p = 1/2: unbiased for independent samples (CR2);
                                              p = 1: leaving each cluster out (CR3, jackknife)
    kappa  = tr M C (sum g_c g_c^T + P) C / tr M C

M = mean of J^T J over the postures that count, J the slope of the place of what is wanted: one
number, for what the robot is used for. (A full matrix would have a lower rank than C.) See Bell and
McCaffrey 2002, "Bias reduction in standard errors for linear regression with multi-stage samples".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

BLOCKS = 10
"""Stretches of time, and at most this many corners of the workspace: few enough that a slow error
fills one, enough that they can be averaged."""

FULLEST = 1 - 1e-9
"""Largest leverage of a cluster: one that alone determines a direction."""


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
    """tr M C (sum g g^T + P) C / tr M C for one way of clustering.

    Args:
        scores: of a fit.
        J: (n, 3, P) as in `inflation`.
        labels: (n_samples,) number of each sample's cluster.
        power: p.
    """
    moves = J.reshape(-1, J.shape[2]) / np.sqrt(len(J))
    pulls = moved_by(scores, labels, power)
    if power == 1.0:
        pulls = pulls * np.sqrt(max(len(pulls) - 1, 1) / max(len(pulls), 1))
    prior = scores.C * np.sqrt(scores.precision)
    found = np.sum((moves @ pulls.T) ** 2) + np.sum((moves @ prior) ** 2)
    return float(found / max(np.sum((moves @ scores.root) ** 2), 1e-300))


def moved_by(scores: Scores, labels: Ints, power: float) -> Array:
    """(n_clusters, P) C g_c: how far each cluster pulls the variables."""
    owner = labels[scores.sample]
    order = np.argsort(owner, kind="stable")
    begins = np.flatnonzero(np.diff(owner[order], prepend=-1))
    sizes = np.diff(begins, append=len(order))
    B, z = scores.A[order] @ scores.root, scores.z[order]
    found = np.empty((len(begins), B.shape[1]))
    for n in np.unique(sizes):
        same = np.flatnonzero(sizes == n)
        rows = begins[same, None] + np.arange(n)
        found[same] = _pulls(B[rows], z[rows], power)
    return found @ scores.root.T


def _pulls(B: Array, z: Array, power: float) -> Array:
    """B^T (1 - B B^T)^-p z of clusters of one size, (m, n, P) and (m, n) -> (m, P).

    By the smaller of the two Gram matrices.
    """
    n, P = B.shape[1:]
    turned = np.swapaxes(B, 1, 2)
    values, vectors = np.linalg.eigh(B @ turned if n <= P else turned @ B)
    factor = (1 - np.clip(values, 0.0, FULLEST)) ** -power
    pull = z[..., None] if n <= P else turned @ z[..., None]
    pull = vectors @ (factor[..., None] * (np.swapaxes(vectors, 1, 2) @ pull))
    return np.asarray((turned @ pull if n <= P else pull)[..., 0])
