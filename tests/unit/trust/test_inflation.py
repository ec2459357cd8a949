"""Samples that share an error are worth less than their number, and the stated error says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.trust.inflation import blocks_of_time, corners, inflation, kappa, moved_by
from bodyschema.trust.scores import Scores
from faulty import autoregressive, recorded


def judged(case):
    """Scores and the slope of the target's place, in units of the prior."""
    scores = Scores.of(case.fit, case.problem.senses)
    J = case.targets[0].slopes(case.fit).by_parameter[:, :3] * case.fit.variables.scale
    return scores, J


def test_independent_samples_are_worth_their_number():
    by_row = [kappa(*judged(recorded(seed)), np.arange(60), 0.5) for seed in range(8)]
    assert np.mean(by_row) == pytest.approx(1.0, abs=0.15)
    assert all(inflation(*judged(recorded(seed))) < 2.5 for seed in range(4))


def test_errors_that_a_posture_shares():
    # Twelve postures seen seven times, the error of each posture its own: worth twelve samples.
    shared = np.repeat(5e-4 * np.random.default_rng(0).normal(size=(12, 3)), 7, axis=0)
    noise = shared + 1e-4 * np.random.default_rng(1).normal(size=shared.shape)
    scores, J = judged(recorded(0, n=12, repeats=7, noise=noise, groups=("offsets",)))
    assert scores.n_moments == 12
    others = [kappa(scores, J, labels, 0.5) for labels in ways(scores)]
    assert inflation(scores, J) > 1.2 * max(others)
    assert inflation(scores, J) > 1.5 * kappa(scores, J, np.arange(84), 0.5)


def ways(scores):
    return blocks_of_time(scores), corners(scores)


def test_errors_that_a_time_shares():
    # Ten hours of ten postures each, in no order; each hour has an error of its own.
    hourly = np.repeat(2e-2 * np.random.default_rng(2).normal(size=(10, 3)), 10, axis=0)
    scores, J = judged(recorded(2, n=100, noise=hourly, groups=("offsets",)))
    in_time, in_posture = (kappa(scores, J, labels, 0.5) for labels in ways(scores))
    assert in_time > 1.5 * max(in_posture, kappa(scores, J, scores.moment, 1.0))
    assert inflation(scores, J) == pytest.approx(in_time)


def test_errors_that_a_corner_of_the_workspace_shares():
    # The arm errs alike on either side of its first joints, at whatever time it comes there.
    arm = recorded(3, n=160)
    side = np.sign(arm.problem.senses[0].q[:, :3])
    noise = 1e-3 * np.prod(side, axis=1)[:, None] * [1.0, 0.5, 0.2]
    scores, J = judged(recorded(3, n=160, noise=noise, groups=("offsets",)))
    cells = (side > 0) @ [1, 2, 4]
    in_posture = kappa(scores, J, corners(scores), 0.5)
    assert kappa(scores, J, cells.astype(int), 0.5) > 1.5 * kappa(scores, J, scores.moment, 1.0)
    others = max(1.0, kappa(scores, J, scores.moment, 1.0), kappa(scores, J, ways(scores)[0], 0.5))
    assert inflation(scores, J) == pytest.approx(max(others, in_posture))
    assert in_posture > others


def test_too_much_noise_that_was_stated_is_no_reason_to_be_surer():
    case = recorded(5, groups=("offsets",))
    wide = replace(case.fit, levels=((4 * case.fit.levels[0][0],),))
    assert inflation(*judged(replace(case, fit=wide))) == 1.0


def test_errors_that_last():
    noise = autoregressive(120, 0.95, 5e-4, np.random.default_rng(2))
    scores, J = judged(recorded(2, n=120, smooth=True, noise=noise, groups=("offsets",)))
    in_time = kappa(scores, J, blocks_of_time(scores), 0.5)
    assert in_time > 2 * kappa(scores, J, np.arange(120), 0.5)
    assert inflation(scores, J) >= in_time


def test_leaving_a_moment_out_is_what_the_jackknife_says():
    # C g of CR3 is how far the variables move when a cluster is left out, to first order exactly.
    scores, _ = judged(recorded(3, n=20, groups=("offsets",)))
    pulls = moved_by(scores, scores.moment, 1.0)
    rows = scores.sample != 4
    A, z = scores.A[rows], scores.z[rows]
    x = scores.estimate.x / scores.estimate.variables.scale + scores.step
    left = -np.linalg.solve(A.T @ A + np.diag(scores.precision), A.T @ z + scores.precision * x)
    alone = pulls[4] * np.sqrt(20 / 19)
    assert np.allclose(left, alone, rtol=1e-6, atol=1e-9)


def test_pulls_are_the_same_by_either_gram_matrix():
    scores, _ = judged(recorded(4, n=40, groups=("offsets",)))
    large, small = blocks_of_time(scores, 2), scores.moment
    B = scores.A @ scores.root
    for labels in (large, small):
        for cluster, pull in zip(np.unique(labels), moved_by(scores, labels, 0.5), strict=True):
            rows = labels[scores.sample] == cluster
            H = B[rows] @ B[rows].T
            values, vectors = np.linalg.eigh(np.eye(len(H)) - H)
            inside = vectors @ ((values**-0.5) * (vectors.T @ scores.z[rows]))
            assert np.allclose(scores.root @ (B[rows].T @ inside), pull, rtol=1e-6, atol=1e-9)


def test_corners_are_equally_large_and_moments_stay_together():
    scores, _ = judged(recorded(5, n=16, repeats=3))
    cells = corners(scores)
    assert sorted(np.bincount(cells)) == [6] * 8
    for moment in range(16):
        assert len(set(cells[scores.moment == moment])) == 1
