"""Corners of hand and wall from frame to frame, and the rows that they leave.

A corner that was born on the hand but stays where it is while others move is on the wall: it is
dropped with its rows. One of the forearm moves too, and is found out by its residuals later; until
every joint that moves has moved during a corner's life it is not `proven` to be on the hand.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import PictureState
from bodyschema.vision.anchored_corners import AnchoredTracker, Corners

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

HAND, WALL = AnchoredTracker(most=40), AnchoredTracker(most=16)
STAY, STAYS, GOES = 10, 1.0, 4.0
"""Frames between two looks at which corners stay, px that one that stays moves at most, and px that
the fastest quarter must have moved meanwhile."""
EXCURSION, LATELY, REMEMBERED = 0.08, 50, 600
"""rad by which every joint that moves must have moved while a corner lived, moments in which it
must have moved twice as far to count as one that moves, and moments that are remembered."""
LONGEST = 200
"""Rows that a corner keeps; every second one goes when there are more."""


def followed(state: PictureState, frame: StereoFrame) -> PictureState:
    """All corners in the next frame."""
    assert state.hand is not None
    assert state.wall is not None
    hand = HAND.step(state.hand, frame.left, frame.right)
    wall = WALL.step(state.wall, frame.left, frame.right)
    hand = hand.only(~np.isin(hand.name, state.strays))
    passed, rows = state.passed, state.rows
    if state.frame % STAY == 0:
        if passed is not None:
            stays = _stays(hand, *passed)
            rows = rows.only(~np.isin(rows.corner, hand.name[stays] + 1))
            hand = hand.only(~stays)
        passed = (hand.name, hand.place)
    return replace(state, frame=state.frame + 1, hand=hand, wall=wall, passed=passed, rows=rows)


def noted(state: PictureState, frame: StereoFrame, settings: PictureSettings) -> PictureState:
    """With rows of this moment, every few frames."""
    if state.frame % settings.every:
        return state
    assert state.hand is not None
    assert state.wall is not None
    rows = state.rows.joined(_rows(state.hand, 1, frame.T_world_hand, state))
    rows = rows.joined(_rows(state.wall, -1, np.eye(4), state))
    moment, q = np.array([state.frame]), np.asarray(frame.q, dtype=np.float64)[None]
    if state.readings is not None:
        moment = np.concatenate([state.readings[0], moment])[-REMEMBERED:]
        q = np.concatenate([state.readings[1], q])[-REMEMBERED:]
    return replace(state, rows=_shortened(rows, state), readings=(moment, q))


def proven(state: PictureState, rows: CornerRows, until: int) -> Ints:
    """Names of corners in whose rows, up to a moment, every joint that moves has moved."""
    rows = rows.only(rows.moment <= until)
    if state.readings is None or not len(rows):
        return np.zeros(0, dtype=np.int64)
    moment, q = state.readings
    moves = np.ptp(q[-LATELY:], axis=0) > 2 * EXCURSION
    names, first, _ = rows.grouped()
    read = q[np.clip(np.searchsorted(moment, rows.moment), 0, len(moment) - 1)]
    span = np.maximum.reduceat(read, first) - np.minimum.reduceat(read, first)
    return np.asarray(names[(span[:, moves] > EXCURSION).all(axis=1)])


def _rows(corners: Corners, sign: int, carrier: Array, state: PictureState) -> CornerRows:
    """One row of each corner that is seen in both pictures."""
    stereo = corners.stereo
    seen = np.isfinite(stereo[:, 0])
    n = int(seen.sum())
    return CornerRows(
        sign * (corners.name[seen] + 1), np.full(n, state.frame), np.full(n, state.camera),
        np.repeat(carrier[None], n, axis=0), stereo[seen],
    )  # fmt: skip


def _shortened(rows: CornerRows, state: PictureState) -> CornerRows:
    """Without every second row of corners that have many, and without corners of the wall that have
    ended before they could carry a turn of the camera over."""
    assert state.wall is not None
    if state.camera == 0:
        rows = rows.only((rows.corner > 0) | np.isin(-rows.corner - 1, state.wall.name))
    _, first, which = rows.grouped()
    size = np.bincount(which)[which] if len(rows) else which
    nth = np.arange(len(rows)) - first[which] if len(rows) else which
    return rows.only((size <= LONGEST) | (nth % 2 == 1))


def _stays(hand: Corners, name: Ints, place: Array) -> Flags:
    """(K,) which corners stayed where they were while others moved: they are on the wall."""
    if not len(name) or not len(hand.name):
        return np.zeros(len(hand.name), dtype=bool)
    order = np.argsort(name)
    at = order[np.minimum(np.searchsorted(name, hand.name, sorter=order), len(name) - 1)]
    old = name[at] == hand.name
    far = np.linalg.norm(hand.place - place[at], axis=1)
    if not old.any() or np.percentile(far[old], 75) < GOES:
        return np.zeros(len(far), dtype=bool)
    return np.asarray(old & (far < STAYS))
