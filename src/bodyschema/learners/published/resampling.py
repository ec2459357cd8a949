"""Resampling: weighted particles become equally weighted ones, the heavy ones several times over.

Particle m of weight w_m (summing to one) is drawn N_m times out of n, with E N_m = n w_m for each
of the four schemes. They differ in how much N_m varies (Douc, Cappe, Moulines 2005; Hol, Schon,
Gustafsson 2006). The cumulated weights are read at n ascending places u_i in [0, 1):

    multinomial   u_i independent and uniform, sorted
    stratified    u_i = (i + v_i) / n, one v_i ~ U[0, 1) for each
    systematic    u_i = (i + v) / n, one v ~ U[0, 1) for all
    residual      floor(n w_m) copies for certain, the rest multinomial by n w_m - floor(n w_m)

The systematic scheme draws every particle floor(n w_m) or that plus one times, so none with a
weight above 1 / n is lost. Places and cumulated weights both ascend: one pass over both.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

Resampler = Callable[[ArrayLike, int, np.random.Generator], Ints]
"""(weights (m,), n, rng) -> ascending indices (n,) of the particles that live on."""


def systematic(weights: ArrayLike, n: int, rng: np.random.Generator) -> Ints:
    """n indices by one random number; see the module for what the schemes are.

    Args:
        weights: (m,) not negative, with a positive sum that need not be one.
        n: how many are drawn.
        rng: decides where the comb lies.

    Raises:
        InputError: the weights are no weights.
    """
    return _read(_checked(weights), (np.arange(n) + rng.uniform()) / n)


def stratified(weights: ArrayLike, n: int, rng: np.random.Generator) -> Ints:
    """n indices, one from each nth of the weight; see `systematic`."""
    return _read(_checked(weights), (np.arange(n) + rng.uniform(size=n)) / n)


def multinomial(weights: ArrayLike, n: int, rng: np.random.Generator) -> Ints:
    """n independent draws; see `systematic`."""
    # Partial sums of exponentials are sorted uniforms without sorting.
    gaps = np.cumsum(rng.exponential(size=n + 1))
    return _read(_checked(weights), gaps[:-1] / gaps[-1])


def residual(weights: ArrayLike, n: int, rng: np.random.Generator) -> Ints:
    """Whole copies for certain, the rest by chance; see `systematic`."""
    w = _checked(weights)
    expected = n * w / w.sum()
    # A weight of k / n may come out as k - 1e-16 copies; the sum of the rest stays an integer.
    sure = np.floor(expected + 1e-9).astype(np.int64)
    left = n - int(sure.sum())
    if left > 0:
        drawn = multinomial(np.maximum(expected - sure, 0.0), left, rng)
        np.add.at(sure, drawn, 1)
    return np.repeat(np.arange(len(w)), sure)


RESAMPLERS: dict[str, Resampler] = {
    "systematic": systematic,
    "stratified": stratified,
    "residual": residual,
    "multinomial": multinomial,
}
"""The schemes by name."""


def effective_size(weights: ArrayLike) -> float:
    """1 / sum w^2 of the weights over their sum: how many equal ones would be worth as much."""
    w = _checked(weights)
    return float(w.sum() ** 2 / np.sum(w**2))


def _read(weights: Array, places: Array) -> Ints:
    """The particle in whose share of the weight each place lies."""
    shares = np.cumsum(weights)
    found = np.searchsorted(shares, places * shares[-1], side="right")
    last = int(np.flatnonzero(weights)[-1])  # rounding must not lead beyond the last one alive
    return np.asarray(np.minimum(found, last), dtype=np.int64)


def _checked(weights: ArrayLike) -> Array:
    w = np.asarray(weights, dtype=np.float64)
    if w.ndim != 1 or not np.isfinite(w).all() or (w < 0).any() or not w.sum() > 0:
        raise InputError(
            "expected weights (m,) that are finite, not negative and not all zero, got an array "
            f"of shape {w.shape} with {np.count_nonzero(~(w >= 0) | ~np.isfinite(w))} bad entries."
        )
    return w
