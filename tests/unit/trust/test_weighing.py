"""The one number: as large as the error, whatever is wrong, and no larger where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.answers.calibrate import calibrate
from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.points import Points
from bodyschema.trust.weighing import weighed_up
from faulty import PAIR, autoregressive, bumped, recorded, sagging, slipped
from simulated import seen_arm


def weighed(case):
    (sense,) = case.problem.senses
    fields = {sense.label: learn_discrepancy(case.fit.body, sense, ~case.fit.outliers[0])}
    return weighed_up(case.fit, case.fit, case.problem.senses, fields, [PAIR])


def test_a_good_answer_stays_good_and_narrow():
    cases = [recorded(seed) for seed in range(10)]
    found = [weighed(case) for case in cases]
    assert [w.trust.level for w in found] == ["good"] * 10
    ratio = [w.total / case.error for w, case in zip(found, cases, strict=True)]
    assert 0.9 < np.median(ratio) < 1.3


FAULTS = {
    "late": {"n": 120, "smooth": True, "late": 0.05},
    "bumped": {"moved": bumped(np.array([0.0, 0.008, 0.005]))},
    "slipped": {"turned": slipped(1, np.radians(2))},
    "gear": {"turned": lambda q: q * [1, 1, 1.02, 1, 1]},
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_answer_is_never_good_nor_its_number_small(fault):
    for seed in range(3):
        case = recorded(seed, **FAULTS[fault])
        found = weighed(case)
        assert found.trust.level != "good"
        assert found.total > case.error / 2
        assert found.stated < case.error / 1.5


def test_slow_noise_is_said():
    noise = autoregressive(100, 0.9, 1e-3, np.random.default_rng(0))
    found = weighed(recorded(0, n=100, smooth=True, noise=noise))
    assert found.trust.level != "good"
    assert any("neighbours in time err alike" in reason for reason in found.trust.reasons)


def test_the_cause_is_named_with_its_share_and_its_runner_up():
    found = weighed(recorded(1, n=120, smooth=True, late=0.05))
    (reason, *_) = found.trust.reasons
    assert "the joints were read" in reason
    assert "next best" in reason
    assert found.causes[0]["cause"] == "lag"
    assert found.causes[0]["share"] > 0.5
    assert found.rather_than("lag") == ""
    assert found.rather_than("sag").startswith("the joints were read")


def test_calibrate_refuses_what_its_samples_contradict():
    case = recorded(1, n=120, smooth=True, late=0.05)
    problem = case.problem
    answer = calibrate(problem.body, problem.senses, problem.frames, ("offsets", "axes"), folds=3)
    assert answer.trust.level == "contradicted"
    assert answer.verdict == "contradicted"
    assert answer.withheld
    assert answer.stated_95 == answer.weighing.total > answer.weighing.stated
    document = answer.document
    assert document["trust"]["level"] == "contradicted"
    assert document["predicted_95_mm"] == pytest.approx(1e3 * answer.stated_95, rel=1e-4)
    assert document["uncertainty"]["causes"][0]["cause"] == "lag"
    assert "Trust: contradicted" in answer.summary()


def test_half_of_a_fit_that_has_not_arrived_is_added():
    # A learner that stands where its samples would not leave it: the rest of the way is its error.
    case = recorded(3, groups=("offsets",))
    away = replace(case.fit, x=case.fit.x + 10 * case.fit.std)
    moved = weighed_up(away, away, case.problem.senses, {}, [PAIR])
    settled = weighed_up(case.fit, case.fit, case.problem.senses, {}, [PAIR])
    assert moved.core > 3 * settled.core


def test_a_joint_that_gives_way_is_no_fault_of_the_clocks():
    # Two joints on a grid, one sweeping fastest: what a weight does looks like what a lag does.
    rng = np.random.default_rng(0)
    arm = seen_arm(2, rng)
    one, other = np.meshgrid(np.linspace(-1.2, 1.2, 7), np.linspace(-1.2, 1.2, 14), indexing="ij")
    q = np.stack([one.ravel(), other.ravel()], axis=1)
    bent = sagging(arm, 1, 0.004)(sagging(arm, 0, 0.004)(q))
    place = relative_pose(arm, bent, *PAIR)[:, :3, 3] + 1e-4 * rng.normal(size=(len(q), 3))
    seen = Points.make(q, place, *PAIR, 1e-3)
    answer = calibrate(arm, [seen], {"tracker": "no", "tool": "no"}, folds=3)
    assert answer.clock.instead == "'joint_1' gives way under its load"
