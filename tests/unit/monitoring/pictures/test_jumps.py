"""A slip is several corners that jump as one; a creep, a flight of one and a forearm are none."""

from __future__ import annotations

import numpy as np

from bodyschema import lie
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.monitoring.pictures import jumps
from carried_corners import STEREO, hand_poses, world_camera

MOMENTS = 30
RNG = np.random.default_rng(0)
CAMERA = world_camera(RNG)
POSES = hand_poses(MOMENTS, RNG)
PLACES = 0.05 * RNG.normal(size=(12, 3))


def seen(shift: np.ndarray, noise: float = 0.05) -> CornerRows:
    """Rows of 12 corners that are shifted on the hand by (12, MOMENTS, 3) m."""
    rows, rng = CornerRows.none(), np.random.default_rng(1)
    for k, place in enumerate(PLACES):
        at = place + shift[k]
        c = np.einsum("nij,nj->ni", POSES[:, :3, :3], at) + POSES[:, :3, 3]
        pixel = STEREO.project(c)
        y = np.column_stack([pixel[:, :2], pixel[:, 0] - pixel[:, 2]])
        rows = rows.joined(
            CornerRows(
                np.full(MOMENTS, k + 1), 3 * np.arange(MOMENTS), np.zeros(MOMENTS, dtype=np.int64),
                CAMERA @ POSES, y + noise * rng.normal(size=y.shape),
            )
        )  # fmt: skip
    return rows


def found(shift: np.ndarray):
    return jumps.found(seen(shift), 3 * (MOMENTS - 1), CAMERA, STEREO, 3)


def nothing() -> np.ndarray:
    return np.zeros((12, MOMENTS, 3))


def test_nothing_has_jumped():
    assert found(nothing()) is None


def test_five_corners_that_jump_as_one_are_a_slip():
    shift = nothing()
    shift[:5, -2:] = [0.0, 0.012, 0.004]
    jump = found(shift)
    assert jump is not None
    assert set(jump.name) == {1, 2, 3, 4, 5}
    assert abs(jump.length - np.hypot(0.012, 0.004)) < 0.003


def test_a_turn_of_the_tool_is_a_slip_too():
    shift, R = nothing(), lie.exp_so3([0.0, 0.25, 0.1])
    shift[:6, -2:] = (PLACES[:6] @ R.T - PLACES[:6] + [0.01, 0, 0])[:, None]
    jump = found(shift)
    assert jump is not None
    assert len(jump.name) >= 4


def test_three_are_too_few():
    shift = nothing()
    shift[:3, -2:] = [0.0, 0.012, 0.004]
    assert found(shift) is None


def test_corners_that_fly_each_its_own_way_are_none():
    shift = nothing()
    shift[:6, -2:] = 0.02 * np.random.default_rng(2).normal(size=(6, 1, 3))
    assert found(shift) is None


def test_what_creeps_away_is_none():
    shift = nothing()
    shift[:6] = 0.0006 * np.arange(MOMENTS)[None, :, None] * [0.0, 1.0, 0.4]
    assert found(shift) is None


def test_what_has_begun_to_creep_is_none():
    """A corner of the forearm, when the wrist begins to turn after it was still for long."""
    shift = nothing()
    shift[:6] = 0.001 * np.maximum(np.arange(MOMENTS) - 22, 0)[None, :, None] * [0.0, 1.0, 0.4]
    assert found(shift) is None


def test_what_stays_in_the_world_is_none():
    """Corners of the wall jump on the hand when the hand does; in the world they stand."""
    T = CAMERA @ POSES
    T[-2:] = T[-2:] @ lie.transform(np.eye(3), [0.0, 0.02, 0.0])
    on_world = np.einsum("nij,kj->nki", T[:1, :3, :3], PLACES) + T[:1, None, :3, 3]
    c = (on_world - CAMERA[:3, 3]) @ CAMERA[:3, :3]
    pixel = STEREO.project(np.repeat(c, MOMENTS, axis=0))
    still = T.copy()
    still[:-2] = T[0]
    rows = CornerRows.none()
    for k in range(12):
        y = np.column_stack([pixel[:, k, :2], pixel[:, k, 0] - pixel[:, k, 2]])
        rows = rows.joined(
            CornerRows(
                np.full(MOMENTS, k + 1), 3 * np.arange(MOMENTS), np.zeros(MOMENTS, dtype=np.int64),
                still, y,
            )
        )  # fmt: skip
    assert jumps.found(rows, 3 * (MOMENTS - 1), CAMERA, STEREO, 3) is None
