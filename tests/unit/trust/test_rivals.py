"""Causes that are not in the model: found with their size, beside their rivals, or not at all."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.estimation.problem import Problem
from bodyschema.model.kernels import OFFSET
from bodyschema.trust.effects import Effects
from bodyschema.trust.families import families
from bodyschema.trust.rival import Rival, weigh
from bodyschema.trust.scores import Scores
from bodyschema.trust.weighing import RIVAL, best_of_families
from faulty import bumped, recorded, sagging, slipped


def causes(case):
    """Families that beat chance, best first."""
    found = best_of_families(Scores.of(case.fit, case.problem.senses), case.targets)
    return sorted((w for w in found if w.p_value < RIVAL), key=lambda w: -w.criterion)


def test_nothing_is_found_where_nothing_is_wrong():
    found = [w for seed in range(12) for w in causes(recorded(seed))]
    assert found == []


def test_lengths_that_were_seen_do_not_agree_with_their_own_noise():
    # The scale of what was seen must be tried on what was predicted: 12 of 12 alarms otherwise.
    for seed in range(3):
        case = recorded(seed)
        scores = Scores.of(case.fit, case.problem.senses)
        found = families(Effects.of(scores, case.targets))
        scale = next(some[0] for some in found if some and some[0].family == "scale")
        weighed = weigh(scale, 1, scores, scores.A @ scores.root)
        assert weighed is None or weighed.p_value > 1e-3


@pytest.mark.parametrize("late", [0.05, -0.05])
def test_a_lag_of_either_sign(late):
    # The joints are read `late` before (after) they are seen: the eye's stamps are that early.
    case = recorded(1, n=120, smooth=True, late=late)
    best = causes(case)[0]
    assert best.family == "lag"
    assert best.gamma[0] == pytest.approx(late, rel=0.2)
    assert best.bias == pytest.approx(case.error, rel=0.4)


def test_a_slip_has_a_joint_a_size_and_a_row():
    case = recorded(2, turned=slipped(1, np.radians(2.0)))
    best = causes(case)[0]
    assert best.family == "joint slipped"
    assert "'joint_2' slipped by 1.99 deg" in best.says
    assert "row 30" in best.says
    assert best.bias == pytest.approx(case.error, rel=0.3)


def test_a_bump_has_a_frame_and_a_row():
    case = recorded(3, moved=bumped(np.array([0.0, 0.006, 0.004])))
    best = causes(case)[0]
    assert (best.family, best.share > 0.4) == ("frame moved", True)
    assert "row 30" in best.says


def test_a_gear_that_turns_too_far():
    case = recorded(4, turned=lambda q: q * [1, 1, 1.02, 1, 1])
    best = causes(case)[0]
    assert best.family == "gear"
    assert best.gamma[0] == pytest.approx(0.02, rel=0.15)


def test_a_wave_and_a_joint_that_gives_way():
    wave = causes(recorded(5, turned=lambda q: q + 0.004 * np.sin(2 * q + 1) * [0, 1, 0, 0, 0]))[0]
    assert (wave.family, "'joint_2'" in wave.says, "2 a turn" in wave.says) == ("wave", True, True)
    arm = recorded(6).truth
    sag = causes(recorded(6, n=120, turned=sagging(arm, 1, 0.02)))
    assert sag[0].family == "sag"
    assert "'joint_2'" in sag[0].says


def test_what_it_says_of_the_fit_is_what_a_fit_with_it_would_find():
    # A joint's zero that is not free, as a rival; and freed. Small, so that one step is enough.
    case = recorded(7, groups=("offsets", "axes"))
    free = case.fit.variables
    left_out = [i for i in range(len(free)) if not (free.code[i] == OFFSET and free.index[i] == 1)]
    whole = case.problem
    without = whole.learner.fit(whole.begun, free.take(left_out), whole.senses)
    scores = Scores.of(without, whole.senses)
    effects = Effects.of(scores, case.targets)
    rival = Rival("offset", "{}", "rad", effects.by_joint[:, [1]])
    weighed = weigh(rival, 1, scores, scores.A @ scores.root)
    assert weighed is not None
    again = Problem(whole.body, whole.senses, whole.frames, whole.joints)
    found = again.learner.fit(again.begun, free, again.senses)
    name = free.names.index("joint_2.offset")
    sure = found.std[name]
    assert weighed.gamma[0] == pytest.approx(found.x[name], abs=sure)
    moved = without.x + weighed.moved * without.variables.scale
    gap = np.abs(moved - found.x[left_out]) / found.std[left_out]
    assert gap.max() < 1.0


def test_the_best_of_many_is_less_of_a_surprise():
    scores = Scores.of((case := recorded(8)).fit, case.problem.senses)
    effects = Effects.of(scores, case.targets)
    B = scores.A @ scores.root
    for rival in (some[0] for some in families(effects) if some):
        alone, among = (weigh(rival, n, scores, B) for n in (1, 17))
        if alone is not None and among is not None:
            assert among.p_value == pytest.approx(min(17 * alone.p_value, 1.0))
            assert among.criterion == pytest.approx(alone.criterion - np.log(17))
