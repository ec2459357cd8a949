"""Whole runs of the pool on a body that watches its own markers.

The pool learns sample by sample, as a user's recording would feed it. The run has converged when
the body that it believes in is right, within the threshold, about all markers in fresh postures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.online_gradient import from_nothing, typical_link
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.studies.self_watching import FRESH, SelfWatching

Array = NDArray[np.float64]

SIZE = 16
"""Hypotheses: a tree has more ways to go wrong than a chain."""


@dataclass(frozen=True)
class PooledRun:
    """How one run went."""

    samples: int | None
    """Postures until convergence; None if the limit came first."""
    curve: Array
    """(samples, n_markers) m: mean error in the fresh postures after each sample."""
    body: Body
    """What was learned."""


def pool_tree_run(
    watching: SelfWatching, threshold: float, limit: int, rng: np.random.Generator
) -> PooledRun:
    """Learn a whole body from nothing.

    Args:
        watching: the robot and what it sees of itself.
        threshold: share of each path's length.
        limit: postures after which to give up.
        rng: randomness.
    """
    fresh = watching.postures(FRESH, rng)
    q = watching.postures(limit, rng)
    pool = Pool(size=SIZE, seed=int(rng.integers(2**31)))
    variables = free_skeleton(watching.body)
    length = typical_link(Skeleton.of(watching.body))
    state = pool.start(from_nothing(watching.body, variables, length, rng), variables)
    curve = []
    for i in range(limit):
        for sense in watching.at(q, i):
            state, _ = pool.step(state, (sense,))
        curve.append(watching.errors(state.body, fresh).mean(axis=0))
        if watching.worst(state.body, fresh) <= threshold:
            return PooledRun(i + 1, np.array(curve), state.body)
    return PooledRun(None, np.array(curve), state.body)
