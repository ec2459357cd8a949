"""Whole runs of the online gradient on random chains, compiled.

A run is the simulation of section 4.4.2 of Hersch et al. (2008): a random true chain, an untaught
one, and samples with joints uniform in +-reach until the distance between both chains' end points
has stayed below a threshold, a share of the chain's length (all links summed), for `STREAK` samples
in a row; or until the limit. The paper's end point v, in the last segment's frame, can be read in
three ways:

    varied   known, another at each sample, as far off as a link is long     path 1 .. n
    learnt   fixed and unknown: the tip's link, learned too                  path 1 .. n + 1
    known    fixed and known: the tip's link, which stays as it is           path 1 .. n + 1
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.gradient_step import Flags, descend
from bodyschema.model.kernels import kernel
from bodyschema.model.skeleton import walk_in
from bodyschema.studies.random_chains import (
    LONGEST,
    SHORTEST,
    Generator,
    chain_kinds,
    direction,
    draw_chain,
    draw_untaught,
    fill,
    length_of,
    run_generator,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Reading = Literal["varied", "learnt", "known"]

STREAK = 500
"""Successive samples that must stay below the threshold."""

BLOCK = 256
"""Samples whose random numbers are drawn together."""


@dataclass(frozen=True)
class Protocol:
    """What the paper leaves open, settled. Lengths are in units of the mean link."""

    reading: Reading = "varied"
    reach: float = np.pi / 2
    """rad: joints are uniform within +-reach."""
    epsilon: float = 0.03
    normalised: bool = False
    threshold: float = 0.01
    """Share of the chain's length."""
    limit: int = 1_000_000
    """Iterations."""


def gradient_run(protocol: Protocol, n_joints: int, seed: int, run: int) -> int:
    """Iterations until convergence, its streak included; -1 if the limit came first."""
    last = n_joints if protocol.reading == "varied" else n_joints + 1
    moves = np.ones(n_joints + 2, dtype=np.bool_)
    moves[n_joints + 1] = protocol.reading == "learnt"
    steps = whole_run(
        run_generator(seed, n_joints, run), np.arange(1, last + 1), chain_kinds(n_joints), moves,
        protocol.reach, protocol.epsilon, protocol.normalised, protocol.threshold, protocol.limit,
    )  # fmt: skip
    return int(steps)


@kernel
def begin(
    rng: Generator, moves: Flags, axes: Array, links: Array, true_axes: Array, true_links: Array
) -> None:
    """Draw the true chain and the untaught one, which knows the links that are not learned."""
    draw_chain(rng, true_axes, true_links)
    draw_untaught(rng, axes, links)
    for k in range(moves.shape[0]):
        if not moves[k]:
            links[k] = true_links[k]


@kernel
def show(
    random: Array, path: Ints, kind: Ints, axes: Array, links: Array, reach: float,
    levers: Array, theta: Array, v: Array, x: Array,
) -> None:  # fmt: skip
    """A sample of the true chain from (n + 3,) uniform numbers: posture, v, where it is seen."""
    tip = theta.shape[0] - 1
    for k in range(1, tip):
        theta[k] = reach * (2.0 * random[k - 1] - 1.0)
    if path[path.shape[0] - 1] < tip:
        direction(random[tip - 1], random[tip], v)
        far = SHORTEST + (LONGEST - SHORTEST) * random[tip + 1]
        for j in range(3):
            v[j] *= far
    walk_in(path, 0, kind, axes, links, theta, v, levers, x)


@kernel
def whole_run(
    rng: Generator, path: Ints, kind: Ints, moves: Flags, reach: float, epsilon: float,
    normalised: bool, threshold: float, limit: int,
) -> int:  # fmt: skip
    """See `gradient_run`."""
    nodes = kind.shape[0]
    axes, links = np.empty((nodes, 3)), np.empty((nodes, 3))
    true_axes, true_links = np.empty((nodes, 3)), np.empty((nodes, 3))
    begin(rng, moves, axes, links, true_axes, true_links)
    turns = np.ones(nodes, dtype=np.bool_)
    theta, v, x, e = np.zeros(nodes), np.zeros(3), np.empty(3), np.empty(3)
    levers, by_axis, by_link = np.empty((nodes + 1, 3)), np.empty((nodes, 3)), np.empty((nodes, 3))
    small, near, random = threshold * length_of(true_links), 0, np.empty((BLOCK, nodes + 1))
    for t in range(limit):
        if t % BLOCK == 0:
            fill(rng, random)
        show(random[t % BLOCK], path, kind, true_axes, true_links, reach, levers, theta, v, x)
        descend(
            path, 0, kind, axes, links, theta, v, x, turns, moves, 1.0, epsilon, normalised,
            levers, by_axis, by_link, e,
        )  # fmt: skip
        near = near + 1 if e[0] ** 2 + e[1] ** 2 + e[2] ** 2 < small**2 else 0
        if near == STREAK:
            return t + 1
    return -1
