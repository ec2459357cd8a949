"""What a pool believes between two samples, and what one sample did; see `pool`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.normal_equations import positive_factor
from bodyschema.learners.filter import Belief
from bodyschema.learners.skeletons.growth import Look
from bodyschema.learners.skeletons.hypotheses import Hypotheses
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.learners.skeletons.sight import Routes, Sightings
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.skeleton import Skeleton, zero_rotations
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]
Phase = Literal["searching", "locked", "known"]


@dataclass(frozen=True)
class PoolState:
    """What is believed, and what the search is at."""

    reference: Body
    """As it was given; its free axes and links mean nothing."""
    variables: Variables
    phase: Phase
    pool: Hypotheses | None = None
    """The hypotheses, once there are sightings enough."""
    best: int = 0
    looks: tuple[Look, ...] = ()
    """Who looks at whom, in order of appearance."""
    routes: Routes | None = None
    sightings: Sightings | None = None
    samples: tuple[Sense, ...] = ()
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
        n = len(self.variables)
        return Estimate(self.reference, self.variables, np.zeros(n), np.zeros((n, n)))

    def expected_error(self, sample: Sense) -> float:
        """m, root mean square of what a prediction of this sample errs by; inf while searching.

        The square root of tr J C J^T, with C the covariance of the belief.
        """
        if self.belief is None:
            return np.inf
        belief, D = self.belief, self.variables.scale
        J = sample.linearize(belief.reference, belief.variables, belief.anchor).by_parameter[0]
        L = positive_factor(D[:, None] * belief.information * D)
        half, _ = lapack.dtrtrs(L, (J * D).T, lower=1)
        return float(np.linalg.norm(half))


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


def look_of(sample: Sense) -> Look:
    """Who looks at whom in a sample."""
    return Look(sample.seen_from, sample.seen, isinstance(sample, Touches))


def sightings_of(body: Body, looks: tuple[Look, ...], samples: tuple[Sense, ...]) -> Sightings:
    """The samples as the search takes them."""
    R0 = zero_rotations(body)
    parts = [SkeletonSamples.of(sample, body, R0) for sample in samples]
    theta = np.concatenate([part.theta for part in parts])
    turning = body.kind == REVOLUTE
    return Sightings(
        np.where(turning, np.cos(theta), 1.0),
        np.where(turning, np.sin(theta), theta),
        np.array([looks.index(look_of(sample)) for sample in samples]),
        np.concatenate([part.v for part in parts]),
        np.concatenate([part.x for part in parts]),
    )
