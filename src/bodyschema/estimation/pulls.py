"""Pulls: how far clusters of samples pull a fit, and what they make of its stated error.

With the whitened residuals z, their slopes A and C = L L^T = (A^T A + P)^-1 of a fit, a cluster c
of samples that may share an error pulls by

    g_c = A_c^T (1 - H_cc)^-p z_c,   H_cc = A_c C A_c^T

p = 1/2: unbiased for independent samples (CR2); p = 1: leaving each cluster out, times (G - 1) / G
(CR3, the jackknife). What is wanted moves by J dx, and the error stated of it is too small by

    kappa = (sum |J C g_c|^2 + tr J C P C J^T) / tr J C J^T

one number for what the fit is used for; a full matrix would have a lower rank than C. See Bell and
McCaffrey 2002, "Bias reduction in standard errors for linear regression with multi-stage samples",
and MacKinnon, Nielsen and Webb 2023.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FULLEST = 1 - 1e-9
"""Largest leverage of a cluster: one that alone determines a direction."""


def pulls(B: Array, z: Array, owner: Ints, root: Array, power: float) -> Array:
    """C g_c of each cluster, (n_clusters, P).

    Args:
        B: (N, P) A L.
        z: (N,) whitened residuals.
        owner: (N,) number of the cluster of each.
        root: (P, P) L.
        power: p.
    """
    order = np.argsort(owner, kind="stable")
    begins = np.flatnonzero(np.diff(owner[order], prepend=-1))
    sizes = np.diff(begins, append=len(order))
    B, z, found = B[order], z[order], np.empty((len(begins), B.shape[1]))
    for n in np.unique(sizes):
        same = np.flatnonzero(sizes == n)
        rows = begins[same, None] + np.arange(n)
        found[same] = _of_one_size(B[rows], z[rows], power)
    share = np.sqrt(max(len(found) - 1, 1) / max(len(found), 1)) if power == 1.0 else 1.0
    return np.asarray(share * found @ root.T)


def kappa(J: Array, pulled: Array, root: Array, precision: Array) -> float:
    """By how much the variance of what is wanted exceeds that of the fit.

    Args:
        J: (k, P) slopes of what is wanted, all of it one below the other.
        pulled: (n_clusters, P) C g_c.
        root: (P, P) L.
        precision: (P,) diagonal of P.
    """
    by_prior = (J @ root @ root.T) * np.sqrt(precision)
    found = np.sum((J @ pulled.T) ** 2) + np.sum(by_prior**2)
    return float(found / max(np.sum((J @ root) ** 2), 1e-300))


def _of_one_size(B: Array, z: Array, power: float) -> Array:
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
