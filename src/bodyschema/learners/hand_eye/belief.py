"""What is known of hand and eye at a moment of a stream, and how it is fitted to the sums.

    F(theta) = sum_k x_k^T (C_k - N_k) x_k / tau + (theta - theta_0)^T Lambda (theta - theta_0)
    P = (J^T C J / tau + Lambda)^-1,  tau = (1 + r1) / (1 - r1)

r1 is the lag-1 correlation of the residuals: correlated noise says less than its number of samples.
Lambda is the prior that a change leaves behind. Symbols as in `stereo_points` and `point_memory`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import Normal, descend
from bodyschema.learners.hand_eye.chart import CameraAndPoints, normal_equations
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.rotation_search import search
from bodyschema.learners.hand_eye.stereo_points import StereoPoints

Array = NDArray[np.float64]

FEWEST = 12
"""Points seen before the first fit."""

APART = 0.1
"""rad: a rival answer is at least so far away."""

OWN_CORRELATION = 300
"""Points before a belief with a prior measures r1 itself; until then the prior's counts."""


@dataclass(frozen=True)
class Prior:
    """What remains true from before."""

    theta: CameraAndPoints
    information: Array
    """(6 + 3 K, same) Lambda; zero for what changed."""
    level: float = 1.0
    """Mean squared white residual of the points behind it, 1 or more."""


@dataclass(frozen=True)
class HandEyeBelief:
    """State of the learner."""

    memory: PointMemory
    waiting: tuple[StereoPoints, ...] = ()
    """The first moments; empty once they are in the memory."""
    flushed: bool = False
    theta: CameraAndPoints | None = None
    """None before the first fit."""
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """(6 + 3 K, same) P."""
    prior: Prior | None = None
    correlation: float = 0.0
    """r1."""
    seen: float = 0.0
    """Points behind theta."""
    cost: float = np.inf
    """Sum of squared white residuals, each point's at most the gate."""
    gap: float = 0.0
    """To the next best answer far away; inf with a prior."""
    searched: float = 0.0
    """`seen` at the last search."""
    rejected: float = 0.0
    """Points outside the gate so far."""
    recent: float = 0.0
    """Running share of points outside the gate, over about 30 moments."""


class PointCost:
    """The cost on a memory; a `relation_fit.Problem`."""

    def __init__(self, memory: PointMemory, tau: float, prior: Prior | None) -> None:
        self.memory, self.tau, self.prior = memory, tau, prior

    def normal(self, theta: CameraAndPoints) -> Normal:
        size = 6 + 3 * len(theta.points)
        g, H = np.zeros(size), np.zeros((size, size))
        M, u, points = theta.M, theta.u, theta.points
        cost = float(normal_equations(M, u, points, self.memory.C, self.memory.N, g, H))
        cost, g, H = cost / self.tau, g / self.tau, H / self.tau
        if self.prior is not None:
            away = theta.away_from(self.prior.theta)
            pull = self.prior.information @ away
            cost, g, H = cost + float(away @ pull), g + pull, H + self.prior.information
        return Normal(cost, g, H)

    def move(self, theta: CameraAndPoints, delta: Array) -> CameraAndPoints:
        return theta.move(delta)


def theta_of(state: HandEyeBelief) -> CameraAndPoints:
    """The unknowns, once there is a first fit."""
    if state.theta is None:
        raise ValueError("the belief has no first fit yet; step it until `theta` is there.")
    return state.theta


def correlation_time(correlation: float) -> float:
    """tau: how many samples are worth one independent one."""
    return (1 + correlation) / (1 - correlation)


def search_all(state: HandEyeBelief, memory: PointMemory) -> HandEyeBelief:
    """The best of all minima over rotations, with the gap to the best of those far away."""
    problem = PointCost(memory, correlation_time(state.correlation), None)
    starts = search(memory.D)
    if state.theta is not None:
        starts.append(state.theta)
    found = [descend(problem, start)[:2] for start in starts]
    theta, best = min(found, key=lambda pair: pair[1].cost)
    others = [
        normal.cost - best.cost
        for other, normal in found
        if float(np.sum(other.M * theta.M)) < 1 + 2 * np.cos(APART)
    ]
    count = max(memory.count, 1.0)
    return replace(state, theta=theta, gap=min(others, default=np.inf), searched=count)


def settle(
    state: HandEyeBelief, memory: PointMemory, theta: CameraAndPoints, extra_cost: float = 0.0
) -> HandEyeBelief:
    """Fit the sums from theta, with covariance and correlation.

    Args:
        state: whose prior and correlation hold.
        memory: the sums.
        theta: where to start.
        extra_cost: of points that were left out.
    """
    tau = correlation_time(state.correlation)
    theta, normal, _ = descend(PointCost(memory, tau, state.prior), theta)
    fewest = FEWEST if state.prior is None else OWN_CORRELATION
    own = memory.correlation(theta) if memory.count >= fewest else state.correlation
    return replace(
        state,
        theta=theta,
        covariance=_inverse(normal.H),
        correlation=own,
        seen=memory.count,
        cost=memory.cost(theta) + extra_cost,
    )


def _inverse(H: Array) -> Array:
    """Covariance from information, balanced; infinite spread where nothing is known."""
    D = 1 / np.sqrt(np.maximum(np.diag(H), 1e-12))
    values, vectors = np.linalg.eigh(D[:, None] * H * D)
    half = D[:, None] * vectors / np.sqrt(np.maximum(values, 1e-14))
    return np.asarray(half @ half.T)
