"""The parts of the watch, one rule at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

import cv2

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.corner_fit import fitted
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.monitoring.pictures import turning
from bodyschema.monitoring.pictures.following import followed, proven
from bodyschema.monitoring.pictures.held_tool import gone, known_again
from bodyschema.monitoring.pictures.landmarks import Landmarks
from bodyschema.monitoring.pictures.learning import learned
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import ChangedTool, PictureState
from bodyschema.monitoring.pictures.watch import PictureWatch
from bodyschema.vision.anchored_corners import AnchoredTracker, no_corners
from carried_corners import STEREO, hand_poses, rows_of, world_camera
from seen_patch import HEIGHT, WIDTH, sights
from seen_patch import STEREO as SEEN

SETTINGS = PictureSettings(("a", "b"), STEREO)
EMPTY = np.zeros((HEIGHT, WIDTH), dtype=np.uint8)


def test_corners_of_the_wall_that_were_born_on_the_hand_are_dropped_with_their_rows():
    seen = list(sights(7, 32))
    around = cv2.dilate(seen[0].mask.astype(np.uint8), np.ones((41, 41), np.uint8)) > 0
    hand = AnchoredTracker(most=40).births(no_corners(seen[0].left), around, seen[0].right)
    u, v = np.rint(hand.place).astype(int).T
    on_plate = dict(zip(hand.name.tolist(), seen[0].mask[v, u].tolist(), strict=True))
    assert 0.1 < np.mean(list(on_plate.values())) < 0.9
    n = len(hand.name)
    rows = CornerRows(hand.name + 1, np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64),
                      np.tile(np.eye(4), (n, 1, 1)), hand.stereo)  # fmt: skip
    state = PictureState(mode="learn", hand=hand, wall=no_corners(seen[0].left), rows=rows)
    for sight in seen[1:]:
        state = followed(
            state,
            StereoFrame(sight.time, np.zeros(2), sight.T_world_hand, sight.left, sight.right),
        )
    left = [on_plate[int(name)] for name in state.hand.name]
    assert len(left) >= 4
    assert np.mean(left) > 0.9
    wall = [name + 1 for name, on in on_plate.items() if not on]
    assert not np.isin(wall, state.rows.corner).all()


def state_of(readings: np.ndarray, seed: int = 0) -> tuple[np.ndarray, PictureState]:
    """A camera, and a state whose rows and readings (n, 2) are of the same moments."""
    rng = np.random.default_rng(seed)
    camera = world_camera(rng)
    rows = rows_of(camera, hand_poses(len(readings), rng), rng)
    state = PictureState(
        mode="learn", frame=len(readings), hand=no_corners(EMPTY), wall=no_corners(EMPTY),
        rows=rows, readings=(np.arange(len(readings)), readings),
    )  # fmt: skip
    return camera, state


def wave(n: int) -> np.ndarray:
    return np.sin(np.arange(n) / 6.0)


def test_a_corner_is_proven_only_when_every_joint_that_moves_has_moved_in_its_life():
    late = np.where(np.arange(60) < 40, 0.0, wave(60))
    _, state = state_of(np.column_stack([wave(60), late]))
    names = proven(state, state.rows, 60)
    last = {
        n: state.rows.moment[state.rows.corner == n].max() for n in np.unique(state.rows.corner)
    }
    assert len(names)
    assert all(last[n] >= 40 for n in names)
    assert not len(proven(state, state.rows, 39))


def test_a_joint_that_never_moves_is_not_waited_for():
    _, state = state_of(np.column_stack([wave(60), np.zeros(60)]))
    assert len(proven(state, state.rows, 60)) > 5


def test_the_map_of_the_hand_is_made_of_proven_corners_alone():
    _, sure = state_of(np.column_stack([wave(60), wave(60)]))
    later = np.where(np.arange(80) < 60, 0.0, wave(80))
    moments = (np.arange(80), np.column_stack([wave(80), later]))
    unproven = replace(sure, readings=moments, frame=80)
    assert not len(learned(unproven, SETTINGS).hand_map.points)
    assert len(learned(sure, SETTINGS).hand_map.points) > 5


def test_a_fit_that_explains_nothing_is_not_taken_and_nothing_is_certain_meanwhile():
    camera, state = state_of(np.column_stack([wave(60), wave(60)]))
    fit = fitted(state.rows, camera[None], STEREO)
    known = replace(state, certified=True, fit=fit)
    assert np.isfinite(known.bounds).all()
    spoiled = state.rows.seen + 30 * np.random.default_rng(0).normal(size=state.rows.seen.shape)
    seen = np.maximum(spoiled, 5.0)
    refused = learned(replace(known, rows=replace(state.rows, seen=seen)), SETTINGS)
    assert refused.refused == 1
    assert np.array_equal(refused.fit.cameras, fit.cameras)
    assert refused.bounds == (np.inf, np.inf)
    assert learned(replace(refused, rows=state.rows), SETTINGS).refused == 0


def test_a_camera_that_turns_again_before_it_was_known_begins_from_the_last_known_one():
    camera, state = state_of(np.column_stack([wave(60), wave(60)]))
    fit = fitted(state.rows, camera[None], STEREO)
    state = replace(state, certified=True, fit=fit)
    once = turning.ended(state)
    assert once.camera == 1
    assert len(once.fit.cameras) == 2
    assert once.bounds == (np.inf, np.inf)
    new = state.rows.in_camera(1)
    again = turning.ended(replace(once, rows=once.rows.joined(new)))
    assert (again.rows.camera == 0).all()
    assert len(again.rows) == len(state.rows)
    assert np.array_equal(again.fit.cameras[0], fit.cameras[0])


def test_a_camera_that_turns_before_anything_was_known_begins_anew():
    _, state = state_of(np.column_stack([wave(60), wave(60)]))
    anew = turning.ended(state)
    assert anew.fit is None
    assert not len(anew.rows)
    assert anew.camera == 0


def test_a_certified_camera_hands_its_knowledge_on_and_gives_its_rows_up():
    camera, state = state_of(np.column_stack([wave(60), wave(60)]))
    fit = fitted(state.rows, camera[None], STEREO)
    two = replace(
        state, camera=1,
        fit=replace(
            fit, cameras=np.repeat(fit.cameras, 2, 0), covariance=np.kron(np.eye(2), fit.covariance)
        ),
    )  # fmt: skip
    after = turning.certified(two)
    assert after.mode == "observe"
    assert (after.camera, len(after.rows)) == (0, 0)
    assert np.allclose(np.linalg.inv(after.prior.S), fit.covariance, rtol=1e-6)


def with_lost_tool(**fields) -> PictureState:
    """A hand whose tool's landmarks have just been missed for the second time."""
    camera, state = state_of(np.column_stack([wave(60), wave(60)]))
    n, none = 14, np.zeros(14, dtype=np.int64)
    tool = np.arange(n) < 6
    marks = Landmarks(
        np.arange(n), np.where(tool[:, None], [0.0, 0.0, 0.2], [0.0, 0.0, 0.0]),
        np.tile(lie.exp_so3([0.0, 0.0, 3.0]), (n, 1, 1)), np.zeros((n, 225)),
        np.zeros((n, 6, 225)), np.full(n, 100.0), np.where(tool, 2, 0), none + 10,
        none + 10 + np.where(tool, 2, 0), np.full(n, 5.0),
    )  # fmt: skip
    fit = fitted(state.rows, camera[None], STEREO)
    return replace(state, certified=True, fit=fit, landmarks=marks, **fields)


def frame() -> StereoFrame:
    return StereoFrame(5.5, np.zeros(2), np.eye(4), EMPTY, EMPTY)


def test_a_swap_is_told_once():
    state, told = gone(with_lost_tool(), frame(), SETTINGS)
    assert told
    assert len(state.landmarks.name) == 8
    assert state.changed_tool is not None
    known = ChangedTool(0, np.zeros((0, 3)))
    again, told = gone(with_lost_tool(changed_tool=known), frame(), SETTINGS)
    assert not told
    assert again.changed_tool is known


def test_a_tool_is_known_again_by_corners_that_are_younger_and_elsewhere():
    state = with_lost_tool(changed_tool=ChangedTool(0, np.zeros((0, 3))))
    assert known_again(state)
    assert not known_again(replace(state, changed_tool=ChangedTool(10**6, np.zeros((0, 3)))))
    assert not known_again(replace(state, changed_tool=ChangedTool(0, state.fit.place)))
    assert not known_again(replace(state, changed_tool=None))


def test_pictures_that_are_none_are_refused():
    watch = PictureWatch(PictureSettings(("a",), SEEN))
    wrong = replace(frame(), right=np.zeros((3, 4), dtype=np.uint8))
    with pytest.raises(InputError, match="two grey 8-bit pictures of one size"):
        watch.step(watch.start(), wrong)
