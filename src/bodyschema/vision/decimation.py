"""Fewer faces for the same look: decimation to a budget, remembered on disk.

A silhouette costs what its mesh has in edges, and a robot's meshes are far finer than a camera's
pixels. Quadric decimation takes a second for a whole robot, so its results are kept in the user's
cache folder under a hash of everything that they depend on. A cache that cannot be read or
written is no error: the work is done again.
"""

from __future__ import annotations

import hashlib
import os
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.atomic import new_file
from bodyschema.documents import is_file
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.meshes import Triangles, triangles_of
from bodyschema.model.tree import Visual

Array = NDArray[np.float64]

HASTE = (3.0, 7.0, 10.0)
"""How fast the decimator goes, tried in turn: 3 leaves half the error of the outline that 7 does,
but does not always reach the budget."""

VERSION = "2"
"""Changes when the same meshes would give other triangles."""


def decimated(visuals: Sequence[Visual], placements: Sequence[Array], budget: int) -> Triangles:
    """One mesh of several shapes, with about `budget` faces; from the cache if it is there.

    A mesh that folds back on itself all over, such as a double skin, may keep more faces: none is
    taken away that would turn another one over.

    Args:
        visuals: shapes of links that do not move against each other.
        placements: (4, 4) T_piece_link of the link of each.
        budget: faces; 0 for all of them.

    Raises:
        InputError: a mesh file is missing or cannot be read.
        MissingExtraError: trimesh or fast-simplification is not installed.
    """
    place = cache_folder() / "meshes" / f"{_key(visuals, placements, budget)}.npz"
    try:
        with place.open("rb") as source, np.load(source) as stored:
            return stored["vertices"], stored["faces"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        pass
    parts = [_moved(triangles_of(v), T) for v, T in zip(visuals, placements, strict=True)]
    vertices, faces = welded(*_joined(parts))
    if 0 < budget < len(faces):
        vertices, faces = welded(*_simplified(vertices, faces, budget))
    try:
        with new_file(place) as temporary, temporary.open("wb") as stream:
            np.savez(stream, vertices=vertices, faces=faces)
    except (InputError, OSError):
        pass
    return vertices, faces


def cache_folder() -> Path:
    """BODYSCHEMA_CACHE, or the folder where this system keeps what can be made again."""
    chosen = os.environ.get("BODYSCHEMA_CACHE")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "bodyschema"


def welded(vertices: Array, faces: NDArray[np.int64]) -> Triangles:
    """Vertices of equal position (in float32) as one; faces that vanish by that are dropped."""
    single = vertices.astype(np.float32) + np.float32(0)  # no -0: positions are compared as bytes
    rows = np.ascontiguousarray(single).view("V12").ravel()
    _, kept, name = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(kept))  # vertices stay in the order of the file
    faces = order[name[faces]]
    a, b, c = faces.T
    solid = faces[(a != b) & (b != c) & (c != a)]
    return vertices[np.sort(kept)], solid


def _key(visuals: Sequence[Visual], placements: Sequence[Array], budget: int) -> str:
    """Hash of all that the triangles depend on; the file's content, not its name."""
    digest = hashlib.sha256(f"{VERSION} {budget}".encode())
    for visual, T in zip(visuals, placements, strict=True):
        digest.update(f"{visual.shape} {visual.size} {Path(visual.mesh).suffix}".encode())
        digest.update(np.ascontiguousarray(np.stack([visual.placement, T])).tobytes())
        if visual.mesh and is_file(Path(visual.mesh)):
            digest.update(Path(visual.mesh).read_bytes())
    return digest.hexdigest()


def _moved(triangles: Triangles, T: Array) -> Triangles:
    vertices, faces = triangles
    return vertices @ T[:3, :3].T + T[:3, 3], faces


def _joined(parts: Sequence[Triangles]) -> Triangles:
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts[:-1])])
    faces = [start + faces for start, (_, faces) in zip(first, parts, strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def _simplified(vertices: Array, faces: NDArray[np.int64], budget: int) -> Triangles:
    try:
        import fast_simplification
    except ImportError:
        raise MissingExtraError("fast-simplification", "mesh", "decimating a mesh") from None
    for haste in HASTE:
        points, triangles = fast_simplification.simplify(
            vertices, faces, target_count=budget, agg=haste
        )
        if len(triangles) <= budget:
            break
    return np.asarray(points, dtype=np.float64), np.asarray(triangles, dtype=np.int64)
