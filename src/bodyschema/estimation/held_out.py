"""Held-out accuracy: errors on samples that the fit has not seen, by k folds.

Rows of one moment (several markers in one image) and rows of one posture stay in one fold, so that
no fold knows the others' posture: who has seen a twin of a sample need only recognise it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.loss import Loss, cost
from bodyschema.estimation.moments import SAME_POSTURE, moments_of
from bodyschema.estimation.normal_equations import level_rows
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Senses = Sequence[Sense]


@dataclass(frozen=True)
class HeldOut:
    """Residuals of every sample, each from a fit that did not see it."""

    residuals: tuple[Array, ...]
    """(n, dimension) a sense: seen minus predicted by the body alone."""
    scores: Array
    """(n_rows,) negative log predictive density of each row, all senses together."""
    moments: Ints
    """(n_rows,) number of the posture or moment that a row belongs to."""
    seen_by: Ints
    """(n_rows,) which senses a row was seen by: equal numbers, the same senses."""
    folds: tuple[Ints, ...]
    """Row numbers of each fold."""
    fits: tuple[Estimate, ...]
    """What predicted each fold."""

    def scored_by(self, good: NDArray[np.bool_]) -> HeldOut:
        """The same with the scores of some rows only, (n_rows,)."""
        kept = {name: getattr(self, name)[good] for name in ("scores", "moments", "seen_by")}
        return replace(self, **kept)

    def behind(self, other: HeldOut) -> float:
        """Mean excess score over another test of the same rows, in standard errors.

        Rows of one posture err together, so their excess is summed before it is squared. A picture
        tells more than a point, which is no noise: rows vary round the mean of those that the same
        senses saw (a stratified mean). The fits
        of k folds share most of their samples; the variance of their mean is larger by
        1 + k/(k - 1) than if each had seen its own (Nadeau and Bengio 2003).
        """
        excess = self.scores - other.scores
        mean, k = float(np.mean(excess)), len(self.folds)
        _, stratum, size = np.unique(self.seen_by, return_inverse=True, return_counts=True)
        round_mean = excess - (np.bincount(stratum, excess) / size)[stratum]
        # One row alone shows no spread: it counts in full against the mean of all.
        round_mean = np.where(size[stratum] > 1, round_mean, excess - mean)
        round_mean *= np.sqrt(size / np.maximum(size - 1, 1))[stratum]
        together = np.sum(np.bincount(self.moments, round_mean) ** 2)
        error = float(np.sqrt((1 + k / max(k - 1, 1)) * together)) / len(excess)
        return mean / error if error > 0 else 0.0


@dataclass(frozen=True)
class Errors:
    """Root mean square, median and maximum of some errors."""

    rms: float
    median: float
    max: float

    @classmethod
    def of(cls, values: Array) -> Errors:
        """Summary of (n,) non-negative errors."""
        if not len(values):
            return cls(float("nan"), float("nan"), float("nan"))
        return cls(
            float(np.sqrt(np.mean(values**2))), float(np.median(values)), float(np.max(values))
        )


def folds_of(senses: Senses, folds: int, seed: int, body: Body | None = None) -> list[Ints]:
    """Row numbers of each fold: a seeded shuffle of all moments, cut into about equal parts.

    Args:
        senses: what was seen.
        folds: how many; fewer if there are fewer moments.
        seed: of the shuffle.
        body: see `moments.postures`.
    """
    rows, moment = moments_of(senses, SAME_POSTURE, body)
    first, sizes = np.unique(moment, return_index=True, return_counts=True)[1:]
    order = np.argsort(first)[np.random.default_rng(seed).permutation(len(first))]
    k = min(folds, len(first))
    # Parts as those of array_split; a moment belongs where its middle row falls.
    ends = np.cumsum([len(part) for part in np.array_split(rows, k)])
    middle = np.cumsum(sizes[order]) - (sizes[order] + 1) / 2
    part = np.empty(len(first), dtype=np.int64)
    part[order] = np.searchsorted(ends, middle, side="right")
    shuffled = np.concatenate([np.flatnonzero(moment == m) for m in order])
    found = [rows[shuffled[part[moment[shuffled]] == i]] for i in range(k)]
    return [fold for fold in found if len(fold)]


def held_out(
    fit: Callable[[Senses], Estimate],
    senses: Senses,
    folds: Sequence[Ints],
    loss: Loss,
    body: Body | None = None,
) -> HeldOut:
    """Fit on all folds but one, predict that one, for every fold.

    Args:
        fit: makes a fit from training samples, frames included.
        senses: all samples.
        folds: row numbers of each fold, see `folds_of`.
        loss: scores the held-out samples.
        body: see `moments.postures`.
    """
    rows, moment = moments_of(senses, SAME_POSTURE, body)
    residuals = [np.zeros((len(sense), len(sense.covariance))) for sense in senses]
    scores, fits = np.zeros(len(rows)), []
    seen_by = sum(np.isin(rows, sense.rows) << i for i, sense in enumerate(senses))
    for fold in folds:
        out = [np.isin(sense.rows, fold) for sense in senses]
        found = fit([sense.take(~mask) for sense, mask in zip(senses, out, strict=True)])
        fits.append(found)
        for i, (sense, mask) in enumerate(zip(senses, out, strict=True)):
            if not mask.any():
                continue
            test = sense.take(mask)
            residuals[i][mask] = residual = test.residual(found.body)
            surprise = _surprise(residual, test, found.levels[i], loss.freedom)
            np.add.at(scores, np.searchsorted(rows, test.rows), surprise)
    return HeldOut(tuple(residuals), scores, moment, np.asarray(seen_by), tuple(folds), tuple(fits))


def with_field(test: HeldOut, senses: Senses, loss: Loss) -> tuple[Array, ...]:
    """Held-out residuals with the residual field of the training samples in the prediction.

    Args:
        test: with its fits, none of which is made again.
        senses: what was tested.
        loss: see `outlier_free`.

    Returns:
        (n, dimension) a sense.
    """
    corrected = [residual.copy() for residual in test.residuals]
    for fold, found in zip(test.folds, test.fits, strict=True):
        out = [np.isin(sense.rows, fold) for sense in senses]
        training = [sense.take(~mask) for sense, mask in zip(senses, out, strict=True)]
        good = outlier_free(training, found, loss)
        for i, (sense, mask) in enumerate(zip(senses, out, strict=True)):
            if mask.any() and good[i].any():
                learned = learn_discrepancy(found.body, training[i], good[i])
                corrected[i][mask] -= learned.predict(sense.q[mask])
    return tuple(corrected)


def _surprise(r: Array, sense: Sense, levels: Sequence[float], nu: float) -> Array:
    """Negative log Student-t density of residuals, up to a constant shared by all models.

    Under the nu of the loss, whatever was learnt: a held-out outlier must not decide.
    """
    s = np.sqrt(np.diag(sense.covariance)) * level_rows(sense, levels)
    Q = np.sum((r / s) ** 2, axis=1)
    return np.asarray(cost(Q, r.shape[1], nu) + np.sum(np.log(s)))


def outlier_free(senses: Senses, fit: Estimate, loss: Loss) -> list[NDArray[np.bool_]]:
    """Which samples of each sense are no gross outliers, (n,).

    Of a batch fit what its gate said; else what the gate says of the fit's weights, those of its
    own nu.
    """
    if fit.outliers:
        return [~mask for mask in fit.outliers]
    dimensions = [len(sense.covariance) for sense in senses]
    nu = loss.freedom
    lengths = [
        (nu + d) / np.maximum(w, 1e-300) - nu for d, w in zip(dimensions, fit.weights, strict=True)
    ]
    return list(loss.good(lengths, dimensions))


def sizes(sense: Sense, residual: Array, component: str) -> Array:
    """Length of one component of each residual, (n,); empty when the sense has none such."""
    for name, _, part in sense.components:
        if name == component:
            return np.asarray(np.linalg.norm(residual[:, part], axis=1))
    return np.empty(0)
