"""Mean and scatter of a touch: like numpy's, and honest about what errs together."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.touch.evidence import Evidence, principal

FOREVER = 1e12


def gathered(wrenches, factors, longest=FOREVER):
    """The evidence of samples."""
    evidence = Evidence.none(factors.shape[2])
    for w, L in zip(wrenches, factors, strict=True):
        evidence = evidence.add(w, L, longest)
    return evidence


def test_nothing_fades_it_is_numpys_mean_and_covariance():
    rng = np.random.default_rng(0)
    w, L = rng.normal(size=(40, 6)), rng.normal(size=(40, 6, 3))
    found = gathered(w, L)
    assert found.count == pytest.approx(40)
    assert found.mean == pytest.approx(w.mean(axis=0))
    assert found.scatter == pytest.approx(39 * np.cov(w.T))
    assert found.factor == pytest.approx(L.mean(axis=0))
    off = L - L.mean(axis=0)
    assert found.spread == pytest.approx(np.einsum("nik,njk->ij", off, off))


def test_old_samples_fade():
    rng = np.random.default_rng(1)
    w, none = rng.normal(size=(300, 6)), np.zeros((300, 6, 0))
    found = gathered(w, none, longest=10.0)
    weights = 0.9 ** np.arange(299, -1, -1)
    assert found.count == pytest.approx(weights.sum())
    assert found.mean == pytest.approx(weights @ w / weights.sum())


def test_noise_alone_leaves_the_mean_only():
    rng = np.random.default_rng(2)
    for _ in range(50):
        evidence = gathered(rng.normal(size=(30, 6)), np.zeros((30, 6, 0)))
        assert len(principal(evidence, np.eye(6)).wrenches) == 1


def test_what_a_touch_changed_is_free_of_the_offset():
    rng = np.random.default_rng(3)
    offset, touch = 50 * rng.normal(size=6), 30 * rng.normal(size=6)
    on = (np.arange(60) >= 30)[:, None]
    w = offset + on * touch + rng.normal(size=(60, 6))
    L = np.tile(50 * np.eye(6), (60, 1, 1))
    found = principal(gathered(w, L), np.eye(6))
    assert len(found.wrenches) == 2
    change = found.wrenches[1]
    cosine = change @ touch / np.linalg.norm(change) / np.linalg.norm(touch)
    assert abs(cosine) > 0.999
    # The mean is as uncertain as the offset, the change as the noise.
    assert found.covariances[0][0, 0] == pytest.approx(1 + 60 * 2500)
    assert found.covariances[1] == pytest.approx(np.eye(6))
