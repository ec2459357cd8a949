"""By how much the errors that a load's fit states are too small, were nothing in common but noise.

Means of one moment, one stretch of time, or one posture may share an error; then their scores do
not cancel as independent ones do. kappa of `estimation.pulls` for each thing that is asked (mass,
centre of mass, moments about it), the largest over the ways of clustering less what chance makes of
them, never below 1; and with few numbers the noise itself is not well known, which Student's t
counts in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from bodyschema.estimation import pulls
from bodyschema.trust.wrench_rows import WrenchRows

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

NORMAL = 1.95996
"""Two-sided 95 % of a normal variable."""


def inflations(rows: WrenchRows, asked: Mapping[str, Array]) -> dict[str, float]:
    """kappa of each thing that is asked, from its slopes (k, p)."""
    B, z = rows.B.reshape(-1, rows.B.shape[2]), rows.z.ravel()
    pulled = [
        pulls.pulls(B, z, np.repeat(label, rows.z.shape[1]), rows.root, power)
        for label, power in _ways(rows)
    ]
    few = (float(stdtrit(rows.freedom / 2, 0.975)) / NORMAL) ** 2
    found = {}
    for name, J in asked.items():
        # What chance alone makes of independent clusters, one standard deviation, is nothing.
        chance = [1 + np.sqrt(2 / (len(J) * len(some))) for some in pulled]
        seen = [
            pulls.kappa(J, some, rows.root, rows.precision) / c
            for some, c in zip(pulled, chance, strict=True)
        ]
        found[name] = few * max(1.0, *seen)
    return found


def _ways(rows: WrenchRows) -> Iterator[tuple[Ints, float]]:
    """Clusters, and the power of each: moments also left out, one at a time."""
    moments = np.arange(len(rows))
    yield moments, 0.5
    yield moments, 1.0
    for label in rows.clusters():
        yield label, 0.5
