"""A body whose learner can be watched: the recursive Gauss-Newton filter, ready for a monitor.

What may change on its own are the zero of each joint and each free frame (a tracker, a tool): these
are the blocks. Axes and lengths of links wear slowly and are no block; they stay as learned.

Jacobians stay where they were taken: elsewhere they would not share the directions that no motion
tells (a first joint's zero and the tracker's turn), and those would run away. Noise that remembers
weighs as white noise with tau times the variance (`stream_noise`): from the first change on, noise
levels are multiplied by sqrt(tau) and held, and Lambda is divided by tau. The sum of squared
innovations r^T S^-1 r of such a filter is the least cost of its samples, the pull against the prior
included; each counts at most as much as the rarest good sample, so that single outliers do not
decide.

A first belief is certified when it predicts what is seen, in random postures of the whole
workspace, to what was asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import GaussianBelief, WhiteInnovation, forget
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.normal_equations import level_rows, whiten
from bodyschema.estimation.stream_noise import StreamNoise, outlier_limit
from bodyschema.learners.filter import Belief, Filter, Innovation
from bodyschema.learners.learner import Moment, MonitoredLearner, in_turn
from bodyschema.learners.workspace import prediction_slopes
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SETTLED = 60
"""Samples behind the burn-in before a certificate is looked at."""

HELD = 1e12
"""Samples that a noise level counts for when it is to stay."""


@dataclass(frozen=True)
class WatchedBelief:
    """State: the filter's belief, and what its residuals look like."""

    filter: Belief
    noise: StreamNoise = StreamNoise()  # noqa: RUF009  (frozen)
    before: Mapping[str, Array] = field(default_factory=dict)
    """Sense label -> white residual of the sample before, if that was good."""
    tempered: float = 1.0
    """tau by which the noise's variance was multiplied for good; 1 before the first change."""
    relearning: bool = False
    """Whether this belief began from a prior, with a block forgotten."""
    cost: float = 0.0
    rows: float = 0.0
    """Sum of squared innovations, and their number of rows."""


@dataclass(frozen=True)
class WatchedBody(MonitoredLearner[WatchedBelief, Sense, tuple[Innovation, ...]]):
    """Settings; watch it with a `Monitor`."""

    body: Body
    """Reference, with every frame attached."""
    variables: Variables
    learner: Filter = Filter(burn_in=300)  # noqa: RUF009  (frozen settings)
    """With a long burn-in: Jacobians stay where its fit ends, and a poor place costs false alarms
    for as long as the belief lives."""
    tolerance: Tolerance = field(default_factory=lambda: Tolerance({"position": 0.002}))
    """m, rad: 99 % bounds of the prediction; add "rotation" for senses of poses."""

    @cached_property
    def blocks(self) -> Mapping[str, Ints]:
        """Joint or frame -> places of its parameters."""
        parts: dict[str, list[int]] = {}
        for i, (name, group) in enumerate(
            zip(self.variables.names, self.variables.groups, strict=True)
        ):
            if group == "offsets" or group.startswith("frame:"):
                parts.setdefault(name.rpartition(".")[0], []).append(i)
        return {part: np.array(rows, dtype=np.int64) for part, rows in parts.items()}

    def start(self) -> WatchedBelief:
        """Nothing known but the prior."""
        return WatchedBelief(self.learner.start(self.body, self.variables))

    def known(self, estimate: Estimate, noise: StreamNoise, senses: Moment) -> WatchedBelief:
        """A belief from a calibration that is done.

        Args:
            estimate: of a body with this one's parameters.
            noise: of the stream to come; noise levels are multiplied by the root of its level.
            senses: one of each, for labels and units; samples in them do not matter.
        """
        root = np.sqrt(noise.level)
        levels = {
            s.label: (tuple(root * a for a in believed_levels(estimate, s)), HELD) for s in senses
        }
        filter_ = Belief(
            estimate.reference, estimate.variables, estimate.x, estimate.x,
            estimate.information, levels, (), True, {s.label: s.take([]) for s in senses},
        )  # fmt: skip
        return WatchedBelief(filter_, replace(noise, level=1.0))

    def step(
        self, state: WatchedBelief, moment: Moment
    ) -> tuple[WatchedBelief, tuple[Innovation, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def innovation(self, state: WatchedBelief, moment: Moment) -> WhiteInnovation:
        """A moment against what the belief predicts."""
        k = len(self.variables)
        e, J, source = [np.zeros(0)], [np.zeros((0, k))], [np.zeros(0, dtype=np.int64)]
        labels = list(state.filter.templates)
        for seen in moment:
            white, slope = (part[0] for part in self.innovations(state, seen))
            place = labels.index(seen.label) if seen.label in labels else len(labels)
            e.append(white)
            J.append(slope)
            source.append(np.full(len(white), place, dtype=np.int64))
        return WhiteInnovation(np.concatenate(e), np.concatenate(J), np.concatenate(source))

    def belief(self, state: WatchedBelief) -> GaussianBelief:
        """Of the variables, in the chart of the reference."""
        level = state.noise.level
        cost, rows = state.cost / level, state.rows / state.tempered
        relearned = state.relearning and rows > 0
        return GaussianBelief(
            state.filter.estimate.covariance,
            self.tolerance,
            state.noise,
            state.tempered,
            cost,
            rows,
            # The first fit finds the noise levels itself: it cannot fail to explain the residuals.
            fit=cost / rows if relearned else 1.0,
            freedom=rows,
            begun=state.filter.started and state.rows >= SETTLED,
        )

    def difference(self, state: WatchedBelief, earlier: WatchedBelief) -> Array:
        """(k,) the step of x."""
        return state.filter.x - earlier.filter.x

    def certificate(self, state: WatchedBelief) -> Certificate:
        """Whether the body predicts well enough in its whole workspace."""
        old = state.filter
        templates = old.templates.values()
        slopes = prediction_slopes(templates, old.reference, old.variables, old.anchor)
        return self.belief(state).certificate(slopes)

    def forget(self, state: WatchedBelief, block: str) -> WatchedBelief:
        """Go on with one block as unknown as at first; "" keeps everything."""
        old = state.filter
        tau = max(state.noise.long_run / state.tempered, 1.0)
        information = old.information / tau
        if block:
            rows = self.blocks[block]
            information = forget(information, rows, old.variables.prior_std[rows] ** -2.0)
        root = np.sqrt(tau)
        levels = {
            label: (tuple(root * s for s in level), HELD)
            for label, (level, _) in old.levels.items()
        }
        fresh = replace(old, information=information, levels=levels)
        return WatchedBelief(fresh, state.noise, tempered=state.tempered * tau, relearning=True)

    def _learn(self, state: WatchedBelief, seen: Sense) -> tuple[WatchedBelief, Innovation]:
        filter_, (info,) = self.learner.step(state.filter, (seen,))
        if not state.filter.started:
            return replace(state, filter=filter_), info
        d = len(seen.covariance)
        limit = outlier_limit(d) * state.noise.level
        cost = state.cost + min(info.surprise, limit)
        after = replace(state, filter=filter_, cost=cost, rows=state.rows + d)
        if state.relearning:
            return after, info
        e = self.innovations(state, seen)[0][0]
        noise = state.noise.learn(e, state.before.get(seen.label), info.surprise)
        before = {label: old for label, old in state.before.items() if label != seen.label}
        if info.surprise <= limit:
            before[seen.label] = e
        return replace(after, noise=noise, before=before), info

    def innovations(self, state: WatchedBelief, seen: Sense) -> tuple[Array, Array]:
        """White residuals (n, d) of one sense, and their growth with the parameters (n, d, k)."""
        old = state.filter
        part = whiten(seen, old.reference, old.variables, old.anchor)
        body = old.reference.with_variables(old.variables, old.x)
        white = np.linalg.solve(part.factor, seen.residual(body).T).T
        level = old.levels.get(seen.label, ((1.0,) * len(seen.components), 1.0))[0]
        # The noise itself, not the tempered one that the filter learns with.
        s = level_rows(seen, level) / np.sqrt(state.tempered)
        return white / s, -part.jacobian / s[:, None]


def believed_levels(estimate: Estimate, sense: Sense) -> tuple[float, ...]:
    """Noise levels of a calibration, in units of the sense's believed noise."""
    std = np.sqrt(np.diag(sense.covariance))
    noise = estimate.noise or {}
    return tuple(
        noise[f"{sense.label}: {name} ({unit})"] / float(np.mean(std[rows]))
        for name, unit, rows in sense.components
    )
