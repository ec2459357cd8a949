"""How far off the corrected body still is: predicted errors, before anyone measures them.

The posterior covariance C of the parameters makes the pose of frame b in frame a uncertain by

    Sigma(q) = J(q) C J(q)^T          (6, 6): position and rotation, in frame a at b

The squared length of a Gaussian error with covariance S has mean tr S and variance 2 tr S^2; it is
taken as g times a chi-square of h degrees of freedom (Satterthwaite 1946),

    g = tr S^2 / tr S,      h = (tr S)^2 / tr S^2,

and, since the noise level that scales C was itself learned from few numbers, as g h times an F of
(h, nu) degrees of freedom, nu = numbers seen - directions determined. Over several postures the
error is a mixture; its quantile is found by bisection.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.special import fdtr, fdtri, gammainc, gammaincinv

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import SAYS_LITTLE
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PredictedError:
    """Predicted errors of one frame seen from another, over some postures."""

    seen_from: str
    seen: str
    position: Array
    """(n,) m: the position error stays below this with the stated probability, by posture."""
    rotation: Array
    """(n,) rad."""
    position_overall: float
    """m: the same over all the postures together."""
    rotation_overall: float
    """rad."""

    def widened(self, factor: float) -> PredictedError:
        """The same so many times as large: what noise and few samples alone do not account for."""
        grown = ("position", "rotation", "position_overall", "rotation_overall")
        return replace(self, **{name: factor * getattr(self, name) for name in grown})


def predict_error(
    estimate: Estimate,
    q: ArrayLike,
    seen_from: str,
    seen: str,
    freedom: float = np.inf,
    probability: float = 0.95,
) -> PredictedError:
    """Predicted error of the corrected pose of `seen` in `seen_from` at postures q.

    Args:
        estimate: the belief.
        q: (n, n_joints) postures: those seen, or those that will be worked in.
        seen_from: frame a.
        seen: frame b.
        freedom: nu, degrees of freedom of the noise level; inf when it is known.
        probability: of staying below.
    """
    D = relative_pose_derivatives(
        estimate.reference, estimate.variables, estimate.x, q, seen_from, seen
    )
    J = D.by_parameter
    covariance = J @ estimate.covariance @ np.swapaxes(J, 1, 2)
    parts = [covariance[:, :3, :3], covariance[:, 3:, 3:]]
    bounds = [length_quantiles(part, freedom, probability) for part in parts]
    overall = [length_quantile(list(part), freedom, probability) for part in parts]
    return PredictedError(seen_from, seen, bounds[0], bounds[1], overall[0], overall[1])


def degrees_of_freedom(fit: Estimate, senses: Sequence[Sense]) -> float:
    """Numbers behind the noise levels of a fit: those seen less the directions determined."""
    numbers = sum(len(sense) * len(sense.covariance) for sense in senses)
    scale = fit.variables.scale
    told = np.linalg.eigvalsh(scale[:, None] * fit.data_information * scale)
    return float(max(numbers - int(np.sum(told >= SAYS_LITTLE)), 1))


def length_quantiles(covariances: Array, freedom: float, probability: float) -> Array:
    """Length that a Gaussian vector stays below, for each of these covariances, (n,).

    Args:
        covariances: (n, d, d).
        freedom: degrees of freedom of their common scale; inf when it is known.
        probability: of staying below.
    """
    mean, h = _matched(covariances)
    known = np.isinf(freedom)
    ratio = 2 * gammaincinv(h / 2, probability) / h if known else fdtri(h, freedom, probability)
    return np.asarray(np.sqrt(np.maximum(mean, 0.0) * ratio))


def length_quantile(covariances: Sequence[Array], freedom: float, probability: float) -> float:
    """Length that a Gaussian vector, with one of these covariances at random, stays below.

    Args:
        covariances: (d, d) each.
        freedom: degrees of freedom of their common scale; inf when it is known.
        probability: of staying below.
    """
    mean, h = _matched(np.asarray(covariances))
    if mean.max(initial=0.0) <= 0:
        return 0.0
    mean = np.maximum(mean, 1e-300)

    def below(log_length: float) -> float:
        ratio = np.exp(2 * log_length) / mean
        # An F with infinitely many degrees of freedom below is a chi-square over h.
        known = np.isinf(freedom)
        share = gammainc(h / 2, h * ratio / 2) if known else fdtr(h, freedom, ratio)
        return float(np.mean(share)) - probability

    centre = 0.5 * np.log(mean.max())
    return float(np.exp(brentq(below, centre - 15, centre + 15)))


def _matched(covariances: Array) -> tuple[Array, Array]:
    """Mean of the squared length, and h of the chi-square that has its mean and variance, (n,)."""
    mean = np.trace(covariances, axis1=1, axis2=2)
    square = np.trace(covariances @ covariances, axis1=1, axis2=2)
    return mean, np.maximum(mean**2 / np.maximum(square, 1e-300), 1.0)
