"""What changed is named, nothing else is, and only that is learned again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from linear_learner import Linear, Monitor, Stream, begin, certified, dated, follow, weigh

APART = {"a": [0, 1], "b": [2, 3], "c": [4]}

CLOSE = np.array([[1.0, 1.1], [1.0, 0.9], [1.0, 1.0]])
"""A slope under which two variables look nearly alike."""


def named(events: list[tuple[int, str, str]]) -> list[str]:
    """Blocks that were named."""
    return [block for _, event, block in events if event == "changed"]


@pytest.mark.parametrize("part", APART)
@pytest.mark.parametrize("size", [1.0, 12.0])
def test_a_part_is_named_and_learned_again_and_the_others_stay(part: str, size: float) -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    stream = Stream(learner, np.arange(5.0), 0)
    state = certified(monitor, stream)
    state, events = follow(monitor, state, [stream.draw() for _ in range(70)])
    assert not events
    stream.x[APART[part]] += size
    after, events = follow(monitor, state, [stream.draw() for _ in range(150)])
    assert [event for _, event, _ in events] == ["alarm", "changed", "identified"]
    assert named(events) == [part]
    assert after.belief.x == pytest.approx(stream.x, abs=0.4)
    # Nobody had to wait for the others: what was known of them was enough to go on.
    assert events[2][0] - events[1][0] < 60


def test_a_burst_of_outliers_is_a_scare_not_a_change() -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    for seed in range(8):
        stream = Stream(learner, np.zeros(5), seed)
        state = certified(monitor, stream)
        before = state.belief.x
        samples = [stream.draw(60.0 * (i < 6)) for i in range(120)]
        state, events = follow(monitor, state, samples)
        assert [event for _, event, _ in events] == ["alarm", "dismissed"]
        assert state.belief.x == pytest.approx(before, abs=0.3)


def test_of_two_parts_that_explain_the_same_the_smaller_is_named() -> None:
    """A tool can move in every way that the last joint moves it, so it explains the joint, too."""
    learner = Linear({"joint": [0], "tool": [0, 1, 2], "other": [3]}, bound=0.1)
    monitor = Monitor(learner)
    for seed in range(4):
        stream = Stream(learner, np.zeros(4), seed)
        state = certified(monitor, stream)
        stream.x[0] += 2.0
        state, events = follow(monitor, state, [stream.draw() for _ in range(300)])
        assert named(events) == ["joint"]


def test_nobody_is_named_while_another_part_explains_nearly_as_well() -> None:
    learner = Linear({"a": [0], "b": [1], "c": [2]}, bound=0.5, prior=3.0)
    monitor = Monitor(learner)
    for seed in range(20):
        stream = Stream(learner, np.zeros(3), seed)
        state = certified(monitor, stream)
        stream.x[0] += 2.0
        A = np.column_stack([CLOSE, 0.1 * stream.rng.normal(size=3)])
        _, events = follow(monitor, state, [stream.draw(A=A) for _ in range(60)])
        assert set(named(events)) <= {"a"}


def test_a_change_is_not_dismissed_before_it_had_time_to_show() -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(5), 6)
    state = certified(monitor, stream)
    stream.x[2] += 2.0
    for _ in range(20):
        # What is seen while it changes is of no use.
        state, report = monitor.step(state, (stream.draw(80.0),))
        if report.event == "alarm":
            break
    still = [stream.draw(A=np.zeros((3, 5))) for _ in range(24)]
    _, events = follow(monitor, state, still + [stream.draw() for _ in range(30)])
    assert events[0][1:] == ("changed", "b")


def test_a_change_in_noise_that_remembers_is_not_dismissed_for_what_was_before() -> None:
    """Moments that waited are tried too, but calm is counted from the alarm on."""
    learner = Linear({"a": [0], "b": [1]}, bound=0.25, prior=3.0, correlation=0.9)
    monitor = Monitor(learner, 1e6)
    for seed in range(6):
        stream = Stream(learner, np.zeros(2), seed)
        state = certified(monitor, stream)
        state, _ = follow(monitor, state, [stream.draw() for _ in range(80)])
        stream.x[0] += 3.0
        _, events = follow(monitor, state, [stream.draw() for _ in range(60)])
        assert [event for _, event, _ in events[:2]] == ["alarm", "changed"]
        assert named(events) == ["a"]


def test_a_change_is_dated_through_outliers() -> None:
    learner = Linear(APART, bound=0.1)
    for seed in range(6):
        stream = Stream(learner, np.zeros(5), seed)
        base, samples = certified(Monitor(learner), stream).belief, []
        for i in range(40):
            if i == 32:
                stream.x[2] += 2.0
            samples.append(stream.draw(200.0 * (i == 20)))
        seen = [learner.innovation(base, (sample,)) for sample in samples]
        assert 6 <= dated(learner, base, seen) <= 11


def test_calm_is_counted_from_the_alarm_on() -> None:
    learner = Linear(APART, bound=0.1)
    stream = Stream(learner, np.zeros(5), 8)
    base = certified(Monitor(learner), stream).belief
    trials = begin(learner, base, [(stream.draw(),) for _ in range(50)])
    verdicts = []
    for _ in range(60):
        trials, verdict = weigh(learner, trials, (stream.draw(),))
        verdicts.append(verdict)
        if verdict is not None:
            break
    assert len(verdicts) >= 40
    assert verdicts[-1] is not None
    assert verdicts[-1].block == ""


def test_two_parts_at_once_are_not_one() -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(5), 1)
    state = certified(monitor, stream)
    stream.x[[0, 2, 4]] += [3.0, 3.0, 3.0]
    state, events = follow(monitor, state, [stream.draw() for _ in range(400)])
    assert named(events) == ["everything"]
    assert events[-1][1] == "identified"
    assert state.belief.x == pytest.approx(stream.x, abs=0.4)


def test_a_part_that_moves_for_a_while_is_named_when_it_rests() -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(5), 2)
    state, samples = certified(monitor, stream), []
    for i in range(200):
        if i < 40:
            stream.x[2] += 0.5
        samples.append(stream.draw())
    state, events = follow(monitor, state, samples)
    assert set(named(events)) == {"b"}
    assert state.mode == "observe"
    assert state.belief.x == pytest.approx(stream.x, abs=0.4)


def test_what_changes_during_relearning_is_found_too() -> None:
    learner = Linear(APART, bound=0.1)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(5), 3)
    state = certified(monitor, stream)
    stream.x[0] += 5.0
    for _ in range(60):
        state, report = monitor.step(state, (stream.draw(),))
        if report.event == "changed":
            break
    assert report.block == "a"
    stream.x[4] += 5.0
    state, events = follow(monitor, state, [stream.draw() for _ in range(600)])
    assert events[-1][1] == "identified"
    assert state.mode == "observe"
    assert state.belief.x == pytest.approx(stream.x, abs=0.4)


def test_a_belief_that_began_wrong_starts_anew() -> None:
    learner = Linear(APART, bound=0.005, prior=1.0)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(5), 4)
    state, events = follow(monitor, monitor.start(), [stream.draw() for _ in range(140)])
    assert not events
    stream.x += 20.0
    state = replace(state, belief=replace(state.belief, information=1e4 * np.eye(5)))
    state, events = follow(monitor, state, [stream.draw() for _ in range(60)])
    assert "restarted" in {event for _, event, _ in events}


def test_a_slow_change_has_not_been_learned_when_it_is_noticed() -> None:
    """Samples wait: the belief that trials begin from is that of before the change."""
    learner = Linear({"a": [0], "b": [1]}, bound=0.12)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(2), 5, rows=1)
    state = certified(monitor, stream)
    before = state.belief
    stream.x[0] += 2.0
    for _ in range(200):
        state, report = monitor.step(state, (stream.draw(A=np.array([[0.6, 0.6]])),))
        if report.event == "alarm":
            break
    assert report.event == "alarm"
    assert state.base == before
