"""What changed? Every part is tried: it alone is forgotten, all else stays as prior.

After an alarm each block b, and also "nothing", gets its own learner that starts with the others as
prior and learns from the moments since the alarm. With c_b its cost, n the residuals behind it
(`GaussianBelief`) and k_b the block's size,

    I_b = c_b + k_b ln n - 2 ln odds_b

is compared (Schwarz 1978). A block is named when its cost explains the residuals, and every other I
is a margin higher. Some blocks contain others: a tool can move in every way that the last joint
moves it. From SIMPLER moments on a block needs no margin over larger ones, only the lower I. While
the body is still moving no block explains: all start anew. "Nothing" wins a scare that a burst of
outliers caused. When time runs out all is learned again.

Moments that wait at the alarm are tried first, those since the change: it is dated where the ratio
of any one block (`block_ratio`) over the newest moments is largest, innovations clipped to CLIP
standard deviations, so that outliers date nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from bodyschema.estimation.belief import WhiteInnovation
from bodyschema.learners.learner import MonitoredLearner
from bodyschema.monitoring.block_ratio import limit, ratio
from bodyschema.monitoring.whitening import in_time

State = TypeVar("State")
Sample = TypeVar("Sample")

NOTHING, EVERYTHING = "", "everything"

MOVING, CALM, LONGEST = 27, 45, 240
"""Moments before trials start anew, before nothing has changed, and before everything is learned
again."""

SIMPLER = 120
"""Moments after which the smaller of two blocks that explain the same is named."""

CLIP, RARE = 3.0, 1e-6
"""Standard deviations that an innovation counts for, and the chance of a ratio, in dating."""

Seen = Sequence[WhiteInnovation]


@dataclass(frozen=True)
class Trials(Generic[State]):
    """State: one learner a hypothesis."""

    base: State
    """The belief before the alarm."""
    beliefs: Mapping[str, State]
    """Block, or NOTHING -> its learner's state."""
    moments: int = 0
    """Since these trials began."""
    total: int = 0
    """Since the alarm, those that waited included."""
    waited: int = 0
    """Of the moments since these trials began: seen before the alarm."""
    leader: str = NOTHING
    """The hypothesis with the lowest I when they were compared last."""


@dataclass(frozen=True)
class Verdict(Generic[State]):
    """A named block, and the belief that learning goes on from."""

    block: str
    """A block, NOTHING or EVERYTHING."""
    belief: State


def dated(learner: MonitoredLearner[State, Sample, Any], base: State, seen: Seen) -> int:
    """Number of the newest moments since which one block best explains what was seen.

    Args:
        learner: whose blocks may have changed.
        base: the belief before the alarm.
        seen: white innovations of the waiting moments against it, newest last.
    """
    belief = learner.belief(base)
    P, k = belief.doubt, len(belief.covariance)
    s, H = np.zeros(k), np.zeros((k, k))
    best, at = 0.0, 1
    for n in range(1, len(seen) + 1):
        before = seen[-n - 1] if n < len(seen) else None
        white = in_time(seen[-n], before, belief.noise.correlation)
        S = np.eye(len(white.e)) * belief.level + white.J @ P @ white.J.T
        size = float(np.sqrt(white.e @ np.linalg.solve(S, white.e)))
        s += white.J.T @ white.e * min(1.0, CLIP / max(size, CLIP)) / belief.level
        H += white.J.T @ white.J / belief.level
        share = max(ratio(s, H, P, b) / limit(RARE, len(b)) for b in learner.blocks.values())
        if share > best:
            best, at = share, n
    return at


def begin(
    learner: MonitoredLearner[State, Sample, Any],
    base: State,
    since: Sequence[tuple[Sample, ...]] = (),
) -> Trials[State]:
    """Trials from the belief before the alarm; they have seen the moments since the change."""
    names = [*learner.blocks, NOTHING]
    trials = Trials(base, {name: learner.forget(base, name) for name in names})
    for moment in since:
        trials = weigh(learner, trials, moment)[0]
    return replace(trials, waited=trials.moments)


def weigh(
    learner: MonitoredLearner[State, Sample, Any], trials: Trials[State], moment: tuple[Sample, ...]
) -> tuple[Trials[State], Verdict[State] | None]:
    """One more moment for all trials; a verdict when one is due."""
    beliefs = {name: learner.step(belief, moment)[0] for name, belief in trials.beliefs.items()}
    trials = replace(trials, beliefs=beliefs, moments=trials.moments + 1, total=trials.total + 1)
    if trials.moments < learner.pace.first or trials.moments % 3:
        return trials, None
    index, explains = _compare(learner, trials)
    best = min(index, key=lambda name: index[name])
    trials = replace(trials, leader=best)
    early = best == NOTHING and trials.moments - trials.waited < CALM
    if explains[best] and not early and _stands_out(learner, best, index, trials.moments):
        belief = trials.base if best == NOTHING else beliefs[best]
        return trials, Verdict(best, belief)
    if trials.total >= LONGEST:
        return trials, Verdict(EVERYTHING, learner.start())
    if trials.moments >= MOVING and not any(explains.values()):
        return replace(begin(learner, trials.base), total=trials.total), None
    return trials, None


def _stands_out(
    learner: MonitoredLearner[State, Sample, Any],
    best: str,
    index: Mapping[str, float],
    moments: int,
) -> bool:
    """Whether every other I is far enough above the lowest."""
    if best == NOTHING:
        return True
    size = {name: len(learner.blocks[name]) if name else 0 for name in index}
    rivals = [
        index[name]
        for name in index
        if name != best and not (moments >= SIMPLER and size[name] > size[best])
    ]
    return min(rivals) - index[best] > learner.pace.margin


def _compare(
    learner: MonitoredLearner[State, Sample, Any], trials: Trials[State]
) -> tuple[dict[str, float], dict[str, bool]]:
    """I_b of every trial, and whether it explains what was seen."""
    index, explains = dict[str, float](), dict[str, bool]()
    for name, state in trials.beliefs.items():
        belief = learner.belief(state)
        size = len(learner.blocks[name]) if name else 0
        odds = learner.odds[name] if name else 1.0
        index[name] = belief.cost + size * np.log(max(belief.rows, 2.0)) - 2 * np.log(odds)
        explains[name] = belief.explains
    return index, explains
