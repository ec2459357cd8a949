"""What an answer from pictures states of the hand in its base."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.answers.track import _predicted_95
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.prediction import predict_error
from bodyschema.learners.images.elsewhere import Elsewhere
from bodyschema.model.kinematics import relative_pose

RNG = np.random.default_rng(0)
BODY = bs.Body.random_chain(3, RNG).attach("eye", "base")
Q = RNG.uniform(-1, 1, (30, 3))
OFFSETS = bs.free_joints(BODY, ["offsets"]).with_prior(np.full(3, 0.1))


def test_a_doubted_camera_brings_its_own_error_and_the_shift_of_the_hand() -> None:
    hand = BODY.frames[-2]
    own = Estimate(BODY, OFFSETS, np.zeros(3), 1e6 * np.eye(3))
    both = bs.join(OFFSETS, bs.free_frame(BODY, "eye", 0.05, 0.1))
    shifted = np.array([0.01, -0.01, 0.01, *np.zeros(6)])
    freed = Estimate(BODY, both, shifted, 1e4 * np.eye(9))
    other = Elsewhere(freed, ("eye",), 200.0, 5, 1.0)
    found: Any = SimpleNamespace(fit=SimpleNamespace(lost=False, estimate=own), elsewhere=None)
    base = BODY.frames[0]
    alone = predict_error(own, Q, base, hand).position_overall
    assert _predicted_95(found, hand, Q) == alone
    found.elsewhere = replace(other, surprise=1.0)
    assert _predicted_95(found, hand, Q) == alone
    found.elsewhere = other
    there = [relative_pose(body, Q, base, hand)[:, :3, 3] for body in (BODY, freed.body)]
    moved = np.quantile(np.linalg.norm(there[1] - there[0], axis=1), 0.95)
    wide = predict_error(freed, Q, base, hand).position_overall
    assert moved > 5 * alone
    assert _predicted_95(found, hand, Q) == pytest.approx(np.hypot(moved, wide))
    found.fit.lost = True
    assert _predicted_95(found, hand, Q) is None
