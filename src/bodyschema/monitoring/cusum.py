"""Cumulative sums: small lasting surprise raises an alarm, a few outliers do not.

Two sums of log likelihood ratios, each g <- max(0, g + l) with an alarm at g > h (Page 1954):

    core    l = (q (1 - 1/r) - d ln r) / 2    q the squared white innovation of a source of d
                                              rows, against r times its variance; outliers left out
    gross   l = ln(p1 / p0) if one is an outlier, else ln((1 - p1) / (1 - p0))
                                              p0 the share of outliers, p1 that after a change

Since E exp(l) <= 1 while nothing changed, the mean time to a false alarm of each sum is at least
exp(h) samples (Lorden 1971): h = ln(2 samples between false alarms) for the two together. A source
is an outlier beyond the 1.5e-5 point of chi-square; leaving those out only lowers E exp(l).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.estimation.stream_noise import outlier_limit

AFTER = 0.9
"""p1: share of outliers after a large change."""


@dataclass(frozen=True)
class Sums:
    """State: both sums."""

    core: float = 0.0
    gross: float = 0.0


@dataclass(frozen=True)
class Cusum:
    """Settings of the two sums."""

    samples: float
    """Mean number of samples between false alarms, at least."""
    inflation: float = 3.0
    """r: variance after the change that the core sum looks for."""

    @property
    def limit(self) -> float:
        """h."""
        return float(np.log(2 * self.samples))

    def step(
        self, state: Sums, squared: list[tuple[float, int]], outliers: float, armed: bool
    ) -> tuple[Sums, bool]:
        """One sample.

        Args:
            state: the sums so far.
            squared: squared innovation and number of rows of each source.
            outliers: p0.
            armed: whether innovations are independent enough for the core sum: as long as the
                belief's own error makes up much of them they are not.

        Returns:
            the sums, and whether there is an alarm.
        """
        core, gross, r = 0.0, 0.0, self.inflation
        for q, d in squared:
            if q > outlier_limit(d):
                gross += np.log(AFTER / outliers)
            else:
                gross += np.log((1 - AFTER) / (1 - outliers))
                core += (q * (1 - 1 / r) - d * np.log(r)) / 2
        sums = Sums(max(0.0, state.core + core) if armed else 0.0, max(0.0, state.gross + gross))
        return sums, max(sums.core, sums.gross) > self.limit
