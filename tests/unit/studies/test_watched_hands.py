"""Both hands on their way to each other: the aims, the errors, what knowing the offsets does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

from bodyschema.acting.servoing import Servoing
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.studies.hand_methods import Method
from bodyschema.studies.meeting_hands import APART, ARMS, both_offsets, fingertips, meeting
from bodyschema.studies.watched_hands import MeetingTrace, watch_meeting

pytestmark = pytest.mark.usefixtures("offscreen")


@dataclass(frozen=True)
class Known:
    """What a learner reports that has been told the offsets of an arm."""

    offsets: np.ndarray
    covariance: np.ndarray
    effective_size: float = 1.0


@dataclass(frozen=True)
class Told:
    """A learner that knows a share of the true offsets, and looks at nothing."""

    share: float

    def start(self, body: Any, joints: tuple[str, ...]) -> np.ndarray:
        return self.share * np.array([both_offsets()[name] for name in joints])

    def step(self, state: np.ndarray, moment: Any) -> tuple[np.ndarray, tuple[Known]]:
        return state, (Known(state, np.zeros((7, 7))),)


def met(share: float) -> MeetingTrace:
    method = Method(lambda *_: Told(share), True)
    return watch_meeting(method, 0, "plain", "identical", 1, 0, 2, 25, Servoing())


def test_palms_face_each_other_12_cm_apart_at_the_end() -> None:
    body, way = icub.nominal_icub(), meeting(0)
    assert meeting(5).q_d.tolist() == way.q_d.tolist()
    assert meeting(5).q_i.tolist() != way.q_i.tolist()
    tips = fingertips(way.T_d)
    assert np.linalg.norm(tips[0] - tips[1]) == pytest.approx(APART, abs=1e-5)
    right, left = (relative_pose(body, way.q_d, body.frames[0], arm.hand) for arm in ARMS)
    np.testing.assert_allclose(right[:3, 1], [0, 1, 0], atol=1e-5)
    np.testing.assert_allclose(left[:3, 1], [0, -1, 0], atol=1e-5)


def test_the_left_hand_is_the_right_one_in_a_mirror() -> None:
    """But for what the two sides of the URDF differ by."""
    body = icub.nominal_icub()
    q = np.clip(np.zeros(len(body.joints)), body.lower, body.upper)
    T = np.array([relative_pose(body, q, body.frames[0], arm.hand) for arm in ARMS])
    right, left = fingertips(T)
    np.testing.assert_allclose(left, right * [1, -1, 1], atol=1e-3)


def test_who_knows_the_offsets_brings_the_hands_together() -> None:
    knowing, ignorant = met(1.0), met(0.0)
    assert knowing.gap[1] == pytest.approx(ignorant.gap[1])  # the open loop is blind
    assert knowing.gap[1] > 160
    assert knowing.gap[-1] == pytest.approx(1e3 * APART, abs=0.1)
    assert knowing.between[-1] == pytest.approx([0, 0], abs=0.1)
    np.testing.assert_allclose(knowing.estimation, 0, atol=1e-3)
    np.testing.assert_allclose(knowing.reaching[-1], 0, atol=0.1)
    assert ignorant.gap[-1] > 160
    assert np.min(ignorant.reaching[-1], axis=0)[0] > 20
