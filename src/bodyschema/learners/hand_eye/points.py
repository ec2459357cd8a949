"""Hand and eye from tracked points, one moment after the other: the learner for streams.

Unknown are the camera's pose in the world and each tracked point in the hand, 6 + 3 K numbers. What
is kept is of fixed size (`point_memory`), what is minimised is exact on it (`hand_eye.belief`). The
first moments wait in a buffer (`hand_eye.burn_in`), then they move into the sums, and later moments
join when they lie within the gate. The search over all rotations, now and then, guards against a
wrong answer that fits.

After a change of one block the others keep what was known of them, as prior of a fresh start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import GaussianBelief, Slopes, WhiteInnovation, forget, inverse
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.stream_noise import StreamNoise
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
from bodyschema.learners.learner import MonitoredLearner, in_turn

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class PointInfo:
    """What became of the points of a moment."""

    seen: int
    kept: int
    """Not outliers; 0 while the moment waits for a fit."""


@dataclass(frozen=True)
class HandEyePoints(MonitoredLearner[HandEyeBelief, StereoPoints, tuple[PointInfo, ...]]):
    """Learner of camera pose and tracked points; also a camera on a head, see `head_eye`."""

    stereo: Stereo
    points: int = 1
    """K."""
    tolerance: Tolerance = field(
        default_factory=lambda: Tolerance({"rotation": 0.0035, "camera": 0.005, "tip": 0.002})
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

    def step(
        self, state: HandEyeBelief, moment: tuple[StereoPoints, ...]
    ) -> tuple[HandEyeBelief, tuple[PointInfo, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def innovation(self, state: HandEyeBelief, moment: tuple[StereoPoints, ...]) -> WhiteInnovation:
        """A moment against what the belief predicts; without rows if nothing was seen."""
        parts = [self._innovation(state, sample) for sample in moment]
        return WhiteInnovation(
            np.concatenate([part.e for part in parts]),
            np.concatenate([part.J for part in parts]),
            np.concatenate([part.source + i * self.points for i, part in enumerate(parts)]),
        )

    def _innovation(self, state: HandEyeBelief, sample: StereoPoints) -> WhiteInnovation:
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

    def belief(self, state: HandEyeBelief) -> GaussianBelief:
        """Of theta; the noise is the one that the cameras declare."""
        tau = correlation_time(state.correlation)
        pull, unknowns = 0.0, 6 + 3 * self.points
        if state.prior is not None and state.theta is not None:
            away, unknowns = state.theta.away_from(state.prior.theta), 0
            pull = float(away @ state.prior.information @ away)
        level = state.cost / (3 * state.seen) if state.seen else 1.0
        used = level if state.prior is None else state.prior.level
        freedom = max(3 * state.seen - unknowns, 1.0)
        return GaussianBelief(
            state.covariance,
            self.tolerance,
            StreamNoise(
                level,
                state.correlation,
                state.seen + state.rejected,
                state.rejected + 2,
                state.recent,
            ),
            tau,
            (state.cost / tau + pull) / max(used, 1.0),
            3 * state.seen / tau,
            state.cost / freedom,
            freedom / _long_run(state.correlation),
            state.gap,
            state.seen > 0 and len(state.covariance) > 0,
        )

    def forget(self, state: HandEyeBelief, block: str) -> HandEyeBelief:
        """Start anew with all but one block as prior; "" keeps everything as prior."""
        known = inverse(state.covariance)
        known = forget(known, self.blocks[block]) if block else known
        prior = Prior(theta_of(state), known, self.belief(state).level)
        return replace(
            self.start(), theta=prior.theta, prior=prior, correlation=state.correlation,
            gap=np.inf, covariance=state.covariance,
        )  # fmt: skip

    def difference(self, state: HandEyeBelief, earlier: HandEyeBelief) -> Array:
        """(6 + 3 K,) the step of theta from an earlier belief to this one."""
        if state.theta is earlier.theta:
            return np.zeros(6 + 3 * self.points)
        return theta_of(state).away_from(theta_of(earlier))

    def certificate(self, state: HandEyeBelief) -> Certificate:
        """Whether camera and points are known well enough."""
        belief = self.belief(state)
        if not belief.begun:
            return belief.certificate({})
        G = theta_of(state).world_slope()
        tips = G[6:].reshape(self.points, 3, -1)
        known = {"rotation": Slopes(G[None, :3], "rad"), "camera": Slopes(G[None, 3:6], "m")}
        return belief.certificate(known | {"tip": Slopes(tips, "m")})

    def _learn(self, state: HandEyeBelief, sample: StereoPoints) -> tuple[HandEyeBelief, PointInfo]:
        if state.flushed:
            return self._absorb(state, sample)
        state = replace(state, waiting=(*state.waiting, sample))
        idle = PointInfo(int(np.isfinite(sample.pixels).all(axis=1).sum()), 0)
        if len(state.waiting) % self.every:
            return state, idle
        return self._fit_waiting(state), idle

    def _absorb(
        self, state: HandEyeBelief, sample: StereoPoints
    ) -> tuple[HandEyeBelief, PointInfo]:
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
        info = PointInfo(int(np.sum(seen)), int(np.sum(keep)))
        if after.memory.count - state.seen < wait:
            return after, info
        if state.prior is None and after.memory.count > SEARCH_AGAIN * state.searched:
            after = search_all(after, after.memory)
        return settle(after, after.memory, theta_of(after)), info

    def _fit_waiting(self, state: HandEyeBelief) -> HandEyeBelief:
        """Fit the buffer; when it is full and the answer has no rival, empty it into the sums."""
        fitted, memory = BurnIn(state, self.stereo, self.gate).fit(state)
        # A wrong answer must not become the gate's measure; doubt earns four times the patience.
        doubtful = fitted.gap < self.tolerance.gap and len(state.waiting) < 4 * self.buffer
        if memory is None or len(state.waiting) < self.buffer or doubtful:
            return fitted
        return replace(fitted, memory=memory, waiting=(), flushed=True)


def _long_run(correlation: float) -> float:
    """By how much correlation inflates the variance of a mean of squares."""
    return (1 + correlation**2) / (1 - correlation**2)
