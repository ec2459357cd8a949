"""A small pool of skeletons that compete to explain what was seen.

Each hypothesis is refined by `Rule.iterations` steps of Levenberg-Marquardt at every new sighting;
the best one gets `Rule.polish` more. One that gains less than a share `Rule.gain` of its squared
level, or grows older than `Rule.oldest` iterations, makes room for a random one, unless it is the
best. A single start finds the truth in 2 to 90 % of the cases, a few of them nearly always do.

A tree is learned outward, stage by stage (`growth`): a hypothesis that explains the routes of its
stage becomes a base, and from it the nodes of the next stage are tried at random, up to
`Rule.tries` times; all nodes go on moving, those solved first too. Then it begins from nothing. The
search begins when all sightings together could determine the whole tree: a first limb may then be
fitted by chance, and is found out by the next.

A few sightings can be fitted by chance if others may be called outliers, so costs are squares until
there are twice as many numbers as the skeleton has, and Student-t only from then on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.skeletons.fit import improve
from bodyschema.learners.skeletons.sight import Routes, Sightings, work_for
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FINISH = 40
"""Iterations of whoever is compared on everything."""

WITNESS = 1.05
"""Times the best level; who comes so near is kept, and may turn out to be at the same place."""

AGREEMENT = 1.001
"""Times the best level; two that come so near from different starts are at the same place."""


class Rule(NamedTuple):
    """How a pool goes about it."""

    iterations: int = 5
    """Of each hypothesis at each sighting, times the number of stages."""
    polish: int = 10
    """More of them for the best, times the number of stages."""
    gain: float = 0.02
    """Share of the squared level; who gains less in a round is slow."""
    patience: int = 20
    """Iterations before slowness counts."""
    oldest: int = 100
    """Iterations after which a hypothesis that is not the best is dropped."""
    tries: int = 12
    """Random starts of a stage from one base."""
    spread: float = 0.05
    """Standard deviation of the links of a random start, in units of what was seen."""
    exact: float = 1e-4
    """Level, in units of what was seen, that no false skeleton reaches."""
    passing: float = 0.03
    """Level, in units of what was seen, with which the next stage may be tried."""
    promising: float = 0.3
    """Level, in units of what was seen, above which nothing has been explained."""
    freedom: float = 4.0
    """nu of the Student-t cost."""


class Hypotheses(NamedTuple):
    """The pool; kernels change it in place, so learners hand them a copy."""

    axes: Array
    """(K, n_nodes, 3)."""
    links: Array
    """(K, n_nodes, 3) m."""
    base_axes: Array
    """(K, n_nodes, 3) from which the stage was begun."""
    base_links: Array
    damping: Array
    """(K,) lambda."""
    level: Array
    """(K,) m; inf before the first fit."""
    age: Ints
    """(K,) iterations since the start."""
    stage: Ints
    """(K,) routes up to this stage are explained or being tried."""
    failures: Ints
    """(K,) starts of this stage that came to nothing."""
    draws: NDArray[np.uint64]
    """(1,) state of the random numbers."""


def new_pool(size: int, axes: Array, links: Array, seed: int) -> Hypotheses:
    """A pool round one skeleton, (n_nodes, 3) each, which gives what is known."""
    many = (size, 1, 1)
    return Hypotheses(
        np.tile(axes, many), np.tile(links, many), np.tile(axes, many), np.tile(links, many),
        np.ones(size), np.full(size, np.inf), np.zeros(size, np.int64), np.zeros(size, np.int64),
        np.zeros(size, np.int64), np.array([seed], np.uint64),
    )  # fmt: skip


def copied(pool: Hypotheses) -> Hypotheses:
    """A pool that may be changed."""
    return Hypotheses._make(array.copy() for array in pool)


@kernel
def uniform(draws: NDArray[np.uint64]) -> float:
    """Next number in (0, 1) of SplitMix64 (Steele, Lea, Flood 2014); the state moves on."""
    draws[0] += np.uint64(0x9E3779B97F4A7C15)
    z = draws[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return (float(z >> np.uint64(11)) + 0.5) / 9007199254740992.0


@kernel
def normal(draws: NDArray[np.uint64]) -> float:
    """Standard normal number (Box and Muller 1958)."""
    length = np.sqrt(-2.0 * np.log(uniform(draws)))
    return float(length * np.cos(2.0 * np.pi * uniform(draws)))


@kernel
def spawn(routes: Routes, pool: Hypotheses, h: int, unit: float, rule: Rule) -> None:
    """A new start of hypothesis h: its base, and random nodes from its stage outward."""
    s = pool.stage[h]
    first = routes.columns[s - 1] if s > 0 else 0
    pool.axes[h] = pool.base_axes[h]
    pool.links[h] = pool.base_links[h]
    for k in range(routes.kind.shape[0]):
        if routes.axis_column[k] >= first:
            length = 0.0
            for j in range(3):
                pool.axes[h, k, j] = normal(pool.draws)
                length += pool.axes[h, k, j] ** 2
            pool.axes[h, k] /= np.sqrt(length)
        if routes.link_column[k] >= first:
            for j in range(3):
                pool.links[h, k, j] = rule.spread * unit * normal(pool.draws)
    pool.damping[h], pool.age[h], pool.level[h] = 1.0, 0, np.inf


@kernel
def best_of(pool: Hypotheses) -> int:
    """Row of the hypothesis at the farthest stage, with the smallest level of these."""
    best = 0
    for h in range(1, pool.level.shape[0]):
        farther = pool.stage[h] > pool.stage[best]
        if farther or (pool.stage[h] == pool.stage[best] and pool.level[h] < pool.level[best]):
            best = h
    return best


@kernel
def refine(
    routes: Routes, sightings: Sightings, chosen: Ints, pool: Hypotheses, h: int, unit: float,
    rule: Rule, iterations: int,
) -> float:  # fmt: skip
    """Iterations of hypothesis h on the sightings of its stage; returns the level it had before."""
    work = work_for(routes, chosen.shape[0])
    s, kept = pool.stage[h], 0
    rows = np.empty(chosen.shape[0], np.int64)
    for i in chosen:
        if routes.stage[sightings.route[i]] <= s:
            rows[kept] = i
            kept += 1
    freedom = rule.freedom if 3 * kept >= 2 * routes.rank[s] else np.inf
    pool.damping[h], pool.level[h], before = improve(
        routes, sightings, rows[:kept], s, pool.axes[h], pool.links[h], unit, pool.damping[h],
        freedom, iterations, work,
    )  # fmt: skip
    pool.age[h] += iterations
    return float(before)


@kernel
def search(
    routes: Routes, sightings: Sightings, chosen: Ints, pool: Hypotheses, unit: float, rule: Rule
) -> int:
    """One round: everybody is refined, the idle are replaced; returns the best row.

    Args:
        routes: where is looked.
        sightings: what was seen.
        chosen: rows of the sightings that count.
        pool: overwritten.
        unit: size of what was seen, m.
        rule: how.
    """
    last = routes.columns.shape[0] - 1
    m, more = rule.iterations * (last + 1), rule.polish * (last + 1)
    best = best_of(pool)
    for h in range(pool.level.shape[0]):
        before = refine(routes, sightings, chosen, pool, h, unit, rule, m)
        level = pool.level[h]
        exact = level <= rule.exact * unit
        held = pool.stage[h] == last and (h == best or level <= WITNESS * pool.level[best])
        slow = pool.age[h] >= rule.patience and level**2 > (1.0 - rule.gain) * before**2
        if pool.stage[h] < last and (exact or (slow and level <= rule.passing * unit)):
            pool.base_axes[h] = pool.axes[h]
            pool.base_links[h] = pool.links[h]
            pool.stage[h] += 1
            pool.failures[h] = 0
            spawn(routes, pool, h, unit, rule)
        elif not (exact or held) and (slow or pool.age[h] >= rule.oldest):
            give_up(routes, pool, h, unit, rule)
    best = best_of(pool)
    refine(routes, sightings, chosen, pool, best, unit, rule, more)
    return int(best)


@kernel
def give_up(routes: Routes, pool: Hypotheses, h: int, unit: float, rule: Rule) -> None:
    """Another start from the same base, or from nothing after too many."""
    pool.failures[h] += 1
    if pool.failures[h] >= rule.tries:
        pool.stage[h], pool.failures[h] = 0, 0
    spawn(routes, pool, h, unit, rule)


def agreed(pool: Hypotheses, last: int) -> bool:
    """Whether two hypotheses of the last stage came to the best place from different starts.

    False places are many, and seldom found twice.
    """
    levels = pool.level[pool.stage == last]
    return int(np.sum(levels <= AGREEMENT * levels.min(initial=np.inf))) > 1


def challenge(
    routes: Routes, sightings: Sightings, recent: int, pool: Hypotheses, best: int, unit: float,
    rule: Rule, challengers: int, rounds: int,
) -> int:  # fmt: skip
    """The best skeleton, refined on everything, against fresh ones; returns the winner's row.

    Args:
        routes: where is looked.
        sightings: all that was kept.
        recent: how many of the last of them the challengers are searched on.
        pool: overwritten.
        best: row of the incumbent.
        unit: size of what was seen, m.
        rule: how.
        challengers: how many; fewer than the pool holds.
        rounds: of search for them.
    """
    everything = np.arange(len(sightings.route))
    last = len(pool.level) - 1
    for array in pool[:-1]:
        array[last] = array[best]
    refine(routes, sightings, everything, pool, last, unit, rule, FINISH)
    ring = Hypotheses._make([*(array[:challengers] for array in pool[:-1]), pool.draws])
    ring.stage[:], ring.failures[:] = 0, 0
    for h in range(challengers):
        spawn(routes, ring, h, unit, rule)
    first = 0
    for _ in range(rounds):
        first = search(routes, sightings, everything[-recent:], ring, unit, rule)
    refine(routes, sightings, everything, ring, first, unit, rule, FINISH)
    # The others have levels of fewer sightings, which do not compare.
    others = np.delete(np.arange(last), first)
    pool.level[others], pool.stage[others] = np.inf, 0
    return int(best_of(pool))
