"""Do held-out errors agree with what the estimate predicts of them?

Seen minus predicted is, for sample i and one component of a sense, the error of the body and the
noise of the sense together,

    r_i ~ (0, S_i),     S_i = J_i C J_i^T + s^2 I

J the derivative by the parameters, C their posterior covariance, s the noise level. The squared
length is taken as tr S_i times an F of (h_i, nu) degrees of freedom, h = (tr S)^2 / tr S^2 as in
`prediction`, nu being that of the Student-t noise. Where the model has the right form, the share of
the samples within their bound is the probability that the bound was made for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtr

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.normal_equations import level_rows
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]


def within_prediction(
    estimate: Estimate,
    sense: Sense,
    levels: Sequence[float],
    residual: Array,
    freedom: float,
    probability: float = 0.95,
) -> dict[str, NDArray[np.bool_]]:
    """Whether each residual is as small as predicted with this probability, by component, (n,).

    Args:
        estimate: the belief.
        sense: the samples.
        levels: noise level of each component, in units of the believed noise.
        residual: (n, dimension) seen minus predicted, best by fits that did not see the sample.
        freedom: nu of the noise; inf when it is Gaussian.
        probability: of the bound.
    """
    J = sense.linearize(estimate.reference, estimate.variables, estimate.x).by_parameter
    scale = np.sqrt(np.diag(sense.covariance)) * level_rows(sense, levels)
    inside = {}
    for name, _, part in sense.components:
        S = J[:, part] @ estimate.covariance @ np.swapaxes(J[:, part], 1, 2)
        S = S + np.diag(scale[part] ** 2)
        mean, square = np.trace(S, axis1=1, axis2=2), np.trace(S @ S, axis1=1, axis2=2)
        ratio = np.sum(residual[:, part] ** 2, axis=1) / np.maximum(mean, 1e-300)
        h = mean**2 / np.maximum(square, 1e-300)
        inside[name] = np.asarray(fdtr(h, min(freedom, 1e9), ratio) <= probability)
    return inside
