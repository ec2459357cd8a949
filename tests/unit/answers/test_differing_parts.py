"""Which parts explain a difference, on beliefs made for the purpose."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.answers.common_ground import CommonGround
from bodyschema.answers.differing_parts import Differing
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.variables import free_joints

ARM = Body.random_chain(3, np.random.default_rng(0))
ZEROS = free_joints(ARM, ("offsets",))


def test_a_part_that_stood_for_two_others_goes_out_again() -> None:
    """The first joint's column lies between those of the others, of which both have changed."""
    J = 3e3 * np.array([[0.7, 1.0, 0.0], [0.7, 0.0, 1.0], [0.14, 0.0, 0.0]])
    ground = CommonGround(
        ZEROS, np.array([0.0, 0.05, 0.05]), np.linalg.inv(J.T @ J), np.eye(3), (), ()
    )
    found = Differing.of(ground, 0.005)
    assert [part.part for part in found.parts if part.differs] == ["joint_2", "joint_3"]
    assert found.parts[0].change == pytest.approx([0.05])
    assert np.abs(found.left).max() < 1e-9


def test_what_a_prior_holds_back_is_given_back() -> None:
    """Data that say nine times as much as the prior move a belief by nine tenths of a change."""
    H = np.diag([1e8, 1e8, 9.0]) * np.diag(ZEROS.prior_std**-2.0)
    before = Estimate(ARM, ZEROS, np.zeros(3), H)
    after = Estimate(ARM, ZEROS, np.array([0.0, 0.0, 0.27]), H)
    found = Differing.of(CommonGround.of(before, after), 0.05)
    (third,) = [part for part in found.parts if part.part == "joint_3"]
    assert third.change == pytest.approx([0.3])
