"""Identify, then observe; when the body changed, find out what, and learn that part again.

    identify --certificate--> observe --alarm--> blame --block named--> identify with the rest known
                                 ^                 |
                                 +----nothing------+    everything ---> identify from nothing

A pure transition function round any `MonitoredLearner`: `step(state, moment)` returns the next
state and what happened. While observing, a moment is tested first and learned when the longest test
has done with it, so that a change that shows late is not learned, and the uncertain grows certain.
A learner with one block has nobody else to blame: what changed is that block, and the samples of
the next few moments, while it may still be changing, are left out.

The tests share the allowed rate of false alarms: half for the sums of `cusum`, half for the ratios
of `block_ratio` (if the learner's pace has them), both on innovations that are white in time too
(`whitening`). The core sum is armed only while the belief's error is a small part of them,
tr J P J^T < m / 4: before, innovations are not independent.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Generic, Literal, NamedTuple, TypeVar

import numpy as np

from bodyschema.estimation.belief import WhiteInnovation
from bodyschema.estimation.certificate import Certificate
from bodyschema.learners.learner import MonitoredLearner
from bodyschema.monitoring.blame import EVERYTHING, NOTHING, Trials, begin, dated, weigh
from bodyschema.monitoring.block_ratio import BlockRatio, Window, noticeable
from bodyschema.monitoring.cusum import Cusum, Sums
from bodyschema.monitoring.whitening import prepare

State = TypeVar("State")
Sample = TypeVar("Sample")

Mode = Literal["identify", "observe", "blame"]
Event = Literal["", "identified", "alarm", "changed", "dismissed", "restarted"]

ARMED = 0.25
"""Share of the belief's own error in the innovations below which the core sum runs."""

DAY = 24 * 3600.0
"""s"""

PATIENCE = 150
"""Moments that a first belief may contradict its samples before it starts anew; doubled then."""


class Waiting(NamedTuple, Generic[Sample]):
    """A moment that waits."""

    moment: tuple[Sample, ...]
    seen: WhiteInnovation
    """Against the belief of its time."""


@dataclass(frozen=True)
class MonitorState(Generic[State, Sample]):
    """State of the monitor."""

    belief: State
    mode: Mode = "identify"
    base: State | None = None
    """The last certified belief while a block is being learned again; None at first."""
    sums: Sums = field(default_factory=Sums)
    window: Window | None = None
    before: WhiteInnovation | None = None
    """The innovation of the moment before."""
    waiting: tuple[Waiting[Sample], ...] = ()
    """Moments that are tested, not yet learned; newest last."""
    trials: Trials[State] | None = None
    moments: int = 0
    """Since the mode began."""
    left_out: int = 0
    """Moments still to be left out."""
    patience: int = PATIENCE


@dataclass(frozen=True)
class MonitorInfo:
    """What one moment led to."""

    mode: Mode
    event: Event = ""
    block: str = ""
    """The block that changed, or "everything"; at an alarm, the one that is suspected, if any."""
    change: str = ""
    """When a block is known again: a word for what happened to it, if the learner has one."""
    certificate: Certificate | None = None
    """While identifying, when it was looked at."""


@dataclass(frozen=True)
class Monitor(Generic[State, Sample]):
    """Settings."""

    learner: MonitoredLearner[State, Sample, Any]
    samples: float | None = None
    """Mean number of moments between false alarms, at least; None for a day of the learner's."""

    def start(self) -> MonitorState[State, Sample]:
        """Nothing known."""
        return MonitorState(self.learner.start())

    def observing(self, belief: State) -> MonitorState[State, Sample]:
        """A belief that is known to be good: watched from the first moment on."""
        window = self._empty(belief) if self.learner.pace.ratios else None
        return MonitorState(belief, "observe", window=window)

    def step(
        self, state: MonitorState[State, Sample], moment: tuple[Sample, ...]
    ) -> tuple[MonitorState[State, Sample], MonitorInfo]:
        """The state after one moment, and what happened."""
        if state.left_out:
            return replace(state, left_out=state.left_out - 1), MonitorInfo(state.mode)
        state = replace(state, moments=state.moments + 1)
        if state.mode == "identify":
            return self._identify(state, moment)
        if state.mode == "observe":
            return self._observe(state, moment)
        return self._blame(state, moment)

    def vigilance(self, state: MonitorState[State, Sample]) -> dict[str, float]:
        """Smallest change of each block, worst direction, that the last seconds would have shown.

        In the block's units; inf when the motion says nothing about it or nothing is watched yet.
        """
        blocks = self.learner.blocks
        if state.window is None:
            return dict.fromkeys(blocks, np.inf)
        H, P = state.window.H.sum(axis=0), self.learner.belief(state.belief).doubt
        return {name: noticeable(H, P, b, self._ratio.limit(name)) for name, b in blocks.items()}

    @cached_property
    def _share(self) -> float:
        """Moments between false alarms of the sums, or of the ratios."""
        pace = self.learner.pace
        return (1 + pace.ratios) * (self.samples or DAY * pace.rate)

    @cached_property
    def _cusum(self) -> Cusum:
        return Cusum(self._share)

    @cached_property
    def _ratio(self) -> BlockRatio:
        learner = self.learner
        return BlockRatio(self._share, learner.blocks, learner.odds, learner.pace.group)

    def _empty(self, belief: State) -> Window:
        return Window.empty(len(self.learner.belief(belief).covariance))

    def _identify(
        self, state: MonitorState[State, Sample], moment: tuple[Sample, ...]
    ) -> tuple[MonitorState[State, Sample], MonitorInfo]:
        """Learn; certified, or contradicted, by now?"""
        if self.learner.pace.early and self.learner.belief(state.belief).begun:
            state, alarm, blame = self._tested(state, moment)
            if alarm:
                return self._suspect(state), MonitorInfo("identify", "alarm", blame)
            state = self._learned(state, 1)
        else:
            state = replace(state, belief=self.learner.step(state.belief, moment)[0])
        if state.moments % self.learner.pace.look:
            return state, MonitorInfo("identify")
        certificate = self.learner.certificate(state.belief)
        if certificate.holds:
            return self._certified(state, certificate)
        belief = self.learner.belief(state.belief)
        if state.base is not None and not belief.explains:
            suspicious = self._suspect(replace(state, belief=state.base))
            return suspicious, MonitorInfo(suspicious.mode, certificate=certificate)
        if state.base is None and state.moments >= state.patience and belief.diverged:
            anew = replace(self.start(), patience=2 * state.patience)
            return anew, MonitorInfo("identify", "restarted", certificate=certificate)
        return state, MonitorInfo("identify", certificate=certificate)

    def _certified(
        self, state: MonitorState[State, Sample], certificate: Certificate
    ) -> tuple[MonitorState[State, Sample], MonitorInfo]:
        change = "" if state.base is None else self.learner.change(state.base, state.belief)
        watch = replace(self.observing(state.belief), waiting=state.waiting)
        return watch, MonitorInfo("observe", "identified", change=change, certificate=certificate)

    def _observe(
        self, state: MonitorState[State, Sample], moment: tuple[Sample, ...]
    ) -> tuple[MonitorState[State, Sample], MonitorInfo]:
        """Test, and learn what has waited long enough."""
        state, alarm, blame = self._tested(state, moment)
        if alarm:
            suspicious = self._suspect(replace(state, base=state.belief))
            return suspicious, MonitorInfo(suspicious.mode, "alarm", blame)
        return self._learned(state, self.learner.pace.wait), MonitorInfo("observe")

    def _tested(
        self, state: MonitorState[State, Sample], moment: tuple[Sample, ...]
    ) -> tuple[MonitorState[State, Sample], bool, str]:
        """The tests with one moment more; whether there is an alarm, and whom it suspects."""
        belief = self.learner.belief(state.belief)
        seen = self.learner.innovation(state.belief, moment)
        tested = prepare(seen, state.before, belief)
        armed = tested.spread < ARMED
        share = belief.noise.outlier_share
        sums, alarm = self._cusum.step(state.sums, tested.squared, share, armed)
        window, blame = state.window, ""
        if self.learner.pace.ratios:
            window = window or self._empty(state.belief)
            window, blame = self._ratio.step(window, tested.e, tested.J, belief.doubt)
        waiting = (*state.waiting, Waiting(moment, seen))
        state = replace(state, sums=sums, window=window, before=tested.kept, waiting=waiting)
        return state, alarm or blame != "", blame

    def _learned(
        self, state: MonitorState[State, Sample], wait: int
    ) -> MonitorState[State, Sample]:
        """The oldest moment is learned if more than so many wait."""
        if len(state.waiting) <= wait:
            return state
        oldest, *waiting = state.waiting
        belief, window = self.learner.step(state.belief, oldest.moment)[0], state.window
        if window is not None:
            window = window.move(self.learner.difference(belief, state.belief))
        return replace(state, belief=belief, waiting=tuple(waiting), window=window)

    def _suspect(self, state: MonitorState[State, Sample]) -> MonitorState[State, Sample]:
        """Who was it? With one block alone nobody has to be asked."""
        base, settle = state.base, self.learner.pace.settle
        if base is None:
            return replace(self.start(), left_out=settle)
        if len(self.learner.blocks) > 1:
            n = dated(self.learner, base, [one.seen for one in state.waiting])
            since = [one.moment for one in state.waiting[-n:]]
            return MonitorState(base, "blame", base, trials=begin(self.learner, base, since))
        (block,) = self.learner.blocks
        return MonitorState(self.learner.forget(base, block), base=base, left_out=settle)

    def _blame(
        self, state: MonitorState[State, Sample], moment: tuple[Sample, ...]
    ) -> tuple[MonitorState[State, Sample], MonitorInfo]:
        """One moment more for all trials."""
        if state.trials is None:
            raise ValueError("a state in mode 'blame' needs trials; make it with `step`.")
        trials, verdict = weigh(self.learner, state.trials, moment)
        if verdict is None:
            # Until it is clear, the hypothesis that leads answers.
            leading = trials.beliefs[trials.leader]
            return replace(state, belief=leading, trials=trials), MonitorInfo("blame")
        if verdict.block == NOTHING:
            return self.observing(verdict.belief), MonitorInfo("observe", "dismissed")
        base = None if verdict.block == EVERYTHING else trials.base
        found = MonitorState[State, Sample](verdict.belief, base=base)
        return found, MonitorInfo("identify", "changed", verdict.block)
