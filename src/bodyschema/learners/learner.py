"""The learner protocol, and the one loop that runs any learner over any recording.

A learner is a frozen object of settings. `start` makes a state; `step` takes a state and one sample
and returns the next state and an info for people. Nothing is mutated, so a state can be kept,
compared, saved, or stepped twice with different samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol, TypeVar

import numpy as np

from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

State = TypeVar("State")
Info = TypeVar("Info", covariant=True)


class Learner(Protocol[State, Info]):
    """Anything that learns a body from one sample after the other."""

    def start(self, body: Body, variables: Variables) -> State:
        """The state before the first sample."""
        ...

    def step(self, state: State, sample: Sense) -> tuple[State, Info]:
        """The state after one sample (a batch of one), and what happened."""
        ...


def in_time_order(senses: Sequence[Sense]) -> Iterator[Sense]:
    """All samples of all senses one by one, by time; senses in the given order within a moment."""
    times = np.concatenate([sense.time for sense in senses]) if senses else np.empty(0)
    which = np.concatenate([np.full(len(s), i) for i, s in enumerate(senses)]) if senses else times
    row = np.concatenate([np.arange(len(s)) for s in senses]) if senses else times
    for k in np.argsort(times, kind="stable"):
        yield senses[int(which[k])].take([int(row[k])])


def run(
    learner: Learner[State, Info], state: State, senses: Sequence[Sense]
) -> Iterator[tuple[State, Info]]:
    """Feed a recording to a learner; yields the state and info after each sample."""
    for sample in in_time_order(senses):
        state, info = learner.step(state, sample)
        yield state, info
