"""What changed? Every part is tried: it alone is forgotten, all else stays as prior.

After an alarm each block b, and also "nothing", gets its own learner that starts with the others as
prior and learns from the samples since the alarm. With c_b its cost (residuals and the pull against
the prior, over the noise's level), n the residuals behind it and k_b the block's size,

    I_b = c_b + k_b ln n

is compared (Schwarz 1978). A block is named when its cost is credible, c < n + 6 sqrt(2 n), and
every other I is MARGIN higher. Some blocks contain others: a tool can move in every way that the
last joint moves it. From SIMPLER samples on a block needs no margin over larger ones, only the
lower I. While the body is still moving no block is credible: all start anew.
"Nothing" wins a scare that a burst of wild samples caused. When time runs out all is learned again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from bodyschema.learners.watchable import Watchable

State = TypeVar("State")
Sample = TypeVar("Sample")

NOTHING, EVERYTHING = "", "everything"

FIRST, MOVING, CALM, LONGEST = 15, 27, 45, 240
"""Samples before the first verdict, before trials start anew, before nothing has changed, and
before everything is learned again."""

SIMPLER = 120
"""Samples after which the smaller of two blocks that explain the same is named."""

MARGIN = 30.0
"""In units of chi-square."""


@dataclass(frozen=True)
class Trials(Generic[State]):
    """State: one learner a hypothesis."""

    base: State
    """The belief before the alarm."""
    beliefs: Mapping[str, State]
    """Block, or NOTHING -> its learner's state."""
    samples: int = 0
    """Since these trials began."""
    total: int = 0
    """Since the alarm."""


@dataclass(frozen=True)
class Verdict(Generic[State]):
    """A named block, and the belief that learning goes on from."""

    block: str
    """A block, NOTHING or EVERYTHING."""
    belief: State


def begin(learner: Watchable[State, Sample], base: State) -> Trials[State]:
    """Trials from the belief before the alarm."""
    names = [*learner.blocks, NOTHING]
    return Trials(base, {name: learner.forget(base, name) for name in names})


def weigh(
    learner: Watchable[State, Sample], trials: Trials[State], sample: Sample
) -> tuple[Trials[State], Verdict[State] | None]:
    """One more sample for all trials; a verdict when one is due."""
    beliefs = {name: learner.step(belief, sample) for name, belief in trials.beliefs.items()}
    trials = replace(trials, beliefs=beliefs, samples=trials.samples + 1, total=trials.total + 1)
    if trials.samples < FIRST or trials.samples % 3:
        return trials, None
    index, credible = _compare(learner, trials)
    best = min(index, key=lambda name: index[name])
    early = best == NOTHING and trials.samples < CALM
    if credible[best] and not early and _stands_out(learner, best, index, trials.samples):
        belief = trials.base if best == NOTHING else beliefs[best]
        return trials, Verdict(best, belief)
    if trials.total >= LONGEST:
        return trials, Verdict(EVERYTHING, learner.start())
    if trials.samples >= MOVING and not any(credible.values()):
        return replace(begin(learner, trials.base), total=trials.total), None
    return trials, None


def _stands_out(
    learner: Watchable[State, Sample], best: str, index: Mapping[str, float], samples: int
) -> bool:
    """Whether every other I is far enough above the lowest."""
    if best == NOTHING:
        return True
    size = {name: len(learner.blocks[name]) if name else 0 for name in index}
    rivals = [
        index[name]
        for name in index
        if name != best and not (samples >= SIMPLER and size[name] > size[best])
    ]
    return min(rivals) - index[best] > MARGIN


def credible(learner: Watchable[State, Sample], belief: State, level: float) -> bool:
    """Whether a belief explains the samples that it learned from."""
    cost, n = learner.evidence(belief)
    return bool(cost / level < n + 6 * np.sqrt(2 * n))


def _compare(
    learner: Watchable[State, Sample], trials: Trials[State]
) -> tuple[dict[str, float], dict[str, bool]]:
    """I_b of every trial, and whether it is credible."""
    level = learner.doubt(trials.base).level
    index, believable = {}, {}
    for name, belief in trials.beliefs.items():
        cost, n = learner.evidence(belief)
        size = len(learner.blocks[name]) if name else 0
        index[name] = cost / level + size * float(np.log(max(n, 2.0)))
        believable[name] = credible(learner, belief, level)
    return index, believable
