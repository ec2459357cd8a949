"""What a pool believes between two samples, and what one sample did; see `pool`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.parameters import Parameters
from bodyschema.body.skeleton import Skeleton
from bodyschema.body.tree import Body
from bodyschema.learning.estimate import Estimate
from bodyschema.learning.gauss_newton import Belief
from bodyschema.learning.growth import Look
from bodyschema.learning.hypotheses import Hypotheses
from bodyschema.learning.skeleton_fit import Routes, Sightings
from bodyschema.senses.observations import Observations

Array = NDArray[np.float64]
Phase = Literal["searching", "locked", "known"]


@dataclass(frozen=True)
class PoolState:
    """What is believed, and what the search is at."""

    reference: Body
    """As it was given; its free axes and links mean nothing."""
    parameters: Parameters
    phase: Phase
    pool: Hypotheses | None = None
    """The hypotheses, once there are sightings enough."""
    best: int = 0
    looks: tuple[Look, ...] = ()
    """Who looks at whom, in order of appearance."""
    routes: Routes | None = None
    sightings: Sightings | None = None
    samples: tuple[Observations, ...] = ()
    """The same sightings as they came; none once the skeleton is known."""
    unit: float = 0.0
    """Size of what was seen, m."""
    streak: int = 0
    """Sightings in a row that were predicted exactly."""
    lock: int = 0
    """Sightings at the lock."""
    belief: Belief | None = None
    """Of the recursive learner, from the lock on."""
    surprise: float = 1.0
    """Running mean of the capped surprise over its expectation."""
    learned: int = 0
    """Sightings behind the belief."""

    @property
    def body(self) -> Body:
        """The best body so far; the one that was given until there is a hypothesis."""
        if self.belief is not None:
            return self.belief.estimate.body
        return self.reference if self.pool is None else self.hypothesis(self.pool)

    def hypothesis(self, pool: Hypotheses) -> Body:
        """The body of the best hypothesis."""
        old = Skeleton.of(self.reference)
        return replace(old, axes=pool.axes[self.best], links=pool.links[self.best]).into(
            self.reference
        )

    @property
    def estimate(self) -> Estimate:
        """The belief in the form of every learner's result; the prior until the lock."""
        if self.belief is not None:
            return self.belief.estimate
        n = len(self.parameters)
        return Estimate(self.reference, self.parameters, np.zeros(n), np.zeros((n, n)))

    @property
    def expected_error(self) -> float:
        """m, root mean square of what a prediction errs by; inf while searching.

        Noise level times sqrt(rank / sightings), which is the mean over the postures seen.
        """
        if self.belief is None or self.routes is None:
            return np.inf
        noise = self.belief.estimate.noise or {}
        return float(
            max(noise.values(), default=0.0) * np.sqrt(self.routes.rank[-1] / self.learned)
        )


@dataclass(frozen=True)
class PoolInfo:
    """What one sample did."""

    phase: Phase
    residual: Array
    """(3,) m, seen minus predicted before learning from it; nan while nothing predicts."""
    expected_error: float
    """m, see `PoolState.expected_error`."""
    surprise: float
    """Running mean, see the module; about 1 when all is well."""
