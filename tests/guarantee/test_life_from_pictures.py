"""The whole chain on drawn pictures: found, certified truly, a turned head and a slip noticed.

What the parts promise must hold when they are joined: no certificate that is not true, no change
that did not happen.
"""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.hand_eye.corner_fit import twist_between
from bodyschema.monitoring.pictures.settings import PictureSettings, StereoFrame
from bodyschema.monitoring.pictures.watch import PictureWatch
from bodyschema.simulation.living_film import Happening, LivingFilm

pytestmark = pytest.mark.usefixtures("offscreen")


def lived(seed: int, seconds: float, *happenings: Happening):
    """(time, event, part, deg off, mm off) of a film."""
    film = LivingFilm(seed, seconds, happenings)
    watch = PictureWatch(PictureSettings(film.joints, film.stereo))
    state, told = watch.start(), []
    for one in film.moments():
        frame = StereoFrame(one.time, one.q, one.T_world_hand, one.left, one.right)
        state, info = watch.step(state, frame)
        if info.event:
            off = [np.inf, np.inf]
            if state.T_world_cam is not None:
                twist = twist_between(state.T_world_cam, film.camera(one.time))
                off = [np.rad2deg(np.linalg.norm(twist[3:])), 1e3 * np.linalg.norm(twist[:3])]
            told.append((one.time, info.event, info.part, *off))
    return told


def test_it_is_found_certified_truly_and_each_change_is_noticed_and_blamed():
    told = lived(1, 13.5, Happening("head", 7.0), Happening("slip", 13.0))
    assert [one[1:3] for one in told] == [
        ("found", ""), ("certified", "camera"), ("changed", "camera"), ("certified", "camera"),
        ("changed", "tool"),
    ]  # fmt: skip
    _, first, turned, again, slipped = told
    assert first[0] < 7.0
    assert 7.0 < turned[0] < 8.0
    assert again[0] - turned[0] < 3.0
    assert 13.0 < slipped[0] < 13.5
    for certificate in (first, again):
        assert certificate[3] < 0.2
        assert certificate[4] < 5.0
