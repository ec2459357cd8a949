"""Pool: a skeleton learned from nothing, and then held by a recursive learner.

`searching`  A small pool of hypotheses (`hypotheses`) is refined at every sighting. A new sighting
             is predicted before it is learned from. The search locks when the best hypothesis has
             predicted everything that is seen `successes` times in a row exactly; or, for noisy
             points, when there are `enough` times as many numbers as the skeleton has and two
             hypotheses have come to the same best place from different starts.
`locked`     The winner becomes the reference body of the recursive `Filter` learner. Priors
             of axes and links stay those of the parameters, so directions that nothing seen can
             tell keep their variance. The search goes on for a while, and a rival that explains
             more brings it back. At 2, 4 and 8 times the sightings of the lock, everything
             kept so far is fitted again, against fresh challengers.
`known`      No challenger has won; or the skeleton is exact. Nothing but the recursive learner's
             belief is kept: constant memory.

It goes back to searching when the mean surprise of the recursive learner leaves its band: the
running mean of min(surprise, 16) / 3, which is about 1 when all is well.

Axes and links that are free in the parameters are found from nothing; what the body says of them
plays no part. All else is taken as known. Positions must be seen from one frame, or from frames
whose orientation at zero posture is known.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.learners.filter import Filter, Innovation
from bodyschema.learners.learner import Moment, in_turn
from bodyschema.learners.skeletons.growth import plan
from bodyschema.learners.skeletons.hypotheses import (
    Hypotheses,
    Rule,
    agreed,
    challenge,
    copied,
    new_pool,
    search,
    spawn,
)
from bodyschema.learners.skeletons.pool_state import PoolInfo, PoolState, look_of, sightings_of
from bodyschema.learners.skeletons.sight import Routes, Sightings
from bodyschema.model.kernels import AXIS, LINK
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

AGAIN = (2, 4, 8)
"""Times the sightings of the lock at which all is fitted again."""

BETTER = 0.7
"""Times the level of the locked skeleton: a rival that goes below it reopens the search."""

PREDICTED = 1e-3
"""Of the unit: an exact skeleton predicts better than this."""

SURPRISE_RATE, SURPRISE_CAP, SURPRISE_BAND = 0.05, 16.0, 2.5
"""Weight of a new sample in the mean surprise; largest surprise of one sample; where it is lost."""


@dataclass(frozen=True)
class Pool:
    """Global learner of a skeleton: a pool of hypotheses, then recursive Gauss-Newton."""

    size: int = 8
    """Hypotheses."""
    rule: Rule = Rule()  # noqa: RUF009  (frozen settings)
    window: int = 4
    """Times the least sightings that the search remembers."""
    enough: int = 2
    """Times the least sightings at which a noisy skeleton may be locked."""
    successes: int = 5
    """Exact predictions in a row, of each that is seen, that make a skeleton known."""
    challengers: int = 3
    """Fresh hypotheses at each new fit of the burn-in."""
    rounds: int = 20
    """Of search for them."""
    recursive: Filter = field(default_factory=Filter)
    """The learner after the lock."""
    seed: int = 0

    def start(self, body: Body, variables: Variables) -> PoolState:
        """Nothing is known but the arrangement of the joints.

        Raises:
            InputError: the parameters free no axis and no link.
        """
        if not np.isin(variables.code, (AXIS, LINK)).any():
            raise InputError(
                "a pool searches axes and links, and the parameters free none; "
                "use free_skeleton(body)."
            )
        return PoolState(body, variables, "searching")

    def step(self, state: PoolState, moment: Moment) -> tuple[PoolState, tuple[PoolInfo, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: PoolState, sample: Sense) -> tuple[PoolState, PoolInfo]:
        """Learn from one sighting."""
        if state.belief is None:
            return self._search(state, sample)
        if look_of(sample) not in state.looks:
            # A marker never seen before hangs on joints that may not be known.
            return self._search(_lost(state), sample)
        belief, (innovation,) = self.recursive.step(state.belief, (sample,))
        after = replace(state, belief=belief, surprise=_surprise(state, innovation))
        if after.surprise > SURPRISE_BAND:
            after = _lost(after)
        elif after.phase == "locked":
            after = self._doubted(_remember(after, sample))
        return after, _info(after, sample, innovation.residual)

    def _search(self, state: PoolState, sample: Sense) -> tuple[PoolState, PoolInfo]:
        look = look_of(sample)
        if look not in state.looks:
            # Plans are dear: others that are seen for the first time may come in this moment.
            fresh = replace(state, looks=(*state.looks, look), routes=None, pool=None)
            fresh = replace(fresh, sightings=None, samples=(*state.samples, sample))
            return fresh, _info(fresh, sample, np.full(3, np.nan))
        residual = sample.residual(state.body)[0] if state.pool is not None else np.full(3, np.nan)
        state = self._planned(_remember(state, sample))
        routes, sightings = state.routes, state.sightings
        assert routes is not None
        assert sightings is not None
        if 3 * len(sightings.route) < routes.rank[-1]:
            return state, _info(state, sample, residual)
        if state.pool is None:
            state = self._begun(state, routes, sightings)
        else:
            state = replace(state, pool=copied(state.pool))
        pool = state.pool
        assert pool is not None
        good = float(np.linalg.norm(residual)) <= PREDICTED * state.unit
        exact = pool.level[state.best] <= self.rule.exact * state.unit
        final = pool.stage[state.best] == len(routes.columns) - 1
        if good and exact and final:
            state = replace(state, streak=state.streak + 1)
        else:
            rows = np.arange(len(sightings.route))
            best = search(routes, sightings, rows, pool, state.unit, self.rule)
            state = replace(state, best=int(best), streak=0)
        state = self._judged(state, pool, routes)
        return state, _info(state, sample, residual)

    def _planned(self, state: PoolState) -> PoolState:
        """Routes for the looks so far, and no more sightings than the search remembers."""
        routes, sightings = state.routes, state.sightings
        if routes is None:
            routes = plan(state.reference, state.variables, state.looks)
        if sightings is None:
            sightings = sightings_of(state.reference, state.looks, state.samples)
        most = _most(self.window, routes)
        return replace(
            state,
            routes=routes,
            samples=state.samples[-most:],
            sightings=Sightings._make(array[-most:] for array in sightings),
        )

    def _begun(self, state: PoolState, routes: Routes, sightings: Sightings) -> PoolState:
        """The first hypotheses."""
        seen = sightings.seen
        unit = float(np.median(np.linalg.norm(seen - np.median(seen, axis=0), axis=1)))
        old = Skeleton.of(state.reference)
        pool = new_pool(self.size, old.axes, old.links, self.seed)
        for h in range(self.size):
            spawn(routes, pool, h, unit, self.rule)
        return replace(state, pool=pool, unit=unit, best=0)

    def _judged(self, state: PoolState, pool: Hypotheses, routes: Routes) -> PoolState:
        """Whether the search is over."""
        if pool.stage[state.best] < len(routes.columns) - 1:
            return state
        if state.streak >= self.successes * len(state.looks):
            return replace(
                self._handed_over(state, pool), phase="known", samples=(), sightings=None
            )
        many = 3 * len(state.samples) >= self.enough * routes.rank[-1]
        level = pool.level[state.best] / state.unit
        noisy = self.rule.exact < level <= self.rule.promising
        if many and noisy and agreed(pool, len(routes.columns) - 1):
            return replace(self._handed_over(state, pool), phase="locked", lock=len(state.samples))
        return state

    def _handed_over(self, state: PoolState, pool: Hypotheses) -> PoolState:
        """The recursive learner's belief, fitted to all samples kept, round the best body."""
        learner = replace(self.recursive, burn_in=len(state.samples))
        empty = learner.start(state.hypothesis(pool), state.variables)
        *before, last = state.samples
        belief, _ = learner.step(replace(empty, waiting=tuple(before)), (last,))
        return replace(state, belief=belief, surprise=1.0)

    def _doubted(self, state: PoolState) -> PoolState:
        """The search goes on until there are twice as many sightings; later, now and then.

        False places that many starts come to do exist in trees.
        """
        M = len(state.samples)
        if AGAIN[0] * state.lock < M:
            return self._again(state)
        assert state.pool is not None
        assert state.routes is not None
        assert state.sightings is not None
        pool = copied(state.pool)
        rows = np.arange(max(0, M - _most(self.window, state.routes)), M)
        best = int(search(state.routes, state.sightings, rows, pool, state.unit, self.rule))
        better = pool.level[best] < BETTER * pool.level[state.best]
        state = replace(state, pool=pool)
        if better:
            return replace(state, best=best, phase="searching", belief=None, streak=0)
        return self._again(state)

    def _again(self, state: PoolState) -> PoolState:
        """Fit all that was kept again when its size says so."""
        times = len(state.samples) / state.lock
        if times not in AGAIN:
            return state
        assert state.pool is not None
        assert state.routes is not None
        assert state.sightings is not None
        pool = copied(state.pool)
        now = Skeleton.of(state.body)
        pool.axes[state.best], pool.links[state.best] = now.axes, now.links
        best = challenge(
            state.routes, state.sightings, 2 * state.lock, pool, state.best, state.unit, self.rule,
            self.challengers, self.rounds,
        )  # fmt: skip
        state = self._handed_over(replace(state, pool=pool, best=int(best)), pool)
        if times < AGAIN[-1]:
            return state
        return replace(state, phase="known", samples=(), sightings=None)


def _lost(state: PoolState) -> PoolState:
    """Searching again, from nothing but who looks at whom."""
    fresh = PoolState(state.reference, state.variables, "searching")
    return replace(fresh, looks=state.looks, routes=state.routes)


def _remember(state: PoolState, sample: Sense) -> PoolState:
    """The state with one more sighting."""
    state = replace(state, samples=(*state.samples, sample))
    if state.sightings is None:
        return state
    new = sightings_of(state.reference, state.looks, (sample,))
    pairs = zip(state.sightings, new, strict=True)
    return replace(state, sightings=Sightings._make(np.concatenate(pair) for pair in pairs))


def _most(window: int, routes: Routes) -> int:
    """Sightings that the search remembers."""
    return window * -(-int(routes.rank[-1]) // 3)


def _surprise(state: PoolState, innovation: Innovation) -> float:
    """The running mean after one more sample."""
    new = min(innovation.surprise, SURPRISE_CAP) / len(innovation.residual)
    return (1 - SURPRISE_RATE) * state.surprise + SURPRISE_RATE * new


def _info(state: PoolState, sample: Sense, residual: Array) -> PoolInfo:
    return PoolInfo(state.phase, residual, state.expected_error(sample), state.surprise)
