"""`check` at its stated rate although the model is not quite true, and with a least effect."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.answers.answer import Answer
from bodyschema.answers.calibrate import calibrate
from bodyschema.model.variables import free_joints
from bodyschema.monitoring.change import detect_change
from faulty import PAIR, recorded, sagging
from simulated import points, postures

SPLITS = 10
"""Of each robot, seven tenths against three."""


def answered(sense, problem) -> Answer:
    return calibrate(problem.body, [sense], problem.frames, ("offsets", "axes", "links"), folds=2)


def split(case, seed):
    """Some samples to calibrate with, and the others to check with."""
    (sense,) = case.problem.senses
    order = np.random.default_rng(seed).permutation(len(sense))
    k = round(0.7 * len(sense))
    return sense.take(np.sort(order[:k])), sense.take(np.sort(order[k:]))


def imperfect(seed):
    """A gear that turns two percent too far, or a joint that gives way."""
    truth = recorded(seed).truth
    turned = sagging(truth, 1, 0.02) if seed % 2 else lambda q: q * [1, 1, 1.02, 1, 1]
    return recorded(seed, n=100, turned=turned, noise=1e-4)


def test_one_robot_that_is_not_its_model_has_not_changed():
    alarms, plain = [], []
    for seed in range(2 * SPLITS):
        case = imperfect(seed)
        before, after = split(case, seed)
        answer = answered(before, case.problem)
        alarms.append(answer.check([after], 0.01, least=0.0).changed)
        plain.append(detect_change(answer.estimate, [after], answer.fields, 0.01).changed)
    # A belief that takes each sample at its word calls one robot in six another.
    assert sum(plain) >= 3
    assert sum(alarms) == 0


@pytest.fixture(scope="module")
def calibrated():
    """A good robot's answer, and how it would be seen with the zero of joint 2 so far off."""
    case = recorded(3, n=80)
    answer = answered(case.problem.senses[0], case.problem)

    def seen(offset: float):
        zero = free_joints(case.truth, ("offsets",), ["joint_2"])
        rng = np.random.default_rng(9)
        q = postures(40, case.truth, rng, 1.5)
        return points(case.truth.with_variables(zero, [offset]), q, rng, 5e-4, *PAIR)

    return answer, seen


def test_a_change_that_matters_is_found_with_its_effect(calibrated):
    answer, seen = calibrated
    test = answer.check([seen(np.radians(0.5))])
    assert test.changed
    joint = next(suspect for suspect in test.suspects if suspect.part == "joint_2")
    assert joint.change[0] == pytest.approx(np.radians(0.5), rel=0.2)
    assert joint.effect > answer.least_change > 0


def test_a_change_that_does_not_matter_is_none(calibrated):
    answer, seen = calibrated
    small = [seen(np.radians(0.08))]
    found = answer.check(small, least=0.0)
    assert found.changed
    largest = max(suspect.effect for suspect in found.suspects)
    assert not answer.check(small, least=2 * largest).changed
    assert answer.check(small, least=2 * largest).suspects == ()
