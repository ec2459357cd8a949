"""Folds, error summaries and the false alarms of the outlier test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import (
    Errors,
    HeldOut,
    folds_of,
    held_out,
    outlier_free,
    sizes,
    with_field,
)
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.solver import Solver
from bodyschema.model.variables import free_joints
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense
from simulated import points, poses, postures, seen_arm, spoiled

Array = NDArray[np.float64]
SENSES = {"points": points, "poses": poses}


def two_senses(seed: int = 0) -> list[Sense]:
    """Points with rows 0 to 29, and poses that share rows 10 to 29 and go on to 39."""
    rng = np.random.default_rng(seed)
    body = seen_arm(4, rng)
    q = postures(40, body, rng)
    later = poses(body, q[10:], rng)
    return [points(body, q[:30], rng), replace(later, rows=later.rows + 10)]


@pytest.mark.parametrize("folds", [2, 5, 7])
def test_folds_hold_every_row_once(folds: int) -> None:
    cut = folds_of(two_senses(), folds, 0)
    assert len(cut) == folds
    assert sorted(np.concatenate(cut).tolist()) == list(range(40))
    assert max(map(len, cut)) - min(map(len, cut)) <= 1


def test_folds_depend_on_the_seed_alone() -> None:
    one, same, other = (folds_of(two_senses(seed), 5, seed // 2) for seed in (0, 1, 2))
    assert all((a == b).all() for a, b in zip(one, same, strict=True))
    assert any((a != b).any() for a, b in zip(one, other, strict=True))


def test_there_are_no_more_folds_than_rows() -> None:
    assert len(folds_of([two_senses()[0].take([0, 1, 2])], 5, 0)) == 3


def test_what_was_seen_in_one_posture_stays_together() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng)
    q = np.repeat(postures(12, body, rng), 7, axis=0) + 1e-5 * rng.normal(size=(84, 4))
    seen = points(body, q, rng)
    cut = folds_of([seen], 5, 0, body)
    assert sorted(np.concatenate(cut).tolist()) == list(range(84))
    assert sorted(np.concatenate([np.unique(fold // 7) for fold in cut])) == list(range(12))
    two = points(body, np.repeat(q[[0, 7]], [95, 5], axis=0), rng)
    assert sorted(map(len, folds_of([two], 5, 0))) == [5, 95]


def test_no_fit_sees_a_row_that_it_is_judged_on() -> None:
    """Rows of one moment leave together, whichever sense they belong to."""
    senses, seen = two_senses(), []
    body = seen_arm(4, np.random.default_rng(0))
    learner, variables = Solver(), free_joints(body, ["offsets"])

    def fit(training: Sequence[Sense]) -> Estimate:
        seen.append({int(row) for sense in training for row in sense.rows})
        return learner.fit(body, variables, training)

    cut = folds_of(senses, 5, 0)
    test = held_out(fit, senses, cut, learner.loss)
    assert [set(range(40)) - rows for rows in seen] == [set(fold.tolist()) for fold in cut]
    assert [r.shape for r in test.residuals] == [(30, 3), (30, 6)]
    assert test.scores.shape == (40,)
    assert len(test.fits) == len(test.folds) == 5
    # About 1 mm a coordinate.
    assert np.sqrt(np.mean(test.residuals[0] ** 2)) == pytest.approx(1e-3, rel=0.25)


def test_scores_prefer_the_body_that_predicts() -> None:
    rng = np.random.default_rng(1)
    body = seen_arm(4, rng)
    offsets = free_joints(body, ["offsets"])
    truth = body.with_variables(offsets, np.full(4, 0.02))
    senses = [poses(truth, postures(40, body, rng), rng)]
    learner, cut = Solver(), folds_of(senses, 5, 0)
    plain, corrected = (
        held_out(lambda s, p=p: learner.fit(body, p, s), senses, cut, learner.loss)
        for p in (free_joints(body, ()), offsets)
    )
    assert corrected.scores.mean() < plain.scores.mean() - 3
    assert plain.behind(corrected) > 5
    assert corrected.behind(plain) == -plain.behind(corrected)


def scored(scores: Array, seen_by: Array | None = None, moments: Array | None = None) -> HeldOut:
    """A test of five folds with these scores of rows, each a moment of its own if not said."""
    n = len(scores)
    strata = np.zeros(n, dtype=np.int64) if seen_by is None else seen_by
    apart = np.arange(n) if moments is None else moments
    return HeldOut((), scores, apart, strata, tuple(np.array_split(np.arange(n), 5)), ())


def behind(excess: Array, seen_by: Array | None = None, moments: Array | None = None) -> float:
    """Of a test whose rows score so much more than another's."""
    n = np.zeros(len(excess))
    return scored(excess, seen_by, moments).behind(scored(n, seen_by, moments))


def test_rows_that_the_same_senses_saw_are_compared_as_usual() -> None:
    """One stratum: the mean over the standard error of a mean, widened for the shared samples."""
    excess = np.random.default_rng(0).normal(0.3, 1.0, 40)
    standard = np.std(excess, ddof=1) / np.sqrt(40)
    expected = np.mean(excess) / standard / np.sqrt(1 + 5 / 4)
    assert behind(excess) == pytest.approx(expected)
    assert behind(excess, np.full(40, 6)) == pytest.approx(expected)
    assert behind(np.zeros(40)) == 0.0


def test_a_few_telling_pictures_among_many_rows_are_no_noise() -> None:
    """Six pictures of 20 each beside 200 points of none: what they tell is told alike by each."""
    rng = np.random.default_rng(1)
    excess = np.concatenate([rng.normal(0.0, 0.1, 200), rng.normal(20.0, 1.0, 6)])
    kinds = np.repeat([1, 2], [200, 6])
    assert behind(excess) < 2
    assert behind(excess, kinds) > 10
    # Pictures that contradict each other tell nothing, whatever they are called.
    torn = np.concatenate([excess[:200], [20.0, -20, 20, -20, 20, -15]])
    assert abs(behind(torn, kinds)) < 2


def test_strata_know_the_error_of_their_mean() -> None:
    """The error is the spread of the mean over recordings with as many rows of each kind."""
    kinds = np.repeat([1, 2, 3], [30, 5, 3])
    means, stds = np.array([0.0, 4.0, -8.0])[kinds - 1], np.array([0.3, 2.0, 1.0])[kinds - 1]
    rng = np.random.default_rng(2)
    drawn = means + stds * rng.normal(size=(2000, 38))
    stated = [np.mean(x) / behind(x, kinds) for x in drawn]
    spread = np.std(drawn.mean(axis=1)) * np.sqrt(1 + 5 / 4)
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(spread, rel=0.05)


def test_a_row_of_a_kind_of_its_own_counts_in_full() -> None:
    """One picture alone shows no spread, so it cannot decide."""
    excess = np.append(np.random.default_rng(3).normal(0.0, 0.1, 50), 30.0)
    assert 0 < behind(excess, np.append(np.zeros(50, dtype=np.int64), 1)) < 1


def test_rows_of_one_posture_err_together() -> None:
    one = np.random.default_rng(4).normal(0.3, 1.0, 20)
    seven = np.repeat(one, 7)
    assert behind(seven, moments=np.repeat(np.arange(20), 7)) == pytest.approx(
        behind(one), rel=0.03
    )
    assert behind(seven) > 2 * behind(one)


def test_a_test_of_some_rows_keeps_what_they_were_seen_by() -> None:
    test = scored(np.arange(6.0), np.array([1, 1, 2, 2, 3, 3]), np.array([0, 0, 1, 1, 2, 2]))
    some = test.scored_by(np.array([True, False, True, False, True, False]))
    assert (some.scores.tolist(), some.seen_by.tolist()) == ([0.0, 2.0, 4.0], [1, 2, 3])
    assert some.moments.tolist() == [0, 1, 2]
    assert some.folds is test.folds


def test_rows_know_which_senses_saw_them() -> None:
    senses = two_senses()
    body, learner = seen_arm(4, np.random.default_rng(0)), Solver()
    variables = free_joints(body, ["offsets"])
    cut = folds_of(senses, 2, 0)
    test = held_out(lambda s: learner.fit(body, variables, s), senses, cut, learner.loss)
    assert test.seen_by.tolist() == [1] * 10 + [3] * 20 + [2] * 10


def test_the_residual_field_corrects_what_no_offset_explains() -> None:
    rng = np.random.default_rng(2)
    body = seen_arm(3, rng)
    q = postures(100, body, rng, 1.0)
    clean = points(body, q, rng)
    bend = 0.01 * np.sin(q @ [[1.0, 0, 1], [1, 1, 0], [0, -1, 2]])
    senses = [replace(clean, observed=clean.position + bend)]
    learner, offsets = Solver(), free_joints(body, ["offsets"])
    cut = folds_of(senses, 4, 0)
    test = held_out(lambda s: learner.fit(body, offsets, s), senses, cut, learner.loss)
    (corrected,) = with_field(test, senses, learner.loss)
    assert np.std(corrected) < np.std(test.residuals[0]) / 2


def test_errors_are_summarised() -> None:
    errors = Errors.of(np.array([3.0, 4.0, 0.0, 0.0]))
    assert (errors.rms, errors.median, errors.max) == (2.5, 1.5, 4.0)
    assert all(np.isnan([(empty := Errors.of(np.empty(0))).rms, empty.median, empty.max]))


def test_sizes_of_a_component() -> None:
    seen, posed = two_senses()
    r = np.array([[3.0, 4, 0, 0, 6, 8]])
    assert sizes(posed, r, "position").tolist() == [5]
    assert sizes(posed, r, "rotation").tolist() == [10]
    assert sizes(seen, r[:, :3], "rotation").shape == (0,)


@pytest.mark.parametrize("freedom", [4.0, np.inf])
@pytest.mark.parametrize("sense", SENSES)
def test_a_clean_recording_seldom_raises_an_alarm(sense: str, freedom: float) -> None:
    """5 % of recordings where noise is as heavy-tailed as assumed; none where it is normal."""
    alarms = []
    for seed in range(80):
        rng = np.random.default_rng(seed)
        body = seen_arm(4, rng)
        seen = SENSES[sense](body, postures(50, body, rng), rng)
        if np.isfinite(freedom):
            seen = heavy_tailed(seen, seen.residual(body), freedom, rng)
        fit = Solver().fit(body, free_joints(body, ["offsets"]), [seen])
        alarms.append(not outlier_free([seen], fit, Loss())[0].all())
    # 4 of 80 are expected; 9 or more have a chance of 1 %.
    assert sum(alarms) <= (9 if np.isfinite(freedom) else 1)


def heavy_tailed(seen: Sense, noise: Array, freedom: float, rng: np.random.Generator) -> Sense:
    """The samples with their normal noise stretched to Student's t."""
    stretch = 1 / np.sqrt(rng.chisquare(freedom, len(noise)) / freedom)
    more = noise * (stretch - 1)[:, None]
    if isinstance(seen, Points):
        return replace(seen, observed=seen.position + more)
    R = lie.exp_so3(more[:, 3:]) @ seen.pose[:, :3, :3]
    return replace(seen, observed=lie.transform(R, seen.pose[:, :3, 3] + more[:, :3]))


@pytest.mark.parametrize("sense", SENSES)
def test_gross_outliers_are_named(sense: str) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        body = seen_arm(4, rng)
        clean = SENSES[sense](body, postures(60, body, rng), rng)
        seen, bad = spoiled(clean, 0.15, 0.05, rng)
        fit = Solver().fit(body, free_joints(body, ["offsets"]), [seen])
        assert (outlier_free([seen], fit, Loss())[0] == ~bad).all()
