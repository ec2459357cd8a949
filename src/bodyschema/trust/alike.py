"""Are the outliers of a recording alike, or is the whole of it two heaps?

Bad rows that come from many causes point everywhere. If they point one way they are one thing (a
marker that was knocked, another target, another clock) and may well be the true half: n unit
vectors of d numbers have under chance d |sum u|^2 / n ~ chi^2_d (Rayleigh's test). Two heaps of
about equal size leave no outliers; on the axis on which residuals spread most they have a kurtosis
near -2, a normal one 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from bodyschema.estimation.estimate import Estimate
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

FEWEST = 3
ENOUGH = 40
"""Samples below which a kurtosis says nothing."""

TWO_HEAPS = -1.3
"""Kurtosis on the main axis: a uniform spread has -1.2."""


def outliers_alike(estimate: Estimate, sense: Sense, out: NDArray[np.bool_]) -> float:
    """Chance that so many outliers point so much one way; 1 where there are too few.

    Args:
        estimate: whose body predicts.
        sense: the samples.
        out: (n,) the outliers.
    """
    if int(out.sum()) < FEWEST:
        return 1.0
    r = sense.take(out).residual(estimate.body)
    p = [1.0]
    for _, _, part in sense.components:
        length = np.linalg.norm(r[:, part], axis=1, keepdims=True)
        u = r[:, part] / np.maximum(length, 1e-300)
        d = part.stop - part.start
        p.append(float(chdtrc(d, d * np.sum(u.sum(axis=0) ** 2) / len(u))))
    return min(p)


def two_heaps(residual: Array) -> bool:
    """Whether residuals (n, d) lie in two heaps."""
    if len(residual) < ENOUGH:
        return False
    centred = residual - residual.mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    power = float(np.mean(along**2))
    return power > 0 and float(np.mean(along**4)) / power**2 - 3 < TWO_HEAPS
