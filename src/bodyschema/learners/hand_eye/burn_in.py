"""The first moments of a stream, kept and fitted anew until outliers and weights are settled.

With q the squared white residual of a point (three rows) and s^2 = max(1, median q / 2.366), points
with q < gate s^2 are kept (2.366 is the median of chi-square with three degrees of freedom, so a
poor first fit opens the gate and a good one closes it). Weights use the predicted depth: the
measured one shares its noise with the residual. Choice and fit alternate until nothing changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import descend
from bodyschema.learners.hand_eye.belief import (
    FEWEST,
    HandEyeBelief,
    PointCost,
    correlation_time,
    search_all,
    settle,
    theta_of,
)
from bodyschema.learners.hand_eye.chart import CameraAndPoints, predict
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MEDIAN = 2.366

CREDIBLE = 0.3
"""Relative difference to the measured depth up to which the predicted one is taken."""

ROUNDS = 8

SEARCH_AGAIN = 1.2
"""Growth of the number of points after which all rotations are searched again."""


class BurnIn:
    """The waiting moments of a belief as arrays."""

    def __init__(self, state: HandEyeBelief, stereo: Stereo, gate: float) -> None:
        self.stereo, self.gate = stereo, gate
        self.T = np.array([sample.T_world_hand for sample in state.waiting])
        self.pixels = np.array([sample.pixels for sample in state.waiting])
        self.measured = stereo.depth(self.pixels)
        self.seen = np.isfinite(self.pixels).all(axis=2) & np.isfinite(self.measured)

    def fit(self, state: HandEyeBelief) -> tuple[HandEyeBelief, PointMemory | None]:
        """The belief after a fit of all waiting moments, and their sums; None if too few."""
        count = float(np.sum(self.seen))
        if count < FEWEST:
            return state, None
        state = self._first_guess(state, count)
        theta, tau = theta_of(state), correlation_time(state.correlation)
        keep, depth = self._choose(theta)
        for _ in range(ROUNDS):
            memory = self._remember(keep, depth)
            theta, _, _ = descend(PointCost(memory, tau, state.prior), theta)
            before, (keep, depth) = keep, self._choose(theta)
            if (keep == before).all():
                break
        lost = count - float(np.sum(keep))
        state = replace(state, rejected=lost, recent=lost / count)
        memory = self._remember(keep, depth)
        return settle(state, memory, theta, self.gate * lost), memory

    def _first_guess(self, state: HandEyeBelief, count: float) -> HandEyeBelief:
        """With a belief to start from: the old one, or the best of a new search."""
        if state.prior is not None or count < SEARCH_AGAIN * state.searched:
            return state
        keep, depth = self.seen & _near(self.stereo.triangulate(self.pixels)), self.measured
        if state.theta is not None:
            keep, depth = self._choose(state.theta)
        return replace(search_all(state, self._remember(keep, depth)), searched=count)

    def _remember(self, keep: Flags, depth: Array) -> PointMemory:
        empty = PointMemory.empty(self.pixels.shape[1])
        return empty.add(self.T, self.pixels, depth, keep, self.stereo.numbers)

    def _choose(self, theta: CameraAndPoints) -> tuple[Flags, Array]:
        """Points within the gate, and depths for the weights."""
        e, _, predicted = predict(theta, self.T, self.pixels, self.stereo.numbers)
        q = np.sum(e * e, axis=2)
        scale = max(1.0, float(np.median(q[self.seen])) / MEDIAN)
        with np.errstate(invalid="ignore"):
            keep = self.seen & (q < self.gate * scale)
            credible = np.abs(predicted / self.measured - 1) < CREDIBLE
        return keep, np.where(credible, predicted, self.measured)


def _near(c: Array) -> Flags:
    """Points (n, K) within reach of the others; a wild stereo match may lie far behind the room."""
    # A point that no moment shows has no median; as a fixed one it is near nothing.
    c = np.where(np.isfinite(c).any(axis=0), c, 0.0)
    centre = np.nanmedian(c, axis=0)
    away = np.linalg.norm(c - centre, axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(away < 4 * np.nanmedian(away, axis=0))
