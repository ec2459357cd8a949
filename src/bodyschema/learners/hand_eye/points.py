"""Hand and eye from tracked points, one moment after the other: the learner for streams.

Unknown are the camera's pose in the world and each tracked point in the hand, 6 + 3 K numbers. What
is kept is of fixed size (`point_memory`), what is minimised is exact on it (`hand_eye.belief`). The
first moments wait in a buffer (`hand_eye.burn_in`), then they move into the sums, and later moments
join when they lie within the gate. The search over all rotations, now and then, guards against a
wrong answer that fits.

After a change of one block t, the others k keep what was known of them,
Lambda_kk = H_kk - H_kt H_tt^-1 H_tk and zero elsewhere (Schur), as prior of a fresh start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Certificate, Demand, certify
from bodyschema.learners.hand_eye.belief import (
    HandEyeBelief,
    Prior,
    correlation_time,
    search_all,
    settle,
    theta_of,
)
from bodyschema.learners.hand_eye.burn_in import SEARCH_AGAIN, BurnIn
from bodyschema.learners.hand_eye.chart import predict
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.stereo_points import Stereo, StereoPoints
from bodyschema.learners.watchable import Doubt, WhiteInnovation

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

UNITS = {"rotation": (180 / np.pi, "deg"), "camera": (1e3, "mm"), "tip": (1e3, "mm")}


@dataclass(frozen=True)
class HandEyePoints:
    """Learner of camera pose and tracked points; also a camera on a head, see `head_eye`."""

    stereo: Stereo
    points: int = 1
    """K."""
    demand: Demand = field(
        default_factory=lambda: Demand({"rotation": 0.0035, "camera": 0.005, "tip": 0.002})
    )
    """rad, m, m: 0.2 degrees, 5 mm, 2 mm."""
    buffer: int = 150
    """Moments that are kept before the sums take over; four times as many while a rival answer
    fits nearly as well."""
    gate: float = 25.0
    """Squared white residual (three rows) beyond which a point is an outlier."""
    every: int = 3
    """Moments between two fits; more when there are so many that a fit changes little."""
    forgetting: float = 1.0
    """Share of the sums that stays, per moment; below 1 the belief follows slow drift."""

    @property
    def blocks(self) -> Mapping[str, Ints]:
        """What may change, and its entries of theta: the camera, and the held tool."""
        return {
            "camera": np.arange(6, dtype=np.int64),
            "tool": np.arange(6, 6 + 3 * self.points, dtype=np.int64),
        }

    def start(self) -> HandEyeBelief:
        """Nothing known."""
        return HandEyeBelief(PointMemory.empty(self.points))

    def step(self, state: HandEyeBelief, sample: StereoPoints) -> HandEyeBelief:
        """Learn from one moment."""
        if state.flushed:
            return self._absorb(state, sample)
        state = replace(state, waiting=(*state.waiting, sample))
        if len(state.waiting) % self.every:
            return state
        return self._fit_waiting(state)

    def innovation(self, state: HandEyeBelief, sample: StereoPoints) -> WhiteInnovation:
        """A moment against what the belief predicts; without rows if nothing was seen."""
        e, J, _ = predict(
            theta_of(state), sample.T_world_hand[None], sample.pixels[None], self.stereo.numbers
        )
        tracks = np.flatnonzero(np.isfinite(e[0]).all(axis=1))
        wide = np.zeros((len(tracks), 3, 6 + 3 * self.points))
        wide[:, :, :6] = J[0, tracks, :, :6]
        for row, k in enumerate(tracks):
            wide[row, :, 6 + 3 * k : 9 + 3 * k] = J[0, k, :, 6:]
        flat = wide.reshape(-1, wide.shape[2])
        return WhiteInnovation(e[0, tracks].ravel(), flat, np.repeat(tracks, 3))

    def doubt(self, state: HandEyeBelief) -> Doubt:
        """Covariance, correlation, level and share of outliers."""
        level = max(state.cost / max(3 * state.seen, 1.0), 1.0)
        wild = (state.rejected + 2) / (state.seen + state.rejected + 100)
        return Doubt(state.covariance, state.correlation, level, max(wild, 1e-3))

    def forget(self, state: HandEyeBelief, block: str) -> HandEyeBelief:
        """Start anew with all but one block as prior; "" keeps everything as prior."""
        theta, information = theta_of(state), np.linalg.inv(state.covariance)
        kept = information
        if block:
            t = self.blocks[block]
            part = information[:, t] @ np.linalg.solve(information[np.ix_(t, t)], information[t])
            kept = information - part
            kept[t], kept[:, t] = 0.0, 0.0
        prior = Prior(theta, (kept + kept.T) / 2)
        fresh = self.start()
        return replace(
            fresh, theta=theta, prior=prior, correlation=state.correlation, gap=np.inf,
            covariance=state.covariance,
        )  # fmt: skip

    def evidence(self, state: HandEyeBelief) -> tuple[float, float]:
        """What the belief costs, the prior's pull included, and the residuals behind it."""
        tau, pull = correlation_time(state.correlation), 0.0
        if state.prior is not None and state.theta is not None:
            away = state.theta.away_from(state.prior.theta)
            pull = float(away @ state.prior.information @ away)
        return state.cost / tau + pull, 3 * state.seen / tau

    def difference(self, state: HandEyeBelief, earlier: HandEyeBelief) -> Array:
        """(6 + 3 K,) the step of theta from an earlier belief to this one."""
        if state.theta is earlier.theta:
            return np.zeros(6 + 3 * self.points)
        return theta_of(state).away_from(theta_of(earlier))

    def astray(self, state: HandEyeBelief) -> bool:
        """Whether most of the last moments lie outside the gate, or residuals are far too large."""
        if state.theta is None:
            return False
        freedom = max(3 * state.seen - 6 - 3 * self.points, 1.0)
        excess = state.cost / freedom - 1 - self.demand.misfit
        spread = np.sqrt(2 * _long_run(state.correlation) / freedom)
        return state.recent > 0.5 or bool(excess > 8 * spread)

    def certificate(self, state: HandEyeBelief) -> Certificate:
        """Whether the belief meets the demand."""
        if state.theta is None or not len(state.covariance):
            return Certificate(False, {}, np.inf, ("too few moments for a first fit.",))
        P = state.theta.in_world(state.covariance)
        parts = {"rotation": P[:3, :3], "camera": P[3:6, 3:6]}
        tips = [P[i : i + 3, i : i + 3] for i in range(6, len(P), 3)]
        parts["tip"] = max(tips, key=lambda part: float(np.linalg.eigvalsh(part)[-1]))
        unknowns = 0 if state.prior is not None else 6 + 3 * self.points
        freedom = max(3 * state.seen - unknowns, 1.0)
        independent = freedom / _long_run(state.correlation)
        held = certify(self.demand, parts, state.cost / freedom, independent, state.gap, UNITS)
        if state.recent < 0.3:
            return held
        wild = "most of the last moments do not fit."
        return replace(held, holds=False, missing=(*held.missing, wild))

    def _absorb(self, state: HandEyeBelief, sample: StereoPoints) -> HandEyeBelief:
        """One moment into the sums, if it lies within the gate."""
        theta, pixels = theta_of(state), sample.pixels[None]
        T = np.ascontiguousarray(sample.T_world_hand)[None]
        e, _, depth = predict(theta, T, pixels, self.stereo.numbers)
        q = np.sum(e * e, axis=2)
        seen = np.isfinite(q)
        keep = seen & (q < self.gate)
        lost = float(np.sum(seen & ~keep))
        share = lost / max(float(np.sum(seen)), 1.0)
        memory = state.memory if self.forgetting == 1 else state.memory.fade(self.forgetting)
        after = replace(
            state,
            memory=memory.add(T, pixels, depth, keep, self.stereo.numbers),
            rejected=state.rejected + lost,
            recent=state.recent + (share - state.recent) / 30,
        )
        wait = min(max(self.every * self.points, 0.01 * state.seen), 30 * self.points)
        if after.memory.count - state.seen < wait:
            return after
        if state.prior is None and after.memory.count > SEARCH_AGAIN * state.searched:
            after = search_all(after, after.memory)
        return settle(after, after.memory, theta_of(after))

    def _fit_waiting(self, state: HandEyeBelief) -> HandEyeBelief:
        """Fit the buffer; when it is full and the answer has no rival, empty it into the sums."""
        fitted, memory = BurnIn(state, self.stereo, self.gate).fit(state)
        # A wrong answer must not become the gate's measure; doubt earns four times the patience.
        doubtful = fitted.gap < self.demand.gap and len(state.waiting) < 4 * self.buffer
        if memory is None or len(state.waiting) < self.buffer or doubtful:
            return fitted
        return replace(fitted, memory=memory, waiting=(), flushed=True)


def _long_run(correlation: float) -> float:
    """By how much correlation inflates the variance of a mean of squares."""
    return (1 + correlation**2) / (1 - correlation**2)
