"""Feeling a touch: the statistic is what it claims, and so is the rate of false ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema.learners.touch.onset import SHARE, Smoothed, limits

NOISE = np.diag([0.02, 0.02, 0.04, 5e-4, 5e-4, 5e-4]) ** 2
NONE = np.zeros((6, 0))


def test_surprise_is_the_squared_size_in_standard_deviations():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(6, 6))
    noise, L = root @ root.T, rng.normal(size=(6, 3))
    now = Smoothed(np.zeros(6), np.zeros((6, 3)))
    for _ in range(5):
        now = now.follow(0.1 * rng.normal(size=6), L, noise)
    C = now.variance * noise + now.factor @ now.factor.T
    assert now.surprise == pytest.approx(now.wrench @ np.linalg.solve(C, now.wrench))
    assert now.factor == pytest.approx(L)


def test_the_variance_is_that_of_the_average():
    rng = np.random.default_rng(1)
    ends = []
    for _ in range(3000):
        now = Smoothed(np.zeros(6), NONE)
        for w in rng.normal(size=(12, 6)):
            now = now.follow(w, NONE, np.eye(6))
        ends.append(now.wrench)
    assert np.var(ends) == pytest.approx(now.variance, rel=0.05)
    assert now.variance > SHARE / (2 - SHARE)


def test_white_noise_passes_a_quantile_as_often_as_it_should():
    rng = np.random.default_rng(2)
    now, above = Smoothed(np.zeros(6), NONE), 0
    limit = chi2.isf(0.01, 6)
    for w in rng.normal(size=(40000, 6)) @ np.sqrt(NOISE):
        now = now.follow(w, NONE, NOISE)
        above += now.surprise > limit
    assert above / 40000 == pytest.approx(0.01, rel=0.3)


def test_a_hard_touch_and_its_end_are_felt_at_once():
    now, push = Smoothed(np.zeros(6), NONE), np.array([0.0, 0.0, 5.0, 0.1, 0.0, 0.0])
    for w in [np.zeros(6)] * 20 + [push] * 20:
        now = now.follow(w, NONE, NOISE)
    assert now.wrench == pytest.approx(push)
    assert now.follow(np.zeros(6), NONE, NOISE).surprise == pytest.approx(0.0)


def test_limits_allow_for_noise_that_was_measured():
    known, measured = limits(0.1, 100.0, np.inf), limits(0.1, 100.0, 150)
    assert known[0] == pytest.approx(chi2.isf(0.1 / 360000, 6))
    assert measured[0] > known[0]
    assert limits(0.1, 100.0, 1e6) == pytest.approx(known, rel=1e-3)
