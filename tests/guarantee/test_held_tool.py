"""A tool in the hand, seen by poor eyes: outliers change nothing, what changed is named soon."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.learner import moments
from bodyschema.learners.watched_smoother import WatchedSmoother
from bodyschema.studies.held_tool import BLOCKS, TIP, Change, Setting, arm, freed
from linear_learner import Monitor, watch

SETTING = Setting(noise=0.05, outliers=0.05, motion="smooth", arm_error=1.0)
LEARNER = WatchedSmoother(arm(), freed(True), BLOCKS)


def test_outliers_raise_no_alarm() -> None:
    """With a sample in twenty off by decimetres."""
    monitor = Monitor(LEARNER)
    for seed in range(2):
        scene = SETTING.scene(np.random.default_rng(seed), 400)
        _, events = watch(monitor, monitor.start(), moments([scene.seen]))
        assert [event for _, event, _ in events] == ["identified"]


def test_an_alarm_by_chance_blames_nobody() -> None:
    monitor, events = Monitor(LEARNER, samples=40), []
    for seed in (5, 6):
        scene = SETTING.scene(np.random.default_rng(seed), 300)
        events += watch(monitor, monitor.start(), moments([scene.seen]))[1]
    told = [event for _, event, _ in events]
    assert told.count("alarm") >= 3
    assert told.count("dismissed") >= told.count("alarm") - 2
    assert "changed" not in told


@pytest.mark.parametrize(("part", "size"), [("tool", 0.34), ("tool", 0.10), ("upper arm", 0.10)])
def test_what_changed_is_named_soon_and_learned_anew(part: str, size: float) -> None:
    change, monitor = Change(part, size, 80), Monitor(LEARNER)
    for seed in range(2):
        scene = SETTING.scene(np.random.default_rng(seed), 200, change)
        state, events = watch(monitor, monitor.start(), moments([scene.seen]))
        assert [(event, block) for _, event, block in events if event == "changed"] == [
            ("changed", part)
        ]
        assert [event for _, event, _ in events[:3]] == ["identified", "alarm", "changed"]
        assert 80 <= events[1][0] < 95
        assert events[2][0] < 125
        assert scene.miss(state.belief.body, scene.places(199, TIP), TIP) < 0.02


def test_what_changed_is_named_by_what_was_seen_before_the_alarm_too() -> None:
    change, monitor, needed = Change("tool", 0.10, 80), Monitor(LEARNER), []
    for seed in range(10, 18):
        scene = SETTING.scene(np.random.default_rng(seed), 130, change)
        _, events = watch(monitor, monitor.start(), moments([scene.seen]))
        needed += [at - 80 for at, event, _ in events if event == "changed"]
    assert len(needed) == 8
    assert np.median(needed) < 20


def test_the_hypothesis_that_leads_answers_until_it_is_clear() -> None:
    change, monitor, misses = Change("tool", 0.34, 80), Monitor(LEARNER), []
    for seed in range(6):
        scene = SETTING.scene(np.random.default_rng(seed), 88, change)
        state, _ = watch(monitor, monitor.start(), moments([scene.seen]))
        if state.mode == "blame":
            misses.append(scene.miss(state.belief.body, scene.places(87, TIP), TIP))
    assert len(misses) >= 3
    assert np.median(misses) < 0.1
