"""A small arm that was calibrated from a few postures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.solver import Solver
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.senses.sense import concatenate
from simulated import drawn, free_all, points, postures, seen_arm

Array = NDArray[np.float64]


@dataclass(frozen=True)
class World:
    """What is believed, what was seen, and what is true."""

    estimate: Estimate
    sense: Points
    truth: Body
    rng: np.random.Generator

    def error_after(self, q: Array) -> float:
        """True rms tool error (m) when the postures q are seen as well."""
        sense = concatenate([self.sense, points(self.truth, q, self.rng)])
        old = self.estimate
        fit = Solver().fit(old.reference, old.variables, [sense])
        test = postures(200, self.truth, np.random.default_rng(99))
        found, true = (
            relative_pose(body, test, "tracker", "tool")[:, :3, 3]
            for body in (fit.body, self.truth)
        )
        return float(np.sqrt(np.mean(np.sum((found - true) ** 2, axis=1))))


@pytest.fixture(scope="session")
def calibrated() -> Callable[..., World]:
    """Simulate and calibrate: (seed, joint that never moved or None, postures) -> World."""

    def make(seed: int = 0, still: int | None = None, n: int = 10) -> World:
        rng = np.random.default_rng(seed)
        body = seen_arm(5, rng)
        variables = free_all(body, turns=False)
        truth = body.with_variables(variables, drawn(variables, rng, 0.5))
        q = postures(n, body, rng)
        if still is not None:
            q[:, still] = 0.3
        sense = points(truth, q, rng)
        fit = Solver().fit(body, variables, [sense])
        return World(fit, sense, truth, rng)

    return make
