"""Means of a wrench as samples come in, one by one or in bundles.

Only the samples of the current window are kept, so the cost of a sample does not grow with time.
A mean is told half a window after its middle.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.senses.wrench_means import FEWEST, Averaging, WrenchMeans
from bodyschema.senses.wrist_samples import COLUMNS, WristSamples

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Buffer:
    """State: the samples of the window, and when the next mean is due."""

    samples: WristSamples | None = None
    due: float = np.inf
    """s"""


@dataclass(frozen=True)
class WrenchStream:
    """The averaging of `wrench_means` for a stream."""

    averaging: Averaging = field(default_factory=Averaging)

    def start(self) -> Buffer:
        """Nothing seen yet."""
        return Buffer()

    def step(self, state: Buffer, sample: WristSamples) -> tuple[Buffer, WrenchMeans | None]:
        """The state after some samples, and a mean if one is due.

        Raises:
            InputError: time goes back.
        """
        window = self.averaging.window
        if state.samples is None:
            return Buffer(sample, float(sample.time[0]) + window), None
        if sample.time[0] <= state.samples.time[-1]:
            raise InputError(
                f"time goes back from {state.samples.time[-1]:.6f} to {sample.time[0]:.6f} s; "
                "give samples in the order of time."
            )
        samples = _after(state.samples, sample)
        now = float(samples.time[-1])
        if now < state.due - 1e-9:
            return replace(state, samples=samples), None
        kept = samples.take(slice(int(np.searchsorted(samples.time, now - window - 1e-9)), None))
        due = max(state.due + self.averaging.overlap * window, now)
        return Buffer(kept, due), self._mean(kept)

    def _mean(self, kept: WristSamples) -> WrenchMeans | None:
        """The mean over the whole buffer; None after a gap."""
        if len(kept) < FEWEST:
            return None
        span = float(kept.time[-1] - kept.time[0])
        if span < 0.8 * self.averaging.window:
            return None
        try:
            return replace(self.averaging, window=span).means(kept)
        except InputError:
            return None


def _after(samples: WristSamples, more: WristSamples) -> WristSamples:
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(samples, name), getattr(more, name)])
        for name in COLUMNS
        if getattr(samples, name) is not None
    }
    return replace(samples, **joined)
