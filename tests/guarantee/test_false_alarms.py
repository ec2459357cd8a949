"""The stated rate of false alarms holds, whatever the noise, and alarms come soon all the same."""

from __future__ import annotations

import numpy as np
import pytest

from linear_learner import (
    GaussianBelief,
    Linear,
    Monitor,
    Sample,
    Stream,
    StreamNoise,
    WhiteInnovation,
    certified,
    follow,
    prepare,
)

RATE = 500.0
"""Samples between false alarms, as set: a high rate, so that it can be counted."""

SINGLES = {f"part {k}": [k] for k in range(12)}


def alarms(learner: Linear, samples: int, wild: float = 0.0) -> int:
    """Number of alarms while nothing changes."""
    monitor = Monitor(learner, RATE)
    stream = Stream(learner, np.zeros(learner.size), 0)
    state = certified(monitor, stream)
    wilds = 1e3 * (np.random.default_rng(1).uniform(size=samples) < wild)
    _, events = follow(monitor, state, [stream.draw(w) for w in wilds])
    return sum(event == "alarm" for _, event, _ in events)


def at_most(samples: int) -> float:
    """Alarms that the stated rate allows, three standard deviations of chance included."""
    return samples / RATE + 3 * np.sqrt(samples / RATE)


@pytest.mark.parametrize(
    ("learner", "wild"),
    [
        (Linear(SINGLES), 0.0),
        (Linear(SINGLES, level=4.0), 0.0),
        (Linear({"a": [0, 1], "b": [2]}, correlation=0.9), 0.0),
        (Linear({"a": [0, 1], "b": [2]}, outliers=0.06), 0.05),
    ],
    ids=["many parts", "loud", "remembering", "outliers"],
)
def test_a_quiet_stream_raises_no_more_alarms_than_stated(learner: Linear, wild: float) -> None:
    assert alarms(learner, 5_000, wild) <= at_most(5_000)


def test_a_belief_that_is_poor_but_honest_raises_no_alarm() -> None:
    """Its own error, common to all samples, is neither outlier nor change."""
    learner = Linear({"a": [0], "b": [1]}, prior=3.0, bound=10.0)
    monitor, count = Monitor(learner, 1e5), 0
    first, then = np.array([[0.0, 0.3]] * 2), np.array([[1.0, 0.2], [0.2, 0.6]])
    for seed in range(100):
        truth = 3.0 * np.random.default_rng(seed).normal(size=2)
        stream = Stream(learner, truth, 1000 + seed, rows=2)
        samples = [stream.draw(A=first if i < 6 else then) for i in range(90)]
        _, events = follow(monitor, monitor.start(), samples)
        count += sum(event == "alarm" for _, event, _ in events)
    assert count <= 1


def test_a_wild_sample_alone_is_no_alarm() -> None:
    learner = Linear({"a": [0, 1], "b": [2]}, outliers=0.03)
    monitor = Monitor(learner, 1e6)
    stream = Stream(learner, np.zeros(3), 5)
    state = certified(monitor, stream)
    samples = [stream.draw(1e3 * (i % 40 == 20)) for i in range(800)]
    assert not follow(monitor, state, samples)[1]


def test_a_change_is_noticed_soon_however_long_nothing_happened() -> None:
    learner = Linear({"a": [0, 1], "b": [2]})
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(3), 2)
    state, events = follow(monitor, certified(monitor, stream), [stream.draw() for _ in range(900)])
    assert not events
    for size, delay in ((8.0, 6), (1.5, 30)):
        moved = Stream(learner, [size, 0.0, 0.0], 3)
        _, events = follow(monitor, state, [moved.draw() for _ in range(200)])
        assert events[0][1] == "alarm"
        assert events[0][0] <= delay


def test_a_change_is_noticed_in_noise_that_remembers() -> None:
    """White in time, innovations of slow noise are small: what changes fast stands out."""
    learner = Linear({"a": [0], "b": [1]}, prior=0.1, bound=0.2, correlation=0.97)
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(2), 4)
    state = certified(monitor, stream)
    stream.x[0] = 1.0
    _, events = follow(monitor, state, [stream.draw() for _ in range(60)])
    assert events[0][1] == "alarm"


def test_noise_that_grows_is_noticed_though_no_part_explains_it() -> None:
    learner = Linear({"a": [0], "b": [1]})
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(2), 7)
    state = certified(monitor, stream)
    _, events = follow(monitor, state, [stream.draw(1.7) for _ in range(60)])
    assert events[0][1] == "alarm"


def test_whitened_slopes_are_those_of_whitened_innovations() -> None:
    rng = np.random.default_rng(0)
    noise = StreamNoise(level=4.0, product=0.8)
    belief = GaussianBelief(np.zeros((2, 2)), noise=noise)
    d, before = rng.normal(size=2), None
    for _ in range(5):
        J = 0.1 * rng.normal(size=(3, 2))
        tested = prepare(WhiteInnovation(J @ d, J, np.zeros(3, dtype=np.int64)), before, belief)
        before = tested.kept
        assert tested.e == pytest.approx(tested.J @ d)


def test_the_state_does_not_grow() -> None:
    learner = Linear({"a": [0], "b": [1]})
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(2), 4)
    state, _ = follow(monitor, certified(monitor, stream), [stream.draw() for _ in range(70)])
    later, _ = follow(monitor, state, [stream.draw() for _ in range(900)])
    assert size(later) == pytest.approx(size(state), rel=0.05)


def size(state: object) -> int:
    """Bytes."""
    import pickle

    return len(pickle.dumps(state))


def test_what_was_not_moved_is_said_not_to_be_watched() -> None:
    learner = Linear({"a": [0], "b": [1]})
    monitor = Monitor(learner)
    stream = Stream(learner, np.zeros(2), 6)
    state = certified(monitor, stream)
    A = np.array([[1.0, 0.0]] * 3)
    samples = [Sample(A, stream.rng.normal(size=3)) for _ in range(60)]
    state, _ = follow(monitor, state, samples)
    seen = monitor.vigilance(state)
    assert seen["a"] < 2
    assert seen["b"] == np.inf
