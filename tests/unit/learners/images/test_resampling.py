"""Resampling: fair on average, steadier from scheme to scheme, and the same as counting by hand."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.published.resampling import RESAMPLERS, effective_size

W = np.array([0.02, 0.31, 0.0, 0.17, 0.4, 0.1])


def counts(name: str, n: int, runs: int, seed: int = 0) -> np.ndarray:
    """How often each particle was drawn, (runs, m)."""
    rng = np.random.default_rng(seed)
    return np.array(
        [np.bincount(RESAMPLERS[name](W, n, rng), minlength=len(W)) for _ in range(runs)]
    )


@pytest.mark.parametrize("name", RESAMPLERS)
def test_counts_are_unbiased(name: str) -> None:
    drawn = counts(name, 10, 4000)
    assert (drawn.sum(axis=1) == 10).all()
    spread = np.maximum(drawn.std(axis=0), 1e-12) / np.sqrt(len(drawn))
    assert (np.abs(drawn.mean(axis=0) - 10 * W) < 4.5 * spread + 1e-9).all()
    assert (drawn[:, 2] == 0).all()


def test_variance_falls_from_scheme_to_scheme() -> None:
    variance = {name: counts(name, 10, 4000).var(axis=0).sum() for name in RESAMPLERS}
    assert variance["systematic"] < variance["stratified"] < variance["multinomial"]
    assert variance["residual"] < variance["multinomial"]
    expected = 10 * np.sum(W * (1 - W))
    assert variance["multinomial"] == pytest.approx(expected, rel=0.05)


def test_systematic_draws_the_whole_number_or_one_more() -> None:
    drawn, least = counts("systematic", 10, 500), np.floor(10 * W)
    assert ((drawn == least) | (drawn == least + 1)).all()


@pytest.mark.parametrize("name", ["systematic", "stratified"])
def test_one_pass_over_both_lists_finds_the_same(name: str) -> None:
    found = RESAMPLERS[name](W, 50, np.random.default_rng(3))
    rng = np.random.default_rng(3)
    places = (np.arange(50) + rng.uniform(size=1 if name == "systematic" else 50)) / 50
    by_hand, m, reached = [], 0, W[0]
    for place in places:
        while place >= reached:
            m += 1
            reached += W[m]
        by_hand.append(m)
    np.testing.assert_array_equal(found, by_hand)


@pytest.mark.parametrize("name", RESAMPLERS)
def test_scale_and_number_are_free_and_equal_weights_all_live(name: str) -> None:
    rng = np.random.default_rng
    np.testing.assert_array_equal(
        RESAMPLERS[name](W, 7, rng(1)), RESAMPLERS[name](8 * W, 7, rng(1))
    )
    assert len(RESAMPLERS[name](W, 1, rng(1))) == 1
    if name != "multinomial":
        np.testing.assert_array_equal(RESAMPLERS[name](np.ones(9), 9, rng(1)), np.arange(9))


def test_effective_size() -> None:
    assert effective_size(np.ones(40)) == pytest.approx(40)
    assert effective_size([0.0, 3.0, 0.0]) == pytest.approx(1)


@pytest.mark.parametrize("bad", [[0.0, 0.0], [1.0, -0.1], [1.0, np.nan], [[1.0]], []])
def test_what_is_no_weight_is_refused(bad: list[float]) -> None:
    with pytest.raises(InputError, match="expected weights"):
        RESAMPLERS["systematic"](bad, 2, np.random.default_rng(0))
