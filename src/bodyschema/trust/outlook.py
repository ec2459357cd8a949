"""Outlook: the error at the targets, under everything that the rows leave possible.

Draws of the variables, and of what else may have shaped the rows, in proportion to how well each
choice of sizes explains them (`hierarchy`), make the target's place

    p_true(q) - p_fit(q) = p_larger(q) - p_fit(q) + J(q) (x - x_larger) + K(q) gamma

where larger is the largest model, J its slopes and K the effect of an explanation on the robot.
95 % of the lengths over all draws and postures is what is stated. Two explanations that fit alike
are both among the draws: their distance is in the number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose
from bodyschema.trust.effects import Effects
from bodyschema.trust.explanations import Explanation, explanations
from bodyschema.trust.hierarchy import Hierarchy, Sizes
from bodyschema.trust.inflation import inflation
from bodyschema.trust.scores import Scores
from bodyschema.trust.target import Target

Array = NDArray[np.float64]

BEFOREHAND = 0.1
"""Chance of each explanation over that of none, before anything was seen."""

DRAWS = 400
"""A 95 % of the errors over 200 postures is then known to a few percent."""


@dataclass(frozen=True)
class Outlook:
    """95 % of the error of an answer, m, the worst target's."""

    core: float
    """By noise and what the rows leave open of the robot's numbers, as samples hang together."""
    total: float
    """With whatever else may have shaped what was seen."""
    share: float
    """Chance that something else has."""
    says: str
    """The likeliest of it, in words."""


@dataclass(frozen=True)
class _Case:
    """One explanation, or none, with all sizes tried."""

    hierarchy: Hierarchy
    sizes: Sizes
    explanation: Explanation | None
    weight: Array
    """(K,) not normalised."""


def outlook(
    fit: Estimate, larger: Scores, effects: Effects, wanted: Sequence[Target], seed: int = 0
) -> Outlook:
    """What may be true of the targets.

    Args:
        fit: the answer.
        larger: of the largest model.
        effects: on the same rows.
        wanted: where the robot is to be right.
        seed: of the draws.
    """
    cases = _cases(larger, effects)
    shares = np.array([np.sum(case.weight) for case in cases])
    shares /= shares.sum()
    views = [_View.of(fit, larger.estimate, target, i) for i, target in enumerate(wanted)]
    rho = cases[0].sizes.D[np.argmax(cases[0].weight)]
    learnt = larger.under(larger.estimate.variables.scale * rho)
    kappa = max((inflation(learnt, view.J * rho) for view in views), default=1.0)
    rng = np.random.default_rng(seed)
    core = max((_quantile(v, cases[:1], rng, np.sqrt(kappa)) for v in views), default=0.0)
    total = max((_quantile(v, cases, rng, 1.0) for v in views), default=0.0)
    best = 1 + int(np.argmax(shares[1:])) if len(cases) > 1 else 0
    one = cases[best].explanation
    return Outlook(core, total, float(1 - shares[0]), "" if one is None else one.says)


def _cases(larger: Scores, effects: Effects) -> list[_Case]:
    """None first; weights are relative to the best of all."""
    plain = Hierarchy.of(larger)
    alone = plain.alone()
    most = alone.D[np.argmax(alone.log_weight)]
    found: list[tuple[Hierarchy, Sizes, Explanation | None, float]] = [(plain, alone, None, 0.0)]
    for one in explanations(effects):
        beside = plain.beside(one.Z)
        found.append((beside, beside.smaller(most), one, np.log(BEFOREHAND)))
    best = max(float(np.max(sizes.log_weight)) + prior for _, sizes, _, prior in found)
    return [
        _Case(beside, sizes, one, np.exp(sizes.log_weight + prior - best))
        for beside, sizes, one, prior in found
    ]


@dataclass(frozen=True)
class _View:
    """A target as the answer and the largest model see it."""

    apart: Array
    """(n, 3) m, from the answer's place to the larger model's."""
    J: Array
    """(n, 3, P) slopes there, in units of the prior."""
    x: Array
    """(P,) where the larger model stands, likewise."""
    target: int
    """Its number."""

    @classmethod
    def of(cls, fit: Estimate, larger: Estimate, target: Target, number: int) -> _View:
        here, there = (
            relative_pose(e.body, target.q, *target.pair)[:, :3, 3] for e in (fit, larger)
        )
        scale = larger.variables.scale
        slopes = target.slopes(larger).by_parameter[:, :3]
        return cls(there - here, slopes * scale, larger.x / scale, number)


def _quantile(
    view: _View, cases: Sequence[_Case], rng: np.random.Generator, spread: float
) -> float:
    """95 % of the error of one target, each case for what it weighs."""
    total = sum(float(np.sum(case.weight)) for case in cases)
    lengths = []
    for case in cases:
        share = DRAWS * case.weight / total
        counts = np.floor(share + rng.random(len(share))).astype(int)
        for k in np.flatnonzero(counts):
            drawn = case.hierarchy.draws(case.sizes.D[k], int(counts[k]), rng, spread)
            lengths.append(_lengths(view, case.explanation, drawn).ravel())
    return float(np.quantile(np.concatenate(lengths), 0.95)) if lengths else 0.0


def _lengths(view: _View, one: Explanation | None, drawn: Array) -> Array:
    """(draws, n) m; where the robot has changed, as it was when the answer suits it best."""
    P = len(view.x)
    off = view.apart + _moved(view.J, drawn[:, :P] - view.x)
    if one is None or not one.ways:
        return np.asarray(np.linalg.norm(off, axis=2))
    ways = [np.linalg.norm(off + _moved(K, drawn[:, P:]), axis=2) for K in one.ways[view.target]]
    best = np.argmin([np.quantile(way, 0.95, axis=1) for way in ways], axis=0)
    return np.asarray(np.stack(ways)[best, np.arange(len(best))])


def _moved(J: Array, x: Array) -> Array:
    """J x for each of (draws, p), (draws, n, 3)."""
    n = len(J)
    return np.asarray((x @ J.reshape(3 * n, -1).T).reshape(len(x), n, 3))
