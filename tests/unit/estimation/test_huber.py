"""Weights: one for good samples, a bounded pull for bad ones, and information that is right."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.estimation.huber import gross, huber_weights


@pytest.mark.parametrize("dimension", [1, 3, 6])
def test_small_residuals_count_fully_and_large_ones_pull_alike(dimension: int) -> None:
    along = np.eye(dimension)[0]
    weights = huber_weights(np.array([0.1, 10.0, 20.0, 1e4])[:, None] * along)
    assert weights[0] == 1
    pull = weights[1:] * [10.0, 20.0, 1e4]
    assert pull == pytest.approx(pull[0])
    assert 1.5 < pull[0] < gross(dimension) ** 0.5


@pytest.mark.parametrize("dimension", [3, 6])
def test_shares_of_normal_samples_and_the_information_of_an_estimate(dimension: int) -> None:
    r = np.random.default_rng(0).normal(size=(400_000, dimension))
    w, squared = huber_weights(r), np.sum(r**2, axis=1)
    assert np.mean(w < 1) == pytest.approx(0.05, abs=0.002)
    assert np.mean(squared > gross(dimension)) == pytest.approx(1e-3, rel=0.15)
    efficiency = np.mean(w * squared) ** 2 / np.mean(w**2 * squared) / dimension
    assert np.mean(w) == pytest.approx(efficiency, rel=0.005)
