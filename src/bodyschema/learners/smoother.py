"""Fixed-lag smoother: the newest samples are weighed again at each step, the older ones are kept.

The belief is a prior that has absorbed all samples older than a window of W, and the window itself:

    cost      C(x) = 1/2 x^T Lambda x - eta^T x + sum_window rho(|r_i(x)|)
    Huber     rho(u) = u^2 / 2 for u < k,   k u - k^2 / 2 beyond;   weight w, see `huber`
    step      H = Lambda + sum w J^T J,   d = -H^-1 (Lambda x - eta + sum w J^T r)

with r and J whitened by the believed noise, in the fixed chart of `variables`. At each sample the
window is solved again by a few Gauss-Newton steps from the estimate before, so that a bad first
sample loses its weight as soon as others contradict it; a filter that weighs each sample once keeps
what the first one told. The sample that leaves the window is absorbed as it looks from there,

    Lambda <- Lambda + w J^T J,    eta <- eta + w J^T (J x - r),

unless |r|^2 is beyond what normal noise does once in a thousand: a gross outlier teaches nothing.
From the first sample that leaves, J is taken at an anchor, the estimate at that time: Jacobians at
changing x have no common null space, and would seem to tell what no motion can tell (Huang,
Mourikis, Roumeliotis 2008, see `filter`).

`forgetting` makes a group of variables uncertain again while all others keep what they know
(`belief.forget`): a tool that was exchanged is learned anew, the arm is not.
Source: the tool experiment of Hersch, Sauser and Billard 2008, section 5.3, whose gradient has no
prior and reaches the tool by changing the arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from bodyschema.estimation.belief import forget
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.huber import gross, huber_weights
from bodyschema.estimation.normal_equations import (
    Whitened,
    information,
    positive_factor,
    solve_factored,
    whiten,
)
from bodyschema.learners.learner import Moment, in_turn
from bodyschema.learners.window import Window
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SETTLED = 0.3
"""Length of the last Gauss-Newton step in posterior standard deviations."""

MOST_STEPS = 10


@dataclass(frozen=True)
class Smoothed:
    """State of the smoother."""

    reference: Body
    variables: Variables
    x: Array
    """(n_parameters,)."""
    information: Array
    """(n_parameters, n_parameters) Lambda: the prior and the samples that have left the window."""
    pull: Array
    """(n_parameters,) eta."""
    total: Array
    """(n_parameters, n_parameters) posterior information, the window included."""
    anchor: Array
    """(n_parameters,) where Jacobians are taken; nan where that is x itself."""
    window: Window = field(default_factory=Window)
    """The newest samples, not absorbed."""

    @property
    def estimate(self) -> Estimate:
        """The belief in the form of every learner's result."""
        data = self.total - np.diag(self.variables.prior_std**-2.0)
        return Estimate(self.reference, self.variables, self.x, data)

    @property
    def slope_at(self) -> Array:
        """(n_parameters,) where Jacobians are taken."""
        return np.where(np.isnan(self.anchor), self.x, self.anchor)

    @property
    def body(self) -> Body:
        """The body as believed now."""
        return self.reference.with_variables(self.variables, self.x)


@dataclass(frozen=True)
class Foresight:
    """What was predicted of one sample, and how the sample compares."""

    residual: Array
    """(dimension,) seen minus predicted, before learning from it; SI units, not whitened."""
    innovation: Array
    """(dimension,) the residual whitened by its predicted covariance, noise and belief together."""

    @property
    def surprise(self) -> float:
        """Squared innovation; about `dimension` when all is well."""
        return float(self.innovation @ self.innovation)


@dataclass(frozen=True)
class Smoother:
    """Learner with a window that is solved again at each sample."""

    lag: int = 32
    """W: samples in the window."""

    def start(self, body: Body, variables: Variables) -> Smoothed:
        """The prior belief, before the first sample."""
        prior = np.diag(variables.prior_std**-2.0)
        zero = np.zeros(len(variables))
        return Smoothed(body, variables, zero, prior, zero, prior, np.full(len(zero), np.nan))

    def step(self, state: Smoothed, moment: Moment) -> tuple[Smoothed, tuple[Foresight, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: Smoothed, sample: Sense) -> tuple[Smoothed, Foresight]:
        """Learn from one sample (a batch of one)."""
        seen = foresee(state, sample)
        after, look = _solved(replace(state, window=state.window.with_sample(sample)))
        if len(after.window) <= self.lag:
            return after, seen
        oldest = _oldest(look, after.window.order[0])
        left = _absorbed(replace(after, anchor=look.slope_at), oldest)
        return replace(left, total=after.total, window=after.window.without_oldest()), seen

    def absorbing(self, state: Smoothed) -> Smoothed:
        """The belief with its window absorbed: nothing in it will be weighed again."""
        after = _absorbed(state, _look(state))
        return replace(after, total=after.information, window=Window())

    def forgetting(self, state: Smoothed, rows: Ints, spread: float, tau: float = 1.0) -> Smoothed:
        """The belief with some variables made uncertain again, their mean kept.

        Args:
            state: its window is absorbed first.
            rows: of the variables; their anchor is lifted too.
            spread: standard deviation of the change that each may have made.
            tau: variance by which all that was learned counts less.
        """
        settled = self.absorbing(state)
        left = settled.information / tau
        if len(rows):
            left = forget(left, rows, spread**-2)
        anchor = settled.anchor.copy()
        anchor[rows] = np.nan
        return replace(settled, information=left, pull=left @ settled.x, total=left, anchor=anchor)


def foresee(state: Smoothed, sample: Sense) -> Foresight:
    """What a belief predicts of a sample (a batch of one), before learning from it.

    The covariance of the prediction, in units of the believed noise, is 1 + J C J^T.
    """
    part = compared(state, sample)
    r, J = part.residual[0], part.jacobian[0]
    D = state.variables.scale
    half, _ = lapack.dtrtrs(positive_factor(D[:, None] * state.total * D), (J * D).T, lower=1)
    L = np.linalg.cholesky(np.eye(len(r)) + half.T @ half)
    white, _ = lapack.dtrtrs(L, r, lower=1)
    return Foresight(part.factor @ r, white)


@dataclass(frozen=True)
class _Look:
    """The window as it looks from one estimate."""

    x: Array
    slope_at: Array
    parts: list[Whitened]
    weights: list[Array]


def _look(state: Smoothed) -> _Look:
    parts = [compared(state, batch) for batch in state.window.batches]
    return _Look(state.x, state.slope_at, parts, [huber_weights(part.residual) for part in parts])


def compared(state: Smoothed, batch: Sense) -> Whitened:
    """Residuals at x and Jacobians at the anchor, in units of the believed noise."""
    part = whiten(batch, state.reference, state.variables, state.slope_at)
    if np.isnan(state.anchor).all():
        return part
    white, _ = lapack.dtrtrs(part.factor, batch.residual(state.body).T, lower=1)
    return replace(part, residual=np.ascontiguousarray(white.T))


def _solved(state: Smoothed) -> tuple[Smoothed, _Look]:
    """The cost minimised, and the window as it looked before the last, short step."""
    D, bound = state.variables.scale, state.variables.bound
    for _ in range(MOST_STEPS):
        look = _look(state)
        H, g = _normal(look, look.weights)
        H, g = state.information + H, state.information @ state.x - state.pull + g
        d = -D * solve_factored(positive_factor(D[:, None] * H * D), D * g)
        state = replace(state, x=np.clip(state.x + d, -bound, bound), total=H)
        if -float(g @ d) < SETTLED**2:
            break
    return state, look


def _oldest(look: _Look, label: str) -> _Look:
    """The first sample of one sense alone."""
    place = [part.sense.label for part in look.parts].index(label)
    part, weight = look.parts[place], look.weights[place]
    first = Whitened(part.sense.take([0]), part.residual[:1], part.jacobian[:1], part.factor)
    return _Look(look.x, look.slope_at, [first], [weight[:1]])


def _absorbed(state: Smoothed, look: _Look) -> Smoothed:
    """Lambda and eta with the samples of a look, unless they are gross."""
    weights = [
        weight * (np.sum(part.residual**2, axis=1) < gross(part.residual.shape[1]))
        for part, weight in zip(look.parts, look.weights, strict=True)
    ]
    H, g = _normal(look, weights)
    return replace(state, information=state.information + H, pull=state.pull + H @ look.x - g)


def _normal(look: _Look, weights: Sequence[Array]) -> tuple[Array, Array]:
    """sum w J^T J and sum w J^T r: (n, n) and (n,)."""
    n = len(look.x)
    if not look.parts:
        return np.zeros((n, n)), np.zeros(n)
    levels = [(1.0,) * len(part.sense.components) for part in look.parts]
    return information(look.parts, levels, weights)
