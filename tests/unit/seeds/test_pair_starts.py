"""Candidates of A_i X = Y B_i, in batches as one by one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.seeds.closed_forms import least_squares, mean_transform, solve_ax_xb
from bodyschema.seeds.pair_starts import pair_starts
from simulated import random_pose, random_poses

Array = NDArray[np.float64]


def pairs(n: int, bad: int, rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """A, B, X, Y; some B are anything."""
    A, X, Y = random_poses(n, rng), random_pose(rng), random_pose(rng)
    B = lie.inverse(Y) @ A @ X
    B[:bad] = random_poses(bad, rng)
    return A, B, X, Y


@pytest.mark.parametrize("seed", range(5))
def test_the_best_start_is_exact_although_half_of_the_pairs_are_bad(seed: int) -> None:
    A, B, X, Y = pairs(40, 20, np.random.default_rng(seed))
    found = pair_starts(A, B)[0]
    assert found[0] == pytest.approx(X, abs=1e-6)
    assert found[1] == pytest.approx(Y, abs=1e-6)


def test_closed_forms_take_batches() -> None:
    rng = np.random.default_rng(0)
    A, B = random_poses(20, rng).reshape(5, 4, 4, 4), random_poses(20, rng).reshape(5, 4, 4, 4)
    w = rng.uniform(0.1, 1, (5, 4))
    together, means = solve_ax_xb(A, B, w), mean_transform(A, w)
    for k in range(5):
        assert together[k] == pytest.approx(solve_ax_xb(A[k], B[k], w[k]), abs=1e-9)
        assert means[k] == pytest.approx(mean_transform(A[k], w[k]), abs=1e-12)


@pytest.mark.parametrize("told", [6, 4], ids=["determined", "flat"])
def test_least_squares_is_that_of_all_rows(told: int) -> None:
    rng = np.random.default_rng(1)
    A, b = rng.normal(size=(50, 3, told)) @ rng.normal(size=(told, 6)), rng.normal(size=(50, 3))
    expected = np.linalg.lstsq(A.reshape(-1, 6), b.ravel(), rcond=1e-12)[0]
    assert least_squares(A, b) == pytest.approx(expected, abs=1e-10)
