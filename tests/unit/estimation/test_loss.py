"""The robust family: its weight, its density and its gate."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import multivariate_t

from bodyschema.estimation.loss import Loss, beyond, cost, normaliser, weight

Array = NDArray[np.float64]
FREEDOMS = [1.0, 4.0, 30.0, np.inf]


@pytest.mark.parametrize("nu", FREEDOMS)
@pytest.mark.parametrize("d", [1, 3, 6])
def test_the_weight_is_twice_the_slope_of_the_cost(d: int, nu: float) -> None:
    Q = np.array([0.01, 1.0, 7.0, 500.0])
    slope = (cost(Q * (1 + 1e-6), d, nu) - cost(Q * (1 - 1e-6), d, nu)) / (2e-6 * Q)
    assert weight(Q, d, nu) == pytest.approx(2 * slope, rel=1e-6)


@pytest.mark.parametrize("nu", FREEDOMS)
def test_the_cost_is_that_of_a_density(nu: float) -> None:
    def density(x: float) -> float:
        return float(np.exp(normaliser(1, nu) - cost(np.array([x**2]), 1, nu)[0]))

    assert quad(density, -np.inf, np.inf)[0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("d", [2, 6])
def test_the_density_is_the_multivariate_t(d: int) -> None:
    x = np.arange(1.0, d + 1)
    expected = multivariate_t.logpdf(x, shape=np.eye(d), df=4.0)
    assert normaliser(d, 4.0) - cost(np.array([x @ x]), d, 4.0)[0] == pytest.approx(expected)


def test_one_recording_in_twenty_raises_a_false_alarm() -> None:
    rng = np.random.default_rng(0)
    alarms = 0
    for _ in range(1000):
        scale = rng.chisquare(4, 60) / 4
        z = rng.normal(size=(60, 3)) / np.sqrt(scale)[:, None]
        alarms += not Loss().good([np.sum(z**2, axis=1)], [3])[0].all()
    assert alarms == pytest.approx(50, abs=15)


def test_the_chance_beyond_falls_to_that_of_normal_noise() -> None:
    Q = np.array([0.5, 5.0, 20.0])
    assert (beyond(Q, 3, 4.0)[1:] > beyond(Q, 3, np.inf)[1:]).all()
    assert beyond(Q, 3, 1e7) == pytest.approx(beyond(Q, 3, np.inf), rel=1e-4)
