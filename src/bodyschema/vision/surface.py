"""Surface: the visible body as rigid pieces, in the form in which it is imagined.

All pieces lie end to end in one set of arrays: piece b has the vertices vo[b] .. vo[b+1], the
faces fo[b] .. fo[b+1] and the edge entries eo[b] .. eo[b+1]. Indices count over all pieces. The
plane of a face is n.p = d with n its unit normal; the eye at e is on the outer side where
n.e - d > 0. For the edge entries see `bodyschema.vision.edges`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import FIXED
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.vision.decimation import decimated, welded
from bodyschema.vision.edges import edge_table

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]

FACES = 600
"""Faces that a piece keeps unless told otherwise."""


class Columns(NamedTuple):
    """The arrays of a surface as kernels read them: one contiguous array a coordinate."""

    VX: Floats
    VY: Floats
    VZ: Floats
    NX: Floats
    NY: Floats
    NZ: Floats
    ND: Floats
    F: NDArray[Any]
    """(n_faces, 3) unsigned."""
    EU: NDArray[Any]
    EV: NDArray[Any]
    E0: NDArray[Any]
    E1: NDArray[Any]
    vo: Ints
    fo: Ints
    eo: Ints


@dataclass(frozen=True)
class Surface:
    """Rigid pieces of triangles; built by `of` from a body or by `build` from arrays."""

    frames: tuple[str, ...]
    """Frame of the body that carries each piece."""
    vertices: Array
    """(n_vertices, 3) m, in the frame of their piece."""
    faces: Ints
    """(n_faces, 3) rows of `vertices`, counter-clockwise from outside."""
    vo: Ints
    """(n_pieces + 1,) first vertex of each piece, and the end."""
    fo: Ints
    """(n_pieces + 1,) first face of each piece, and the end."""
    eo: Ints
    """(n_pieces + 1,) first edge entry of each piece, and the end."""
    planes: Array
    """(n_faces, 4) unit normal and distance d (m) of each face; zeros for a face without area."""
    edges: Ints
    """(n_edges, 4) rows u, v, f, g; g is n_faces where there is none."""

    @classmethod
    def of(
        cls,
        body: Body,
        frames: Sequence[str] | None = None,
        faces: int | Mapping[str, int] = FACES,
    ) -> Surface:
        """The visible shapes of a body, links that fixed joints hold together as one piece.

        Args:
            body: with visuals, such as one read from a URDF.
            frames: links whose pieces are wanted; None for all that have a shape.
            faces: budget of a piece, 0 for all faces; or by link, where others keep all of theirs.
                A mesh that cannot be made that coarse keeps more, see `decimation`.

        Raises:
            InputError: a link is unknown or has no shape, or a mesh cannot be read.
            MissingExtraError: trimesh or fast-simplification is not installed.
        """
        carriers = {name: carrier(body, name) for name in body.frames}
        shown = [v for v in body.visuals if v.frame in carriers]
        wanted = {carriers[v.frame]: 0 for v in shown}
        if frames is not None:
            wanted = {carriers[_known(name, body)]: 0 for name in frames}
        budgets = {k: 0 if isinstance(faces, Mapping) else faces for k in wanted}
        if isinstance(faces, Mapping):
            budgets |= {carriers[_known(name, body)]: n for name, n in faces.items()}
        rest = np.zeros(len(body.joints))
        pieces = {}
        for piece in wanted:
            mine = [v for v in shown if carriers[v.frame] == piece]
            if not mine:
                shapes = sorted({v.frame for v in shown})
                raise InputError(f"'{piece}' of {body.name} has no shape{did_you_mean('', shapes)}")
            placements = [relative_pose(body, rest, piece, v.frame) for v in mine]
            pieces[piece] = decimated(mine, placements, budgets[piece])
        return cls.build(pieces)

    @classmethod
    def build(cls, pieces: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> Surface:
        """A surface from vertices (n, 3) m and faces (m, 3) of each frame.

        Raises:
            InputError: there is no triangle, or a face names a vertex that is not there.
        """
        checked = {name: _checked(name, *arrays) for name, arrays in pieces.items()}
        counts = [(len(vertices), len(faces)) for vertices, faces in checked.values()]
        vo, fo = np.cumsum([(0, 0), *counts], axis=0).T.copy()
        if fo[-1] == 0:
            raise InputError("a surface needs at least one triangle with three different corners.")
        vertices = np.concatenate([vertices for vertices, _ in checked.values()])
        faces = np.concatenate([v + f for v, (_, f) in zip(vo, checked.values(), strict=False)])
        edges = edge_table(faces, none=len(faces))
        order = np.argsort(edges[:, 2], kind="stable")  # by face, hence by piece
        eo = np.searchsorted(edges[order, 2], fo)
        return cls(
            tuple(pieces), vertices, faces, vo, fo, eo, _planes(vertices, faces), edges[order]
        )

    @cached_property
    def columns(self) -> Columns:
        """The arrays as kernels read them."""
        VX, VY, VZ = np.ascontiguousarray(self.vertices.T, dtype=np.float32)
        NX, NY, NZ, ND = np.ascontiguousarray(self.planes.T, dtype=np.float32)
        EU, EV, E0, E1 = np.ascontiguousarray(self.edges.T, dtype=np.uint32)
        F = self.faces.astype(np.uint32)
        return Columns(VX, VY, VZ, NX, NY, NZ, ND, F, EU, EV, E0, E1, self.vo, self.fo, self.eo)


def carrier(body: Body, frame: str) -> str:
    """The frame nearest above (or at) this one that a joint moves, or the root."""
    k = body.frame_index(frame)
    while body.kind[k] == FIXED and body.parent[k] >= 0:
        k = int(body.parent[k])
    return body.frames[k]


def _known(name: str, body: Body) -> str:
    return body.frames[body.frame_index(name)]


def _checked(name: str, vertices: ArrayLike, faces: ArrayLike) -> tuple[Array, Ints]:
    V, F = np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise InputError(
            f"piece '{name}' needs vertices (n, 3) and faces (m, 3); got {V.shape} and {F.shape}."
        )
    if not np.isfinite(V).all() or (len(F) and not 0 <= F.min() <= F.max() < len(V)):
        raise InputError(f"piece '{name}' has a vertex that is no number, or a face without one.")
    return welded(V, F)


def _planes(vertices: Array, faces: Ints) -> Array:
    """Unit normal and distance of each face, (m, 4)."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    n = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    return np.column_stack([n, np.sum(n * a, axis=1)])
