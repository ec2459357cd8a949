"""What becomes of hand and eye when the camera turns, and when the turned one is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bodyschema.learners.hand_eye.corner_fit import CameraPrior
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.monitoring.pictures.settings import PictureSettings
from bodyschema.monitoring.pictures.state import PictureState

BEFORE = 2
"""Rows that are dropped from before a turn was noticed."""


def begun(state: PictureState, settings: PictureSettings) -> PictureState:
    """The camera moves: what was seen just now is not of the old one any more."""
    late = state.frame - BEFORE * settings.every
    return replace(state, rows=state.rows.only(state.rows.moment < late), mode="turning")


def ended(state: PictureState) -> PictureState:
    """The camera stands again, elsewhere: a second camera, if the first was known."""
    fit = state.fit
    if fit is None or (state.camera == 0 and not state.certified):
        # Nothing was known that could be carried over: rows begin anew.
        return replace(state, mode="learn", rows=CornerRows.none(), fit=None, prior=None, camera=0)
    rows = state.rows
    if state.camera == 1:
        # It turned again before it was known: what was seen in between is left out.
        rows = rows.only(rows.camera == 0)
    cameras = np.repeat(fit.cameras[:1], 2, axis=0)
    fit = replace(fit, cameras=cameras, covariance=np.full((12, 12), np.inf), misfit=np.inf)
    return replace(state, mode="learn", rows=rows, camera=1, certified=False, fit=fit)


def certified(state: PictureState) -> PictureState:
    """The camera is known: observe; what came before a turn is now a prior of the camera alone."""
    state = replace(state, mode="observe", certified=True)
    if not state.camera:
        return state
    fit = state.fit
    assert fit is not None
    P = fit.covariance[-6:, -6:]
    information = np.asarray(np.linalg.inv(P), dtype=np.float64)
    prior = CameraPrior(fit.cameras[-1], information, np.zeros(6), information, fit.corners)
    one = replace(fit, cameras=fit.cameras[-1:], covariance=P)
    return replace(state, camera=0, prior=prior, fit=one, rows=CornerRows.none())
