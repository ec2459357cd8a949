"""Where the camera is, from the rows of all corners; where the hand is; and new corners on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.corner_fit import CornerFit, absorbed, fitted
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.learners.hand_eye.corner_start import bridged, started
from bodyschema.monitoring.pictures import regions
from bodyschema.monitoring.pictures.following import HAND, WALL, proven
from bodyschema.monitoring.pictures.landmarks import remembered
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import PictureState

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_ROWS, LEAST_CORNERS = 4, 4
"""Rows of a corner in a fit, and corners of the hand that a fit needs."""
SURE_ROWS = 10
"""Of a corner that may say where the hand is."""
AGAINST = 5
"""Votes of a corner that is not on the hand: it is looked at once, others every time."""
PROBES, BESIDE = 4, 28
"""Corners that may be born at a time beside what is known to be the hand, and px beside it: a tool
that was picked up is found there."""


def explains(fit: CornerFit | None, settings: PictureSettings) -> bool:
    """Whether a fit leaves no more of what the last camera saw than the noise of corners."""
    return fit is not None and fit.misfit < settings.explains_px


def good(state: PictureState, settings: PictureSettings) -> bool:
    """Whether the camera is known as well as is wanted."""
    fit, wanted, (turn, away) = state.fit, settings.tolerance.bounds, state.bounds
    if fit is None or not fit.settled or fit.corners < settings.least_corners:
        return False
    return explains(fit, settings) and turn < wanted["rotation"] and away < wanted["camera"]


def learned(state: PictureState, settings: PictureSettings) -> PictureState:
    """The cameras anew, from all rows, and what that says about the hand."""
    rows = _usable(state.rows)
    if len(np.unique(rows.corner[rows.corner > 0])) < LEAST_CORNERS:
        return state
    fit, stereo = state.fit, settings.stereo
    if fit is not None and state.camera == 0 and explains(fit, settings):
        fit = fitted(rows, fit.cameras, stereo, state.prior, fit.level)
    else:
        starts = _starts(state, rows, settings)
        if not starts:
            return state
        fits = [fitted(rows, cameras, stereo, state.prior) for cameras in starts]
        fit = min(fits, key=lambda one: one.cost)
    if state.certified and not (fit.settled and explains(fit, settings)):
        return replace(state, refused=state.refused + 1)
    state = replace(state, fit=fit, refused=0)
    if explains(fit, settings):
        state = _mapped(state, fit, rows)
    return _given_up(state, fit, settings)


def born(state: PictureState, frame: StereoFrame, settings: PictureSettings) -> PictureState:
    """New corners on the hand and on the wall."""
    assert state.hand is not None
    assert state.wall is not None
    camera, corners = None, state.hand
    if state.fit is not None and explains(state.fit, settings):
        # Once something is known, only corners that are surely on the hand speak for it.
        camera = state.T_world_cam
        corners = corners.only(np.isin(corners.name + 1, state.fit.names[state.fit.good]))
    me = regions.of_me(
        frame.left.shape, corners.place, state.hand_map.points, camera, frame.T_world_hand,
        settings.stereo,
    )  # fmt: skip
    hand = HAND.births(state.hand, me, frame.right)
    if state.certified:
        hand = HAND.births(hand, regions.beside(me, BESIDE), frame.right, most=PROBES)
    wall = WALL.births(state.wall, regions.of_background(me), frame.right)
    return replace(state, hand=hand, wall=wall)


def _starts(state: PictureState, rows: CornerRows, settings: PictureSettings) -> list[Array]:
    """(C, 4, 4) each: where the cameras may be."""
    fit, stereo = state.fit, settings.stereo
    if state.camera == 0:
        starts = [one[None] for one in started(rows.only(rows.corner > 0), stereo)]
        return starts if fit is None else [*starts, fit.cameras]
    assert fit is not None
    new = bridged(rows, fit.cameras[0], stereo)
    return [fit.cameras] if new is None else [fit.cameras, np.stack([fit.cameras[0], new])]


def _usable(rows: CornerRows) -> CornerRows:
    """Rows of corners with a few of them; of the wall only where two cameras saw it."""
    names, _, which = rows.grouped()
    n = len(names)
    enough = np.bincount(which, minlength=n) >= LEAST_ROWS
    second = np.bincount(which, rows.camera, minlength=n) > 0
    first = np.bincount(which, 1 - rows.camera, minlength=n) > 0
    kept = enough & ((names > 0) | (first & second))
    return rows.only(kept[which])


def _mapped(state: PictureState, fit: CornerFit, rows: CornerRows) -> PictureState:
    """Where the hand is; corners that are not on it are dropped."""
    assert state.hand is not None
    size = np.bincount(np.searchsorted(fit.names, rows.corner), minlength=len(fit.names))
    mine = fit.names > 0
    sure = fit.good & mine & (size >= SURE_ROWS)
    sure &= np.isin(fit.names, proven(state, rows, state.frame))
    stray = mine & ~fit.good
    hand_map = state.hand_map.voted(fit.place[sure], 1).voted(fit.place[stray], -AGAINST)
    strays = fit.names[stray] - 1
    kept = state.rows.only(~np.isin(state.rows.corner, strays + 1))
    landmarks = remembered(state.landmarks, state.hand, fit, rows, fit.names[sure])
    landmarks = landmarks.only(~np.isin(landmarks.name, strays))
    return replace(state, hand_map=hand_map, strays=strays, rows=kept, landmarks=landmarks)


def _given_up(state: PictureState, fit: CornerFit, settings: PictureSettings) -> PictureState:
    """Rows of the oldest corners that have ended move into the prior; those of too few are lost."""
    assert state.hand is not None
    if state.camera or not state.certified:
        return state
    names, _, which = state.rows.grouped()
    ended = (names > 0) & ~np.isin(names - 1, state.hand.name)
    few = ended & (np.bincount(which, minlength=len(names)) < LEAST_ROWS)
    told = names[ended & ~few]
    old = told[: max(len(told) - settings.keep, 0)]
    gone, prior = np.isin(state.rows.corner, old), state.prior
    if len(old):
        prior = absorbed(state.rows.only(gone), fit, settings.stereo, prior)
    kept = ~gone & ~np.isin(state.rows.corner, names[few])
    return replace(state, rows=state.rows.only(kept), prior=prior)
