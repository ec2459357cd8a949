"""One step of gradient descent on a skeleton, compiled (Hersch et al. 2008, Eq. 5, 9, 14, 15).

A sample is a point v of the last node of a path, seen at x' from its first: E = 1/2 |e|^2 with
e = x' - x(a, l). All axes and links move at once, from the old values, in O(n):

    l_k <- l_k - eps dE/dl_k
    a_k <- a_k - eps / L^2 dE/da_k,       a_k <- a_k / |a_k|

which is the paper's step with lengths measured in L, so that one eps means the same for an arm in
metres and in millimetres. The normalised step takes, in that unit, eps = mu |e|^2 / |grad E|^2.
Only nodes on the path are touched: a step costs what the path is long, however large the body.

All arrays are changed in place: whoever calls owns copies.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.model.skeleton import pull_back, walk_in

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@kernel
def squared(path: Ints, rows: Array, free: Flags) -> float:
    """Sum of squares of the free rows on the path, of (n_frames, 3)."""
    total = 0.0
    for i in range(path.shape[0]):
        k = path[i]
        if free[k]:
            total += rows[k, 0] ** 2 + rows[k, 1] ** 2 + rows[k, 2] ** 2
    return total


@kernel
def climb(
    path: Ints, axes: Array, links: Array, by_axis: Array, by_link: Array, turns: Flags,
    moves: Flags, for_axes: float, for_links: float,
) -> None:  # fmt: skip
    """Move the free axes and links of the path in the given directions; axes stay unit vectors."""
    for i in range(path.shape[0]):
        k = path[i]
        if moves[k]:
            for j in range(3):
                links[k, j] += for_links * by_link[k, j]
        if turns[k]:
            x = axes[k, 0] + for_axes * by_axis[k, 0]
            y = axes[k, 1] + for_axes * by_axis[k, 1]
            z = axes[k, 2] + for_axes * by_axis[k, 2]
            shrink = 1.0 / np.sqrt(x * x + y * y + z * z)
            axes[k, 0], axes[k, 1], axes[k, 2] = x * shrink, y * shrink, z * shrink


@kernel
def descend(
    path: Ints, climbed: int, kind: Ints, axes: Array, links: Array, theta: Array, v: Array,
    x: Array, turns: Flags, moves: Flags, length: float, epsilon: float, normalised: bool,
    levers: Array, by_axis: Array, by_link: Array, e: Array,
) -> None:  # fmt: skip
    """Learn from one sample; e is its residual before.

    Args:
        path, climbed: from the frame that looks to the one that carries the point.
        kind, axes, links: the skeleton; axes and links are changed.
        theta: (n_frames,) joint values at the nodes.
        v, x: (3,) the point in its own node and where it was seen, as the skeleton has them.
        turns, moves: (n_frames,) which axes and which links are free.
        length: L, m.
        epsilon: eps, or mu of the normalised step.
        normalised: which of both.
        levers, by_axis, by_link: room for (steps + 1, 3), (n_frames, 3), (n_frames, 3).
        e: (3,) x' - x, out.
    """
    walk_in(path, climbed, kind, axes, links, theta, v, levers, e)
    pull = levers[path.shape[0]]
    for j in range(3):
        e[j] = x[j] - e[j]
        pull[j] = e[j]
    for i in range(path.shape[0]):
        for j in range(3):
            by_axis[path[i], j] = 0.0
            by_link[path[i], j] = 0.0
    pull_back(path, climbed, kind, axes, links, theta, levers, pull, by_axis, by_link)
    size = epsilon
    if normalised:
        steep = squared(path, by_link, moves) + squared(path, by_axis, turns) / length**2
        error = e[0] ** 2 + e[1] ** 2 + e[2] ** 2
        size = epsilon * error / steep if steep > 0.0 else 0.0
    climb(path, axes, links, by_axis, by_link, turns, moves, size / length**2, size)


@kernel
def descend_through(
    path: Ints, climbed: int, kind: Ints, axes: Array, links: Array, theta: Array, v: Array,
    x: Array, turns: Flags, moves: Flags, length: float, epsilon: float, normalised: bool,
    residual: Array,
) -> None:  # fmt: skip
    """`descend` for samples one after the other: theta (n, n_frames), v and x (n, 3) ->
    residual (n, 3), each before its sample was learned from."""
    levers = np.empty((path.shape[0] + 1, 3))
    by_axis, by_link = np.empty(axes.shape), np.empty(axes.shape)
    for n in range(theta.shape[0]):
        descend(
            path, climbed, kind, axes, links, theta[n], v[n], x[n], turns, moves, length,
            epsilon, normalised, levers, by_axis, by_link, residual[n],
        )  # fmt: skip
