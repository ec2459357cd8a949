"""Rows of least squares from the outline of a body in pictures of several postures.

For rim point i, found at the estimate x and looked for along its normal (see
`imagination.correspondences` and `imagination.normal_search`), with c its camera,

    r_i = d_i - J_i delta - b_c,        w_i = l_i (1 + (e_i / k)^2)^-2,   k = max(1, reach / 6)

d_i pixels outward, b_c the bias of camera c (a mask or an edge that lies outward by so much all
round the body), l_i the length of contour that the point stands for, e_i = d_i - b_c what is left
of d_i, and w_i the weight of Geman and McClure. Pixels along a contour err together; so do all
points of one piece in one picture when the mesh, the mask or the lens is wrong there. The sums of
w r J over such groups g tell by how much the information of independent points is too large:

    f = G / (G - 1) sum_g |H^-1/2 u_g|^2 / n,    u_g = sum_i in g w_i r_i J_i,  H = J^T W J

for n unknowns and G groups: pieces in pictures, or whole postures, whichever gives more.
J^T W J / f is the information of the data: f is the design effect of cluster sampling (Kish 1965;
Liang and Zeger 1986, here as one factor), with the noise level in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.camera import Camera
from bodyschema.body.parameters import Parameters
from bodyschema.body.tree import Body
from bodyschema.imagination.colours import ColourModel
from bodyschema.imagination.correspondences import Rim, find_rim, rim_slopes
from bodyschema.imagination.normal_search import Gradient, Outline, search_edges, search_masks
from bodyschema.imagination.poses import piece_poses
from bodyschema.imagination.surface import Surface
from bodyschema.senses.images import Images, Picture

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

MATCHED = 2.0
"""pixels; a rim point is matched when its outline was found within so much."""

LEAST_EFFECT = 0.27
"""pixels^2: 0.3 pixels that err together over 3 pixels of contour. Postures that are much alike
agree better than that, and are wrong together."""

BIAS_STD = 1.0
"""pixels, prior of the bias of a camera."""


@dataclass(frozen=True)
class Sight:
    """Pictures of one posture, ready to be searched."""

    q: Array
    """(n_joints,) encoder readings."""
    cameras: tuple[Camera, ...]
    masks: tuple[Picture, ...]
    """Masks of the body; empty where there are none."""
    slopes: tuple[Gradient, ...]
    """Without masks: slopes of the images, or of the evidence of colour."""
    polarity: float
    """+1, -1 or 0, see `search_edges`."""

    @classmethod
    def of(cls, seen: Images, colours: Sequence[ColourModel] = ()) -> Sight:
        """Prepare the pictures of one moment.

        Args:
            seen: masks or 8-bit images.
            colours: of each camera; without them the edges of images are used as they are.
        """
        if seen.masked:
            return cls(seen.q, seen.cameras, seen.pictures, (), 0.0)
        if not colours:
            return cls(seen.q, seen.cameras, (), tuple(map(Gradient.of, seen.pictures)), 0.0)
        evidence = [m.evidence(p) for m, p in zip(colours, seen.pictures, strict=True)]
        return cls(seen.q, seen.cameras, (), tuple(map(Gradient.of_evidence, evidence)), -1.0)

    def search(self, rim: Rim, reach: float) -> Outline:
        """Look for the outline within `reach` pixels."""
        if self.masks:
            return search_masks(rim, self.masks, reach)
        return search_edges(rim, self.slopes, reach, self.polarity)


@dataclass(frozen=True)
class RimRows:
    """The rim points of one posture whose outline was found."""

    J: Array
    """(n, n_parameters + n_cameras) pixels per unit; the last columns are of the biases."""
    d: Array
    """(n,) pixels outward."""
    weight: Array
    """(n,) w."""
    group: Ints
    """(n,) camera and piece."""
    length: float
    """pixels of contour that was looked for."""
    matched: float
    """pixels of it that were found within `MATCHED`."""

    @property
    def H(self) -> Array:
        """J^T W J."""
        return np.asarray(self.J.T @ (self.weight[:, None] * self.J))


@dataclass(frozen=True)
class Normal:
    """Normal equations H z = g of one posture, z = (x, b)."""

    H: Array
    """(n, n)"""
    g: Array
    """(n,)"""


@dataclass(frozen=True)
class RimModel:
    """What does not change while the parameters are fitted."""

    surface: Surface
    body: Body
    """Round which the parameters are charted."""
    parameters: Parameters

    def rows(self, sight: Sight, z: Array, reach: float, step: int = 1) -> RimRows:
        """Rows at z = (x, b).

        Args:
            sight: of one posture.
            z: (n_parameters + n_cameras,) deviations, then pixels.
            reach: pixels to either side.
            step: every how many rows and columns of the image.
        """
        n = len(self.parameters)
        x, bias = z[:n], z[n:]
        posed = self.body.with_parameters(self.parameters, x)
        T = piece_poses(posed, sight.q, sight.cameras, self.surface.frames)[0]
        rim = find_rim(self.surface, T, sight.cameras, step)
        slopes = rim_slopes(
            rim, self.surface, sight.cameras, self.body, self.parameters, x, sight.q
        )
        seen = sight.search(rim, reach)
        left = np.abs(seen.distance - bias[rim.camera])
        k = max(1.0, reach / 6)
        here = seen.found
        own = np.eye(len(bias))[rim.camera]
        return RimRows(
            np.hstack([slopes.by_parameter, own])[here],
            seen.distance[here],
            (rim.length * (1 + (left / k) ** 2) ** -2)[here],
            (rim.camera * len(self.surface.frames) + rim.piece)[here],
            float(rim.length.sum()),
            float(rim.length[here & (left < MATCHED)].sum()),
        )

    def imagined(self, cameras: Sequence[Camera], q: Array, z: Array) -> Array:
        """J^T L J of a posture whose whole contour is found, every fourth row and column."""
        n = len(self.parameters)
        posed = self.body.with_parameters(self.parameters, z[:n])
        T = piece_poses(posed, q, cameras, self.surface.frames)[0]
        rim = find_rim(self.surface, T, cameras, 4)
        slopes = rim_slopes(rim, self.surface, cameras, self.body, self.parameters, z[:n], q)
        J = np.hstack([slopes.by_parameter, np.eye(len(z) - n)[rim.camera]])
        return np.asarray(J.T @ (rim.length[:, None] * J))

    def normal(self, rows: RimRows, z: Array, noise: float) -> Normal:
        """What the rows of one posture, found at z, say of the unknowns themselves."""
        n = len(self.parameters)
        y = rows.d + rows.J[:, :n] @ z[:n]
        return Normal(rows.H / noise**2, rows.J.T @ (rows.weight * y) / noise**2)

    def solve(self, parts: Sequence[Normal], n_cameras: int) -> Array:
        """z (n_parameters + n_cameras,) that fits the parts and the prior best, within bounds.

        Args:
            parts: of all postures.
            n_cameras: how many biases there are.
        """
        scale = self.scale(n_cameras)
        H = np.sum([part.H for part in parts], axis=0) + np.diag(self.prior(n_cameras))
        g = np.sum([part.g for part in parts], axis=0)
        z = scale * np.linalg.solve(H * np.outer(scale, scale), g * scale)
        bound = np.concatenate([self.parameters.bound, np.full(n_cameras, np.inf)])
        return np.clip(z, -bound, bound)

    def prior(self, n_cameras: int) -> Array:
        """Information of the prior, (n_parameters + n_cameras,)."""
        return np.concatenate([self.parameters.prior_std, np.full(n_cameras, BIAS_STD)]) ** -2.0

    def scale(self, n_cameras: int) -> Array:
        """Units that make the unknowns comparable, (n_parameters + n_cameras,)."""
        return np.concatenate([self.parameters.scale, np.full(n_cameras, BIAS_STD)])


def design_effect(rows: Sequence[RimRows], z: Array, n_parameters: int) -> float:
    """f, pixels^2: what J^T W J of all rows has to be divided by."""
    b = np.concatenate([np.zeros(n_parameters), z[n_parameters:]])
    pulls = [r.J * (r.weight * (r.d - r.J @ b))[:, None] for r in rows]
    by_piece = [
        pull[r.group == g].sum(axis=0)
        for r, pull in zip(rows, pulls, strict=True)
        for g in np.unique(r.group)
    ]
    values, vectors = np.linalg.eigh(np.sum([r.H for r in rows], axis=0))
    told = values > 1e-9 * values[-1]
    found = [LEAST_EFFECT]
    for u in (by_piece, [pull.sum(axis=0) for pull in pulls]):
        if len(u) > 1 and told.any():
            white = (np.array(u) @ vectors[:, told]) / np.sqrt(values[told])
            found.append(len(u) / (len(u) - 1) * float(np.sum(white**2)) / int(told.sum()))
    return max(found)


def without_bias(information: Array, n_parameters: int) -> Array:
    """Information of the parameters when the biases are not known either (Schur complement).

    Args:
        information: of both, the prior of the biases included.
        n_parameters: how many rows come first.
    """
    A, B = information[:n_parameters, :n_parameters], information[:n_parameters, n_parameters:]
    H = A - B @ np.linalg.solve(information[n_parameters:, n_parameters:], B.T)
    return np.asarray((H + H.T) / 2)
