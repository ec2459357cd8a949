"""Wrenches that are no touch: untaught, crept in, or another load's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.touch.doubtful import Taught, force_error
from bodyschema.learners.touch.finder import Touch
from bodyschema.learners.touch.place import Place
from bodyschema.learners.touch.unexplained import Unexplained

Array = NDArray[np.float64]
TIME = np.arange(120) / 12.0


def felt(wrench: Array, error: float = 0.01) -> Unexplained:
    factor = np.tile(error * np.eye(6), (len(TIME), 1, 1))
    return Unexplained(TIME, wrench, factor)


def touch(begins: float, ends: float, force: float = 1.0) -> Touch:
    place = Place(np.zeros(3), np.eye(3), None, 0.0, 1.0)
    push = np.array([force, 0.0, 0.0])
    return Touch(begins, ends, push, "point", (place,), True, 1.0, 0.0, 1.0)


TAUGHT = Taught(0.01, 0.01)
STILL = np.zeros((len(TIME), 6, 10))


def pushed(begins: float) -> Array:
    w = np.zeros((len(TIME), 6))
    w[begins <= TIME, 0] = 1.0
    return w


def test_a_touch_comes_within_a_moment() -> None:
    assert TAUGHT.doubt(touch(5.0, 6.0), felt(pushed(5.0)), STILL) == ""


def test_what_creeps_is_none() -> None:
    w = np.zeros((len(TIME), 6))
    w[:, 0] = np.clip(TIME / 5.0, 0.0, 1.0)
    assert TAUGHT.doubt(touch(5.0, 6.0), felt(w), STILL) == "crept"


def test_a_posture_that_taught_nothing_tells_no_small_touch() -> None:
    left = felt(pushed(5.0), error=0.5)
    assert np.allclose(force_error(left), 0.5)
    assert TAUGHT.outside(left).all()
    assert TAUGHT.doubt(touch(5.0, 6.0), left, STILL) == "untaught"
    assert TAUGHT.doubt(touch(5.0, 6.0, force=5.0), left, STILL) == ""


def test_what_another_load_explains_is_perhaps_one() -> None:
    rng = np.random.default_rng(0)
    Y = rng.normal(size=(len(TIME), 6, 10))
    w = np.where((TIME >= 4.0)[:, None], Y[:, :, :4] @ [0.2, 0.01, 0.0, 0.02], 0.0)
    w[70:80, 0] += 2.0
    assert TAUGHT.doubt(touch(4.0, 9.9), felt(w), Y) == "load"
    assert TAUGHT.doubt(touch(4.0, 9.9), felt(pushed(4.0)), Y) == ""
    assert TAUGHT.doubt(replace(touch(4.0, 5.0)), felt(w), Y) != "load"
