"""How well imagined hands explain the images, as Vicente, Jamone, Bernardino 2016 measure it.

The pictures of all cameras are one long observation y (Eq. 16), so pixels are counted over all:

    silhouettes   p = s = #(R(y) and R(y^)) / #(R(y) or R(y^))                        Eq. 19-20
    edges         p = exp(-lambda d),  d = 1/k sum_i E(y^)(i) D(y)(i)                 Eq. 21-22

R is the mask, E(y^) the k edge pixels of the imagined image, D(y) the distance of every pixel to
the nearest Canny edge of the seen image, 0 to 255 pixels. The edges that are imagined are those of
the silhouette: a body of one colour has no others, and its folds depend on the light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.senses.images import Images, Picture
from bodyschema.vision.contours import fit_contours
from bodyschema.vision.observed import UNIT, ObservedMask, distance_to, row_sums
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

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

    def __call__(self, surface: Surface, T_cam_piece: Array, seen: Images, threads: int) -> Array:
        """See `Likelihood`."""
        edges = [_distances(picture) for picture in seen.pictures]
        fit = fit_contours(surface, T_cam_piece, seen.cameras, edges, True, threads)
        k = fit.boundary.sum(axis=1)
        d = fit.distance.sum(axis=1) / (UNIT * np.maximum(k, 1))
        return np.asarray(np.exp(-self.rate * np.where(k > 0, d, FARTHEST)))


def _distances(picture: Picture) -> ObservedMask:
    """The seen edges with D(y), in the place of a mask and the distances to its contour."""
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "finding edges") from None
    grey = picture.astype(np.uint8) * np.uint8(255) if picture.dtype == np.bool_ else picture
    if grey.ndim == 3:
        grey = cv2.cvtColor(grey, cv2.COLOR_RGB2GRAY)
    edges = np.asarray(cv2.Canny(cv2.blur(grey, (3, 3)), *CANNY)) > 0
    distance = row_sums(distance_to(edges, FARTHEST))
    return ObservedMask(edges, int(edges.sum()), row_sums(edges), distance, FARTHEST)
