"""The error that the rows leave possible: as large as it is, and no larger for a wide prior."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.estimation.prediction import length_quantile
from bodyschema.model.kinematics import relative_pose
from bodyschema.trust import outlook as module
from bodyschema.trust.effects import Effects
from bodyschema.trust.explanations import WHEN, explanations
from bodyschema.trust.outlook import outlook
from bodyschema.trust.scores import Scores
from faulty import PAIR, recorded


def seen(case, fit=None, larger=None):
    larger = Scores.of(larger or case.fit, case.problem.senses)
    effects = Effects.of(larger, case.targets)
    return outlook(fit or case.fit, larger, effects, case.targets)


def test_few_rows_are_known_as_well_as_the_sizes_of_the_numbers_say():
    ratio = []
    for seed in range(6):
        case = recorded(seed, n=14)
        ratio.append(seen(case).core / case.error)
    assert 0.8 < np.median(ratio) < 1.6


def test_numbers_that_are_small_are_not_left_as_open_as_their_prior():
    # The truth is as modelled: what 14 rows leave open of axes and links is small as well.
    case = recorded(0, n=14)
    (sense,) = case.problem.senses
    right = relative_pose(case.problem.body, sense.q, *PAIR)[:, :3, 3]
    noise = 5e-4 * np.random.default_rng(0).normal(size=right.shape)
    problem = replace(case.problem, senses=(replace(sense, observed=right + noise),))
    variables = problem.variables(("offsets", "axes", "links"))
    exact = replace(case, problem=problem, fit=problem.fit(variables, problem.senses))
    scores = Scores.of(exact.fit, problem.senses)
    J = exact.targets[0].slopes(exact.fit).by_parameter[:, :3] * exact.fit.variables.scale
    rows = J @ scores.root
    by_prior = length_quantile(list(rows @ np.swapaxes(rows, 1, 2)), scores.freedom, 0.95)
    assert seen(exact).core < 0.7 * by_prior


def test_a_smaller_model_is_as_far_off_as_the_larger_one_says():
    # Offsets alone: the axes and links that they leave out are in the number.
    ratio = []
    for seed in range(5):
        case = recorded(seed)
        small = recorded(seed, groups=("offsets",))
        ratio.append(seen(small, small.fit, case.fit).core / small.error)
    assert min(ratio) > 0.9
    assert max(ratio) < 1.3


def test_the_same_rows_give_the_same_number():
    case = recorded(1)
    assert seen(case) == seen(case)


def test_nothing_else_is_likely_where_nothing_else_happened():
    shares = [seen(recorded(seed)).share for seed in range(5)]
    assert np.median(shares) < 0.3


def test_what_wanders_is_named():
    case = recorded(0, moved=lambda p: p + np.outer(np.linspace(-1, 1, len(p)), [0, 2e-3, 1e-3]))
    found = seen(case)
    assert found.share > 0.9
    assert "wanders through the recording" in found.says


def test_explanations_have_unit_size_and_their_effect_on_the_robot():
    case = recorded(0)
    effects = Effects.of(Scores.of(case.fit, case.problem.senses), case.targets)
    found = {one.family: one for one in explanations(effects)}
    assert set(found) == {"eye", "lens", "drift", "warming"}
    for one in found.values():
        assert np.mean(np.sum(one.Z**2, axis=1)) == pytest.approx(1.0)
    assert found["eye"].ways == found["lens"].ways == ()
    for name in ("drift", "warming"):
        (ways,) = found[name].ways
        assert len(ways) == len(WHEN)
        assert ways[0].shape == (len(case.targets[0].q), 3, found[name].Z.shape[1])
        # The cosines cancel between beginning and end for odd k.
        assert ways[0] != pytest.approx(ways[2])


def test_a_wandering_joint_does_to_the_target_what_it_does_to_the_rows():
    case = recorded(0)
    scores = Scores.of(case.fit, case.problem.senses)
    effects = Effects.of(scores, case.targets)
    one = next(e for e in explanations(effects) if e.family == "warming")
    (by_joint, _), *_ = effects.at_targets
    # At the beginning both cosines are 1 and 1/2; rows of the first moment tell the scale.
    first = np.flatnonzero(scores.moment[scores.sample] == 0)
    scale = one.Z[first[0], 0] / effects.by_joint[first[0], 0]
    assert one.ways[0][0][:, :, 0] == pytest.approx(by_joint[:, :, 0] * scale)
    assert one.ways[0][0][:, :, 1] == pytest.approx(by_joint[:, :, 0] * scale / 2)


def test_no_target_no_error(monkeypatch):
    case = recorded(0)
    larger = Scores.of(case.fit, case.problem.senses)
    monkeypatch.setattr(module, "explanations", lambda effects: iter(()))
    found = outlook(case.fit, larger, Effects.of(larger, case.targets), [])
    assert (found.core, found.total, found.share, found.says) == (0.0, 0.0, 0.0, "")
