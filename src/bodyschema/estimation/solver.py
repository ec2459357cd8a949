"""Solver: the variables that explain all samples at once, robustly, with noise levels.

    minimise over x and theta    sum_i u_i c(Q_i) + 1/2 x^T P x + what the levels add

by the iterations of `descent`, until neither moves. Then, each from where the last has come to
rest:

    associate   senses that choose correspondences choose them anew, until that moves nothing
    repeats     samples of one posture are counted for what they are worth
    gate        outliers are taken out; each sense gets the nu that its good samples ask for

The covariance that is reported is the inverse of the Fisher information, `loss.fisher_share` of
J_i^T J_i w_i / s^2, and the prior.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri

from bodyschema.errors import InputError
from bodyschema.estimation.descent import State, begin, covariance, iterate, resume, slope
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.gate import judge, masked
from bodyschema.estimation.loss import Loss, Mask, fisher_share
from bodyschema.estimation.moments import SAME_POSTURE
from bodyschema.estimation.noise import model_error, named_levels
from bodyschema.estimation.normal_equations import information
from bodyschema.estimation.objective import Objective
from bodyschema.estimation.repeats import worth
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]

ASSOCIATIONS, PATIENT = 20, 10
"""Most times that correspondences are chosen anew, and those in which they may still settle."""

NOT_ARRIVED = 0.05
"""Chance that a learner as far off as its error bars say is told that it has not arrived."""

ROUGHLY = 0.01
"""Tolerance of a descent whose end is only looked at before the next one."""

NEARLY, CIRCLE = 0.01, 1.0
"""Posterior standard deviations: correspondences that move the fit by less are the last ones. Some
go round in a circle in the end, which within the second is as good as rest."""


@dataclass(frozen=True)
class Solver:
    """Robust maximum a posteriori of any number of senses in one list."""

    loss: Loss = Loss()  # noqa: RUF009  (frozen settings)
    """What a residual costs, and what an outlier is."""
    max_iterations: int = 200
    """Of each descent; ten are usual."""
    tolerance: float = 1e-4
    """Settled when no variable moves by more than this share of its posterior standard deviation,
    and no log level by more."""
    learn_levels: bool = True
    """Estimate noise levels; otherwise the senses' own covariances are taken as they are."""
    same_posture: float = SAME_POSTURE
    """rad or m: readings that are nearer to each other belong to one posture."""

    @one_thread
    def fit(
        self,
        reference: Body,
        variables: Variables,
        senses: Sequence[Sense],
        start: ArrayLike | None = None,
        levels: Sequence[Sequence[float]] | None = None,
    ) -> Estimate:
        """Fit the variables to the samples.

        Args:
            reference: body at x = 0, with every frame of the senses attached and started.
            variables: what may be wrong, with priors.
            senses: what was seen.
            start: (N,) where to begin; at the reference when None.
            levels: of a fit to much the same samples, by sense and component, to begin with.

        Raises:
            InputError: no samples at all.
        """
        if not sum(len(sense) for sense in senses):
            raise InputError("there is not a single sample to learn from.")
        objective = self._objective(reference, variables, senses)
        x = np.zeros(len(variables)) if start is None else np.array(start, dtype=np.float64)
        theta = self._first_levels(objective, x, levels)
        roughly = max(self.tolerance, ROUGHLY)
        run = self._associated(_Run(objective, begin(objective, x, theta)), roughly)
        shares = worth(run.objective, run.state, self.same_posture)
        if any((u < 1).any() for u in shares):
            counted = replace(run.objective, worth=shares)
            run = self._descend(run.over(counted, run.state.theta), roughly)
        judged = judge(run.objective, run.state, self.loss, self.learn_levels)
        if self.loss.adapt and np.isfinite(self.loss.freedom):
            kept = masked(run.objective.worth, judged.good)
            good_only = replace(run.objective, worth=kept, freedom=judged.freedom)
            run = run.over(good_only, judged.theta)
        return _estimate(self._descend(run, self.tolerance), judged.good)

    def at(
        self, reference: Body, variables: Variables, senses: Sequence[Sense], x: Array
    ) -> Estimate:
        """What the samples say of a body that was found by other means; nothing is moved.

        It counts as converged when the Gauss-Newton step d that is left, g its gradient, is no
        longer than the error bars: d^T C^-1 d = g^T C g below the 95 % quantile of chi-square.

        Args:
            reference: body at x = 0.
            variables: what is free between the two.
            senses: what was seen.
            x: (N,) the body.
        """
        objective = self._objective(reference, variables, senses)
        run = _Run(objective, begin(objective, x, self._first_levels(objective, x, None)))
        judged = judge(objective, run.state, self.loss, self.learn_levels)
        if self.loss.adapt and np.isfinite(self.loss.freedom):
            kept = masked(objective.worth, judged.good)
            good_only = replace(objective, worth=kept, freedom=judged.freedom)
            run = replace(run, objective=good_only, state=replace(run.state, theta=judged.theta))
        found = _estimate(run, judged.good)
        g = slope(run.objective, run.state)
        arrived = g @ found.covariance @ g <= chdtri(max(len(x), 1), NOT_ARRIVED)
        return replace(found, converged=bool(arrived))

    def _objective(
        self, reference: Body, variables: Variables, senses: Sequence[Sense]
    ) -> Objective:
        worth = tuple(np.ones(len(sense)) for sense in senses)
        freedom = (self.loss.freedom,) * len(senses)
        return Objective(reference, variables, tuple(senses), worth, freedom)

    def _first_levels(
        self, objective: Objective, x: Array, levels: Sequence[Sequence[float]] | None
    ) -> Array:
        """Log levels to begin with, (K,)."""
        noise = objective.noise
        if not self.learn_levels:
            return np.zeros(len(noise.lowest))
        if levels is not None:
            return noise.theta(levels)
        return noise.first(objective.reference.with_variables(objective.variables, x))

    def _associated(self, run: _Run, tolerance: float) -> _Run:
        """Descend until nothing moves, with correspondences that no longer change.

        They are kept from then on: what samples are worth and which are outliers is theirs.
        """
        run = self._descend(run, tolerance)
        for turn in range(ASSOCIATIONS):
            x, old = run.state.place.x, run.objective
            body = old.reference.with_variables(old.variables, x)
            again = tuple(sense.associate(body) for sense in old.senses)
            if all(new is sense for new, sense in zip(again, old.senses, strict=True)):
                return run
            objective = self._objective(old.reference, old.variables, again)
            run = self._descend(run.over(objective, run.state.theta), tolerance)
            C = covariance(objective, run.state.shares, run.state.theta)
            moved = float(np.max(np.abs(run.state.place.x - x) / np.sqrt(np.diag(C)), initial=0.0))
            if moved <= (NEARLY if turn < PATIENT else CIRCLE):
                return run
        return replace(run, arrived=False)

    def _descend(self, run: _Run, tolerance: float) -> _Run:
        state = run.state
        for i in range(1, self.max_iterations + 1):
            state = iterate(run.objective, state, self.learn_levels)
            if max(state.moved, state.shifted) < tolerance:
                return replace(run, state=state, iterations=run.iterations + i, settled=True)
        n = run.iterations + self.max_iterations
        return replace(run, state=state, iterations=n, settled=False)


@dataclass(frozen=True)
class _Run:
    """How far a fit has come."""

    objective: Objective
    state: State
    iterations: int = 0
    settled: bool = False
    arrived: bool = True
    """Whether correspondences no longer change."""

    def over(self, objective: Objective, theta: Array) -> _Run:
        """The same place under another objective."""
        return replace(
            self, objective=objective, state=resume(objective, self.state.place.x, theta)
        )


def _estimate(run: _Run, good: Sequence[Mask]) -> Estimate:
    """The belief at the end of a fit."""
    objective, place = run.objective, run.state.place
    levels = objective.noise.levels(run.state.theta)
    weights = objective.weights(place.squares, run.state.theta)
    told = [
        fisher_share(nu, len(sense.covariance)) * w
        for sense, nu, w in zip(objective.senses, objective.freedom, weights, strict=True)
    ]
    return Estimate(
        reference=objective.reference,
        variables=objective.variables,
        x=place.x,
        data_information=information(place.parts, levels, told)[0],
        noise=named_levels(objective.senses, levels),
        levels=levels,
        weights=weights,
        iterations=run.iterations,
        converged=run.settled and run.arrived,
        freedom=objective.freedom,
        outliers=tuple(~mask for mask in good),
        model_error=model_error(objective.senses, levels),
    )
