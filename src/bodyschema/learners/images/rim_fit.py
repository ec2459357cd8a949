"""Rows of least squares from the outline of a body in pictures of several postures.

For rim point i, found at the estimate z = (x, y) and looked for along its normal (see
`vision.correspondences` and `vision.normal_search`), x the parameters of the body and y
what cameras and meshes may have wrong (see `doubts`),

    r_i = d_i - J_i delta,        w_i = l_i (1 + (e_i / k)^2)^-2,   k = max(1, reach / 6)

d_i pixels outward of the outline as drawn, l_i the length of contour that the point stands for, e_i
what is left of d_i when the doubts that are not drawn are taken off, and w_i the weight of Geman
and McClure. How much all rows together say: `rim_information`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.images.doubts import Doubts, corrected, drawn
from bodyschema.learners.images.sight import Sight
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, join
from bodyschema.vision.correspondences import Rim, find_rim, outward_gain, rim_slopes
from bodyschema.vision.patches import Patches
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

MATCHED = 2.0
"""pixels; a rim point is matched when its outline was found within so much."""

LEAST_NOISE = 0.3
"""pixels, of a pixel of contour; more while the search is wide."""

CORRELATED = 3.0
"""pixels of contour that err together, at the least."""


@dataclass(frozen=True)
class RimRows:
    """The rim points of one posture whose outline was found."""

    J: Array
    """(n, size) pixels per unit of z."""
    d: Array
    """(n,) pixels outward of what is drawn."""
    left: Array
    """(n,) e, pixels."""
    length: Array
    """(n,) l, pixels."""
    weight: Array
    """(n,) w."""
    group: Ints
    """(n,) camera and piece."""
    lengths: Array
    """(n_cameras, n_pieces) pixels of contour that was looked for."""
    matches: Array
    """(n_cameras, n_pieces) pixels of it that were found within `MATCHED`."""
    losses: Array
    """(n_cameras, n_pieces) sums of rho over it, pixels^3; see `hypothesis`."""

    @property
    def matched(self) -> float:
        """Share of the contour that was found within `MATCHED`; 0 where there is none."""
        return float(self.matches.sum()) / max(float(self.lengths.sum()), 1.0)

    @property
    def loss(self) -> float:
        """Mean of rho over the contour, pixels^2; that of nothing found where there is none."""
        length = float(self.lengths.sum())
        return float(self.losses.sum()) / length if length else MATCHED**2

    def distance(self, unseen: float) -> float:
        """Pixels that half of the contour lies within, what was not found taken as so far."""
        order = np.argsort(np.abs(self.left))
        so_far = np.cumsum(self.length[order])
        k = int(np.searchsorted(so_far, float(self.lengths.sum()) / 2))
        return float(np.abs(self.left[order[k]])) if k < len(order) else unseen

    @cached_property
    def H(self) -> Array:
        """J^T W J."""
        H = np.zeros((self.J.shape[1], self.J.shape[1]))
        gram(np.ascontiguousarray(self.J), self.weight, H)
        return H


@dataclass(frozen=True)
class Normal:
    """Normal equations H z = g of one posture."""

    H: Array
    """(size, size)"""
    g: Array
    """(size,)"""


@dataclass(frozen=True)
class RimModel:
    """What does not change while z is fitted."""

    surface: Surface
    body: Body
    """Round which the parameters are charted."""
    wanted: Variables
    """Those that were asked for."""
    variables: Variables
    """Those, and the turns of cameras that are doubted."""
    doubts: Doubts
    patches: Patches
    n_cameras: int

    @classmethod
    def of(
        cls,
        surface: Surface,
        body: Body,
        wanted: Variables,
        cameras: Sequence[Camera],
        doubts: Doubts,
    ) -> RimModel:
        """For pictures of these cameras."""
        variables = join(wanted, doubts.turns(body, wanted, cameras))
        patches = Patches.of(surface, doubts.patches if doubts.shape else 0)
        return cls(surface, body, wanted, variables, doubts, patches, len(cameras))

    @cached_property
    def scale(self) -> Array:
        """Standard deviations of the prior of z, 1 where there is none; (size,)."""
        doubted = self.doubts.std(self.n_cameras, len(self.patches))
        return np.concatenate([self.variables.scale, doubted])

    @cached_property
    def drawn(self) -> NDArray[np.bool_]:
        """Which of z are drawn, (size,)."""
        lens = drawn(self.n_cameras, len(self.patches))
        return np.concatenate([np.ones(len(self.variables), dtype=bool), lens])

    def posed(self, z: Array) -> Body:
        """The body by z."""
        return self.body.with_variables(self.variables, z[: len(self.variables)])

    def cameras(self, given: Sequence[Camera], z: Array) -> tuple[Camera, ...]:
        """The cameras by z."""
        return corrected(given, z[len(self.variables) :])

    def outline(
        self, given: Sequence[Camera], q: Array, z: Array, step: int = 1
    ) -> tuple[Rim, Array]:
        """The outline as drawn, and its slopes by z (n, size), pixels per unit."""
        cameras = self.cameras(given, z)
        T = piece_poses(self.posed(z), q, cameras, self.surface.frames)[0]
        rim = find_rim(self.surface, T, cameras, step)
        x = z[: len(self.variables)]
        slopes = rim_slopes(rim, self.surface, cameras, self.body, self.variables, x, q)
        gain = outward_gain(rim, T, cameras)
        doubted = self.doubts.outward(rim, gain, cameras, self.patches)
        return rim, np.hstack([slopes.by_parameter, doubted])

    def rows(self, sight: Sight, z: Array, reach: float, step: int = 1) -> RimRows:
        """Rows at z.

        Args:
            sight: of one posture.
            z: (size,) deviations, then doubts.
            reach: pixels to either side.
            step: every how many rows and columns of the image.
        """
        rim, J = self.outline(sight.cameras, sight.q, z, step)
        seen = sight.search(rim, reach)
        left = seen.distance - J @ np.where(self.drawn, 0.0, z)
        k = max(1.0, reach / 6)
        here, shape = seen.found, (self.n_cameras, len(self.surface.frames))
        cell = rim.camera * shape[1] + rim.piece
        matched = here & (np.abs(left) < MATCHED)
        rho = np.where(here, left**2 / (1 + (left / MATCHED) ** 2), MATCHED**2)
        return RimRows(
            J[here],
            seen.distance[here],
            left[here],
            rim.length[here],
            (rim.length * (1 + (left / k) ** 2) ** -2)[here],
            cell[here],
            _by_cell(cell, rim.length, shape),
            _by_cell(cell[matched], rim.length[matched], shape),
            _by_cell(cell, rim.length * rho, shape),
        )

    def imagined(self, cameras: Sequence[Camera], q: Array, z: Array) -> Array:
        """J^T L J of a posture whose whole contour is found, every fourth row and column."""
        rim, J = self.outline(cameras, q, z, 4)
        H = np.zeros((len(z), len(z)))
        gram(J, rim.length, H)
        return H

    def normal(self, rows: RimRows, z: Array, noise: float) -> Normal:
        """What the rows of one posture, found at z, say of the unknowns themselves."""
        y = rows.d + rows.J @ np.where(self.drawn, z, 0.0)
        return Normal(rows.H / noise**2, rows.J.T @ (rows.weight * y) / noise**2)

    def solve(self, parts: Sequence[Normal]) -> Array:
        """z (size,) that fits the parts of all postures and the prior best, within bounds."""
        known = np.isfinite(self.variables.prior_std)
        S = self.scale
        prior = np.concatenate([known, np.ones(len(S) - len(known))])
        H = np.sum([part.H for part in parts], axis=0) * np.outer(S, S) + np.diag(prior)
        g = np.sum([part.g for part in parts], axis=0) * S
        # What is taken at its word has S = 0: a row of the identity, and stays zero.
        z = S * np.linalg.solve(H, g)
        bound = np.concatenate([self.variables.bound, np.full(len(S) - len(known), np.inf)])
        return np.clip(z, -bound, bound)


def _by_cell(cell: Ints, length: Array, shape: tuple[int, int]) -> Array:
    """Sums of lengths, (n_cameras, n_pieces)."""
    sums = np.bincount(cell, length, shape[0] * shape[1])
    return np.asarray(sums, dtype=np.float64).reshape(shape)


def noise_at(reach: float) -> float:
    """Pixels, of a pixel of contour that is looked for so far away."""
    return float(max(LEAST_NOISE, reach / 10) * np.sqrt(CORRELATED))


@kernel
def gram(J: Array, weight: Array, H: Array) -> None:
    """Add J^T W J to H (m, m); J (n, m) is mostly zero, a point lies on one patch in one camera."""
    n, m = J.shape
    there = np.empty(m, np.int64)
    for i in range(n):
        k = 0
        for a in range(m):
            there[k] = a
            k += J[i, a] != 0
        for a in there[:k]:
            pull = weight[i] * J[i, a]
            for b in there[:k]:
                H[a, b] += pull * J[i, b]
