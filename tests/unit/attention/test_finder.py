"""The detectors on pictures: a bar that turns, a thing that swings by itself."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.frames import Frame
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.errors import InputError
from moving_bar import BREADTH, HEIGHT, LENGTH, PIVOT, WIDTH, angles, pictures

cv2 = pytest.importorskip("cv2")

SIZE = (WIDTH, HEIGHT)
LATE = 2
"""Frames by which the pictures are late."""


def film(motions: int) -> tuple[np.ndarray, np.ndarray]:
    """Grey pictures (n, HEIGHT, WIDTH) of the bar, with a swinging patch, and readings (n, 2)."""
    q = angles(motions)
    seen = np.concatenate([np.full(LATE, q[0]), q[:-LATE]])
    grey = np.stack([picture[..., 0] for picture in pictures(seen)])
    patch = np.random.default_rng(9).integers(0, 256, (32, 32)).astype(np.uint8)
    patch = cv2.GaussianBlur(patch, (0, 0), 1.5)
    for i, picture in enumerate(grey):
        x = round(8 + 6 * np.sin(2 * np.pi * 0.7 * i / 30))
        picture[HEIGHT - 34 : HEIGHT - 2, x : x + 32] = patch
    return grey, np.stack([q, np.zeros(len(q))], axis=1)


def watch(detector: BodyFinder | OnsetCoincidence, motions: int = 6) -> BodyInView:
    state = detector.start(SIZE)
    for i, (picture, q) in enumerate(zip(*film(motions), strict=True)):
        state, _ = detector.step(state, (Frame(i / 30, picture, q),))
    return detector.found(state)


def bar_cells() -> np.ndarray:
    """(9, 12) share of each cell that the bar covers half way through its turn."""
    at = np.full((HEIGHT, WIDTH), 0, dtype=np.float32)
    corners = np.array([[0, -0.5], [1, -0.5], [1, 0.5], [0, 0.5]]) * [LENGTH, BREADTH]
    c, s = np.cos(0.125), np.sin(0.125)
    placed = corners @ np.array([[c, s], [-s, c]]) + PIVOT
    cv2.fillPoly(at, [np.rint(placed).astype(np.int32)], 1.0)
    return at.reshape(9, 16, 12, 16).mean(axis=(1, 3))


@pytest.fixture(scope="module")
def found() -> BodyInView:
    return watch(BodyFinder(("turn", "idle")))


def test_the_bar_is_me_and_the_swinging_patch_is_not(found):
    covered = bar_cells()
    assert found.mask[covered > 0.6][1:].mean() > 0.7
    assert not found.mask[cv2.dilate(covered, np.ones((3, 3))) == 0].any()
    assert set(found.joint[found.mask]) == {0}
    assert (found.joint[~found.mask] == -1).all()
    assert found.pixels().sum() == 256 * found.mask.sum()


def test_the_delay_is_learned_and_known(found):
    assert abs(found.lag_s - LATE / 30) < 0.012
    assert found.lag_sd_s < 0.02
    assert found.motions == 6


def test_it_asks_for_the_joint_that_has_not_moved(found):
    assert not found.enough
    assert "idle" in found.reason
    assert found.next_motion is not None
    assert found.next_motion.joint == "idle"
    alone = BodyFinder(("turn",))
    state = alone.start(SIZE)
    for i, (picture, q) in enumerate(zip(*film(6), strict=True)):
        state, _ = alone.step(state, (Frame(i / 30, picture, q[:1]),))
    assert alone.found(state).enough
    assert alone.found(state).next_motion is None


def test_cells_move_now_only_while_the_bar_does():
    finder, (grey, q) = BodyFinder(("turn", "idle")), film(2)
    state, now = finder.start(SIZE), []
    for i in range(len(grey)):
        state, _ = finder.step(state, (Frame(i / 30, grey[i], q[i]),))
        moves = finder.found(state).now.astype(np.float32)
        around = cv2.filter2D(moves, -1, np.ones((3, 3)), borderType=cv2.BORDER_CONSTANT)
        assert (around[moves > 0] > 1).all()  # no cell moves all alone
        now.append(int(moves.sum()))
    assert max(now[:16]) == 0
    assert max(now[18:30]) > 8
    assert now[-1] == 0


def test_the_published_detector_is_fooled_by_what_its_window_lets_in():
    found = watch(OnsetCoincidence(("turn", "idle")))
    covered = bar_cells()
    assert found.mask[covered > 0.6][1:].mean() > 0.7
    assert found.evidence[0].max() >= 5
    assert not found.evidence[1].any()
    assert found.motions == 6
    assert found.next_motion is not None
    assert (found.next_motion.kind, found.next_motion.joint) == ("repeat", "turn")
    voted = watch(OnsetCoincidence(("turn", "idle"), votes=4))
    assert voted.mask.sum() < found.mask.sum()


def test_states_are_values_and_the_same_film_gives_the_same_answer(found):
    finder, (grey, q) = BodyFinder(("turn", "idle")), film(1)
    first, _ = finder.step(finder.start(SIZE), (Frame(0.0, grey[0], q[0]),))
    before = first.sums.A.copy(), first.image.copy()
    finder.step(first, (Frame(0.1, grey[20], q[20]),))
    np.testing.assert_array_equal(first.sums.A, before[0])
    np.testing.assert_array_equal(first.image, before[1])
    with pytest.raises(FrozenInstanceError):
        first.time = 1.0
    again = watch(finder)
    np.testing.assert_array_equal(again.probability, found.probability)
    assert again.lag_s == found.lag_s


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"joints": ()}, "at least one joint"),
        ({"joints": ("a", "a")}, "named twice: a"),
        ({"cell_px": 4}, "give 8 or more"),
        ({"camera_joints": ("nek",)}, "no joint 'nek'"),
        ({"camera_joints": ("a", "b")}, "every joint carries the camera"),
        ({"false_share": 0.0}, "give 0 to 1"),
        ({"longest_lag_s": 3.0}, "up to 1"),
    ],
)
def test_settings_that_cannot_work_are_refused(change, says):
    with pytest.raises(InputError, match=says):
        BodyFinder(**({"joints": ("a", "b")} | change))


@pytest.mark.parametrize("kind", [BodyFinder, OnsetCoincidence])
def test_frames_that_cannot_be_used_are_refused(kind):
    detector = kind(("a", "b"))
    picture, q = np.zeros((HEIGHT, WIDTH), dtype=np.uint8), np.zeros(2)
    state, _ = detector.step(detector.start(SIZE), (Frame(1.0, picture, q),))
    for time, image, positions, says in (
        (1.0, picture, q, "order of time"),
        (np.nan, picture, q, "order of time"),
        (2.0, picture[:-1], q, "expected frames of 192 x 144"),
        (2.0, picture.astype(float), q, "grey image"),
        (2.0, np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8), q, "grey image"),
        (2.0, picture, np.zeros(3), "expected 2 joint positions"),
        (2.0, picture, np.array([0.0, np.nan]), "joint 'b' at 2 s is nan"),
    ):
        with pytest.raises(InputError, match=says):
            detector.step(state, (Frame(time, image, positions),))
    with pytest.raises(InputError, match="fewer than 3 cells"):
        detector.start((40, 200))


def test_nothing_is_said_before_anything_has_moved():
    finder = BodyFinder(("a",))
    found = finder.found(finder.start(SIZE))
    assert not found.mask.any()
    assert np.isnan(found.lag_s)
    assert found.reason == "no joint has moved yet."
    assert found.next_motion is not None
