"""Corners found in one picture, and how well the picture tells each.

A corner is where all gradients of its surroundings point past it (Foerstner and Guelch 1987): with
g the gradients in a window and s the noise of a pixel,

    C = s^2 (sum g g^T)^-1 + FLOOR^2 1            px^2

s is that of the second differences of the picture, which no straight edge has (Immerkaer 1996).
Blur spreads an edge, which makes its gradients small: a smeared corner says so itself.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.targets.spread import LEAST_HALF, NO_CORNER, in_no_order, spreads

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Grey = NDArray[np.uint8]

HALF = 5
"""px; the window about a corner is 2 HALF + 1 wide, that about a circle reaches half way to the
next."""

LEAST_NOISE = 0.5
"""Grey levels: rounding to whole ones and what pictures were compressed by."""

FLOOR = 0.05
"""px: what detectors are off by in pictures without noise, from edges that fall between pixels."""

BESIDE = 0.5
"""px: half the width of an edge, which a window that is free of it keeps from it."""

FLAT = 1e-6
"""Least sum of squared gradients: of a window without any edge the covariance is huge, not nan."""


@dataclass(frozen=True)
class Found:
    """Corners of one picture."""

    ids: Ints
    """(m,) which corners of the target."""
    image: Array
    """(m, 2) px; (0, 0) is the centre of the top-left pixel."""
    covariance: Array
    """(m, 2, 2) px^2 of each, as stated above."""
    blur: float = 0.0
    """px: the middle one of the spreads of edges about the corners (`spread`); 0 where other edges
    are too near to tell, and for circles."""
    rejected: Array = field(default_factory=lambda: np.empty((0, 2)))
    """(k, 2) px: what the detector took for corners, and no edges meet there."""

    @classmethod
    def of(
        cls, grey: Grey, ids: Ints, image: Array, round_ones: bool = False, clear: float = 1.0
    ) -> Self:
        """Corners, or middles of circles, with what the picture says of their errors.

        Args:
            grey: (height, width).
            ids: (m,) which corners.
            image: (m, 2) px.
            round_ones: circles, whose edges do not meet.
            clear: share of the way to the next corner on which there is no other edge.
        """
        if round_ones:
            return cls(ids, image, covariances(grey, image, _half_way(image)))
        reach = clear * _to_the_next(image) - BESIDE if len(image) > 1 else float(HALF)
        half = int(np.clip(reach, LEAST_HALF, HALF))
        passing = spreads(grey, image, half)
        clean = reach >= LEAST_HALF
        # The rims of tags nearby pass at a distance too, though not like edges in no order.
        good = passing < (NO_CORNER if clean else 1.0) * in_no_order(half)
        blur = float(np.median(passing)) if clean else 0.0
        error = covariances(grey, image[good], HALF)
        return cls(ids[good], image[good], error, blur, image[~good])

    def taken(self, order: Ints) -> Self:
        """The same with other numbers for the corners: number i becomes order[i]."""
        return replace(self, ids=order[self.ids])

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def std(self) -> Array:
        """(m,) px, of each corner in the worse direction."""
        return np.asarray(np.sqrt(np.linalg.eigvalsh(self.covariance)[:, 1]))


def _half_way(image: Array) -> int:
    """Half the way to the nearest neighbour, the middle one of all, px."""
    return max(HALF, round(_to_the_next(image) / 2)) if len(image) > 1 else HALF


def _to_the_next(image: Array) -> float:
    """px from a corner to the nearest other one, the middle of all."""
    apart = np.linalg.norm(image[:, None] - image, axis=2)
    return float(np.median(np.sort(apart, axis=1)[:, 1]))


def covariances(grey: Grey, image: Array, half: int = HALF) -> Array:
    """Covariance of each corner of a picture, (m, 2, 2) px^2; see above."""
    picture = grey.astype(np.float64)
    by_v, by_u = np.gradient(picture, axis=0), np.gradient(picture, axis=1)
    noise = grey_noise(picture)
    out = np.empty((len(image), 2, 2))
    height, width = grey.shape
    for k, (u, v) in enumerate(np.rint(image).astype(int)):
        rows = slice(max(v - half, 0), min(v + half + 1, height))
        columns = slice(max(u - half, 0), min(u + half + 1, width))
        g = np.stack([by_u[rows, columns].ravel(), by_v[rows, columns].ravel()])
        out[k] = noise**2 * np.linalg.inv(g @ g.T + FLAT * np.eye(2)) + FLOOR**2 * np.eye(2)
    return out


def grey_noise(picture: Array) -> float:
    """Noise of a pixel in grey levels, the median over the picture: (height, width) -> s."""
    p = picture
    second = p[:-2] - 2 * p[1:-1] + p[2:]
    mixed = second[:, :-2] - 2 * second[:, 1:-1] + second[:, 2:]
    # 36 = sum of squares of the mask; 0.6745 makes a median of |x| a standard deviation.
    return max(float(np.median(np.abs(mixed))) / (0.6745 * 6.0), LEAST_NOISE)
