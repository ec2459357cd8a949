"""The learner protocols, and the one loop that runs any learner over any recording.

A learner is a frozen object of settings. `start` makes a state; `step` takes a state and a moment,
and returns the next state and an info for people. Nothing is mutated, so a state can be kept,
compared, saved, or stepped twice with different moments.

A moment is a tuple of what was seen at one time: a batch of one from each `Sense` that saw
something; or images, tracked points, a wrench, for learners of these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import GaussianBelief, WhiteInnovation
from bodyschema.estimation.certificate import Certificate
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

State = TypeVar("State")
Sample = TypeVar("Sample")
Learnt = TypeVar("Learnt")
Seen = TypeVar("Seen", contravariant=True)
Info = TypeVar("Info", covariant=True)

Moment = tuple[Sense, ...]
"""What was seen at one time: a batch of one from each sense that saw something."""


class Learner(Protocol[State, Seen, Info]):
    """Anything that learns from one moment after the other."""

    def step(self, state: State, moment: tuple[Seen, ...]) -> tuple[State, Info]:
        """The state after one moment, and what happened."""
        ...


class BodyLearner(Learner[State, Sense, Info], Protocol[State, Info]):
    """A learner of a body's variables from senses."""

    def start(self, body: Body, variables: Variables) -> State:
        """The state before the first moment."""
        ...


@dataclass(frozen=True)
class Pace:
    """How fast a monitor may go about a learner: all in moments, for one of 30 a second."""

    rate: float = 30.0
    """Moments a second."""
    group: int = 5
    """From one look for a change to the next."""
    wait: int = 60
    """Between the test of a moment and learning from it: what shows late must not be learned."""
    settle: int = 0
    """Left out after an alarm, while the body is still changing."""
    look: int = 3
    """From one look at the certificate to the next."""
    first: int = 15
    """From an alarm to the first verdict on what changed, at least."""
    margin: float = 30.0
    """By how much, in units of chi-square, one block must explain better than any other to be
    named."""
    ratios: bool = True
    """Whether ratios over windows of moments are tested beside the sums: they want innovations that
    are white, or can be whitened, in time."""
    early: bool = False
    """Whether moments are tested while the belief is being identified: only if its innovations are
    honest from the first moments on."""


class MonitoredLearner(Learner[State, Seen, Info], Protocol[State, Seen, Info]):
    """A learner that a monitor can watch over; see `monitoring.monitor`."""

    @property
    def blocks(self) -> Mapping[str, Ints]:
        """Parts of the body that may change on their own, and their variables' places."""
        ...

    @property
    def odds(self) -> Mapping[str, float]:
        """Block -> how often it changes, relative to the others: tools more than upper arms."""
        return dict.fromkeys(self.blocks, 1.0)

    @property
    def pace(self) -> Pace:
        """What suits its moments."""
        return Pace()

    def start(self) -> State:
        """Nothing known."""
        ...

    def innovation(self, state: State, moment: tuple[Seen, ...]) -> WhiteInnovation:
        """A moment against a belief that has been certified."""
        ...

    def belief(self, state: State) -> GaussianBelief:
        """What is believed, how far it may be off, and how it fared since it began."""
        ...

    def certificate(self, state: State) -> Certificate:
        """Whether the belief is good enough to watch with."""
        ...

    def forget(self, state: State, block: str) -> State:
        """A new start with all but one block as prior; "" keeps everything as prior."""
        ...

    def difference(self, state: State, earlier: State) -> Array:
        """(k,) the step of the variables from an earlier belief to this one."""
        ...

    def change(self, before: State, after: State) -> str:
        """A word for what happened between two certified beliefs, if the learner has one."""
        return ""


def in_turn(
    learn: Callable[[State, Sample], tuple[State, Learnt]],
    state: State,
    moment: tuple[Sample, ...],
) -> tuple[State, tuple[Learnt, ...]]:
    """Learn from the samples of a moment one after the other; one info for each."""
    infos = []
    for sample in moment:
        state, info = learn(state, sample)
        infos.append(info)
    return state, tuple(infos)


def moments(senses: Sequence[Sense]) -> list[Moment]:
    """Samples in order of time; those of one time together, in the order of the senses."""
    if not senses:
        return []
    times = np.unique(np.concatenate([sense.time for sense in senses]))
    gathered: list[list[Sense]] = [[] for _ in times]
    for sense in senses:
        for i, k in enumerate(np.searchsorted(times, sense.time)):
            gathered[k].append(sense.take([i]))
    return [tuple(group) for group in gathered]


def in_time_order(senses: Sequence[Sense]) -> Iterator[Sense]:
    """The samples of all moments one by one."""
    for moment in moments(senses):
        yield from moment


def run(
    learner: Learner[State, Sense, Info], state: State, senses: Sequence[Sense]
) -> Iterator[tuple[State, Info]]:
    """Feed a recording to a learner; yields the state and info after each moment."""
    for moment in moments(senses):
        state, info = learner.step(state, moment)
        yield state, info
