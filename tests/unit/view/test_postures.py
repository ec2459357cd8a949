"""Which postures are shown, and where the frames are in them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.view.postures import MOST, Moving, Recorded
from simulated import points, postures


def test_rows_are_spread_and_outliers_left_out(seen: Any) -> None:
    recorded = Recorded.by(seen.senses, seen.answer.body, (7,))
    assert recorded.rows.tolist() == [row for row in range(30) if row != 7]
    np.testing.assert_array_equal(recorded.q[3], seen.senses[0].q[3])


def test_many_rows_are_thinned(seen: Any) -> None:
    rng = np.random.default_rng(0)
    body = seen.answer.body
    many = points(body, postures(500, body, rng), rng, 1e-3, "base", "tool")
    recorded = Recorded.by([many], body)
    assert len(recorded.rows) == MOST
    assert recorded.rows[[0, -1]].tolist() == [0, 499]


def test_without_a_recording_there_is_one_posture(seen: Any) -> None:
    recorded = Recorded.by((), seen.answer.body)
    assert recorded.rows.tolist() == [-1]
    assert recorded.q.shape == (1, 4)


def test_frames_are_where_the_bodies_say(seen: Any) -> None:
    estimate, q = seen.answer.estimate, seen.senses[0].q[:3]
    moving = Moving.of(estimate, q, {"tool"}, {"tool"})
    k = moving.frames.index("tool")
    for body, poses in ((estimate.reference, moving.before), (estimate.body, moving.after)):
        np.testing.assert_allclose(poses[:, k], relative_pose(body, q, "base", "tool"))
    assert moving.frames[moving.parent[k]] == estimate.body.frames[4]
    assert not moving.corrected[k], "a frame that was estimated has no before"
    assert moving.shift[1] != "tool"
    packed = moving.packed(moving.after)[:, k]
    np.testing.assert_allclose(packed[:, :3], moving.after[:, k, :3, 3], atol=1e-6)
    R = lie.rotation_from_xyzw(packed[:, 3:].astype(float))
    np.testing.assert_allclose(R, moving.after[:, k, :3, :3], atol=1e-5)
