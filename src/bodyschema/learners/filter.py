"""Recursive Gauss-Newton: one sample at a time, in constant time and memory, with covariance.

The belief is (x, Lambda), mean and information in the fixed chart of `variables`. A sample with
residual r, Jacobian J (of the residual) and noise level s, whitened, changes it by

    predicted variance   S = s^2 1 + J C J^T,            C = Lambda^-1 (factored once a sample)
    robust gate          w = (nu + d) / (nu + r^T S^-1 r)
    mean                 x <- x - C J^T (s^2/w 1 + J C J^T)^-1 r
    information          Lambda <- lambda Lambda + (1 - lambda) P + f w J^T J / s^2

r is that of the present x, J is taken at the first fit for ever: Jacobians at changing x would have
no common null space, and seem to tell what no motion can tell (Huang, Mourikis, Roumeliotis 2008,
"Analysis and improvement of the consistency of extended Kalman filter based SLAM").

f = (nu + d) / (nu + d + 2) is the Student-t distribution's share of information, see
`loss.fisher_share`. With forgetting lambda < 1 the prior P takes the place of what is
forgotten, so directions that the data do not touch keep their prior variance instead of winding up.
Noise levels follow a running mean of w (|r+|^2 + tr J C+ J^T) / d, the expectation-maximisation
update in recursive form. Unknown frames and the first levels come from a batch fit on a short
burn-in; until then the samples wait in the state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.loss import Loss, fisher_share
from bodyschema.estimation.noise import SMALLEST_LEVEL, named_levels
from bodyschema.estimation.normal_equations import level_rows, positive_factor, whiten
from bodyschema.estimation.solver import Solver
from bodyschema.learners.learner import Moment, in_turn
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.sense import Sense, concatenate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Belief:
    """State of the recursive learner."""

    reference: Body
    variables: Variables
    x: Array
    """(n_parameters,)."""
    anchor: Array
    """(n_parameters,) where Jacobians are taken: the result of the first fit."""
    information: Array
    """(n_parameters, n_parameters) posterior information, the prior included."""
    levels: Mapping[str, tuple[tuple[float, ...], float]]
    """Sense label -> noise levels in believed noise, and the number of samples behind them."""
    waiting: tuple[Sense, ...] = ()
    """Samples of the burn-in; empty once the filter runs."""
    started: bool = False
    templates: Mapping[str, Sense] = field(default_factory=dict)
    """Sense label -> that sense without samples, for the units of its noise levels."""

    @property
    def estimate(self) -> Estimate:
        """The belief in the form of every learner's result."""
        data = self.information - np.diag(self.variables.prior_std**-2.0)
        levels = tuple(self.levels[label][0] for label in self.templates)
        noise = named_levels(tuple(self.templates.values()), levels)
        return Estimate(self.reference, self.variables, self.x, data, noise)


@dataclass(frozen=True)
class Innovation:
    """What one sample was worth."""

    residual: Array
    """(dimension,) seen minus predicted, before learning from it; SI units, not whitened."""
    surprise: float
    """Squared innovation over its predicted variance; about `dimension` when all is well."""
    weight: float
    """Robust weight: about 1 for a good sample, near 0 for an outlier."""


@dataclass(frozen=True)
class Filter:
    """Recursive learner with robust gate, forgetting and running noise levels."""

    unknown: tuple[str, ...] = ()
    """Frames that have no first value; the burn-in's samples place them."""
    burn_in: int = 12
    """Samples that the first fit waits for."""
    freedom: float = 4.0
    """nu of the Student-t gate; inf to trust every sample."""
    forgetting: float = 1.0
    """lambda, per sample; 1 never forgets, 0.99 remembers about 100 samples."""
    least_count: float = 20.0
    """Samples that the first noise levels count for, so that early levels do not jump."""

    def start(self, body: Body, variables: Variables) -> Belief:
        """The prior belief, before the first sample."""
        prior = np.diag(variables.prior_std**-2.0)
        zero = np.zeros(len(variables))
        return Belief(body, variables, zero, zero, prior, {})

    def step(self, state: Belief, moment: Moment) -> tuple[Belief, tuple[Innovation, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: Belief, sample: Sense) -> tuple[Belief, Innovation]:
        """Learn from one sample (a batch of one)."""
        if state.started:
            return self._update(state, sample)
        waiting = (*state.waiting, sample)
        residual = sample.residual(state.reference)[0]
        idle = Innovation(residual, float("nan"), 0.0)
        if len(waiting) < self.burn_in:
            return replace(state, waiting=waiting), idle
        return self._first_fit(state, waiting), idle

    def _first_fit(self, state: Belief, waiting: tuple[Sense, ...]) -> Belief:
        senses = merge(waiting)
        reference = start_frames(state.reference, self.unknown, senses)
        fit = Solver(Loss(self.freedom, adapt=False)).fit(reference, state.variables, senses)
        levels = {
            sense.label: (level, max(float(len(sense)), self.least_count))
            for sense, level in zip(senses, fit.levels, strict=True)
        }
        information, x = fit.information, fit.x
        templates = {sense.label: sense.take([]) for sense in senses}
        return Belief(reference, state.variables, x, x, information, levels, (), True, templates)

    def _update(self, state: Belief, sample: Sense) -> tuple[Belief, Innovation]:
        part = whiten(sample, state.reference, state.variables, state.anchor)
        body = state.reference.with_variables(state.variables, state.x)
        residual = sample.residual(body)[0]
        level, count = state.levels.get(sample.label, ((1.0,) * len(sample.components), 1.0))
        s = level_rows(sample, level)
        white, _ = lapack.dtrtrs(part.factor, residual, lower=1)
        r, J = white / s, part.jacobian[0] / s[:, None]
        L, half = _half_gain(state, J)
        absorbed, one = half.T @ half, np.eye(len(r))
        surprise = float(r @ np.linalg.solve(one + absorbed, r))
        weight = self._weight(surprise, len(r))
        solved = np.linalg.solve(one / weight + absorbed, np.column_stack([r, absorbed]))
        # The residual and the variance of the prediction that remain after the step.
        left = solved[:, 0] / weight
        spread = np.diag(absorbed) - np.sum(absorbed * solved[:, 1:].T, axis=1)
        after = self._levels(sample, level, count, weight * (left**2 + spread))
        told = weight * fisher_share(self.freedom, len(r))
        templates = state.templates
        if sample.label not in templates:
            templates = {**templates, sample.label: sample.take([])}
        changed = replace(
            state,
            templates=templates,
            x=_moved(state, L, half @ solved[:, 0]),
            information=self._remembered(state) + told * (J.T @ J),
            levels={**state.levels, sample.label: after},
        )
        return changed, Innovation(residual, surprise, weight)

    def _weight(self, surprise: float, d: int) -> float:
        return 1.0 if np.isinf(self.freedom) else (self.freedom + d) / (self.freedom + surprise)

    def _remembered(self, state: Belief) -> Array:
        """lambda Lambda + (1 - lambda) P."""
        if self.forgetting == 1:
            return state.information
        prior = np.diag(state.variables.prior_std**-2.0)
        return self.forgetting * state.information + (1 - self.forgetting) * prior

    def _levels(
        self, sample: Sense, level: tuple[float, ...], count: float, ratio: Array
    ) -> tuple[tuple[float, ...], float]:
        """Running noise levels; `ratio` is each row's squared size in units of the old level."""
        found = []
        for (_, _, rows), old in zip(sample.components, level, strict=True):
            share = 1 + (float(np.mean(ratio[rows])) - 1) / (count + 1)
            found.append(max(old * np.sqrt(share), SMALLEST_LEVEL))
        longest = 1 / (1 - self.forgetting) if self.forgetting < 1 else np.inf
        return tuple(found), min(count + 1, longest)


def _half_gain(state: Belief, J: Array) -> tuple[Array, Array]:
    """Cholesky factor L of the information, scaled by the prior, and L^-1 J^T.

    The scale keeps radians, metres and ratios in one range, so that the factor stays accurate.
    """
    D = state.variables.scale
    L = positive_factor(D[:, None] * state.information * D)
    half, _ = lapack.dtrtrs(L, (J * D).T, lower=1)
    return L, half


def _moved(state: Belief, L: Array, pull: Array) -> Array:
    """x - C J^T S^-1 r, inside the bounds."""
    step, _ = lapack.dtrtrs(L, pull, lower=1, trans=1)
    bound = state.variables.bound
    return np.asarray(np.clip(state.x - state.variables.scale * step, -bound, bound))


def merge(samples: Sequence[Sense]) -> list[Sense]:
    """Single samples gathered into one batch a sense, in order of first appearance."""
    by_label: dict[str, list[Sense]] = {}
    for sample in samples:
        by_label.setdefault(sample.label, []).append(sample)
    return [concatenate(group) for group in by_label.values()]
