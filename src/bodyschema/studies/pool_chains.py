"""Whole runs of the pool on random chains: the search of `learners.skeletons.pool` and no other.

The chain's end point is fixed, unknown, and learned as its last link. At every sample the best
hypothesis predicts first; then the sample is learned from, unless prediction and fit were exact.

Without noise a run has converged at the sample after which `STREAK` predictions in a row lie within
the threshold, a share of the chain's length (all links summed).

With noise (normal, on each coordinate) and outliers (uniform in a cube of the chain's length either
way, added to the point) the pool locks at twice the least number of samples or, until two
hypotheses agree, up to twice that. It fits again, against challengers, at 2, 4 and 8 times that.
The run has converged when its root mean square error on fresh postures is then below three times
the Cramer-Rao bound of the samples that are no outliers

    bound^2 = s^2 mean over fresh postures of tr J (sum_i J_i^T J_i)^+ J^T.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.skeletons.fit import accumulate, solve_damped, square_errors, told_variance
from bodyschema.learners.skeletons.growth import Look, plan
from bodyschema.learners.skeletons.hypotheses import (
    Hypotheses,
    Rule,
    agreed,
    challenge,
    new_pool,
    search,
    spawn,
)
from bodyschema.learners.skeletons.pool import AGAIN, PREDICTED, Pool
from bodyschema.learners.skeletons.sight import Routes, Sightings, foresee, work_for
from bodyschema.model.kernels import kernel
from bodyschema.model.variables import free_skeleton
from bodyschema.studies.random_chains import (
    Generator,
    chain_body,
    draw_chain,
    length_of,
    run_generator,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STREAK = 500
"""Successive predictions that must stay below the threshold."""

FRESH = 200
"""Postures at which a noisy run is tested."""

THRESHOLDS = (0.01, 0.001)
"""Shares of the chain's length."""

LIMIT = 5000
"""Samples after which a run has failed."""


@dataclass(frozen=True)
class PoolProtocol:
    """Settings of a run."""

    learner: Pool = Pool()  # noqa: RUF009  (frozen settings)
    reach: float = np.pi / 2
    """rad: joints are uniform within +-reach."""
    noise: float = 0.0
    """Standard deviation of each coordinate, as a share of the chain's length."""
    outliers: float = 0.0
    """Share of the samples."""


@lru_cache
def chain_routes(n_joints: int) -> Routes:
    """Base looks at the tip of a chain, all of which is unknown."""
    body = chain_body(np.tile([0.0, 0.0, 1.0], (n_joints + 2, 1)), np.zeros((n_joints + 2, 3)))
    return plan(body, free_skeleton(body), [Look("base", "tip")])


def pool_run(protocol: PoolProtocol, n_joints: int, seed: int, run: int) -> tuple[int, int]:
    """Samples learned from before all predictions hold, for both thresholds; -1 for never."""
    routes, least = _least(n_joints)
    found = exact_run(
        run_generator(seed, n_joints, run), routes, least, protocol.learner.window * least,
        _pool(protocol, n_joints, run), protocol.learner.rule, protocol.reach,
    )  # fmt: skip
    return int(found[0]), int(found[1])


def noisy_pool_run(protocol: PoolProtocol, n_joints: int, seed: int, run: int) -> Array:
    """(4, 2) error over its bound, and over the chain's length: at the lock, at 2, 4, 8 times."""
    routes, least = _least(n_joints)
    learner, pool, rng = (
        protocol.learner,
        _pool(protocol, n_joints, run),
        run_generator(seed, n_joints, run),
    )
    lock = learner.enough * least
    axes, links = np.empty((n_joints + 2, 3)), np.empty((n_joints + 2, 3))
    draw_chain(rng, axes, links)
    fresh = _shown(rng, routes, axes, links, protocol.reach, FRESH)
    seen = _shown(rng, routes, axes, links, protocol.reach, AGAIN[-1] * learner.window * least)
    good = _spoil(rng, seen, protocol, length_of(links))
    unit, best = size_of(seen.seen[:least]), 0
    for h in range(learner.size):
        spawn(routes, pool, h, unit, learner.rule)
    for M in range(least, learner.window * least + 1):
        best = search(routes, seen, np.arange(M), pool, unit, learner.rule)
        if lock <= M and agreed(pool, 0):
            lock = M
            break
    found = []
    for times in (1, *AGAIN):
        part = Sightings._make(array[: times * lock] for array in seen)
        if times > 1:
            best = challenge(
                routes, part, 2 * lock, pool, best, unit, learner.rule, learner.challengers,
                learner.rounds,
            )  # fmt: skip
        error = error_of(routes, fresh, pool.axes[best], pool.links[best])
        inliers = np.flatnonzero(good[: times * lock])
        spread = spread_of(routes, seen, inliers, axes, links, fresh)
        size = length_of(links)
        found.append((error / (protocol.noise * size * spread), error / size))
    return np.array(found)


def _shown(
    rng: np.random.Generator, routes: Routes, axes: Array, links: Array, reach: float, count: int
) -> Sightings:
    """Sightings of the true chain, without noise."""
    sightings: Sightings = blank(count, len(axes))
    levers = np.empty((len(axes), 3))
    for i in range(count):
        show(rng, routes, axes, links, reach, levers, sightings, i)
    return sightings


def _spoil(
    rng: np.random.Generator, seen: Sightings, protocol: PoolProtocol, length: float
) -> NDArray[np.bool_]:
    """Adds noise and outliers; returns (n,) which are none of the latter."""
    n = len(seen.seen)
    good = rng.random(n) >= protocol.outliers
    step = np.where(
        good[:, None], protocol.noise * rng.normal(size=(n, 3)), rng.uniform(-1, 1, (n, 3))
    )
    seen.seen[:] += length * step
    return np.asarray(good)


def _least(n_joints: int) -> tuple[Routes, int]:
    routes = chain_routes(n_joints)
    return routes, -(-int(routes.rank[-1]) // 3)


def _pool(protocol: PoolProtocol, n_joints: int, run: int) -> Hypotheses:
    axes = np.tile([0.0, 0.0, 1.0], (n_joints + 2, 1))
    return new_pool(protocol.learner.size, axes, np.zeros_like(axes), run)


@kernel
def blank(count: int, nodes: int) -> Sightings:
    """Sightings of the origin of the tip, yet to be made."""
    return Sightings(
        np.ones((count, nodes)), np.zeros((count, nodes)), np.zeros(count, np.int64),
        np.zeros((count, 3)), np.zeros((count, 3)),
    )  # fmt: skip


@kernel
def show(
    rng: Generator, routes: Routes, axes: Array, links: Array, reach: float, levers: Array,
    sightings: Sightings, i: int,
) -> None:  # fmt: skip
    """Sighting i of the true chain, without noise."""
    for k in range(1, axes.shape[0] - 1):
        theta = reach * (2.0 * rng.random() - 1.0)
        sightings.cosine[i, k], sightings.sine[i, k] = np.cos(theta), np.sin(theta)
    x = foresee(routes, sightings, i, axes, links, levers)
    sightings.seen[i, 0], sightings.seen[i, 1], sightings.seen[i, 2] = x


@kernel
def size_of(seen: Array) -> float:
    """Median distance from the median place, m."""
    middle = np.empty(3)
    for j in range(3):
        middle[j] = np.median(seen[:, j])
    return float(np.median(np.sqrt(((seen - middle) ** 2).sum(axis=1))))


@kernel
def exact_run(
    rng: Generator, routes: Routes, least: int, window: int, pool: Hypotheses, rule: Rule,
    reach: float,
) -> Ints:  # fmt: skip
    """See `pool_run`."""
    nodes = routes.kind.shape[0]
    axes, links, levers = np.empty((nodes, 3)), np.empty((nodes, 3)), np.empty((nodes, 3))
    draw_chain(rng, axes, links)
    length, sightings, order = length_of(links), blank(window, nodes), np.arange(window)
    wrong, best, unit = np.zeros(2, np.int64), 0, 0.0
    for t in range(LIMIT):
        i = t % window
        show(rng, routes, axes, links, reach, levers, sightings, i)
        missed = np.inf
        if unit > 0.0:
            x = foresee(routes, sightings, i, pool.axes[best], pool.links[best], levers)
            z = sightings.seen[i]
            missed = np.sqrt((z[0] - x[0]) ** 2 + (z[1] - x[1]) ** 2 + (z[2] - x[2]) ** 2)
        for j in range(2):
            if missed > THRESHOLDS[j] * length:
                wrong[j] = t + 1
        if t + 1 - wrong[1] == STREAK:
            return wrong
        if t + 1 < least or (missed <= PREDICTED * unit and pool.level[best] <= rule.exact * unit):
            continue
        if unit == 0.0:
            unit = size_of(sightings.seen[: t + 1])
            for h in range(pool.level.shape[0]):
                spawn(routes, pool, h, unit, rule)
        best = search(routes, sightings, order[: min(t + 1, window)], pool, unit, rule)
    return np.where(LIMIT - wrong < STREAK, -1, wrong)


@kernel
def error_of(routes: Routes, fresh: Sightings, axes: Array, links: Array) -> float:
    """Root mean square error of a skeleton, m."""
    squared = np.empty(fresh.route.shape[0])
    levers = np.empty((routes.path.shape[1], 3))
    square_errors(
        routes, fresh, np.arange(squared.shape[0]), axes, links, levers, squared
    )  # fmt: skip
    return float(np.sqrt(squared.mean()))


@kernel
def spread_of(
    routes: Routes, seen: Sightings, inliers: Ints, axes: Array, links: Array, fresh: Sightings
) -> float:
    """Root mean square of tr J (sum J^T J)^+ J^T at the true chain: the bound at unit noise."""
    N, work = routes.columns[-1], work_for(routes, 1)
    accumulate(routes, seen, inliers, axes, links, 1.0, 1.0, np.inf, N, work)
    # So little damping leaves out what no sighting tells and changes nothing else.
    solve_damped(work, N, 1e-10)
    total = 0.0
    for i in range(fresh.route.shape[0]):
        total += told_variance(routes, fresh, i, axes, links, 1.0, N, work)
    return float(np.sqrt(total / fresh.route.shape[0]))
