"""Touches of a stream: begun, ended, placed, or refused with a reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.touch.finder import TouchFinder, covariance_of
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.model.solid import Solid

STD = np.array([0.02, 0.02, 0.04, 5e-4, 5e-4, 5e-4])
BOX = Solid.box((0.1, 0.12, 0.18))
FINDER = TouchFinder(covariance_of(STD), BOX)
PLACE, PUSH = np.array([0.03, -0.02, 0.09]), np.array([0.1, 0.2, -1.0])


def stream(rng, place=PLACE, push=PUSH, slide=0.0, pitch=0.0, seconds=3.0, offset=0.0):
    """100 samples a second; from 1 to 2 s something pushes."""
    time = np.arange(round(100 * seconds)) / 100
    on = ((time >= 1) & (time < 2))[:, None]
    r = place + slide * (time - 1.5)[:, None] * np.array([1.0, 0.0, 0.0])
    f = on * push
    w = np.hstack([f, np.cross(r, f) + pitch * f]) + STD * rng.normal(size=(len(time), 6))
    L = np.tile(offset * np.diag([1, 1, 1, 0.05, 0.05, 0.05]), (len(time), 1, 1))
    return Unexplained(time, w + L[0] @ rng.normal(size=6), L)


def test_a_touch_is_noticed_placed_and_ended():
    (touch,) = FINDER.touches(stream(np.random.default_rng(0)))
    assert 1.0 <= touch.begins < 1.05
    assert touch.ends is not None
    assert 2.05 < touch.ends < 2.2
    assert touch.verdict == "point"
    assert touch.point == pytest.approx(PLACE, abs=1e-3)
    assert touch.force == pytest.approx(PUSH, abs=0.15)
    assert touch.inside


def test_a_touch_that_lasts_to_the_end_is_told_too():
    (touch,) = FINDER.touches(stream(np.random.default_rng(1), seconds=1.5))
    assert touch.ends is None
    assert touch.point == pytest.approx(PLACE, abs=1.5e-3)


def test_an_offset_that_is_owned_up_to_costs_little():
    rng = np.random.default_rng(2)
    errors = []
    for _ in range(10):
        (touch,) = FINDER.touches(stream(rng, push=5 * PUSH, offset=0.1))
        assert touch.verdict == "point"
        errors.append(np.linalg.norm(touch.point - PLACE))
    # The offset alone would shift the place by 2 % of its arm of 0.1 m.
    assert np.median(errors) < 1e-3


@pytest.mark.parametrize(
    ("verdict", "change"),
    [
        ("twist", {"pitch": 0.006}),
        ("moving", {"slide": 0.04, "push": np.array([0.0, 1e-3, -1.0])}),
        ("beside", {"place": np.array([0.09, 0.0, 0.09]), "push": np.array([0.0, 0.0, -3.0])}),
    ],
)
def test_what_is_no_point_contact_is_refused_with_a_reason(verdict, change):
    rng = np.random.default_rng(3)
    found = [FINDER.touches(stream(rng, **change))[0].verdict for _ in range(10)]
    assert found.count(verdict) >= 8
    assert "point" not in found


def test_forces_that_meet_beside_the_surface_are_beside_it_though_their_line_enters():
    """The box is 2 cm higher than it is said to be."""
    rng, sway = np.random.default_rng(8), 0.5
    time = np.arange(300) / 100
    on = ((time >= 1) & (time < 2))[:, None]
    turn = sway * np.sin(2 * np.pi * time)[:, None] * np.array([1.0, 0.0, 0.0])
    f = on * (np.array([0.0, 0.0, -5.0]) + 5 * turn)
    w = np.hstack([f, np.cross(PLACE + np.array([0.0, 0.0, 0.02]), f)]) + STD * rng.normal(
        size=(300, 6)
    )
    found = Unexplained(time, w, np.zeros((300, 6, 0)))
    (touch,) = FINDER.touches(found)
    assert touch.inside
    assert touch.verdict == "beside"
    (excused,) = replace(FINDER, surface=0.02).touches(found)
    assert excused.verdict == "point"
    assert excused.point == pytest.approx(PLACE + np.array([0.0, 0.0, 0.02]), abs=2e-3)


def test_noise_is_no_touch():
    rng = np.random.default_rng(4)
    w = STD * rng.normal(size=(30000, 6))
    none = np.zeros((30000, 6, 0))
    assert FINDER.touches(Unexplained(np.arange(30000) / 100, w, none)) == []


def test_one_wild_sample_is_no_touch():
    w = STD * np.random.default_rng(7).normal(size=(300, 6))
    w[150, 2] += 1.0
    none = np.zeros((300, 6, 0))
    assert FINDER.touches(Unexplained(np.arange(300) / 100, w, none)) == []


def test_the_state_keeps_its_size_and_the_one_before_is_not_changed():
    found = stream(np.random.default_rng(5))
    state = FINDER.start(6)
    for k, moment in enumerate(found.moments()):
        before = state.evidence.scatter.copy(), state.smoothed.wrench.copy()
        after, _ = FINDER.step(state, moment)
        assert (state.evidence.scatter == before[0]).all()
        assert (state.smoothed.wrench == before[1]).all()
        again, _ = FINDER.step(state, moment)
        assert (again.evidence.scatter == after.evidence.scatter).all()
        assert after.evidence.scatter.shape == (6, 6)
        state = after
        if k > 150:
            break


def test_news_come_at_the_beginning_between_and_at_the_end():
    found = stream(np.random.default_rng(6))
    state, news = FINDER.start(6), []
    for moment in found.moments():
        state, (felt,) = FINDER.step(state, moment)
        if felt.touch is not None:
            news.append(felt.event)
    assert news[0] == "begins"
    assert news[-1] == "ends"
    assert 8 <= news.count("") <= 12


@pytest.mark.parametrize(
    "make",
    [
        lambda: TouchFinder(np.zeros((6, 6))),
        lambda: TouchFinder(np.eye(5)),
        lambda: TouchFinder(np.eye(6), rate=0.0),
        lambda: TouchFinder(np.eye(6), samples=6),
        lambda: TouchFinder(np.eye(6), surface=-1e-3),
        lambda: FINDER.step(
            FINDER.start(),
            (Unexplained(np.zeros(1), np.full((1, 6), np.nan), np.zeros((1, 6, 0))),),
        ),
    ],
)
def test_bad_input_is_refused(make):
    with pytest.raises(InputError):
        make()
