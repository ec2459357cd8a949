"""Limits that leave no range, against what was recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.model.limits import contradicted_limits, with_recorded_limits
from bodyschema.model.tree import Body


def arm(lower: float, upper: float) -> Body:
    body = Body.random_chain(2, np.random.default_rng(1))
    return replace(body, lower=np.array([lower, -1.0]), upper=np.array([upper, 1.0]))


Q = np.array([[-0.4, 0.2], [0.6, 1.3]])


@pytest.mark.parametrize(("lower", "upper"), [(0.0, 0.0), (0.3, 0.3), (1.5, -0.5)])
def test_a_range_of_nothing_is_unknown_when_it_was_left(lower: float, upper: float) -> None:
    body = arm(lower, upper)
    assert contradicted_limits(body, Q).tolist() == [True, False], "1.3 is beyond a real limit"
    known = with_recorded_limits(body, Q)
    assert (known.lower.tolist(), known.upper.tolist()) == ([-0.4, -1], [0.6, 1])
    (remark,) = known.remarks
    assert "The limits of joint_1 leave no range" in remark
    assert with_recorded_limits(known, Q) is known, "said once"


def test_a_locked_joint_stays_locked() -> None:
    """One that stands where its limits are, or was not recorded."""
    body = arm(0.0, 0.0)
    still = Q * [0, 1]
    assert with_recorded_limits(body, still) is body
    assert with_recorded_limits(body, np.empty((0, 2))) is body
    assert with_recorded_limits(arm(-np.inf, np.inf), Q).remarks == ()
