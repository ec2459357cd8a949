"""Held-out accuracy: errors on samples that the fit has not seen, by k folds.

Rows of one moment (several markers in one image) stay in one fold, so that no fold knows the
others' posture. Each fold places the unknown frames and fits anew from its own samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.loss import Loss, cost
from bodyschema.estimation.normal_equations import level_rows
from bodyschema.estimation.solver import Solver
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Senses = Sequence[Sense]


@dataclass(frozen=True)
class HeldOut:
    """Residuals of every sample, each from a fit that did not see it."""

    residuals: tuple[Array, ...]
    """(n, dimension) a sense: seen minus predicted by the body alone."""
    corrected: tuple[Array, ...]
    """The same with the residual field of the training samples added to the prediction."""
    scores: Array
    """(n_rows,) negative log predictive density of each row, all senses together."""


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


def folds_of(senses: Senses, folds: int, seed: int) -> list[Array]:
    """Row numbers of each fold: a seeded shuffle of all rows, cut into equal parts."""
    rows = np.unique(np.concatenate([sense.rows for sense in senses]))
    shuffled = rows[np.random.default_rng(seed).permutation(len(rows))]
    return list(np.array_split(shuffled, min(folds, len(rows))))


def held_out(
    fit: Callable[[Senses], Estimate],
    senses: Senses,
    folds: Sequence[Array],
    learner: Solver,
    field: bool = False,
) -> HeldOut:
    """Fit on all folds but one, predict that one, for every fold.

    Args:
        fit: makes a fit from training samples, frames included.
        senses: all samples.
        folds: row numbers of each fold.
        learner: its loss scores the held-out samples.
        field: also learn the residual field (slower).
    """
    rows = np.unique(np.concatenate([sense.rows for sense in senses]))
    residuals = [np.zeros((len(sense), len(sense.covariance))) for sense in senses]
    corrected = [np.zeros_like(residual) for residual in residuals]
    scores = np.zeros(len(rows))
    for fold in folds:
        out = [np.isin(sense.rows, fold) for sense in senses]
        training = [sense.take(~mask) for sense, mask in zip(senses, out, strict=True)]
        found = fit(training)
        body = found.body
        good = outlier_free(training, found, learner.loss)
        for i, (sense, mask) in enumerate(zip(senses, out, strict=True)):
            test = sense.take(mask)
            if not len(test):
                continue
            residual = test.residual(body)
            residuals[i][mask] = corrected[i][mask] = residual
            if field and good[i].any():
                learned = learn_discrepancy(body, training[i], good[i])
                corrected[i][mask] -= learned.predict(test.q)
            surprise = _surprise(residual, test, found.levels[i], learner.loss.freedom)
            np.add.at(scores, np.searchsorted(rows, test.rows), surprise)
    return HeldOut(tuple(residuals), tuple(corrected), scores)


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
