"""Descent: one iteration on the body's variables, and one on the levels of the noise.

    (H + lambda D^-2) d1 = -g        D the prior's standard deviations
    d2 = -1/2 (H + lambda D^-2)^-1 sum w J^T r_vv / s^2
    r_vv = 2/h [(r(x + h d1) - r(x)) / h - J d1]

d2 is the geodesic correction (Transtrum and Sethna 2012): flat valleys of kinematics are curved,
and a straight step leaves them. A step with 2 |d2 / D| > |d1 / D| is not to be trusted; as one that
raises the cost, it is tried again with more damping, max(10 lambda, 1). An accepted step divides
lambda by ten, and below 0.2 it is none. Damping in units of the prior leaves directions alone that
the data hold: relative to diag H it would stall flat ones, where H runs from 1 to 1e10.

Near the end (lambda = 0, last move below 0.2 posterior standard deviations) the curvature is that
of the robust cost itself, less than H by `bend`; the correction is left out.

The levels take their steps at the new x, see `noise`; more than one while these are long, as the
first levels may be off by any factor and a step on them costs next to nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.noise import newton_step
from bodyschema.estimation.normal_equations import positive_factor, solve_factored
from bodyschema.estimation.objective import Objective, Place

Array = NDArray[np.float64]

NEAR = 0.2
"""Posterior standard deviations: the last move of a fit that is near its end."""

PROBE = 0.1
"""h: share of a step at which its curvature is felt."""

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1.0, 0.2, 1e12
"""lambda after the first refusal; below the second it is none, at the last a fit stays in place."""

ROUNDING = (1e-12, 1e-9)
"""Relative and absolute rise of the cost that is rounding."""

LEVEL_STEPS, FULL_STEP = 4, 0.3
"""Most steps on the log levels in an iteration, and the length below which one was the last."""

STALE = 0.1
"""Change of log levels after which weights are too old for the curvature."""


@dataclass(frozen=True)
class State:
    """Where a descent is."""

    place: Place
    theta: Array
    """(K,) log levels."""
    shares: Array
    """(K, N, N) s_c^2 H_c."""
    damping: float = 0.0
    moved: float = np.inf
    """Largest last move of a variable, in posterior standard deviations."""
    shifted: float = np.inf
    """Largest last change of a log level."""


def begin(objective: Objective, x: Array, theta: Array) -> State:
    """The state before the first iteration."""
    place = objective.place(x)
    return State(place, theta, objective.shares(place, objective.weights(place.squares, theta)))


def resume(objective: Objective, x: Array, theta: Array) -> State:
    """The state at a place that a descent on nearly the same objective has reached."""
    return replace(begin(objective, x, theta), moved=NEAR / 2)


def iterate(objective: Objective, state: State, learn_levels: bool) -> State:
    """One step of the variables, then one of the levels."""
    x, damping = _step(objective, state)
    place = objective.place(x)
    weights = objective.weights(place.squares, state.theta)
    shares = objective.shares(place, weights)
    C = covariance(objective, shares, state.theta)
    away = np.abs(x - state.place.x) / np.sqrt(np.diag(C))
    moved = float(np.max(away, initial=0.0))
    after = State(place, state.theta, shares, damping, moved, 0.0)
    return _level(objective, after, C) if learn_levels else after


def covariance(objective: Objective, shares: Array, theta: Array) -> Array:
    """(N, N) posterior covariance C."""
    D = objective.variables.scale
    F = _information(objective, shares, theta)
    return solve_factored(positive_factor(F), np.eye(len(D))) * np.outer(D, D)


def absorbed(objective: Objective, state: State) -> Array:
    """(K,) gamma_c = tr C H_c: numbers of each component that the variables have absorbed."""
    C = covariance(objective, state.shares, state.theta)
    return np.asarray(np.einsum("kij,ij->k", state.shares, C) * np.exp(-2 * state.theta))


def slope(objective: Objective, state: State) -> Array:
    """(N,) gradient g of the cost."""
    place, weights = state.place, objective.weights(state.place.squares, state.theta)
    residuals = [part.residual for part in place.parts]
    data = objective.pull(place, residuals, weights, state.theta)
    return data + objective.precision * place.x


def _level(objective: Objective, state: State, C: Array) -> State:
    """Newton steps on the levels until they are near their place for this x."""
    theta, squares = state.theta, state.place.squares
    for _ in range(LEVEL_STEPS):
        scale = np.exp(-2 * theta)
        weights = objective.weights(squares, theta)
        sums = [w @ q for w, q in zip(weights, squares, strict=True)]
        coupled = objective.coupled(squares, weights, theta)
        told = state.shares * scale[:, None, None]
        step = newton_step(theta, objective.counts, np.concatenate(sums) * scale, coupled, told, C)
        before, theta = theta, np.maximum(theta + step, objective.noise.lowest)
        if np.max(np.abs(theta - before), initial=0.0) < FULL_STEP:
            break
        C = covariance(objective, state.shares, theta)
    shifted = float(np.max(np.abs(theta - state.theta), initial=0.0))
    shares = state.shares
    if shifted > STALE:
        shares = objective.shares(state.place, objective.weights(squares, theta))
    return replace(state, theta=theta, shares=shares, shifted=shifted)


def _step(objective: Objective, state: State) -> tuple[Array, float]:
    """The next x, (N,), and the damping after it."""
    place, theta, bound = state.place, state.theta, objective.variables.bound
    D, damping = objective.variables.scale, state.damping
    weights = objective.weights(place.squares, theta)
    g = slope(objective, state)
    F = _information(objective, state.shares, theta)
    near = damping == 0 and state.moved < NEAR
    if near:
        F = F - objective.bend(place, weights, theta) * np.outer(D, D)
    limit = objective.cost(place.x, place.squares, theta)
    limit += ROUNDING[0] * abs(limit) + ROUNDING[1]
    while damping < MOST_DAMPING:
        L = positive_factor(F + damping * np.eye(len(D)))
        straight = -D * solve_factored(L, D * g)
        step = straight if near else _bent(objective, state, weights, L, straight)
        if step is not None:
            x = np.clip(place.x + step, -bound, bound)
            if objective.cost(x, objective.squares(objective.residuals(x)), theta) <= limit:
                damping /= 10
                return x, damping if damping >= LEAST_DAMPING else 0.0
        damping = max(10 * damping, FIRST_DAMPING)
    return place.x, 0.0


def _bent(
    objective: Objective, state: State, weights: tuple[Array, ...], L: Array, straight: Array
) -> Array | None:
    """The step with its geodesic correction; None where that is too large to be trusted."""
    D, place = objective.variables.scale, state.place
    there = objective.residuals(place.x + PROBE * straight)
    curved = [
        2 / PROBE * ((r - part.residual) / PROBE - part.jacobian @ straight)
        for part, r in zip(place.parts, there, strict=True)
    ]
    pull = objective.pull(place, curved, weights, state.theta)
    more = -0.5 * D * solve_factored(L, D * pull)
    bent = 2 * np.linalg.norm(more / D) > np.linalg.norm(straight / D)
    return None if bent else straight + more


def _information(objective: Objective, shares: Array, theta: Array) -> Array:
    """H in units of the prior, (N, N)."""
    D = objective.variables.scale
    H = np.tensordot(np.exp(-2 * theta), shares, 1) + np.diag(objective.precision)
    return np.asarray(H * np.outer(D, D))
