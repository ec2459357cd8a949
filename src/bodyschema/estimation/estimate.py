"""Estimate: what is believed of the body, how sure, and what the data did not say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.noise import Levels
from bodyschema.estimation.normal_equations import positive_factor, solve_factored
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A Gaussian belief over parameters charted round a reference body."""

    reference: Body
    variables: Variables
    x: Array
    """(n_parameters,) deviation from the reference."""
    data_information: Array
    """(n_parameters, n_parameters) sum of J^T R^-1 J over the samples, without the prior."""
    noise: Mapping[str, float] | None = None
    """Noise level of each sense's component, "hand seen from camera: position (m)" -> m or rad.

    The scale of a Student-t distribution of `freedom`. Where a sense states its noise, that.
    """
    levels: Levels = ()
    """Noise level of each component of each sense, in units of the believed noise."""
    weights: tuple[Array, ...] = ()
    """(n,) for each sense: near 1 and above for good samples, near 0 for outliers."""
    iterations: int = 0
    converged: bool = True
    """Whether the learner came to rest; an estimate that has not is no answer."""
    freedom: tuple[float, ...] = ()
    """nu of each sense's noise: inf or large for normal noise, small for heavy tails."""
    outliers: tuple[NDArray[np.bool_], ...] = ()
    """(n,) for each sense: samples that the gate of `loss` has taken out."""
    model_error: Mapping[str, float] | None = None
    """What exceeds the noise that a sense states, by component, as `noise`; 0 if nothing does."""

    @cached_property
    def body(self) -> Body:
        """The corrected body."""
        return self.reference.with_variables(self.variables, self.x)

    @cached_property
    def information(self) -> Array:
        """Posterior information: data and prior, (n_parameters, n_parameters)."""
        return self.data_information + np.diag(self.variables.prior_std**-2.0)

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance, (n_parameters, n_parameters), symmetric by construction."""
        # Scaling by the prior keeps the factor well conditioned across rad, m and ratios.
        D = np.outer(self.variables.scale, self.variables.scale)
        inverse = solve_factored(positive_factor(self.information * D), np.eye(len(D)))
        return np.asarray((inverse + inverse.T) / 2 * D)

    def widened(self, factor: float) -> Estimate:
        """The same belief, its data worth so much less that they leave `factor` times the error.

        Args:
            factor: 1 or more; what samples have in common, see `trust.weighing`.
        """
        return replace(self, data_information=self.data_information / factor**2)

    @property
    def std(self) -> Array:
        """Posterior standard deviations, (n_parameters,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))
