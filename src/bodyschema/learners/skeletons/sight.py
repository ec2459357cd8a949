"""Skeletons in the form in which a search visits them: routes, sightings, residuals, derivatives.

Sighting i: at joint values theta_i the point v_i of a route's last node is seen at z_i from its
first node. With x the prediction of `model.skeleton`,

    r_i = z_i - x(theta_i),      J_i = dx / d(step)      (3 x N)

A step has two numbers for each free axis, u in the tangent plane of a, and three for each free
link, in units of `unit`, so that axes (rad) and links weigh alike whatever the robot's size. Row r
of J is `skeleton.pull_back` with g = e_r; all three are carried along at once, as the rows of the
rotation from the node at hand to the frame that looks.

Cosines and sines of the joint values are kept with the sightings, as a search visits each of them
thousands of times, and three-vectors are tuples: they stay in registers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import PRISMATIC, REVOLUTE, kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Vector = tuple[float, float, float]


class Routes(NamedTuple):
    """Which paths are looked along, and where each node's numbers stand in the step vector."""

    kind: Ints
    """(n_nodes,) FIXED, REVOLUTE or PRISMATIC."""
    path: Ints
    """(n_routes, longest) nodes of each route, from the frame that looks; -1 beyond its length."""
    length: Ints
    """(n_routes,)."""
    climbed: Ints
    """(n_routes,) how many nodes of a route go up."""
    axis_column: Ints
    """(n_nodes,) first of the two columns of a free axis; -1 for an axis that is known."""
    link_column: Ints
    """(n_nodes,) first of the three columns of a free link; -1 for a link that is known."""
    stage: Ints
    """(n_routes,) when a route is taken up; see `growth`."""
    columns: Ints
    """(n_stages,) columns in use up to each stage: later stages own later columns."""
    rank: Ints
    """(n_stages,) numbers that sightings up to each stage can determine."""


class Sightings(NamedTuple):
    """What was seen, one row a sighting."""

    cosine: Array
    """(n, n_nodes) of the joint values."""
    sine: Array
    """(n, n_nodes); at a prismatic node the shift itself, m."""
    route: Ints
    """(n,) row of `Routes`."""
    point: Array
    """(n, 3) v, m: the point in the last node, as the skeleton has it."""
    seen: Array
    """(n, 3) z, m: where it was seen from the first node."""


class Work(NamedTuple):
    """Memory of one fit, so that nothing is allocated in the loops."""

    levers: Array
    rows: Array
    """(3, longest * 5) J of one sighting, columns packed along its route."""
    column: Ints
    """(longest * 5,) where the packed columns stand in the step vector."""
    basis: Array
    """(n_nodes, 2, 3) tangent basis of each axis."""
    H: Array
    factor: Array
    b: Array
    d: Array
    axes: Array
    links: Array
    block: Array
    """(longest * 5, longest * 5) packed part of H that one route fills."""
    squared: Array
    """(n,) |r_i|^2 of the skeleton, and"""
    tried: Array
    """(n,) of the one that is tried."""


@kernel
def work_for(routes: Routes, sightings: int) -> Work:
    """Memory for fits of this size."""
    nodes, wide, N = routes.kind.shape[0], 5 * routes.path.shape[1], routes.columns[-1]
    return Work(
        np.empty((routes.path.shape[1], 3)), np.empty((3, wide)), np.empty(wide, np.int64),
        np.empty((nodes, 2, 3)), np.empty((N, N)), np.empty((N, N)), np.empty(N), np.empty(N),
        np.empty((nodes, 3)), np.empty((nodes, 3)), np.empty((wide, wide)), np.empty(sightings),
        np.empty(sightings),
    )  # fmt: skip


@kernel
def tangents(axes: Array, basis: Array) -> None:
    """Two unit vectors normal to each axis, without a pole (Duff et al. 2017, JCGT 6(1))."""
    for k in range(axes.shape[0]):
        x, y, z = axes[k, 0], axes[k, 1], axes[k, 2]
        sign = 1.0 if z >= 0.0 else -1.0
        u = -1.0 / (sign + z)
        basis[k, 0, 0], basis[k, 0, 1], basis[k, 0, 2] = (
            1 + sign * x * x * u,
            sign * x * y * u,
            -sign * x,
        )
        basis[k, 1, 0], basis[k, 1, 1], basis[k, 1, 2] = x * y * u, sign + y * y * u, -y


@kernel
def row(A: Array, k: int) -> Vector:
    """Row k of a matrix with three columns, as three numbers that stay in registers."""
    return A[k, 0], A[k, 1], A[k, 2]


@kernel
def dot(a: Vector, b: Vector) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def turned(a: Vector, c: float, s: float, p: Vector) -> Vector:
    """R p, Rodrigues' formula; -s turns back."""
    along = (1.0 - c) * dot(a, p)
    return (
        c * p[0] + s * (a[1] * p[2] - a[2] * p[1]) + along * a[0],
        c * p[1] + s * (a[2] * p[0] - a[0] * p[2]) + along * a[1],
        c * p[2] + s * (a[0] * p[1] - a[1] * p[0]) + along * a[2],
    )


@kernel
def tilted(a: Vector, c: float, s: float, p: Vector, e: Vector) -> Vector:
    """D(p) e = s e x p + (1 - c) ((a . p) e + (e . p) a): how R p moves when a moves by e."""
    u, v = (1.0 - c) * dot(a, p), (1.0 - c) * dot(e, p)
    return (
        s * (e[1] * p[2] - e[2] * p[1]) + u * e[0] + v * a[0],
        s * (e[2] * p[0] - e[0] * p[2]) + u * e[1] + v * a[1],
        s * (e[0] * p[1] - e[1] * p[0]) + u * e[2] + v * a[2],
    )


@kernel
def foresee(
    routes: Routes, sightings: Sightings, i: int, axes: Array, links: Array, levers: Array
) -> Vector:
    """Where sighting i is expected; fills levers as `skeleton.walk_in` does."""
    r = sightings.route[i]
    climbed, path = routes.climbed[r], routes.path[r]
    x: Vector = row(sightings.point, i)
    for step in range(routes.length[r] - 1, -1, -1):
        k = path[step]
        a, link, c, s = row(axes, k), row(links, k), sightings.cosine[i, k], sightings.sine[i, k]
        if step < climbed:
            x, s = (x[0] - link[0], x[1] - link[1], x[2] - link[2]), -s
        levers[step, 0], levers[step, 1], levers[step, 2] = x
        if routes.kind[k] == REVOLUTE:
            x = turned(a, c, s, x)
        elif routes.kind[k] == PRISMATIC:
            x = (x[0] + s * a[0], x[1] + s * a[1], x[2] + s * a[2])
        if step >= climbed:
            x = (x[0] + link[0], x[1] + link[1], x[2] + link[2])
    return x


@kernel
def jacobian(
    routes: Routes, sightings: Sightings, i: int, axes: Array, unit: float, work: Work
) -> int:
    """J of sighting i into work.rows, packed along the route; returns how many columns.

    Needs the levers of `foresee` and the tangent basis of these axes. g0, g1, g2 are the rows of
    A, the rotation from a node's parent (or, going up, the node) to the frame that looks.
    """
    r = sightings.route[i]
    climbed, path, J, column = routes.climbed[r], routes.path[r], work.rows, work.column
    g0, g1, g2 = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    count = 0
    for step in range(routes.length[r]):
        k = path[step]
        a, c, s = row(axes, k), sightings.cosine[i, k], sightings.sine[i, k]
        link, axis, sign = routes.link_column[k], routes.axis_column[k], unit
        if step < climbed:
            s, sign = -s, -unit
        elif link >= 0:
            count = put(J, column, count, link, unit, g0, g1, g2)
        if axis >= 0:
            p = row(work.levers, step)
            for b in range(2):
                e = row(work.basis[k], b)
                d = tilted(a, c, s, p, e)
                if routes.kind[k] == PRISMATIC:
                    d = (s * e[0], s * e[1], s * e[2])
                J[0, count], J[1, count], J[2, count] = dot(g0, d), dot(g1, d), dot(g2, d)
                column[count] = axis + b
                count += 1
        if routes.kind[k] == REVOLUTE:
            g0, g1, g2 = turned(a, c, -s, g0), turned(a, c, -s, g1), turned(a, c, -s, g2)
        if step < climbed and link >= 0:
            count = put(J, column, count, link, sign, g0, g1, g2)
    return count


@kernel
def put(
    J: Array, column: Ints, count: int, link: int, scale: float, g0: Vector, g1: Vector, g2: Vector
) -> int:
    """The three columns of a link; returns the new number of columns."""
    for j in range(3):
        J[0, count + j], J[1, count + j], J[2, count + j] = (
            scale * g0[j],
            scale * g1[j],
            scale * g2[j],
        )
        column[count + j] = link + j
    return count + 3


@kernel
def missed(
    routes: Routes, sightings: Sightings, i: int, axes: Array, links: Array, levers: Array
) -> Vector:
    """r_i, m: seen minus foreseen."""
    x, z = foresee(routes, sightings, i, axes, links, levers), row(sightings.seen, i)
    return z[0] - x[0], z[1] - x[1], z[2] - x[2]
