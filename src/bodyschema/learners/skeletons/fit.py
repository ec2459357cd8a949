"""Compiled Levenberg-Marquardt on skeletons: from a guess of axes and links to the nearest fit.

With residuals r_i and derivatives J_i of `skeletons.sight`, over M sightings,

    cost        C = sum_i rho(|r_i|^2 / s^2),      rho(u) = (nu + 3) / 2 log(1 + u / nu)
    weights     w_i = (nu + 3) / (nu + |r_i|^2 / s^2)                (1 where nu is infinite)
    level       s^2 = sum_i w_i |r_i|^2 / (3 M - p),     p = numbers that M sightings determine
    step        (H + lambda (tr H / N) 1) d = b,    H = sum w_i J_i^T J_i,   b = sum w_i J_i^T r_i

A step moves each free axis over the sphere, a <- a cos|u| + u sin|u| / |u|. Damping holds what no
sighting determines. After an accepted step lambda falls to a fifth, otherwise it
grows fourfold and H is kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.skeletons.sight import (
    Ints,
    Routes,
    Sightings,
    Vector,
    Work,
    dot,
    foresee,
    jacobian,
    missed,
    tangents,
)
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

LARGEST_DAMPING = 1e4
SMALLEST_DAMPING = 1e-12
LEVEL_ROUNDS = 5

SETTLED = 1e-8
"""Share of the cost; a step that gains less ends the fit."""

EXACT = 1e-9
"""Of the unit: a level below it is rounding, and fitting on would only stir the last digits."""


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
            i, j = work.column[p], work.column[q]
            work.H[max(i, j), min(i, j)] += work.block[p, q]


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
