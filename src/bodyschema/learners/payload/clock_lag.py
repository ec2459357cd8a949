"""How late the wrench's time stamps are against those of the motion.

Sensor and robot often have clocks of their own. For trial lags the wrench is shifted and the load
fitted; with v_i(d) the mean squared residuals of the six components and n samples,

    L(d) = n sum_i ln v_i(d)

is twice the negative log likelihood, a constant left out. The lowest trial and its neighbours give
a parabola, whose lowest point is the lag. It is believed if L falls by `CLEAR` against no lag.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.senses.even_samples import evenly
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples

Array = NDArray[np.float64]

TRIALS, FINE = np.linspace(-0.12, 0.12, 13), np.linspace(-0.016, 0.016, 9)
"""s; the second row round the best of the first."""

CLEAR, SLIGHT = 30.0, 0.002
"""In units of chi-square, and s that are not worth a correction."""

LONGEST = 20_000
"""Samples that are looked at."""


@dataclass(frozen=True)
class ClockLag:
    """What the trials say."""

    lag: float
    """s by which the wrench is late; 0 if no lag is believed."""
    gain: float
    """Fall of L against no lag."""


def clock_lag(samples: WristSamples, learner: LoadLearner, averaging: Averaging) -> ClockLag:
    """Find the lag of a moving recording of one load."""
    even = evenly(samples.take(slice(0, LONGEST)))

    def misfits(trials: Array) -> Array:
        return np.array([_misfit(shifted(even, lag), learner, averaging) for lag in trials])

    L = misfits(TRIALS)
    k = int(np.argmin(L))
    if k in (0, len(TRIALS) - 1):
        return ClockLag(0.0, 0.0)
    # L has a narrow valley: between two trials a finer row is needed before a parabola holds.
    near = TRIALS[k] + FINE
    fine = misfits(near)
    j = int(np.clip(np.argmin(fine), 1, len(near) - 2))
    gain = float(L[len(TRIALS) // 2] - fine[j])
    if gain < CLEAR:
        return ClockLag(0.0, max(gain, 0.0))
    left, middle, right = fine[j - 1 : j + 2]
    bend = max(left - 2 * middle + right, 1e-12)
    lag = float(near[j] + 0.5 * (near[1] - near[0]) * np.clip((left - right) / bend, -1, 1))
    return ClockLag(lag if abs(lag) > SLIGHT else 0.0, gain)


def shifted(samples: WristSamples, lag: float) -> WristSamples:
    """With the wrench that belongs to each moment, read `lag` later; ends without one fall away."""
    if lag == 0:
        return samples
    time = samples.time
    inside = (time + lag >= time[0]) & (time + lag <= time[-1])
    kept = samples.take(np.flatnonzero(inside))
    wrench = [np.interp(kept.time + lag, time, column) for column in samples.wrench.T]
    return replace(kept, wrench=np.column_stack(wrench))


def _misfit(samples: WristSamples, learner: LoadLearner, averaging: Averaging) -> float:
    """L of one trial."""
    means = averaging.means(samples)
    belief, _ = learner.step(learner.start(), (means,))
    if belief.solution is None:
        return np.inf
    return float(len(means) * np.sum(np.log(belief.solution.levels.variance)))
