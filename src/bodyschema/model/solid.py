"""Solids: the shape of an object as triangles, and where a line of force enters it.

Boxes, cylinders and balls are made of triangles too; round ones have `SIDES` sides, so that they
are at most 0.06 % of their radius too thin. Every triangle is looked at each time: 10 microseconds
for a thousand of them. A mesh with many more is better decimated before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.documents import regular_file
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.meshes import triangles_of
from bodyschema.model.solid_kernels import entered, passed
from bodyschema.model.tree import Body, Visual

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SIDES = 96


class Met(NamedTuple):
    """Places where a line meets the outside of a solid."""

    points: Array
    """(n, 3) m."""
    normals: Array
    """(n, 3) unit, outward."""
    inside: bool
    """False when the line misses the solid, and the one point is where it passes nearest."""


@dataclass(frozen=True)
class Solid:
    """Triangles that close a volume, in one frame."""

    vertices: Array
    """(n, 3) m."""
    faces: Ints
    """(m, 3) rows of `vertices`, counter-clockwise from outside."""

    def __post_init__(self) -> None:
        V, F = self.vertices, self.faces
        fits = V.ndim == F.ndim == 2 and V.shape[1] == F.shape[1] == 3 and len(F) > 0
        if not fits or not np.isfinite(V).all() or not 0 <= F.min() <= F.max() < len(V):
            raise InputError(
                "a solid needs vertices (n, 3) of finite numbers and faces (m, 3) that name rows "
                f"of them, at least one; got {V.shape} and {F.shape}."
            )

    @classmethod
    def box(cls, size: ArrayLike, T: ArrayLike | None = None) -> Solid:
        """A box of edges x y z, m, about the origin, or at T (4, 4)."""
        x, y, z = _positive(size, 3, "a box has three edges")
        corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
        return _placed(corners * (x / 2, y / 2, z / 2), faces, T)

    @classmethod
    def cylinder(cls, radius: float, length: float, T: ArrayLike | None = None) -> Solid:
        """A cylinder along z, m, about the origin, or at T (4, 4)."""
        r, z = _positive([radius, length], 2, "a cylinder has a radius and a length")
        turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
        rim = np.stack([r * np.cos(turn), r * np.sin(turn), 0 * turn], axis=1)
        ends = np.array([[0, 0, -z / 2], [0, 0, z / 2]])
        faces = []
        for i in range(SIDES):
            j, low, high = (i + 1) % SIDES, 2 * SIDES, 2 * SIDES + 1
            faces += [(i, j, j + SIDES), (i, j + SIDES, i + SIDES)]
            faces += [(low, j, i), (high, i + SIDES, j + SIDES)]
        return _placed(np.vstack([rim + ends[0], rim + ends[1], ends]), faces, T)

    @classmethod
    def ball(cls, radius: float, T: ArrayLike | None = None) -> Solid:
        """A ball, m, about the origin, or at T (4, 4)."""
        (r,) = _positive([radius], 1, "a ball has a radius")
        rings = SIDES // 2
        polar = np.linspace(0, np.pi, rings + 1)[1:-1]
        turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
        height, angle = (part.ravel() for part in np.meshgrid(polar, turn, indexing="ij"))
        belt = np.stack(
            [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)], axis=1
        )
        top, bottom = len(belt), len(belt) + 1
        faces = []
        for i in range(SIDES):
            j, last = (i + 1) % SIDES, (rings - 2) * SIDES
            faces += [(top, i, j), (bottom, last + j, last + i)]
            for ring in range(0, last, SIDES):
                a, b, c, d = ring + i, ring + j, ring + SIDES + i, ring + SIDES + j
                faces += [(a, c, d), (a, d, b)]
        return _placed(r * np.vstack([belt, [0, 0, 1], [0, 0, -1]]), faces, T)

    @classmethod
    def from_mesh(cls, path: str | Path, scale: float = 1.0, T: ArrayLike | None = None) -> Solid:
        """A mesh file that trimesh reads (STL, OBJ, DAE ...).

        Args:
            path: the file.
            scale: m of one unit of the file, such as 0.001 for millimetres.
            T: (4, 4) from the mesh's frame to the one wanted; identity when None.

        Raises:
            InputError: the file is missing or cannot be read.
            MissingExtraError: trimesh is not installed.
        """
        (s,) = _positive([scale], 1, "the scale of a mesh is one number")
        missing = f"no mesh at '{path}'; give the path of an STL, OBJ or DAE file."
        regular_file(Path(path), missing)
        visual = Visual("object", np.eye(4), "mesh", (s, s, s), str(path))
        return _placed(*triangles_of(visual), T)

    @classmethod
    def from_link(cls, body: Body, link: str, frame: str | None = None) -> Solid:
        """The visible shapes of a link of a body.

        Args:
            body: with visuals, such as one read from a URDF.
            link: whose shapes are wanted.
            frame: the frame wanted, held to the link by fixed joints, such as the sensor's; the
                link itself when None.

        Raises:
            InputError: no such link or frame, the link has no shape, or a mesh cannot be read.
            MissingExtraError: trimesh is not installed.
        """
        link = body.frames[body.frame_index(link)]
        visuals = [visual for visual in body.visuals if visual.frame == link]
        if not visuals:
            shapes = sorted({visual.frame for visual in body.visuals})
            raise InputError(f"'{link}' of {body.name} has no shape{did_you_mean('', shapes)}")
        q = np.vstack([np.zeros(len(body.joints)), np.full(len(body.joints), 0.1)])
        T, moved = relative_pose(body, q, frame or link, link)
        if np.abs(moved - T).max() > 1e-9:
            raise InputError(
                f"a joint moves '{link}' against '{frame}'; name a frame that is fixed to the link."
            )
        pieces = [triangles_of(visual) for visual in visuals]
        starts = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
        faces = [piece + start for (_, piece), start in zip(pieces, starts, strict=False)]
        return _placed(np.vstack([piece for piece, _ in pieces]), np.vstack(faces), T)

    @cached_property
    def corners(self) -> Array:
        """(m, 3, 3) m, of each triangle."""
        return np.ascontiguousarray(self.vertices[self.faces])

    @cached_property
    def normals(self) -> Array:
        """(m, 3) unit, outward; zeros for a triangle without area, which is never met."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        n = np.cross(b - a, c - a)
        length = np.linalg.norm(n, axis=1, keepdims=True)
        return np.asarray(np.divide(n, length, out=np.zeros_like(n), where=length > 0))

    @cached_property
    def centre(self) -> Array:
        """(3,) m, of the box along the axes that holds it."""
        used = self.vertices[self.faces.ravel()]
        return np.asarray((used.min(axis=0) + used.max(axis=0)) / 2)

    @cached_property
    def radius(self) -> float:
        """m, of a ball about the centre that holds it."""
        used = self.vertices[self.faces.ravel()]
        return float(np.linalg.norm(used - self.centre, axis=1).max())

    def pressed(self, push: Array, point: Array, along: Array, limit: float = 0.0) -> Met:
        """Where a force may press on the outside, on the line point + s along.

        Args:
            push: (3,) the force on the solid, of any length.
            point: (3,) m, of the line.
            along: (3,) unit, the line's direction; s grows along it.
            limit: only faces count whose inward normal has more than this cosine to the push.

        Returns:
            The places in the order of s; the one nearest to the line if the line meets none; no
            place if the push presses on no face.
        """
        F = np.ascontiguousarray(push / np.linalg.norm(push))
        faces, s = np.empty(len(self.faces), dtype=np.int64), np.empty(len(self.faces))
        count = entered(self.corners, self.normals, F, limit, point, along, faces, s)
        if count:
            order = np.argsort(s[:count], kind="stable")
            # A line through a common edge meets both faces at one place.
            apart = np.diff(s[order], prepend=-np.inf) > 1e-9
            chosen = order[apart]
            points = point + s[chosen, None] * along
            return Met(points, self.normals[faces[chosen]], True)
        near = np.empty(3)
        face = passed(self.corners, self.normals, F, limit, point, along, near)
        if face < 0:
            return Met(np.empty((0, 3)), np.empty((0, 3)), False)
        return Met(near[None], self.normals[face][None], False)


def _placed(vertices: ArrayLike, faces: ArrayLike, T: ArrayLike | None) -> Solid:
    V = np.asarray(vertices, dtype=np.float64)
    if T is not None:
        M = np.asarray(T, dtype=np.float64)
        if M.shape != (4, 4) or not np.isfinite(M).all():
            raise InputError(f"the place of a solid is a 4x4 transform, got an array {M.shape}.")
        V = V @ M[:3, :3].T + M[:3, 3]
    return Solid(V, np.asarray(faces, dtype=np.int64))


def _positive(sizes: ArrayLike, count: int, what: str) -> Array:
    values = np.asarray(sizes, dtype=np.float64)
    if values.shape != (count,) or not (np.isfinite(values) & (values > 0)).all():
        raise InputError(f"{what}, in metres and above zero; got {values.tolist()}.")
    return values
