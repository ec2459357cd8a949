"""Identify, then observe; when the body changed, find out what, and learn that part again.

    identify --certificate--> observe --alarm--> label --block named--> identify with the rest known
                                 ^                  |
                                 +---nothing--------+   everything ---> identify from nothing

A pure transition function round any `Watchable` learner: `step(state, sample)` returns the next
state and a report. While observing, a sample is tested first and learned when the longest test has
done with it, so that a change that shows late is not learned, and the uncertain grows certain.

The tests share the allowed rate of false alarms: half for the sums of `cusum`, half for the ratios
of `block_ratio`, both on innovations that are white in time too (`whitening`). The core sum is
armed only while the belief's error is a small part of them, tr J P J^T < m / 4: before, innovations
are not independent.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Generic, Literal, TypeVar

import numpy as np

from bodyschema.estimation.certificate import Certificate
from bodyschema.learners.watchable import Watchable, WhiteInnovation
from bodyschema.monitoring.block_ratio import LONGEST, BlockRatio, Window, noticeable
from bodyschema.monitoring.cusum import Cusum, Sums
from bodyschema.monitoring.labelling import (
    EVERYTHING,
    NOTHING,
    Trials,
    begin,
    credible,
    weigh,
)
from bodyschema.monitoring.whitening import prepare

State = TypeVar("State")
Sample = TypeVar("Sample")

Mode = Literal["identify", "observe", "label"]

ARMED = 0.25
"""Share of the belief's own error in the innovations below which the core sum runs."""


@dataclass(frozen=True)
class Watch(Generic[State, Sample]):
    """State of the machine."""

    belief: State
    mode: Mode = "identify"
    base: State | None = None
    """The last certified belief while a block is being learned again; None at first."""
    sums: Sums = field(default_factory=Sums)
    window: Window | None = None
    before: WhiteInnovation | None = None
    """The innovation of the sample before."""
    waiting: tuple[Sample, ...] = ()
    """Tested, not yet learned; newest last."""
    trials: Trials[State] | None = None
    samples: int = 0
    """Since the mode began."""
    patience: int = 150
    """Samples that a contradiction may last before identification starts anew."""


@dataclass(frozen=True)
class Report:
    """What one sample led to."""

    mode: Mode
    event: Literal["", "identified", "alarm", "changed", "dismissed", "restarted"] = ""
    block: str = ""
    """At a change: the block that changed, or "everything"."""
    certificate: Certificate | None = None
    """While identifying, when it was looked at."""


@dataclass(frozen=True)
class Machine(Generic[State, Sample]):
    """Settings."""

    learner: Watchable[State, Sample]
    samples: float = 24 * 3600 * 30.0
    """Mean number of samples between false alarms, at least: a day at 30 a second."""

    def start(self) -> Watch[State, Sample]:
        """Nothing known."""
        return Watch(self.learner.start())

    def step(
        self, state: Watch[State, Sample], sample: Sample
    ) -> tuple[Watch[State, Sample], Report]:
        """The state after one sample, and what happened."""
        state = replace(state, samples=state.samples + 1)
        if state.mode == "identify":
            return self._identify(state, sample)
        if state.mode == "observe":
            return self._observe(state, sample)
        return self._label(state, sample)

    def vigilance(self, state: Watch[State, Sample]) -> dict[str, float]:
        """Smallest change of each block, worst direction, that the last seconds would have shown.

        In the block's units; inf when the motion says nothing about it or nothing is watched yet.
        """
        blocks = self.learner.blocks
        if state.window is None:
            return dict.fromkeys(blocks, np.inf)
        H, P = state.window.H.sum(axis=0), self.learner.doubt(state.belief).covariance
        return {name: noticeable(H, P, b, self._ratio.limit(len(b))) for name, b in blocks.items()}

    @cached_property
    def _cusum(self) -> Cusum:
        return Cusum(2 * self.samples)

    @cached_property
    def _ratio(self) -> BlockRatio:
        return BlockRatio(2 * self.samples, self.learner.blocks)

    def _identify(
        self, state: Watch[State, Sample], sample: Sample
    ) -> tuple[Watch[State, Sample], Report]:
        belief = self.learner.step(state.belief, sample)
        state = replace(state, belief=belief)
        if state.samples % 3:
            return state, Report("identify")
        certificate = self.learner.certificate(belief)
        if certificate.holds:
            window = Window.empty(len(self.learner.doubt(belief).covariance))
            watch = Watch[State, Sample](belief, "observe", window=window)
            return watch, Report("observe", "identified", certificate=certificate)
        if state.base is not None:
            level = self.learner.doubt(state.base).level
            if credible(self.learner, belief, level):
                return state, Report("identify", certificate=certificate)
            return self._suspect(state.base), Report("label", certificate=certificate)
        if state.samples >= state.patience and self.learner.astray(belief):
            anew = Watch[State, Sample](self.learner.start(), patience=2 * state.patience)
            return anew, Report("identify", "restarted", certificate=certificate)
        return state, Report("identify", certificate=certificate)

    def _observe(
        self, state: Watch[State, Sample], sample: Sample
    ) -> tuple[Watch[State, Sample], Report]:
        doubt = self.learner.doubt(state.belief)
        raw = self.learner.innovation(state.belief, sample)
        tested = prepare(raw, state.before, doubt)
        sums, alarm = self._cusum.step(
            state.sums, tested.squared, doubt.wild, tested.spread < ARMED
        )
        window = state.window or Window.empty(len(doubt.covariance))
        window, blame = self._ratio.step(window, tested.e, tested.J, doubt.covariance)
        if alarm or blame:
            return self._suspect(state.belief), Report("label", "alarm", blame)
        belief, waiting = state.belief, (*state.waiting, sample)
        if len(waiting) > LONGEST:
            belief, waiting = self.learner.step(belief, waiting[0]), waiting[1:]
            window = window.move(self.learner.difference(belief, state.belief))
        watch = replace(
            state, belief=belief, waiting=waiting, sums=sums, window=window, before=tested.kept
        )
        return watch, Report("observe")

    def _suspect(self, base: State) -> Watch[State, Sample]:
        return Watch(base, "label", base=base, trials=begin(self.learner, base))

    def _label(
        self, state: Watch[State, Sample], sample: Sample
    ) -> tuple[Watch[State, Sample], Report]:
        if state.trials is None:
            raise ValueError("a state in mode 'label' needs trials; make it with `step`.")
        trials, verdict = weigh(self.learner, state.trials, sample)
        if verdict is None:
            return replace(state, trials=trials), Report("label")
        if verdict.block == NOTHING:
            window = Window.empty(len(self.learner.doubt(verdict.belief).covariance))
            watch = Watch[State, Sample](verdict.belief, "observe", window=window)
            return watch, Report("observe", "dismissed")
        base = None if verdict.block == EVERYTHING else trials.base
        watch = Watch[State, Sample](verdict.belief, "identify", base=base)
        return watch, Report("identify", "changed", verdict.block)
