"""What the hand holds: whether it slipped, whether it has gone, and when it is known again.

A slip shows as corners that jump as one (`jumps`), within a tenth of a second. A swap leaves no
corner to follow; it shows as landmarks that are missed (`landmarks`), as soon as the hand is seen
again from where they were seen before. Either is told once: what comes until the tool is known
again is the same change.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bodyschema import lie
from bodyschema.estimation.certificate import bound
from bodyschema.monitoring.pictures import jumps
from bodyschema.monitoring.pictures.following import proven
from bodyschema.monitoring.pictures.landmarks import REGION
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import ChangedTool, PictureState

GONE = 0.015
"""m round the old places of corners that jumped, in which nothing of the hand is any more."""
KNOWN, CORNERS = 0.002, 4
"""m at 99 %, and corners that must be known so well for a tool to be known again."""
SLIPPING = 4
"""Newest rows of corners that jumped, which may be from while they did."""


def slipped(
    state: PictureState, settings: PictureSettings
) -> tuple[PictureState, jumps.Jump | None]:
    """Has what is held jumped? If so its corners begin anew, under new names."""
    if state.changed_tool is not None or state.fit is None or state.hand is None:
        return state, None
    fit, hand, rows, every = state.fit, state.hand, state.rows, settings.every
    mine = (rows.corner > 0) & ~np.isin(rows.corner, fit.names[~fit.good])
    mine &= rows.camera == state.camera
    mine &= np.isin(rows.corner, proven(state, rows, state.frame - (jumps.RECENT + 1) * every))
    jump = jumps.found(rows.only(mine), state.frame, fit.cameras[-1], settings.stereo, every)
    if jump is None:
        return state, None
    jumped = np.isin(hand.name + 1, jump.name)
    name, n = hand.name.copy(), int(jumped.sum())
    name[jumped] = hand.born + np.arange(n)
    late = (rows.moment > state.frame - SLIPPING * every) & np.isin(rows.corner, jump.name)
    was = fit.place[np.isin(fit.names, jump.name)]
    landmarks = state.landmarks.only(~state.landmarks.near(was, REGION))
    return replace(
        state, hand=replace(hand, name=name, born=hand.born + n), rows=rows.only(~late),
        hand_map=state.hand_map.without(was, GONE), landmarks=landmarks,
        changed_tool=ChangedTool(hand.born, landmarks.place),
    ), jump  # fmt: skip


def gone(
    state: PictureState, frame: StereoFrame, settings: PictureSettings
) -> tuple[PictureState, bool]:
    """Is all that is remembered of the hand still there?"""
    assert state.fit is not None
    assert state.hand is not None
    born = state.hand.born
    T_cam_hand = lie.inverse(state.fit.cameras[-1]) @ frame.T_world_hand
    landmarks = state.landmarks.sought(frame.left, frame.time, T_cam_hand, settings.stereo)
    missed = landmarks.gone(frame.time)
    hand_map = state.hand_map.without(landmarks.place[missed], GONE)
    landmarks = landmarks.only(~missed & landmarks.worth_keeping)
    state = replace(state, landmarks=landmarks, hand_map=hand_map)
    if not missed.any() or state.changed_tool is not None:
        return state, False
    return replace(state, changed_tool=ChangedTool(born, landmarks.place)), True


def known_again(state: PictureState) -> bool:
    """Are there enough sure corners, younger than the change, where the hand was not before?"""
    fit, change = state.fit, state.changed_tool
    if fit is None or change is None:
        return False
    young = (fit.names > change.since) & fit.good
    away = np.linalg.norm(fit.place[young][:, None] - change.hand[None], axis=2)
    doubt = fit.place_covariance[young][away.min(axis=1, initial=np.inf) > GONE]
    if not np.isfinite(doubt).all():
        return False
    return sum(bound(P) < KNOWN for P in doubt) >= CORNERS
