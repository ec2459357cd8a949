"""Sizes of the groups of numbers: learnt where rows tell them, open where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_t

from bodyschema.trust.hierarchy import SHARES, SIZES, Hierarchy, alikeness, independent
from bodyschema.trust.scores import Scores
from faulty import recorded


def rows(rho, n=200, seed=0, noise=1.0):
    """Two groups of eight numbers and one without a prior, of the sizes rho (2,)."""
    rng = np.random.default_rng(seed)
    A = 20 * rng.normal(size=(n, 17))
    x = np.concatenate([rho[0] * rng.normal(size=8), rho[1] * rng.normal(size=8), [30.0]])
    y = A @ x + noise * rng.normal(size=n)
    groups = (np.arange(8), np.arange(8, 16))
    return Hierarchy(A, y, float(n), np.append(np.ones(16), 1e3), groups), x


def chances(hierarchy, sizes, group):
    """Of each of SIZES, for one group."""
    weight = np.exp(sizes.log_weight - sizes.log_weight.max())
    mine = sizes.D[:, hierarchy.groups[group][0]]
    found = np.array([weight[np.isclose(mine, size)].sum() for size in SIZES])
    return found / found.sum()


@pytest.mark.parametrize("rho", [(0.02, 0.5), (0.5, 0.05), (0.1, 0.1)])
def test_sizes_are_those_that_the_numbers_have(rho):
    hierarchy, _ = rows(rho)
    sizes = hierarchy.alone()
    for group in (0, 1):
        chance = chances(hierarchy, sizes, group)
        near = np.abs(np.log(SIZES / rho[group])) < np.log(2.6)
        assert chance[near].sum() > 0.95


def test_what_the_rows_do_not_tell_stays_as_open_as_it_was():
    hierarchy, _ = rows((0.2, 0.2), noise=0.0)
    blind = replace(hierarchy, rows=hierarchy.rows * np.repeat([0.0, 1.0], [8, 9]))
    blind = replace(blind, y=blind.rows[:, 8:] @ np.full(9, 0.1) + 1e-3)
    assert chances(blind, blind.alone(), 0) == pytest.approx(np.full(len(SIZES), 1 / len(SIZES)))


def test_a_weight_is_the_chance_of_the_rows():
    hierarchy, _ = rows((0.1, 0.3), n=40)
    sizes = hierarchy.alone()
    n = len(hierarchy.y)
    expected = []
    for D in sizes.D[::9]:
        V = np.eye(n) + (hierarchy.rows * D**2) @ hierarchy.rows.T
        q = hierarchy.y @ np.linalg.solve(V, hierarchy.y)
        expected.append(-0.5 * n * np.log(q) - 0.5 * np.linalg.slogdet(V)[1])
    got = sizes.log_weight[::9]
    assert got - got[0] == pytest.approx(np.array(expected) - expected[0], abs=1e-4)


def test_draws_are_a_t_of_mean_and_spread():
    hierarchy, _ = rows((0.1, 0.3), n=40)
    D = hierarchy.alone().D[20]
    drawn = hierarchy.draws(D, 4000, np.random.default_rng(0))
    wide = hierarchy.draws(D, 4000, np.random.default_rng(0), spread=2.0)
    M = hierarchy.rows.T @ hierarchy.rows + np.diag(D**-2.0)
    mean = np.linalg.solve(M, hierarchy.rows.T @ hierarchy.y)
    left = hierarchy.y @ (hierarchy.y - hierarchy.rows @ mean)
    shape = np.linalg.inv(M) * left / hierarchy.n
    std = np.sqrt(np.diag(multivariate_t(mean, shape, df=hierarchy.n, allow_singular=True).shape))
    std *= np.sqrt(hierarchy.n / (hierarchy.n - 2))
    assert np.abs(drawn.mean(axis=0) - mean) == pytest.approx(0 * mean, abs=float(std.max()) / 10)
    assert drawn.std(axis=0) == pytest.approx(std, rel=0.05)
    assert wide - mean == pytest.approx(2 * (drawn - mean), abs=1e-9)


def test_something_else_is_weighed_against_larger_numbers():
    # Sixteen numbers of the size that one number in Z explains as well.
    hierarchy, _ = rows((0.02, 0.02), seed=1)
    Z = hierarchy.rows[:, :16] @ np.random.default_rng(2).choice([-1.0, 1.0], (16, 1))
    Z /= np.sqrt(np.mean(Z**2))
    both = replace(hierarchy, y=hierarchy.y + 30 * Z[:, 0])
    alone = both.alone()
    beside = both.beside(Z)
    smaller = beside.smaller(alone.D[np.argmax(alone.log_weight)])
    assert smaller.log_weight.max() > alone.log_weight.max() + 5
    tau = smaller.D[np.argmax(smaller.log_weight), -1]
    assert tau in SHARES[-2:]
    best = beside.draws(smaller.D[np.argmax(smaller.log_weight)], 200, np.random.default_rng(0))
    assert best[:, -1].mean() == pytest.approx(30, rel=0.1)


def test_all_sizes_beside_something_else_weigh_as_much_as_those_without():
    # Where Z does nothing, its chance is that of none.
    hierarchy, _ = rows((0.5, 0.5), n=60)
    nothing = hierarchy.beside(np.zeros((60, 1)))
    alone = hierarchy.alone()
    beside = nothing.smaller(np.append(np.ones(16), 1e3))
    total = [np.sum(np.exp(s.log_weight - alone.log_weight.max())) for s in (alone, beside)]
    assert total[1] == pytest.approx(total[0], rel=1.0)


def test_frames_of_a_posture_and_good_rows_among_bad_are_counted_once():
    case = recorded(0, n=12, repeats=7)
    scores = Scores.of(case.fit, case.problem.senses)
    assert independent(scores) < 84 * 3
    (root,) = scores.roots
    heavy = replace(scores, roots=(np.where(np.arange(len(root)) < 42, 1.5, 1e-6),))
    assert independent(heavy) == pytest.approx(42 * 3, rel=1e-3)


def test_numbers_of_one_moment_that_err_alike_are_worth_less():
    case = recorded(0, n=30, repeats=4)
    scores = Scores.of(case.fit, case.problem.senses)
    apart = np.random.default_rng(0).normal(size=len(scores.z))
    alike = np.tile(np.random.default_rng(0).normal(size=(30, 1, 3)), (1, 4, 1)).ravel()

    def of(z):
        return alikeness(replace(scores, seen=z - scores.A @ scores.step))

    assert of(apart) == pytest.approx(1.0, abs=0.6)
    assert of(alike) > 2.0
    single = recorded(0, n=30)
    assert alikeness(Scores.of(single.fit, single.problem.senses)) == 1.0


def test_only_frames_are_free():
    case = recorded(0, groups=())
    hierarchy = Hierarchy.of(Scores.of(case.fit, case.problem.senses))
    assert hierarchy.groups == ()
    assert len(hierarchy.alone().D) == 1
