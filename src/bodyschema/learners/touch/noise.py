"""The noise of unexplained wrenches, measured where hardly anything touches.

Covariance N of the samples about their mean. A mean of many varies more where neighbours are
alike: with N = C C^T and r_i the correlation of neighbours in component i of C^-1 w, what counts is

    C diag(tau) C^T,     tau_i = max((1 + r_i) / (1 - r_i), 1).

Samples that no noise makes (touches) are left out, and N measured again, until the same ones stay.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import chdtri

from bodyschema.errors import InputError
from bodyschema.learners.touch.unexplained import Unexplained

Array = NDArray[np.float64]

FEWEST = 30
"""Samples that a covariance of six components is believed from."""

WILD = 1e-4
"""Chance of a sample of noise to be left out."""

LARGEST = 0.98
"""Correlation that is believed at most."""

ROUNDS = 10

NORMAL = 1.4826
"""Standard deviation of a normal variable over its median distance from the median."""


class Noise(NamedTuple):
    """What a sample varies by, as it counts in a mean of several."""

    covariance: Array
    """(6, 6) N^2, N Nm and Nm^2."""
    samples: int
    """From which it was measured."""


def measured_noise(quiet: Unexplained, floor: Array | None = None) -> Noise:
    """Noise of a stretch of time in which nothing touches, or not most of the time.

    Args:
        quiet: the stretch.
        floor: (6,) N and Nm, standard deviations below which no noise is believed; none when None.

    Raises:
        InputError: fewer than 30 samples.
    """
    if len(quiet) < FEWEST:
        raise InputError(
            f"the noise of a wrench is measured on {FEWEST} samples without a touch or more; got "
            f"{len(quiet)}."
        )
    least = np.zeros(6) if floor is None else floor
    w = quiet.wrench
    middle = np.median(w, axis=0)
    spread = NORMAL * np.median(np.abs(w - middle), axis=0)
    N = np.diag(np.maximum(spread, np.maximum(least, 1e-9)) ** 2)
    good = np.zeros(len(w), dtype=bool)
    for _ in range(ROUNDS):
        white = solve_triangular(np.linalg.cholesky(N), (w - middle).T, lower=True).T
        kept = np.sum(white**2, axis=1) < chdtri(6, WILD)
        if kept.sum() < FEWEST or (kept == good).all():
            break
        good, middle = kept, w[kept].mean(axis=0)
        N = np.cov(w[kept].T)
        N += np.diag(np.maximum(least**2 - np.diag(N), 0.0) + 1e-18)
    both = good[1:] & good[:-1]
    before, after = white[:-1][both], white[1:][both]
    r = np.sum(before * after, axis=0) / np.maximum(np.sum(before**2, axis=0), 1e-9)
    tau = np.maximum((1 + r) / (1 - np.minimum(r, LARGEST)), 1.0)
    C = np.linalg.cholesky(N)
    return Noise((C * tau) @ C.T, int(good.sum()))
