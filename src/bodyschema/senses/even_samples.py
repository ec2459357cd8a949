"""Samples at even times, from samples at uneven ones: cubic splines, never across a gap.

Means over a bump (`wrench_means`) trade derivatives for slopes of the bump. That is exact for sums
over even steps of time, to all orders that matter, and only to first order for uneven ones.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.senses.wrist_samples import COLUMNS, WristSamples

Array = NDArray[np.float64]

EVEN = 0.02
"""Share of a step by which steps may differ and still be even."""

GAP = 5.0
"""Usual steps that are a gap."""

SHORTEST = 5
"""Samples of a stretch that are worth keeping."""


def evenly(samples: WristSamples) -> WristSamples:
    """The same at the usual step of time; as it is if it is even already."""
    steps = np.diff(samples.time)
    if len(steps) < SHORTEST:
        return samples
    usual = float(np.median(steps))
    uneven = np.abs(steps - usual) > EVEN * usual
    gaps = np.flatnonzero(steps > GAP * usual)
    if not np.any(uneven & (steps <= GAP * usual)):
        return samples
    edges = [0, *(gaps + 1), len(samples)]
    stretches = [
        _stretch(samples.take(slice(a, b)), usual) for a, b in pairwise(edges) if b - a >= SHORTEST
    ]
    if not stretches:
        return samples
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in stretches])
        for name in COLUMNS
        if getattr(samples, name) is not None
    }
    return replace(samples, **joined)


def _stretch(samples: WristSamples, step: float) -> WristSamples:
    """One stretch without a gap."""
    from scipy.interpolate import CubicSpline

    time = np.arange(samples.time[0], samples.time[-1], step)
    columns: dict[str, Any] = {"time": time}
    for name in COLUMNS[1:]:
        values = getattr(samples, name)
        if values is not None:
            flat = values.reshape(len(values), -1)
            columns[name] = CubicSpline(samples.time, flat)(time).reshape(-1, *values.shape[1:])
    if samples.rotation is not None:
        q = lie.quaternion_xyzw(samples.rotation)
        # q and -q are one rotation; a spline wants the nearer one.
        jumps = np.sign(np.sum(q[1:] * q[:-1], axis=1))
        q[1:] *= np.cumprod(np.where(jumps == 0, 1.0, jumps))[:, None]
        columns["rotation"] = lie.rotation_from_xyzw(CubicSpline(samples.time, q)(time))
    return replace(samples, **columns)
