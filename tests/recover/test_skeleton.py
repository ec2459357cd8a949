"""A skeleton is learned from nothing, and what is said of it is true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import InputError, learn_skeleton
from bodyschema.answers.skeleton import SkeletonProblem
from bodyschema.judging.one_pass import pooled
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.senses.poses import Poses
from simulated_skeleton import NOISE, arrangement, true_torso, watched


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """The torso, what was seen with three gross errors, the answer, and fresh samples."""
    rng = np.random.default_rng(4)
    path = arrangement(tmp_path_factory.mktemp("torso"))
    truth = true_torso(path, rng)
    senses = watched(truth, 60, rng)
    wrong = senses[0].position.copy()
    wrong[[7, 21, 44]] += 0.2
    senses[0] = replace(senses[0], observed=wrong)
    answer = learn_skeleton(Body.from_arrangement(path), senses, folds=3)
    return truth, senses, answer, watched(truth, 200, rng)


def test_it_predicts_postures_that_it_has_not_seen(learned):
    truth, _, answer, fresh = learned
    assert answer.verdict == "learned"
    assert answer.outliers == (7, 21, 44)
    for sense in fresh:
        ideal = sense.imagined(truth, sense.q)
        miss = np.linalg.norm(ideal.residual(answer.body), axis=1)
        # 60 postures of 1 mm: far below the noise, and within what was predicted.
        assert np.sqrt(np.mean(miss**2)) < NOISE
        [predicted] = [p for p in answer.predicted_anywhere if p.seen == sense.seen]
        assert np.quantile(miss, 0.9) < predicted.position_overall
    noise = answer.held_out.position.rms / np.sqrt(3)
    assert noise == pytest.approx(NOISE, rel=0.4)


def test_axes_are_right_and_links_are_one_of_many(learned):
    truth, _, answer, _ = learned
    true, found = Skeleton.of(truth), Skeleton.of(answer.body)
    moving = [truth.frame_index(f"{joint}_link") for joint in truth.joints]
    # The camera's frame at zero posture is the root's in both.
    assert np.sum(true.axes[moving] * found.axes[moving], axis=1).min() > np.cos(0.02)
    sentences = " ".join(answer.identifiability.sentences)
    assert "slides along its axis" in sentences
    # Three joints slide, and the root may be anywhere.
    assert len(answer.identifiability.directions) == 6
    total = 3 * 5 + 3 * 3
    assert len(answer.estimate.variables) == total
    assert answer.identifiability.rank == total - 6


def test_the_same_samples_give_the_same_skeleton(learned):
    _, senses, answer, _ = learned
    body = replace(answer.body)
    again = learn_skeleton(body, senses, folds=3)
    # Whatever the arrangement's own numbers are, they play no part.
    assert np.abs(again.body.axis - answer.body.axis).max() < 1e-3


def test_noise_is_not_a_skeleton(tmp_path):
    rng = np.random.default_rng(0)
    path = arrangement(tmp_path)
    senses = watched(true_torso(path, rng), 40, rng)
    stirred = [replace(s, observed=rng.permutation(s.position)) for s in senses]
    answer = learn_skeleton(Body.from_arrangement(path), stirred, folds=2)
    assert answer.verdict == "refused"
    assert "not known" in answer.explanation


def test_a_pool_that_was_startled_at_the_end_has_not_forgotten(tmp_path):
    """Wrong samples at the end send it searching; what it knew before is still the best."""
    rng = np.random.default_rng(1)
    path = arrangement(tmp_path)
    truth = true_torso(path, rng)
    [hand, _] = watched(truth, 60, rng)
    wrong = hand.position.copy()
    wrong[52:] += rng.normal(size=(8, 3))
    problem = SkeletonProblem(Body.from_arrangement(path), (hand,), {}, truth.joints)
    variables = problem.variables(("axes", "links"))
    body = pooled(problem.body, variables, [replace(hand, observed=wrong)])
    ideal = hand.imagined(truth, hand.q)
    assert np.linalg.norm(ideal.residual(body), axis=1).max() < 0.02
    with pytest.raises(InputError, match="too few to find"):
        pooled(problem.body, variables, [hand.take(range(3))])


def test_what_cannot_be_learned_from_is_refused(tmp_path):
    rng = np.random.default_rng(0)
    path = arrangement(tmp_path)
    truth = true_torso(path, rng)
    body, senses = Body.from_arrangement(path), watched(truth, 30, rng)
    hand = senses[0]
    pose = Poses.make(hand.q, np.tile(np.eye(4), (30, 1, 1)), "eye", "hand")
    for bad, message in (
        ([pose], "learned from points"),
        ([hand, replace(senses[1], seen_from="pelvis")], "seen from eye and pelvis"),
        ([replace(hand, seen="shoulder_link")], "is no marker"),
        ([hand.take(range(4))], "too few"),
    ):
        with pytest.raises(InputError, match=message):
            learn_skeleton(body, bad)
