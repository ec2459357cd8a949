"""Replay: gradient descent over a small set of samples that spread over the joints' ranges.

Hersch et al. (2008, section 6) suggest to iterate on few postures, well distributed, where samples
are dear. Of each sense the learner keeps at most `size` samples. One more, and of the two whose
postures are nearest to one another the one leaves that is nearer to a third: so the least distance
between kept postures grows, whatever path the robot takes. After each sample the gradient goes
`passes` times over the set.

A sample is forgotten only when a better placed one comes. A body that changes, or a gross outlier,
therefore stays in memory: start anew after a change.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.learner import Moment, in_turn
from bodyschema.learners.published.online_gradient import Guess, Miss, OnlineGradient
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense, concatenate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Memory:
    """State: the guess, and the samples that it was made of."""

    guess: Guess
    kept: Mapping[str, Sense]
    """Sense label -> at most `size` samples."""

    @property
    def body(self) -> Body:
        """The body as believed now."""
        return self.guess.body


@dataclass(frozen=True)
class Replay:
    """Gradient learner with a memory of `size` samples a sense."""

    gradient: OnlineGradient = field(
        default_factory=lambda: OnlineGradient(epsilon=1.0, rule="normalised")
    )
    size: int = 60
    """Samples kept of each sense."""
    passes: int = 5
    """How often the gradient goes over all kept samples after each new one."""

    def start(self, body: Body, variables: Variables) -> Memory:
        """See `OnlineGradient.start`."""
        return Memory(self.gradient.start(body, variables), {})

    def step(self, state: Memory, moment: Moment) -> tuple[Memory, tuple[Miss, ...]]:
        """Learn from one moment, and again from samples that are kept."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: Memory, sample: Sense) -> tuple[Memory, Miss]:
        """Learn from one sample (a batch of one), and again from those that are kept."""
        guess, (miss,) = self.gradient.step(state.guess, (sample,))
        before = state.kept.get(sample.label)
        more = sample if before is None else concatenate([before, sample])
        kept = {**state.kept, sample.label: well_spread(more, self.size)}
        seen = [SkeletonSamples.of(samples, guess.reference, guess.R0) for samples in kept.values()]
        for _ in range(self.passes):
            for one in seen:
                guess, _ = self.gradient.descend(guess, one)
        return Memory(guess, kept), miss


def well_spread(samples: Sense, size: int) -> Sense:
    """At most `size` of the samples, those whose postures crowd least."""
    stays = np.arange(len(samples))
    while len(stays) > size:
        stays = np.delete(stays, most_crowded(samples.q[stays]))
    return samples if len(stays) == len(samples) else samples.take(stays)


def most_crowded(q: Array) -> int:
    """Of the nearest two postures, (n, n_joints), the one that is nearer to a third."""
    apart = np.linalg.norm(q[:, None] - q[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    pair = np.unravel_index(np.argmin(apart), apart.shape)
    # Both have the same first neighbour distance: the second decides.
    second = [float(np.partition(apart[i], 1)[1]) if len(q) > 2 else 0.0 for i in pair]
    return int(pair[int(np.argmin(second))])
