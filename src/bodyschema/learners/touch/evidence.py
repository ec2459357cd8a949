"""What a touch has shown so far: a few numbers, whatever its length.

Wrenches w_t = (f, tau) of one contact point r obey tau = r x f, and so does every weighted sum of
them. With weights that fade, the mean and the scatter of the samples are enough:

    n = sum a_t,   m = 1/n sum a_t w_t,   S = sum a_t (w_t - m)(w_t - m)^T.

Each sample errs by noise, new each time, and by L_t z: z, of unit variance, stays the same (what is
not known of the load, of the sensor's offset and gain), and L_t says how it enters now. So two
kinds of sums of samples, with squared weights that sum to one at most, tell different things:

    sqrt(n) m                        errs by noise and by  n L L^T, L the mean of L_t
    sqrt(s_k) v_k, S = V diag(s) V^T errs by noise and at most by  sum (L_t - L)(L_t - L)^T

(the bound is Cauchy's inequality). The second kind hardly knows offsets: what changed at the onset
of a touch is what the touch did. Principal scatter that noise alone could have made is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

CLEAR = 2.0
"""Times the largest scatter that noise makes, above which scatter is a wrench."""


@dataclass(frozen=True)
class Evidence:
    """Mean and scatter of the wrenches of a stretch of time, and of what they may err by."""

    count: float
    """n."""
    mean: Array
    """(6,) m: N, Nm."""
    scatter: Array
    """(6, 6) S."""
    factor: Array
    """(6, k) L."""
    spread: Array
    """(6, 6) sum a_t (L_t - L)(L_t - L)^T."""

    @classmethod
    def none(cls, lasting: int) -> Evidence:
        """Of no sample; `lasting` is k."""
        square = np.zeros((6, 6))
        return cls(0.0, np.zeros(6), square, np.zeros((6, lasting)), square)

    def add(self, wrench: Array, factor: Array, longest: float) -> Evidence:
        """With one more sample, (6,) and (6, k), and the older ones a little faded.

        Args:
            wrench: force and torque.
            factor: L_t.
            longest: samples that n approaches.
        """
        count = (1 - 1 / longest) * self.count + 1
        mean, scatter, mean_factor, spread = blended(
            self.count, self.mean, self.scatter, self.factor, self.spread,
            np.ascontiguousarray(wrench), np.ascontiguousarray(factor), 1 - 1 / longest,
        )  # fmt: skip
        return Evidence(count, mean, scatter, mean_factor, spread)


class Principal(NamedTuple):
    """Few wrenches that stand for many."""

    wrenches: Array
    """(K, 6) in N and Nm times the square root of a number of samples."""
    covariances: Array
    """(K, 6, 6)."""


def principal(evidence: Evidence, noise: Array) -> Principal:
    """The wrenches of the module's text: the mean, then what varied, strongest first.

    Args:
        evidence: of at least one sample.
        noise: (6, 6) covariance of a sample, times what its memory makes of it.
    """
    n, root = evidence.count, np.sqrt(evidence.count)
    first = noise + n * evidence.factor @ evidence.factor.T
    varied = noise + evidence.spread
    C = np.linalg.cholesky(varied)
    half = solve_triangular(C, evidence.scatter, lower=True)
    squares, axes = np.linalg.eigh(solve_triangular(C, half.T, lower=True))
    # The largest square of an n x 6 matrix of white noise is about (sqrt(n) + sqrt(6))^2.
    kept = np.flatnonzero(squares > CLEAR * (root + np.sqrt(6)) ** 2)[::-1]
    strong = (C @ axes[:, kept] * np.sqrt(squares[kept])).T
    return Principal(
        np.vstack([root * evidence.mean, strong]),
        np.concatenate([first[None], np.repeat(varied[None], len(kept), axis=0)]),
    )


@kernel
def blended(
    count: float,
    mean: Array,
    scatter: Array,
    factor: Array,
    spread: Array,
    wrench: Array,
    now: Array,
    keep: float,
) -> tuple[Array, Array, Array, Array]:
    """Mean, scatter, factor and spread with one more sample; the older ones weigh `keep` of it."""
    total = keep * count + 1.0
    share = keep * count / total
    step, turn = wrench - mean, now - factor
    new_scatter, new_spread = np.empty((6, 6)), np.empty((6, 6))
    for i in range(6):
        for j in range(i + 1):
            both = 0.0
            for k in range(turn.shape[1]):
                both += turn[i, k] * turn[j, k]
            new_scatter[i, j] = keep * scatter[i, j] + share * step[i] * step[j]
            new_spread[i, j] = keep * spread[i, j] + share * both
            new_scatter[j, i], new_spread[j, i] = new_scatter[i, j], new_spread[i, j]
    return mean + step / total, new_scatter, factor + turn / total, new_spread
