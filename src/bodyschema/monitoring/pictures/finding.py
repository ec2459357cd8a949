"""The hand is what moves when the wrist does: cells of the picture, then corners in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.frames import Frame
from bodyschema.monitoring.pictures import regions
from bodyschema.monitoring.pictures.following import HAND, WALL
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.state import Finding, PictureInfo, PictureState
from bodyschema.vision.anchored_corners import no_corners

Flags = NDArray[np.bool_]

FIRST = 14
"""px, squares of the first births: only now is it known where the whole hand is."""


def found(
    state: PictureState, frame: StereoFrame, settings: PictureSettings
) -> tuple[PictureState, PictureInfo]:
    """Look once more; corners are born when the hand has been seen to move for long enough."""
    finder = BodyFinder(settings.joints)
    height, width = frame.left.shape
    looking = state.finding
    if looking is None:
        cells = np.zeros((height // finder.cell_px, width // finder.cell_px))
        looking = Finding(frame.time, finder.start((width, height)), cells)
    seen, _ = finder.step(looking.finder, (Frame(frame.time, frame.left, frame.q),))
    moving = looking.moving + finder.found(seen).now
    looking = replace(looking, finder=seen, moving=moving, frames=looking.frames + 1)
    state = replace(state, frame=state.frame + 1, finding=looking)
    if frame.time - looking.began < settings.find_s:
        return state, PictureInfo("find")
    me = _pixels(moving > settings.often * looking.frames, frame.left.shape, finder.cell_px)
    if not me.any():
        return replace(state, finding=None), PictureInfo("find")
    hand = HAND.births(no_corners(frame.left), me, frame.right, FIRST)
    wall = WALL.births(no_corners(frame.left), regions.of_background(me), frame.right)
    return replace(state, mode="learn", finding=None, hand=hand, wall=wall), PictureInfo(
        "learn", "found"
    )


def _pixels(cells: Flags, size: tuple[int, ...], side: int) -> Flags:
    """(height, width) the cells in pixels."""
    shown = np.zeros(size, dtype=bool)
    large = cells.repeat(side, axis=0).repeat(side, axis=1)
    shown[: large.shape[0], : large.shape[1]] = large
    return shown
