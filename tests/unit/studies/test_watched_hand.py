"""The protocol of the hand that watches itself: poses, mismatch, errors, both loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

from bodyschema import lie
from bodyschema.acting.servoing import Servoing
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.studies.hand_methods import Method
from bodyschema.studies.hand_movements import LONGEST, SHORTEST, movement, movements_to
from bodyschema.studies.watched_hand import believed, distance, watch
from imagined_hand import BETA

pytestmark = pytest.mark.usefixtures("offscreen")


@dataclass(frozen=True)
class Known:
    """What a learner reports that has been told the offsets."""

    offsets: np.ndarray
    covariance: np.ndarray
    effective_size: float = 1.0


@dataclass(frozen=True)
class Told:
    """A learner that knows, and looks at nothing."""

    offsets: np.ndarray
    spread: float = 1e-6

    def start(self, body, joints):
        return None

    def step(self, state, moment):
        return state, (Known(self.offsets, self.spread**2 * np.eye(7)),)


def run(offsets, gated=False, spread=1e-6, model="identical"):
    method = Method(lambda *_: Told(offsets, spread), gated)
    return watch(method, 0, "plain", model, 1, 0, 3, 25, Servoing())


def test_movements_are_as_long_as_the_paper_s():
    ways = movements_to(0)
    assert len(ways) == 10
    assert movement(4) is ways[1]
    body = icub.nominal_icub()
    for way in ways:
        T = relative_pose(body, np.stack([way.q_i, way.q_d]), icub.LEFT_EYE, icub.HAND)
        assert SHORTEST < np.linalg.norm(T[0, :3, 3] - way.T_d[:3, 3]) < LONGEST
        np.testing.assert_allclose(T[1], way.T_d, atol=1e-5)


def test_distance_is_in_millimetres_and_degrees():
    A = lie.transform(np.eye(3), [0.0, 0, 1])
    B = lie.transform(lie.exp_so3([0, np.pi - 1e-9, 0]), [0.003, 0.004, 1])
    np.testing.assert_allclose(distance(A, B), [5.0, 180.0])


def test_who_knows_the_offsets_reaches_and_who_does_not_stays_off():
    knowing, ignorant = run(BETA), run(np.zeros(7))
    np.testing.assert_allclose(knowing.estimation, 0, atol=1e-3)
    np.testing.assert_allclose(ignorant.estimation, ignorant.without)
    assert knowing.without[2][0] > 30
    assert knowing.reaching[2] == pytest.approx(ignorant.reaching[2])  # the open loop is blind
    assert knowing.reaching[-1][0] < 0.1
    assert ignorant.reaching[-1][0] > 30
    # Without knowing better, the robot believes that it has arrived.
    assert ignorant.believed_reaching[-1][0] < 0.1


def test_a_gate_keeps_an_unsure_arm_where_it_is():
    still = run(BETA, gated=True, spread=0.5)
    assert still.reaching[-1] == pytest.approx(still.reaching[2])


def test_the_mismatch_is_the_stated_one():
    true, wrong = believed("identical"), believed("mismatched")
    for a, b in zip(true.cameras, wrong.cameras, strict=True):
        np.testing.assert_allclose(b.intrinsics[:2], 1.005 * a.intrinsics[:2])
        np.testing.assert_allclose(b.intrinsics[2:], a.intrinsics[2:] + np.array([1, 0]))
        q = np.clip(np.zeros(32), true.body.lower, true.body.upper)
        T = [relative_pose(each.body, q, icub.HEAD, a.frame) for each in (true, wrong)]
        assert distance(*T) == pytest.approx([0, 0.1])
    assert len(wrong.surface.faces) < 0.6 * len(true.surface.faces)
    assert run(np.zeros(7), model="mismatched").without[0][0] > 30
