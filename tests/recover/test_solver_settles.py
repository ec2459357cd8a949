"""Fits with precise trackers and timid arms settle, with levels that are those of the residuals.

The bed is one that expectation-maximisation failed in: levels off by factors of up to 40, fits that
had not come to rest and were taken for the worse, and outliers that were not seen.
"""

from __future__ import annotations

import numpy as np
import pytest

import solver_beds as beds
from bodyschema.estimation.held_out import folds_of, held_out
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.prediction import degrees_of_freedom
from bodyschema.estimation.solver import Solver

SOME = ["as it was", "clean", "1 mm", "far", "timid", "60 rows", "no turntable", "poses"]


@pytest.mark.parametrize("variant", SOME)
def test_a_fit_settles_at_the_level_of_its_residuals(variant: str) -> None:
    for seed in (1, 2):
        bed = beds.grid(seed, **beds.VARIANTS[variant])  # type: ignore[arg-type]
        fit = bed.fit(Solver())
        assert fit.converged
        assert fit.iterations < 30
        (sense,), (bad,) = bed.problem.senses, bed.bad
        assert (fit.outliers[0] == bad).all()
        left = sense.residual(fit.body)[~bad][:, :3]
        numbers = len(sense) * len(sense.covariance)
        rms = np.sqrt(np.mean(left**2) * numbers / degrees_of_freedom(fit, bed.problem.senses))
        nu = fit.freedom[0]
        std = fit.levels[0][0] * 1e-3 * np.sqrt(nu / (nu - 2))
        assert std == pytest.approx(rms, rel=0.1)


def test_the_true_model_is_the_best_and_all_settle() -> None:
    for seed in range(3):
        scores = []
        for groups in beds.MODELS:
            bed = beds.grid(seed, groups=groups)
            fit, senses = bed.fit(Solver()), bed.problem.senses
            assert fit.converged
            cut = folds_of(senses, 5, 0, bed.problem.body)
            test = held_out(lambda s, b=bed, f=fit: b.problem.again(f, s), senses, cut, Loss())
            assert all(part.converged for part in test.fits)
            scores.append(float(test.scores[~bed.bad[0]].mean()))
        assert scores == sorted(scores, reverse=True)


def test_random_beds_settle_in_about_ten_iterations() -> None:
    fits = [beds.drawn(seed).fit(Solver()) for seed in range(30)]
    assert all(fit.converged for fit in fits)
    assert np.mean([fit.iterations for fit in fits]) < 13
    assert max(fit.iterations for fit in fits) < 60


def test_a_fit_that_begins_where_it_ended_is_done_at_once() -> None:
    bed = beds.many(300)
    fit = bed.fit(Solver())
    again = bed.problem.again(fit, bed.problem.senses)
    assert again.iterations <= 4
    assert (np.abs(again.x - fit.x) < 1e-3 * fit.std).all()
