"""One pass: an online learner as a fit, so that all learners are judged by the same held-out test.

The learner is given each training sample once, in order of time, and never goes back. Frames that
nobody knows are placed from the first samples, as the recursive learner does it.

The smoother believes the noise that it is told, and the gradient keeps no covariance. Their noise
levels and information are taken at the body where they ended: what the data can say there, which is
true of the error only once the learner has arrived. Whether it has is tested, for all learners, see
`Solver.at`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.learners.filter import Filter, merge
from bodyschema.learners.learner import in_time_order, run
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.learners.smoother import Smoother
from bodyschema.model.deviation import deviation
from bodyschema.model.kernels import TURN
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Senses = Sequence[Sense]
Fitting = Callable[[Variables, Senses], Estimate]
LearnerName = Literal["batch", "gauss-newton", "smoother", "online-gradient", "pool"]

BURN_IN = 12
"""Samples that place unknown frames."""

GRADIENT_STEP = 0.5
"""mu of the normalised rule. A constant step that suits one robot makes the next one diverge, as
what is stable falls with the number of joints and the square of their levers."""


def fitting(problem: Problem, learner: LearnerName) -> Fitting:
    """How a learner fits a model of a problem to samples: in one pass, or "batch" all at once."""
    if learner == "gauss-newton":
        return lambda variables, senses: _gauss_newton(problem, variables, senses)
    if learner == "smoother":
        return lambda variables, senses: _smoother(problem, variables, senses)
    if learner == "online-gradient":
        return lambda variables, senses: _online_gradient(problem, variables, senses)
    if learner == "pool":
        return lambda variables, senses: _pool(problem, variables, senses)
    return problem.fit


def _gauss_newton(problem: Problem, variables: Variables, senses: Senses) -> Estimate:
    n = sum(len(sense) for sense in senses)
    learner = Filter(problem.unknown, min(BURN_IN, n), problem.learner.loss.freedom)
    steps = run(learner, learner.start(problem.body, variables), senses)
    [(state, _)] = deque(steps, maxlen=1)
    belief = state.estimate
    idle = {sense.label: ((1.0,) * len(sense.components), 0.0) for sense in senses}
    levels = tuple({**idle, **state.levels}[sense.label][0] for sense in senses)
    there = fit_at(problem, state.reference, belief.body, variables, senses)
    information, noise = belief.data_information, belief.noise
    return replace(there, x=belief.x, data_information=information, noise=noise, levels=levels)


def _smoother(problem: Problem, variables: Variables, senses: Senses) -> Estimate:
    begun = _begun(problem, senses)
    learner = Smoother()
    steps = run(learner, learner.start(begun.reference, variables), senses)
    [(state, _)] = deque(steps, maxlen=1)
    return fit_at(problem, begun.reference, state.estimate.body, variables, senses)


def _online_gradient(problem: Problem, variables: Variables, senses: Senses) -> Estimate:
    begun = _begun(problem, senses)
    learner = OnlineGradient(GRADIENT_STEP, "normalised")
    steps = run(learner, learner.start(begun.body, _vectors(variables)), senses)
    [(state, _)] = deque(steps, maxlen=1)
    return fit_at(problem, begun.reference, state.body, variables, senses)


def _pool(problem: Problem, variables: Variables, senses: Senses) -> Estimate:
    begun = _begun(problem, senses)
    body = pooled(begun.body, _vectors(variables), senses)
    return fit_at(problem, begun.reference, body, variables, senses)


def pooled(body: Body, variables: Variables, senses: Senses, seed: int = 0) -> Body:
    """The last body that the pool locked on, or else its best hypothesis.

    A pool that was surprised near the end of a recording searches anew and has nothing yet; what
    it believed before is still the best that is known.

    Args:
        body: the arrangement; what is not free in it counts as known.
        variables: free axes and links.
        senses: what was seen.
        seed: of the search.

    Raises:
        InputError: the samples are fewer than a skeleton needs.
    """
    learner = Pool(seed=seed)
    locked = hypothesis = None
    for state, _ in run(learner, learner.start(body, variables), senses):
        locked = state if state.belief is not None else locked
        hypothesis = state if state.pool is not None else hypothesis
    found = locked or hypothesis
    if found is None:
        n = sum(len(sense) for sense in senses)
        raise InputError(f"{n} samples are too few to find a skeleton; record more postures.")
    return found.body


def _vectors(variables: Variables) -> Variables:
    """What a skeleton is made of; rotations of fixed frames stay as begun."""
    return variables.take([i for i, code in enumerate(variables.code) if code != TURN])


def _begun(problem: Problem, senses: Senses) -> Estimate:
    """The robot as modelled, with the frames that nobody knows placed from the first samples."""
    first = merge(list(islice(in_time_order(senses), BURN_IN)))
    return problem.fit(problem.variables(()), first)


def fit_at(
    problem: Problem, reference: Body, body: Body, variables: Variables, senses: Senses
) -> Estimate:
    """What the samples say of a body that was found by other means; nothing is moved.

    Args:
        problem: its learner weighs the samples.
        reference: body at x = 0.
        body: what was found.
        variables: what is free between the two.
        senses: what was seen.
    """
    found = problem.learner.at(reference, variables, senses, deviation(reference, body, variables))
    return replace(found, iterations=sum(len(sense) for sense in senses))
