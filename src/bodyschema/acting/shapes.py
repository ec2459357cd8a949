"""Convex hulls of a robot's visible shapes, a little thicker than the shapes.

The hull of points P is sampled by its support points, argmax of u^T p over P for many directions u,
each moved outward by the margin: few vertices however fine the mesh is, and a safety distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from bodyschema.documents import is_file
from bodyschema.errors import MissingExtraError
from bodyschema.model.meshes import KINDS
from bodyschema.model.tree import Visual

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

DIRECTIONS = 96
MARGIN = 0.005
"""m."""


@dataclass(frozen=True)
class Hull:
    """A convex solid in the frame of a link."""

    frame: str
    points: Array
    """(n, 3) m."""
    triangles: Ints
    """(m, 3) rows of `points`, counter-clockwise from outside."""
    centre: Array
    """(3,) m, of a ball round it."""
    radius: float
    """m."""


def hulls_of(visuals: Sequence[Visual]) -> tuple[list[Hull], list[str]]:
    """Hulls of all shapes that can be read, and the files that cannot.

    Raises:
        MissingExtraError: there are meshes and trimesh is not installed.
    """
    hulls, missing = [], []
    for visual in visuals:
        points = _points(visual)
        if points is None:
            missing.append(visual.mesh)
        else:
            T = visual.placement
            hulls.append(convex_hull(visual.frame, points @ T[:3, :3].T + T[:3, 3]))
    return hulls, missing


def convex_hull(frame: str, points: Array) -> Hull:
    """The thickened hull of points (n, 3) m."""
    u = _directions(DIRECTIONS)
    support = points[np.argmax(u @ points.T, axis=1)] + MARGIN * u
    triangles = ConvexHull(support).simplices.astype(np.int64)
    centre = (support.min(axis=0) + support.max(axis=0)) / 2
    a, b, c = np.moveaxis(support[triangles], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - support.mean(axis=0)) < 0
    triangles[inward] = triangles[inward, ::-1]
    radius = float(np.linalg.norm(support - centre, axis=1).max())
    return Hull(frame, support, triangles, centre, radius)


def _directions(n: int) -> Array:
    """Unit vectors spread evenly over the sphere (Fibonacci lattice), (n, 3)."""
    i = np.arange(n) + 0.5
    z = 1 - 2 * i / n
    turn = np.pi * (1 + np.sqrt(5)) * i
    ring = np.sqrt(1 - z**2)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)


def _points(visual: Visual) -> Array | None:
    """Points (n, 3) m, in the shape's own frame, whose hull holds the shape; None if unreadable."""
    size = np.array(visual.size)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    if visual.shape == "mesh":
        vertices = _mesh_points(Path(visual.mesh))
        return None if vertices is None else np.asarray(vertices * size)
    if visual.shape == "box":
        return np.asarray(corners * size / 2)
    if visual.shape == "sphere":
        return np.asarray(_directions(DIRECTIONS) * size[0])
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = np.stack([size[0] * np.cos(turn), size[0] * np.sin(turn), 0 * turn], axis=1)
    end = np.array([0.0, 0.0, size[1] / 2])
    return np.concatenate([rim - end, rim + end])


def _mesh_points(path: Path) -> Array | None:
    try:
        import trimesh
    except ImportError:
        raise MissingExtraError("trimesh", "mesh", "checking for self-collision") from None
    if path.suffix.lower() not in KINDS or not is_file(path):
        return None
    try:
        mesh: Any = trimesh.load(path, force="mesh")
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
    except Exception:  # readers of many formats, each with errors of its own
        return None
    return vertices if len(vertices) > 3 and bool(np.isfinite(vertices).all()) else None
