"""A known body that holds something: the smoother, ready for a monitor.

What may change is any group of variables: a tool, an upper arm, a camera. The smoother weighs its
newest samples again at each step, so that a tool of which nothing is known, seen by eyes that err
by centimetres and now and then see something else, is learned within seconds; see `smoother`.

A part that changed is forgotten by elimination and gets the spread of likely changes, which is
wider than its prior where that is tight: an upper arm may be bent. From then on samples count
1 / tau, tau the memory of the noise (`stream_noise`). What a belief costs is the sum of its squared
innovations, each at most as much as the rarest good one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.estimation.belief import GaussianBelief, WhiteInnovation, inverse
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.stream_noise import StreamNoise, outlier_limit
from bodyschema.learners.learner import Moment, MonitoredLearner, Pace, in_turn
from bodyschema.learners.smoother import Foresight, Smoothed, Smoother, compared
from bodyschema.learners.workspace import prediction_slopes
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Block:
    """A part of the body that may change as one."""

    name: str
    members: tuple[str, ...]
    """Names of its variables, which must be among those that are learned."""
    spread: float
    """Standard deviation of a likely change of each variable, in its unit (m, rad)."""
    odds: float = 1.0
    """How often it changes, relative to the others: tools more often than upper arms."""

    def rows(self, variables: Variables) -> list[int]:
        """Places of the members among the variables.

        Raises:
            InputError: a member is not among them.
        """
        for member in self.members:
            if member not in variables.names:
                raise InputError(
                    f"block '{self.name}' has the variable '{member}', which is not learned"
                    f"{did_you_mean(member, variables.names)}"
                )
        return [variables.names.index(member) for member in self.members]


@dataclass(frozen=True)
class SmoothedBelief:
    """State: the smoother's belief, and what its residuals look like."""

    smoothed: Smoothed
    noise: StreamNoise = StreamNoise()  # noqa: RUF009  (frozen)
    before: Mapping[str, Array] = field(default_factory=dict)
    """Sense label -> white residual of the sample before, if that was good."""
    tempered: float = 1.0
    """tau by which the noise's variance was multiplied for good; 1 before the first change."""
    relearning: bool = False
    """Whether this belief began from a prior, with a part forgotten."""
    cost: float = 0.0
    rows: float = 0.0
    """Sum of squared innovations, and their number of rows."""

    @property
    def estimate(self) -> Estimate:
        """The belief in the form of every learner's result."""
        return self.smoothed.estimate

    @property
    def body(self) -> Body:
        """The body as believed now."""
        return self.smoothed.body


@dataclass(frozen=True)
class WatchedSmoother(MonitoredLearner[SmoothedBelief, Sense, tuple[Foresight, ...]]):
    """Settings; watch it with a `Monitor`."""

    reference: Body
    """Around which the variables are."""
    variables: Variables
    parts: tuple[Block, ...]
    """What may change."""
    learner: Smoother = field(default_factory=Smoother)
    tolerance: Tolerance = field(default_factory=lambda: Tolerance({}))
    """m, rad: 99 % bounds of predictions in the workspace; without any, a full window will do."""

    def __post_init__(self) -> None:
        for part in self.parts:
            part.rows(self.variables)

    @cached_property
    def blocks(self) -> Mapping[str, Ints]:
        """Block -> places of its variables."""
        return {one.name: np.array(one.rows(self.variables)) for one in self.parts}

    @property
    def odds(self) -> Mapping[str, float]:
        """Block -> how often it changes."""
        return {one.name: one.odds for one in self.parts}

    @property
    def pace(self) -> Pace:
        """Of ten moments a second."""
        return Pace(rate=10.0, group=2, wait=24, first=5, margin=16.0)

    def start(self) -> SmoothedBelief:
        """Nothing known but the prior."""
        return SmoothedBelief(self.learner.start(self.reference, self.variables))

    def step(
        self, state: SmoothedBelief, moment: Moment
    ) -> tuple[SmoothedBelief, tuple[Foresight, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def innovation(self, state: SmoothedBelief, moment: Moment) -> WhiteInnovation:
        """A moment against what the belief predicts."""
        parts = [compared(state.smoothed, seen) for seen in moment]
        sizes = [len(part.residual[0]) for part in parts]
        return WhiteInnovation(
            np.concatenate([part.residual[0] for part in parts]),
            -np.concatenate([part.jacobian[0] for part in parts]),
            np.repeat(np.arange(len(parts)), sizes),
        )

    def belief(self, state: SmoothedBelief) -> GaussianBelief:
        """Of the variables."""
        cost, rows = state.cost / state.noise.level, state.rows / state.tempered
        relearned = state.relearning and rows > 0
        return GaussianBelief(
            inverse(state.smoothed.total),
            self.tolerance,
            state.noise,
            state.tempered,
            cost,
            rows,
            fit=cost / rows if relearned else 1.0,
            freedom=rows,
            begun=len(state.smoothed.window) >= self.learner.lag,
        )

    def certificate(self, state: SmoothedBelief) -> Certificate:
        """Whether the window is full, and the body predicts well enough in its workspace."""
        belief = self.belief(state)
        if not belief.begun or not self.tolerance.bounds:
            return belief.certificate({})
        known = state.smoothed
        slopes = prediction_slopes(
            known.window.batches, self.reference, self.variables, known.slope_at
        )
        return belief.certificate(slopes)

    def forget(self, state: SmoothedBelief, block: str) -> SmoothedBelief:
        """Go on with one part as it may be after a change; "" keeps everything."""
        tau = max(state.noise.long_run / state.tempered, 1.0)
        rows = self.blocks[block] if block else np.zeros(0, dtype=np.int64)
        spread = next((one.spread for one in self.parts if one.name == block), 1.0)
        fresh = self.learner.forgetting(state.smoothed, rows, spread, tau)
        return SmoothedBelief(fresh, state.noise, tempered=state.tempered * tau, relearning=True)

    def difference(self, state: SmoothedBelief, earlier: SmoothedBelief) -> Array:
        """(k,) the step of x."""
        return state.smoothed.x - earlier.smoothed.x

    def _learn(self, state: SmoothedBelief, seen: Sense) -> tuple[SmoothedBelief, Foresight]:
        counted = replace(seen, covariance=state.tempered * seen.covariance)
        smoothed, (info,) = self.learner.step(state.smoothed, (counted,))
        after = replace(state, smoothed=smoothed)
        if not state.relearning and len(state.smoothed.window) < self.learner.lag:
            # A belief that began with an outlier is as surprised as one whose body has changed.
            return after, info
        limit = outlier_limit(len(info.residual)) * state.noise.level
        cost = state.cost + min(info.surprise, limit)
        after = replace(after, cost=cost, rows=state.rows + len(info.residual))
        if state.relearning:
            return after, info
        e = compared(state.smoothed, seen).residual[0]
        noise = state.noise.learn(e, state.before.get(seen.label), info.surprise)
        before = {label: old for label, old in state.before.items() if label != seen.label}
        if info.surprise <= limit:
            before[seen.label] = e
        return replace(after, noise=noise, before=before), info
