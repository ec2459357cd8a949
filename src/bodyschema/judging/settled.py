"""The smallest correction that a belief speaks for: what is to be changed on a robot.

A fit moves every variable a little: along directions that the data leave open, and by noise. To
write all of that would change joints of which nothing is known. So joints' deviations are put back
to zero one after the other, the cheapest first, and all others follow as the belief says,

    x <- x - C_:i x_i / C_ii,      C <- C - C_:i C_i: / C_ii,      at a cost of x_i^2 / C_ii

until every one that is left lies further from zero than its error. Of a direction that nothing seen
depends on one variable after the other goes back at the cost of its prior alone, and the frames
that moved along with it go back too: what is left is a minimal set. It predicts what the fit
predicts, to a share of what that states; otherwise the last ones put back stay as they were.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.identifiability import random_postures
from bodyschema.judging.calibration import Calibration
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import GROUPS

Array = NDArray[np.float64]

CLEAR = 2.0
"""Standard errors, as wide as the samples make them, from which a correction is told from none."""

SHIFTED = 0.5
"""Share of the stated 95 % error by which the robot that is written may differ from the fit."""

POSTURES = 50
"""Over the joints' limits, in which both are compared."""


@dataclass(frozen=True)
class Settled:
    """A belief with all that need not be changed put back."""

    x: Array
    """(n_parameters,) deviations; zero for what is as modelled."""
    std: Array
    """(n_parameters,) errors of the others, these being as modelled."""
    changed: NDArray[np.bool_]
    """(n_parameters,) what of the joints was changed; everything else of the estimate is True."""
    body: Body
    """The robot that is written."""


def settled(calibration: Calibration) -> Settled:
    """What of an answer is to be written; all of it for a skeleton, of which nothing was known."""
    estimate = calibration.estimate
    n = len(estimate.variables)
    joint = np.isin(estimate.variables.groups, GROUPS)
    if calibration.from_nothing or not joint.any():
        std = calibration.widened.std if n else np.zeros(0)
        return Settled(estimate.x, std, np.ones(n, dtype=bool), estimate.body)
    steps = _put_back(estimate.x, calibration.widened.covariance, np.flatnonzero(joint))
    kept = _close_enough(calibration, steps)
    x, variance, changed = steps[kept]
    std = np.sqrt(np.maximum(variance, 0.0))
    return Settled(x, std, changed, estimate.reference.with_variables(estimate.variables, x))


Step = tuple[Array, Array, NDArray[np.bool_]]


def _put_back(x: Array, covariance: Array, candidates: NDArray[np.int64]) -> list[Step]:
    """x, its variances and what is changed, after each variable that goes back."""
    x, C = x.copy(), covariance.copy()
    left, changed = list(candidates), np.ones(len(x), dtype=bool)
    steps = [(x.copy(), np.diag(C).copy(), changed.copy())]
    while left:
        costs = x[left] ** 2 / np.diag(C)[left]
        cheapest = int(np.argmin(costs))
        if costs[cheapest] > CLEAR**2:
            break
        i = left.pop(cheapest)
        column = C[:, i] / C[i, i]
        x, C = x - column * x[i], C - np.outer(column, C[i])
        x[i], changed[i] = 0.0, False
        steps.append((x.copy(), np.diag(C).copy(), changed.copy()))
    return steps


def _close_enough(calibration: Calibration, steps: Sequence[Step]) -> int:
    """The last step whose robot still predicts what the fit does."""
    estimate, rng = calibration.estimate, np.random.default_rng(0)
    q = random_postures(estimate.body, POSTURES, rng)
    ends = [(e.seen_from, e.seen, e.position_overall) for e in calibration.predicted_anywhere]
    as_fitted = [relative_pose(estimate.body, q, a, b)[:, :3, 3] for a, b, _ in ends]

    def close(step: int) -> bool:
        body = estimate.reference.with_variables(estimate.variables, steps[step][0])
        for (a, b, stated), fitted in zip(ends, as_fitted, strict=True):
            off = np.linalg.norm(relative_pose(body, q, a, b)[:, :3, 3] - fitted, axis=1)
            if np.quantile(off, 0.95) > SHIFTED * stated:
                return False
        return True

    return next((k for k in reversed(range(len(steps))) if close(k)), 0)
