"""Whole runs of the online gradient on a body that watches its own markers, compiled.

At each iteration the joints stand anywhere in their ranges and every marker of the group whose turn
it is teaches the path that leads to it, one `gradient_step` after the other. The run has converged
when for `STREAK` iterations all markers seen were within the threshold of where they were expected,
before that was learned from; Hersch et al. (2008) ask the same of chains in section 4.4.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.gradient_step import descend
from bodyschema.learners.published.online_gradient import from_nothing, typical_link
from bodyschema.model.kernels import REVOLUTE, kernel
from bodyschema.model.kinematics import path_between
from bodyschema.model.skeleton import Skeleton, walk_in
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import EYE
from bodyschema.studies.self_watching import SelfWatching

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STREAK = 500

BINS_A_DECADE = 8
"""Of the learning curve."""


@dataclass(frozen=True)
class TreeRun:
    """How one run went."""

    iterations: int | None
    """Until convergence, its streak included; None if the limit came first."""
    curve: Array
    """(n_bins, n_markers) m: mean error within bins of equal width in the logarithm; NaN where a
    bin saw nothing."""
    body: Body
    """What was learned."""


def bin_ends(limit: int) -> Ints:
    """Last iteration of each bin of the learning curve, (n_bins,)."""
    steps = np.arange(1, np.ceil(BINS_A_DECADE * np.log10(limit)) + 1)
    return np.unique(np.minimum(10 ** (steps / BINS_A_DECADE), limit).astype(np.int64))


def gradient_tree_run(
    watching: SelfWatching, epsilon: float, threshold: float, limit: int, rng: np.random.Generator
) -> TreeRun:
    """Learn a whole body from nothing.

    Args:
        watching: the robot and what it sees of itself.
        epsilon: constant step size, see `OnlineGradient`.
        threshold: share of each path's length.
        limit: iterations after which to give up.
        rng: randomness.
    """
    body = watching.body
    true = Skeleton.of(body)
    length = typical_link(true)
    untaught = from_nothing(body, free_skeleton(body), length, rng)
    start = Skeleton.of(untaught)
    axes, links = start.axes.copy(), start.links.copy()
    paths = [path_between(body, EYE, marker) for marker in watching.markers]
    padded = np.full((len(paths), max(len(path) for path, _ in paths)), -1)
    for row, (path, _) in zip(padded, paths, strict=True):
        row[: len(path)] = path
    ends = bin_ends(limit)
    total = np.zeros((len(ends), len(paths)))
    small = threshold * np.array([watching.path_length(marker) for marker in watching.markers])
    reach = np.stack([body.lower, body.upper], axis=1)[np.maximum(body.driver, 0)]
    steps, seen = whole_tree_run(
        rng, padded, np.array([len(path) for path, _ in paths]),
        np.array([climbed for _, climbed in paths]),
        np.cumsum([0, *(len(group) for group in watching.groups)]),
        body.kind, true.axes, true.links, axes, links, reach, length, epsilon, small, limit,
        ends, total,
    )  # fmt: skip
    with np.errstate(invalid="ignore"):
        curve = total / seen
    learned = Skeleton(true.parent, true.kind, axes, links).into(untaught)
    return TreeRun(steps if steps > 0 else None, curve, learned)


@kernel
def whole_tree_run(
    rng: Any, paths: Ints, lengths: Ints, climbed: Ints, turns: Ints, kind: Ints,
    true_axes: Array, true_links: Array, axes: Array, links: Array, reach: Array, length: float,
    epsilon: float, small: Array, limit: int, ends: Ints, total: Array,
) -> tuple[int, Array]:  # fmt: skip
    """See `gradient_tree_run`. `turns`: first marker of each group; `reach`: (n_frames, 2) rad.

    Changes axes and links; adds errors to total. Returns the iterations, -1 at the limit, and how
    many errors were added.
    """
    nodes, groups = kind.shape[0], turns.shape[0] - 1
    free = np.ones(nodes, dtype=np.bool_)
    theta, v, x, e = np.zeros(nodes), np.zeros(3), np.empty(3), np.empty(3)
    levers = np.empty((nodes + 1, 3))
    by_axis, by_link = np.empty((nodes, 3)), np.empty((nodes, 3))
    count = np.zeros(total.shape)
    near, place = 0, 0
    for t in range(limit):
        if t == ends[place]:
            place += 1
        for k in range(nodes):
            if kind[k] == REVOLUTE:
                theta[k] = reach[k, 0] + (reach[k, 1] - reach[k, 0]) * rng.random()
        near += 1
        group = t % groups
        for m in range(turns[group], turns[group + 1]):
            path = paths[m, : lengths[m]]
            walk_in(path, climbed[m], kind, true_axes, true_links, theta, v, levers, x)
            descend(
                path, climbed[m], kind, axes, links, theta, v, x, free, free, length, epsilon,
                False, levers, by_axis, by_link, e,
            )  # fmt: skip
            error = np.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
            total[place, m] += error
            count[place, m] += 1
            # Written so that a run that has blown up, whose error is no number, is not near.
            if not error <= small[m]:
                near = 0
        if near == STREAK:
            return t + 1, count
    return -1, count
