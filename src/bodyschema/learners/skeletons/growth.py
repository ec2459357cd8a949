"""In which order a tree is learned: outward, stage by stage.

Routes that cross the same unknown joints are learned together. Of those groups the one with fewest
unknown joints comes first, and of equals the one with most routes; then its joints count as known.
A chain has one stage. A humanoid that sees its hands and feet begins with one hand (neck, waist and
arm), the other hand adds an arm, each foot a leg.

What sightings of a route can determine is the rank of their derivatives at a random skeleton and
random joint values: 4 n + 3 for a chain of n joints, because each joint's centre may slide along
its own axis, and the same for nearly every geometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.skeletons.sight import (
    Routes,
    Sightings,
    foresee,
    jacobian,
    tangents,
    work_for,
)
from bodyschema.model.kernels import AXIS, FIXED, LINK, kernel
from bodyschema.model.kinematics import path_between
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


class Look(NamedTuple):
    """Who looks at whom."""

    seen_from: str
    seen: str
    varied: bool = False
    """Whether other points of the frame than its origin are seen, as in Touches."""


CUT = 1e-9
"""A singular value below this share of the largest is zero."""


def plan(body: Body, variables: Variables, looks: Sequence[Look]) -> Routes:
    """Routes, stages, columns and ranks.

    Args:
        body: gives the tree.
        variables: their axes and links are to be found, everything else is known.
        looks: who looks at whom, each once.
    """
    paths = [path_between(body, look.seen_from, look.seen) for look in looks]
    nodes = [path.tolist() for path, _ in paths]
    free = {code: set(variables.index[variables.code == code].tolist()) for code in (AXIS, LINK)}
    turning = free[AXIS] & set(np.flatnonzero(body.kind != FIXED).tolist())
    # Its own joint does not move a point on its axis, such as the origin of its frame.
    crossed = [
        frozenset(path if look.varied or len(path) == climbed else path[:-1]) & turning
        for look, path, (_, climbed) in zip(looks, nodes, paths, strict=True)
    ]
    stage = _stages(crossed)
    axis_column = np.full(len(body.frames), -1)
    link_column = np.full(len(body.frames), -1)
    columns, used = [], 0
    for s in range(max(stage) + 1):
        now = [r for r in range(len(nodes)) if stage[r] == s]
        for k in sorted({k for r in now for k in nodes[r]}):
            if axis_column[k] < 0 and any(k in crossed[r] for r in now):
                axis_column[k], used = used, used + 2
            if link_column[k] < 0 and k in free[LINK]:
                link_column[k], used = used, used + 3
        columns.append(used)
    table = np.full((len(nodes), max(map(len, nodes))), -1)
    for row, path in zip(table, nodes, strict=True):
        row[: len(path)] = path
    ints = [[len(path) for path in nodes], [climbed for _, climbed in paths], stage, columns]
    length, climbed, at, ends = (np.array(part, dtype=np.int64) for part in ints)
    routes = Routes(
        body.kind, table, length, climbed, axis_column, link_column, at, ends, np.zeros_like(ends)
    )
    return routes._replace(rank=_ranks(routes, [look.varied for look in looks]))


def _stages(unknown: Sequence[frozenset[int]]) -> list[int]:
    """Stage of each route, from the joints that it crosses."""
    stage = [-1] * len(unknown)
    known: frozenset[int] = frozenset()
    now = 0
    while -1 in stage:
        groups: dict[frozenset[int], list[int]] = {}
        for r, joints in enumerate(unknown):
            if stage[r] < 0:
                groups.setdefault(joints - known, []).append(r)
        joints, members = min(groups.items(), key=lambda group: (len(group[0]), -len(group[1])))
        for r in members:
            stage[r] = now
        known |= joints
        now += 1
    return stage


def _ranks(routes: Routes, varied: Sequence[bool]) -> Ints:
    """(n_stages,) numbers that sightings up to each stage can determine."""
    rng = np.random.default_rng(0)
    n_routes, nodes = len(routes.length), len(routes.kind)
    axes = rng.normal(size=(nodes, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    links = rng.normal(size=(nodes, 3))
    # More numbers of each route than its path has columns.
    each = 5 * routes.path.shape[1] // 3 + 2
    theta = rng.uniform(-1.5, 1.5, (each * n_routes, nodes))
    nowhere = np.zeros((len(theta), 3))
    route = np.arange(len(theta)) % n_routes
    points = rng.normal(size=(len(theta), 3)) * np.array(varied)[route, None]
    sightings = Sightings(np.cos(theta), np.sin(theta), route, points, nowhere)
    J = np.zeros((len(theta), 3, int(routes.columns[-1])))
    stacked(routes, sightings, axes, links, 1.0, J)
    found = []
    for s, end in enumerate(routes.columns):
        part = J[routes.stage[route] <= s][:, :, :end].reshape(-1, end)
        values = np.linalg.svd(part, compute_uv=False)
        found.append(int(np.sum(values > CUT * values.max(initial=0.0))))
    return np.array(found, dtype=np.int64)


@kernel
def stacked(
    routes: Routes, sightings: Sightings, axes: Array, links: Array, unit: float, out: Array
) -> None:
    """J of every sighting in full width, out (n, 3, N), which must come in as zeros."""
    work = work_for(routes, 1)
    tangents(axes, work.basis)
    for i in range(sightings.route.shape[0]):
        foresee(routes, sightings, i, axes, links, work.levers)
        count = jacobian(routes, sightings, i, axes, unit, work)
        for row in range(3):
            for p in range(count):
                out[i, row, work.column[p]] += work.rows[row, p]
