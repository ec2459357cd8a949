"""Pictures whose lines were not taken at one moment, as corners of a moving board tell.

A corner in line v moves by its velocity w = d(u, v)/dq dq/dt; where lines are read one after the
other, tau each, its residual is tau (v - mean) w beside that of a clock that is late, lag w. Both
are fitted to what the parameters that were found leave, and the share of its squares that the
lines explain is held against that of the clock:

    r = J dx + lag w + tau (v - mean) w

The standard error leaves out one picture after the other: residuals of one share much.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

TOLD = 4.0
"""Standard errors of the time of a line, beyond which it is told."""

CAUSE, LEAST = 0.25, 0.05
"""Shares of what is left: more explained is the cause, less than the second is not worth a word."""

STILL = 5.0
"""px/s: the median speed of corners below which nothing is told."""

MICRO = 1e6


def rolling_shutters(fit: Estimate, senses: Sequence[Sense]) -> tuple[str, ...]:
    """A sentence for every camera whose lines were taken one after the other.

    Args:
        fit: to the senses.
        senses: of which pixels with recorded speeds of the joints can tell.
    """
    masks = fit.outliers or [np.zeros(len(sense), dtype=bool) for sense in senses]
    said = []
    for sense, out in zip(senses, masks, strict=True):
        if isinstance(sense, Pixels) and sense.rate is not None and (~out).sum() > 1:
            said += _of_one(fit, sense.take(~out), sense.rate[~out])
    return tuple(said)


def _of_one(fit: Estimate, sense: Pixels, rate: Array) -> list[str]:
    linear = sense.linearize(fit.reference, fit.variables, fit.x)
    speed = -np.einsum("nij,nj->ni", linear.by_joint, rate)
    if np.median(np.linalg.norm(speed, axis=1)) < STILL:
        return []
    lines = sense.observed[:, 1] - sense.observed[:, 1].mean()
    J = linear.by_parameter.reshape(2 * len(sense), -1)
    basis = _basis(J)
    left, late, by_line = (
        _beyond(basis, np.asarray(column.reshape(-1, 1)))
        for column in (linear.residual, speed, speed * lines[:, None])
    )
    beside = _beyond(_basis(late), np.hstack([left, by_line]))
    r, slope = beside[:, 0], beside[:, 1]
    size = float(slope @ slope)
    if size < 1e-9 * float(np.sum((speed * lines[:, None]) ** 2)):
        return []
    tau = float(slope @ r) / size
    pictures = np.unique(np.repeat(sense.rows, 2), return_inverse=True)[1]
    error = _jackknife(_sums(pictures, slope * r), _sums(pictures, slope**2))
    share = tau**2 * size / max(float(r @ r), 1e-300)
    whole = max(float(np.sum(left**2)), 1e-300)
    clock = 1 - float(r @ r) / whole
    if abs(tau) < TOLD * error or share < LEAST:
        return []
    sure = share >= CAUSE and tau**2 * size / whole > clock
    found = (
        f"lines of the pictures of '{sense.seen_from}' were taken one after the other, "
        f"{MICRO * abs(tau):.0f} ± {MICRO * error:.0f} us a line, which explains "
        f"{100 * share:.0f} % of what the fit leaves of '{sense.seen}': a rolling shutter. Let the "
        "arm come to rest for each picture, or move it more slowly."
    )
    return [f"The {found}" if sure else f"Perhaps {found}"]


def _sums(pictures: NDArray[np.int64], values: Array) -> Array:
    """Of each picture, (p,)."""
    return np.bincount(pictures, weights=values).astype(np.float64)


def _jackknife(tops: Array, bottoms: Array) -> float:
    """Standard error of sum(tops) / sum(bottoms), leaving one picture out after the other."""
    top, bottom, n = tops.sum(), bottoms.sum(), len(tops)
    kept = bottom - bottoms
    if n < 2 or kept.min() < 1e-9 * bottom:
        return float("inf")
    without = (top - tops) / kept
    return float(np.sqrt((n - 1) / n * np.sum((without - top / bottom) ** 2)))


def _basis(J: Array) -> Array:
    """Orthonormal columns that span those of J, (n, k); columns of no size are left out."""
    sized = J[:, np.linalg.norm(J, axis=0) > 0]
    if not sized.shape[1]:
        return np.zeros((len(J), 0))
    U, s, _ = np.linalg.svd(sized / np.linalg.norm(sized, axis=0), full_matrices=False)
    return np.asarray(U[:, s > 1e-9 * s[0]])


def _beyond(basis: Array, columns: Array) -> Array:
    """What a basis leaves of columns."""
    return np.asarray(columns - basis @ (basis.T @ columns))
