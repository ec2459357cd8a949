"""By how much the errors that a load's fit states are too small, were nothing in common but noise.

Means of one moment, one stretch of time, or one posture may share an error; then their scores do
not cancel as independent ones do. With A_c, z_c the rows of a cluster, H_cc = A_c C A_c^T and J the
slope of what is asked (mass, centre of mass, moments about it),

    g_c    = A_c^T (1 - H_cc)^-p z_c       p = 1/2: unbiased for independent rows (CR2);
                                           p = 1: leaving each cluster out (CR3, jackknife)
    kappa  = (sum |J C g_c|^2 + tr J C P C J^T) / tr J C J^T

(Bell and McCaffrey 2002, "Bias reduction in standard errors for linear regression with multi-stage
samples"). One number for each thing that is asked, the largest over the ways of clustering less
what chance makes of them, never below 1; and with few numbers the noise itself is not well known,
which Student's t counts in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from bodyschema.trust.wrench_rows import WrenchRows, blocks

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FULLEST = 1 - 1e-9
"""Largest leverage of a cluster: one that alone determines a direction."""

NORMAL = 1.95996
"""Two-sided 95 % of a normal variable."""


def inflations(rows: WrenchRows, asked: Mapping[str, Array]) -> dict[str, float]:
    """kappa of each thing that is asked, from its slopes (k, p)."""
    pulls = [moved_by(rows, label, power) for label, power in _ways(rows)]
    few = (float(stdtrit(rows.freedom / 2, 0.975)) / NORMAL) ** 2
    found = {}
    for name, J in asked.items():
        # What chance alone makes of independent clusters, one standard deviation, is nothing.
        chance = [1 + np.sqrt(2 / (len(J) * len(some))) for some in pulls]
        seen = [_kappa(rows, J, p) / c for p, c in zip(pulls, chance, strict=True)]
        found[name] = few * max(1.0, *seen)
    return found


def _ways(rows: WrenchRows) -> Iterator[tuple[Ints, float]]:
    """Clusters, and the power of each: moments also left out, one at a time."""
    moments = np.arange(len(rows))
    yield moments, 0.5
    yield moments, 1.0
    for label in rows.clusters():
        yield label, 0.5


def _kappa(rows: WrenchRows, J: Array, pulls: Array) -> float:
    prior = rows.root @ (rows.root.T * np.sqrt(rows.precision))
    found = np.sum((J @ pulls.T) ** 2) + np.sum((J @ prior) ** 2)
    return float(found / max(np.sum((J @ rows.root) ** 2), 1e-300))


def moved_by(rows: WrenchRows, label: Ints, power: float) -> Array:
    """(clusters, p) C g_c: how far each cluster pulls theta."""
    found = []
    for some in blocks(label):
        B = rows.B[some].reshape(-1, rows.B.shape[2])
        found.append(_pull(B, rows.z[some].ravel(), power))
    count = len(found)
    share = np.sqrt(max(count - 1, 1) / count) if power == 1.0 else 1.0
    return np.asarray(share * np.array(found) @ rows.root.T)


def _pull(B: Array, z: Array, power: float) -> Array:
    """B^T (1 - B B^T)^-p z, by the smaller of the two Gram matrices."""
    small = B.shape[0] <= B.shape[1]
    values, vectors = np.linalg.eigh(B @ B.T if small else B.T @ B)
    factor = (1 - np.clip(values, 0.0, FULLEST)) ** -power
    if small:
        return np.asarray(B.T @ (vectors @ (factor * (vectors.T @ z))))
    return np.asarray(vectors @ (factor * (vectors.T @ (B.T @ z))))
