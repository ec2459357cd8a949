"""How well imagined hands explain the images, as Vicente, Jamone, Bernardino 2016 measure it.

The pictures of all cameras are one long observation y (Eq. 16), so pixels are counted over all:

    silhouettes   p = s = #(R(y) and R(y^)) / #(R(y) or R(y^))                        Eq. 19-20
    edges         p = exp(-lambda d),  d = 1/k sum_i E(y^)(i) D(y)(i)                 Eq. 21-22

R is the mask, E(y^) the k edge pixels of the imagined image, D(y) the distance of every pixel to
the nearest Canny edge of the seen image, 0 to 255 pixels. What edges are imagined is a setting:

    hand       those that the same detector finds in the shaded picture of the whole CAD model, as
               the paper renders it: outline, one part before another, creases (`vision.shaded`)
    outline    those of the silhouette alone, a hundred times as fast
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.senses.images import Images, Picture
from bodyschema.vision.contours import fit_contours
from bodyschema.vision.observed import UNIT, ObservedMask, distance_to, row_sums
from bodyschema.vision.shaded import corner_normals, shaded_image
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[Any]
Edges = Literal["hand", "outline"]

EDGES: dict[Edges, str] = {
    "hand": "all edges of the CAD hand",
    "outline": "edges of the outline alone",
}
"""What each says."""

FARTHEST = 255.0
"""pixels; the paper's distance images have 8 bits."""

CANNY = (65.0, 195.0)
"""Lower and upper threshold of Canny's edge detector, in grey levels, after a 3x3 blur."""


class Likelihood(Protocol):
    """p(y | theta, beta) of every hypothesis, up to a factor."""

    def __call__(self, surface: Surface, T_cam_piece: Array, seen: Images, threads: int) -> Array:
        """(n_hypotheses,) not negative.

        Args:
            surface: the visible body.
            T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 4, 4).
            seen: the pictures.
            threads: how many work; the result is the same for any number.
        """


@dataclass(frozen=True)
class SilhouetteLikelihood:
    """The Jaccard index itself, neither its exponential nor a power of it (Eq. 20)."""

    def __call__(self, surface: Surface, T_cam_piece: Array, seen: Images, threads: int) -> Array:
        """See `Likelihood`."""
        if not seen.masked:
            raise InputError("silhouettes are compared with masks (bool); use edges for images.")
        masks = [ObservedMask.of(picture) for picture in seen.pictures]
        fit = fit_contours(surface, T_cam_piece, seen.cameras, masks, False, threads)
        inside = fit.inside.sum(axis=1)
        union = fit.area.sum(axis=1) + fit.observed.sum() - inside
        return np.asarray(inside / np.maximum(union, 1))


@dataclass(frozen=True)
class EdgeLikelihood:
    """Falls with the mean distance of the imagined edges to seen ones (Eq. 21)."""

    rate: float = 0.01
    """lambda, 1/pixel, section 5.2 of the paper."""
    edges: Edges = "hand"
    """What is imagined: all edges of the model, as published, or its outline."""

    def __call__(self, surface: Surface, T_cam_piece: Array, seen: Images, threads: int) -> Array:
        """See `Likelihood`."""
        found = [_seen_edges(picture) for picture in seen.pictures]
        if self.edges == "outline":
            outlines = [_as_mask(edges) for edges in found]
            fit = fit_contours(surface, T_cam_piece, seen.cameras, outlines, True, threads)
            k, total = fit.boundary.sum(axis=1), fit.distance.sum(axis=1)
        else:
            k, total = _over_all_edges(surface, T_cam_piece, seen, found, threads)
        d = total / (UNIT * np.maximum(k, 1))
        return np.asarray(np.exp(-self.rate * np.where(k > 0, d, FARTHEST)))


def canny(picture: Picture) -> Flags:
    """Edge pixels (height, width) of a picture, as the paper finds them.

    Args:
        picture: (height, width) grey or boolean, or (height, width, 3) colours.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    cv2 = _cv2()
    grey = picture.astype(np.uint8) * np.uint8(255) if picture.dtype == np.bool_ else picture
    if grey.ndim == 3:
        grey = cv2.cvtColor(grey, cv2.COLOR_RGB2GRAY)
    return np.asarray(cv2.Canny(cv2.blur(grey, (3, 3)), *CANNY)) > 0


def _over_all_edges(
    surface: Surface,
    T_cam_piece: Array,
    seen: Images,
    found: Sequence[tuple[Flags, Ints]],
    threads: int,
) -> tuple[Ints, Ints]:
    """Edge pixels k of every hypothesis and the sum of their distances in 1/256 pixel; (n,)."""
    normals = corner_normals(surface)

    def counted(T: Array) -> tuple[int, int]:
        k, total = 0, 0
        for pose, camera, (_, distance) in zip(T, seen.cameras, found, strict=True):
            at = distance[canny(shaded_image(surface, normals, pose, camera))]
            k, total = k + at.size, total + int(at.sum(dtype=np.int64))
        return k, total

    with ThreadPoolExecutor(threads) as pool:
        counts = np.array(list(pool.map(counted, T_cam_piece)), dtype=np.int64)
    return counts[:, 0], counts[:, 1]


def _seen_edges(picture: Picture) -> tuple[Flags, Ints]:
    """The seen edges and D(y) in 1/256 pixel, both (height, width)."""
    edges = canny(picture)
    return edges, distance_to(edges, FARTHEST)


def _as_mask(found: tuple[Flags, Ints]) -> ObservedMask:
    """The seen edges with D(y), in the place of a mask and the distances to its contour."""
    edges, distance = found
    return ObservedMask(edges, int(edges.sum()), row_sums(edges), row_sums(distance), FARTHEST)


def _cv2() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "finding edges") from None
    return cv2
