"""Transforms of scipy where an array of matrices may stand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema import lie
from bodyschema.senses.poses import Poses

transforms = pytest.importorskip("scipy.spatial.transform")
if not hasattr(transforms, "RigidTransform"):
    pytest.skip("scipy is older than 1.16", allow_module_level=True)

T = lie.transform(lie.exp_so3(np.random.default_rng(0).normal(size=(12, 3))), np.ones((12, 3)))


@pytest.fixture
def rigid() -> Any:
    return transforms.RigidTransform.from_matrix(T)


def test_one_many_and_lists(rigid: Any) -> None:
    assert lie.matrices(rigid) == pytest.approx(T)
    assert lie.matrices([rigid[0], T[1]]) == pytest.approx(T[:2])
    assert lie.matrices(T) is T


def test_where_a_person_gives_poses(rigid: Any) -> None:
    body = bs.Body.random_chain(2, np.random.default_rng(1))
    assert body.attach("eye", "tip", rigid[0]).placement[-1] == pytest.approx(T[0])
    sense = Poses.make(np.zeros((12, 2)), rigid, "base", "tip")
    assert sense.pose == pytest.approx(T)
    columns = bs.open({"T": rigid}).columns
    assert columns["T_03"].tolist() == [1.0] * 12
    solved = [bs.solve_hand_eye(A, B) for A, B in ((rigid, rigid), (T, T))]
    assert np.abs(solved[0].X - solved[1].X).max() < 1e-12
