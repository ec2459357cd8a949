"""A body whose learner can be watched: the recursive Gauss-Newton filter, ready for a monitor.

What may change on its own are the zero of each joint and each free frame (a tracker, a tool): these
are the blocks. Axes and lengths of links wear slowly and are no block; they stay as learned.

A belief (x, Lambda) forgets block t by elimination (Schur), and t gets its prior again:

    Lambda_kk <- Lambda_kk - Lambda_kt Lambda_tt^-1 Lambda_tk,   Lambda_kt <- 0,   Lambda_tt <- P_t

Jacobians stay where they were taken: elsewhere they would not share the directions that no motion
tells (a first joint's zero and the tracker's turn), and those would run away. Noise that remembers
weighs as white noise with tau times the variance (`stream_noise`): from the first change on, noise
levels are multiplied by sqrt(tau) and held, and Lambda is divided by tau. The sum of squared
innovations r^T S^-1 r of such a filter is the least cost of its samples, the pull against the prior
included; each counts at most as much as the rarest good sample, so that single wild ones do not
decide.

A first belief is certified when it predicts what is seen, in random postures of the whole
workspace, to what was asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Certificate, Demand, certify
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import random_postures
from bodyschema.estimation.normal_equations import level_rows, whiten
from bodyschema.estimation.stream_noise import StreamNoise, wild_beyond
from bodyschema.learners.filter import Belief, Filter
from bodyschema.learners.watchable import Doubt, WhiteInnovation
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

Moment = tuple[Sense, ...]
"""What was seen at one time: a batch of one from each sense that saw something."""

UNITS = {"position": (1e3, "mm"), "rotation": (180 / np.pi, "deg")}

SETTLED = 60
"""Samples behind the burn-in before a certificate is looked at."""

HELD = 1e12
"""Samples that a noise level counts for when it is to stay."""

POSTURES = 24
"""Random postures that stand for the workspace."""


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
class WatchedBody:
    """Settings."""

    body: Body
    """Reference, with every frame attached."""
    variables: Variables
    learner: Filter = Filter(burn_in=300)  # noqa: RUF009  (frozen settings)
    """With a long burn-in: Jacobians stay where its fit ends, and a poor place costs false alarms
    for as long as the belief lives."""
    demand: Demand = field(default_factory=lambda: Demand({"position": 0.002}))
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

    def step(self, state: WatchedBelief, sample: Moment) -> WatchedBelief:
        """Learn from one moment."""
        for seen in sample:
            state = self._learn(state, seen)
        return state

    def innovation(self, state: WatchedBelief, sample: Moment) -> WhiteInnovation:
        """A moment against what the belief predicts."""
        k = len(self.variables)
        e, J, source = [np.zeros(0)], [np.zeros((0, k))], [np.zeros(0, dtype=np.int64)]
        labels = list(state.filter.templates)
        for seen in sample:
            white, slope = (part[0] for part in self.innovations(state, seen))
            place = labels.index(seen.label) if seen.label in labels else len(labels)
            e.append(white)
            J.append(slope)
            source.append(np.full(len(white), place, dtype=np.int64))
        return WhiteInnovation(np.concatenate(e), np.concatenate(J), np.concatenate(source))

    def doubt(self, state: WatchedBelief) -> Doubt:
        """Covariance, correlation, level and share of wild samples."""
        tau = state.noise.long_run / state.tempered
        return Doubt(
            state.filter.estimate.covariance * max(tau, 1.0) * max(state.noise.level, 1.0),
            state.noise.correlation,
            state.noise.level,
            state.noise.wild_share,
        )

    def difference(self, state: WatchedBelief, earlier: WatchedBelief) -> Array:
        """(k,) the step of x."""
        return state.filter.x - earlier.filter.x

    def certificate(self, state: WatchedBelief) -> Certificate:
        """Whether the body predicts well enough in its whole workspace."""
        if not state.filter.started or state.rows < SETTLED:
            return Certificate(False, {}, np.inf, ("too few samples for a first fit.",))
        P = self.doubt(state).covariance
        worst: dict[str, Array] = {}
        for template in state.filter.templates.values():
            for name, J in self._slopes(state, template).items():
                spread = J @ P @ np.swapaxes(J, 1, 2)
                widest = spread[np.argmax(np.linalg.eigvalsh(spread)[:, -1])]
                if name not in worst or np.trace(widest) > np.trace(worst[name]):
                    worst[name] = widest
        cost, independent = self.evidence(state)
        # The first fit finds the noise levels itself: it cannot fail to explain the residuals.
        fit = cost / (state.noise.level * independent) if state.relearning else 1.0
        held = certify(self.demand, worst, fit, independent, np.inf, UNITS)
        if state.noise.recent < 0.3:
            return held
        wild = "most of the last samples do not fit."
        return replace(held, holds=False, missing=(*held.missing, wild))

    def forget(self, state: WatchedBelief, block: str) -> WatchedBelief:
        """Go on with one block as unknown as at first; "" keeps everything."""
        old = state.filter
        tau = max(state.noise.long_run / state.tempered, 1.0)
        information = old.information / tau
        if block:
            t = self.blocks[block]
            part = information[:, t] @ np.linalg.solve(information[np.ix_(t, t)], information[t])
            information = information - part
            information[t], information[:, t] = 0.0, 0.0
            information[t, t] = old.variables.prior_std[t] ** -2.0
        root = np.sqrt(tau)
        levels = {
            label: (tuple(root * s for s in level), HELD)
            for label, (level, _) in old.levels.items()
        }
        fresh = replace(old, information=(information + information.T) / 2, levels=levels)
        return WatchedBelief(fresh, state.noise, tempered=state.tempered * tau, relearning=True)

    def evidence(self, state: WatchedBelief) -> tuple[float, float]:
        """Sum of squared innovations, and the independent rows behind it."""
        return state.cost, state.rows / state.tempered

    def astray(self, state: WatchedBelief) -> bool:
        """Whether most of the last samples are wild."""
        return state.noise.recent > 0.5

    def _learn(self, state: WatchedBelief, seen: Sense) -> WatchedBelief:
        if not state.filter.started:
            return replace(state, filter=self.learner.step(state.filter, seen)[0])
        filter_, info = self.learner.step(state.filter, seen)
        d = len(seen.covariance)
        limit = wild_beyond(d) * state.noise.level
        cost = state.cost + min(info.surprise, limit)
        after = replace(state, filter=filter_, cost=cost, rows=state.rows + d)
        if state.relearning:
            return after
        e = self.innovations(state, seen)[0][0]
        noise = state.noise.learn(e, state.before.get(seen.label), info.surprise)
        before = {label: old for label, old in state.before.items() if label != seen.label}
        if info.surprise <= limit:
            before[seen.label] = e
        return replace(after, noise=noise, before=before)

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

    def _slopes(self, state: WatchedBelief, template: Sense) -> dict[str, Array]:
        """Component -> (POSTURES, 3, k) slope of the prediction in the workspace, SI units."""
        q = random_postures(self.body, POSTURES, np.random.default_rng(0))
        old = state.filter
        ideal = template.imagined(old.reference, q)
        J = ideal.linearize(old.reference, old.variables, old.anchor).by_parameter
        return {name: J[:, rows] for name, _, rows in template.components}


def believed_levels(estimate: Estimate, sense: Sense) -> tuple[float, ...]:
    """Noise levels of a calibration, in units of the sense's believed noise."""
    std = np.sqrt(np.diag(sense.covariance))
    noise = estimate.noise or {}
    return tuple(
        noise[f"{sense.label}: {name} ({unit})"] / float(np.mean(std[rows]))
        for name, unit, rows in sense.components
    )


def moments(senses: Sequence[Sense]) -> list[Moment]:
    """Samples in order of time, those of one time together."""
    times = np.unique(np.concatenate([sense.time for sense in senses]))
    gathered: list[list[Sense]] = [[] for _ in times]
    for sense in senses:
        for i, k in enumerate(np.searchsorted(times, sense.time)):
            gathered[k].append(sense.take([i]))
    return [tuple(group) for group in gathered]
