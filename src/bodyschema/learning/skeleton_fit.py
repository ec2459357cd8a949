"""Compiled Levenberg-Marquardt on skeletons: from a guess of axes and links to the nearest fit.

Sighting i: at joint values theta_i the point v_i of a route's last node is seen at z_i from its
first node. With x the prediction of `body.skeleton` the residual is r_i = z_i - x(theta_i), and

    cost        C = sum_i rho(|r_i|^2 / s^2),      rho(u) = (nu + 3) / 2 log(1 + u / nu)
    weights     w_i = (nu + 3) / (nu + |r_i|^2 / s^2)                (1 where nu is infinite)
    level       s^2 = sum_i w_i |r_i|^2 / (3 M - p),     p = numbers that M sightings determine
    step        (H + lambda (tr H / N) 1) d = b,    H = sum w_i J_i^T J_i,   b = sum w_i J_i^T r_i

A step moves each free axis over the sphere, a <- a cos|u| + u sin|u| / |u| with u in the tangent
plane of a, and each free link by `unit` times its part of d, so that axes (rad) and links weigh
alike whatever the size of the robot. Damping holds the directions that nothing seen determines.
After an accepted step lambda falls to a fifth, otherwise it grows fourfold and H is kept.

J is 3 x N: row r is `pull_back` with g = e_r, projected on the tangent planes. Cosines and sines of
the joint values are kept with the sightings, as a search visits each of them thousands of times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.kernels import PRISMATIC, REVOLUTE, kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Vector = tuple[float, float, float]

LARGEST_DAMPING = 1e4
SMALLEST_DAMPING = 1e-12

LEVEL_ROUNDS = 5

SETTLED = 1e-8
"""Share of the cost; a step that gains less ends the fit."""

EXACT = 1e-9
"""Of the unit: a level below it is rounding, and fitting on would only stir the last digits."""


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
    x = row(sightings.point, i)
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


@kernel
def square_errors(
    routes: Routes, sightings: Sightings, chosen: Ints, axes: Array, links: Array, levers: Array,
    out: Array,
) -> None:  # fmt: skip
    """|r_i|^2 of the chosen sightings, m^2, out (n,)."""
    for n in range(chosen.shape[0]):
        r = missed(routes, sightings, chosen[n], axes, links, levers)
        out[n] = dot(r, r)


@kernel
def cost_at(squared: Array, level: float, freedom: float) -> float:
    """C of the module's formula at a level; half the sum of squares for infinite nu."""
    total = 0.0
    for u in squared:
        if np.isinf(freedom):
            total += 0.5 * u / level**2
        else:
            total += 0.5 * (freedom + 3.0) * np.log1p(u / (freedom * level**2))
    return total


@kernel
def weight_at(squared: float, level: float, freedom: float) -> float:
    """w of one sighting."""
    return 1.0 if np.isinf(freedom) else (freedom + 3.0) / (freedom + squared / level**2)


@kernel
def common_level(
    sightings: Sightings, chosen: Ints, squared: Array, freedom: float, rank: int, work: Work
) -> float:
    """The level of all sightings, m: that of the route that is explained worst.

    One level for all would let the whole of one marker pass for outliers among the others.
    """
    M, total, last = squared.shape[0], 0.0, 0
    for n in range(M):
        total += squared[n]
        last = max(last, sightings.route[chosen[n]])
    free = max(3 * M - rank, 3) / M
    if np.isinf(freedom):
        return float(np.sqrt(total / (free * M)))
    level = 0.0
    for route in range(last + 1):
        count = 0
        for n in range(M):
            if sightings.route[chosen[n]] == route:
                work.tried[count] = squared[n]
                count += 1
        if count > 0:
            level = max(level, settled_level(work.tried[:count], freedom, free))
    return level


@kernel
def settled_level(squared: Array, freedom: float, free: float) -> float:
    """The level that agrees with its own weights, m: expectation-maximisation from the median.

    `free` is the number of degrees of freedom a sighting, 3 less its share of the rank.
    """
    # 2.366 is the median of |r|^2 / s^2 for normal noise.
    level = np.sqrt(np.median(squared) / 2.366)
    for _ in range(LEVEL_ROUNDS):
        if level == 0.0:
            break
        total = 0.0
        for u in squared:
            total += weight_at(u, level, freedom) * u
        level = np.sqrt(total / (free * squared.shape[0]))
    return float(level)


@kernel
def accumulate(
    routes: Routes, sightings: Sightings, chosen: Ints, axes: Array, links: Array, unit: float,
    level: float, freedom: float, N: int, work: Work,
) -> None:  # fmt: skip
    """H (lower triangle) and b of the chosen sightings into work, route by route."""
    work.H[:N, :N] = 0.0
    work.b[:N] = 0.0
    tangents(axes, work.basis)
    for route in range(routes.length.shape[0]):
        count = 0
        for n in range(chosen.shape[0]):
            i = chosen[n]
            if sightings.route[i] != route:
                continue
            r = missed(routes, sightings, i, axes, links, work.levers)
            first = count == 0
            count = jacobian(routes, sightings, i, axes, unit, work)
            if first:
                work.block[:count, :count] = 0.0
            add_square(work, count, r, weight_at(dot(r, r), level, freedom))
        scatter(work, count)


@kernel
def add_square(work: Work, count: int, r: Vector, w: float) -> None:
    """block += w J^T J (lower triangle, packed) and b += w J^T r."""
    J, block = work.rows, work.block
    for p in range(count):
        j0, j1, j2 = w * J[0, p], w * J[1, p], w * J[2, p]
        work.b[work.column[p]] += j0 * r[0] + j1 * r[1] + j2 * r[2]
        for q in range(p + 1):
            block[p, q] += j0 * J[0, q] + j1 * J[1, q] + j2 * J[2, q]


@kernel
def scatter(work: Work, count: int) -> None:
    """H += the packed block, each entry in the lower triangle."""
    for p in range(count):
        for q in range(p + 1):
            row, column = work.column[p], work.column[q]
            work.H[max(row, column), min(row, column)] += work.block[p, q]


@kernel
def solve_damped(work: Work, N: int, damping: float) -> bool:
    """d = (H + lambda (tr H / N) 1)^-1 b by Cholesky, H = L^T L; False where that fails.

    From the last row to the first, so that every inner loop runs along memory from its beginning.
    """
    L, d = work.factor, work.d
    shift = 0.0
    for i in range(N):
        shift += damping / N * work.H[i, i]
        for j in range(i + 1):
            L[i, j] = work.H[i, j]
    for k in range(N - 1, -1, -1):
        pivot = L[k, k] + shift
        if not pivot > 0.0:
            return False
        L[k, k] = np.sqrt(pivot)
        for j in range(k):
            L[k, j] /= L[k, k]
        for i in range(k):
            factor = L[k, i]
            for j in range(i + 1):
                L[i, j] -= factor * L[k, j]
    for k in range(N):
        d[k] = work.b[k]
    for k in range(N - 1, -1, -1):
        d[k] /= L[k, k]
        for j in range(k):
            d[j] -= L[k, j] * d[k]
    for k in range(N):
        for j in range(k):
            d[k] -= L[k, j] * d[j]
        d[k] /= L[k, k]
    return True


@kernel
def told_variance(
    routes: Routes, sightings: Sightings, i: int, axes: Array, links: Array, unit: float, N: int,
    work: Work,
) -> float:  # fmt: skip
    """tr J H^-1 J^T of sighting i under the last factor: variance of its prediction over s^2."""
    foresee(routes, sightings, i, axes, links, work.levers)
    count = jacobian(routes, sightings, i, axes, unit, work)
    total, y = 0.0, work.d
    for r in range(3):
        y[:N] = 0.0
        for p in range(count):
            y[work.column[p]] = work.rows[r, p]
        for k in range(N - 1, -1, -1):
            y[k] /= work.factor[k, k]
            total += y[k] * y[k]
            for j in range(k):
                y[j] -= work.factor[k, j] * y[k]
    return total


@kernel
def move(routes: Routes, axes: Array, links: Array, unit: float, N: int, work: Work) -> None:
    """work.axes and work.links: the skeleton after the step work.d."""
    u = np.empty(3)
    for k in range(axes.shape[0]):
        link, axis = routes.link_column[k], routes.axis_column[k]
        for j in range(3):
            work.axes[k, j] = axes[k, j]
            work.links[k, j] = links[k, j]
            if 0 <= link < N:
                work.links[k, j] += unit * work.d[link + j]
        if 0 <= axis < N:
            e = work.basis[k]
            for j in range(3):
                u[j] = e[0, j] * work.d[axis] + e[1, j] * work.d[axis + 1]
            slide(work.axes[k], u)


@kernel
def slide(a: Array, u: Array) -> None:
    """a <- a cos|u| + u sin|u| / |u|, renormalised against rounding."""
    t = np.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
    c, s = np.cos(t), np.sin(t) / t if t > 1e-9 else 1.0
    length = 0.0
    for j in range(3):
        a[j] = c * a[j] + s * u[j]
        length += a[j] * a[j]
    for j in range(3):
        a[j] /= np.sqrt(length)


@kernel
def improve(
    routes: Routes, sightings: Sightings, chosen: Ints, stage: int, axes: Array, links: Array,
    unit: float, damping: float, freedom: float, iterations: int, work: Work,
) -> tuple[float, float, float]:  # fmt: skip
    """Levenberg-Marquardt iterations on one skeleton, in place.

    Returns its damping, its level, and the level that it came with

    Args:
        routes: where is looked.
        sightings: what was seen.
        chosen: rows of the sightings that count.
        stage: last stage whose nodes move.
        axes: (n_nodes, 3), overwritten.
        links: (n_nodes, 3) m, overwritten.
        unit: length that weighs like a radian, m.
        damping: lambda to begin with.
        freedom: nu; infinity for least squares.
        iterations: how many steps to try.
        work: memory.
    """
    N, rank = routes.columns[stage], routes.rank[stage]
    squared, tried = work.squared[: len(chosen)], work.tried[: len(chosen)]
    square_errors(routes, sightings, chosen, axes, links, work.levers, squared)
    level = common_level(sightings, chosen, squared, freedom, rank, work)
    first = level
    fresh = False
    for _ in range(iterations):
        if level < EXACT * unit:
            break
        if not fresh:
            accumulate(routes, sightings, chosen, axes, links, unit, level, freedom, N, work)
            fresh = True
        if not solve_damped(work, N, damping):
            damping = min(10.0 * damping, LARGEST_DAMPING)
            continue
        move(routes, axes, links, unit, N, work)
        square_errors(routes, sightings, chosen, work.axes, work.links, work.levers, tried)
        before, after = cost_at(squared, level, freedom), cost_at(tried, level, freedom)
        if after < before:
            axes[:] = work.axes
            links[:] = work.links
            squared[:] = tried
            damping = max(0.2 * damping, SMALLEST_DAMPING)
            level = common_level(sightings, chosen, squared, freedom, rank, work)
            fresh = False
            if before - after < SETTLED * before:
                break
        else:
            damping = min(4.0 * damping, LARGEST_DAMPING)
    return damping, level, first
