"""Colours of the body and of what is around it: evidence where there is no mask.

With h_f and h_b the histograms of colour inside and outside of the body, each mixed with a share
epsilon of their mean so that a colour seen nowhere says nothing,

    l(x) = log p_f(c(x)) - log p_b(c(x)),    p = (1 - epsilon) h + epsilon (h_f + h_b) / 2

is the evidence of pixel x, and sum of l over the silhouette the log likelihood of a hypothesis, up
to a constant that all share (Prisacariu, Reid 2012, "PWP3D", Eq. 5-8, with hard regions). The
histograms come from a picture with a silhouette that is about right: pixels within a margin of its
contour are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.vision.observed import UNIT, contour_of, distance_to, row_sums

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

BITS = {1: 6, 3: 4}
"""Bits of each channel that are kept, by the number of channels."""

MARGIN = 3.0
"""pixels"""

EPSILON = 0.05
"""Share of the mean histogram; bounds the evidence of a pixel by log(2 / epsilon)."""


@dataclass(frozen=True)
class ColourModel:
    """How much every colour speaks for the body."""

    evidence_of: Array
    """(n_colours,) l of each cell of the histogram."""
    channels: int
    """1 for grey, 3 for colour."""

    @classmethod
    def learn(cls, image: ArrayLike, silhouette: Flags, margin: float = MARGIN) -> ColourModel:
        """Learn from one view.

        Args:
            image: (height, width) grey or (height, width, 3), 8 bit, without distortion.
            silhouette: (height, width) where the body is thought to be.
            margin: pixels on either side of its contour that are left out.

        Raises:
            InputError: shapes differ, or body or surroundings have no pixel left.
        """
        cells, channels = _cells(image)
        inside = np.asarray(silhouette, dtype=bool)
        if inside.shape != cells.shape:
            raise InputError(f"the image is {cells.shape}, the silhouette {inside.shape}.")
        sure = distance_to(contour_of(inside), margin + 1) > margin * UNIT
        body, rest = cells[inside & sure], cells[~inside & sure]
        if not len(body) or not len(rest):
            raise InputError(
                f"the silhouette leaves {len(body)} pixels to the body and {len(rest)} to what is "
                "around it; learn from a view that shows both."
            )
        n_cells = 1 << (BITS[channels] * channels)
        h_f = np.bincount(body, minlength=n_cells) / len(body)
        h_b = np.bincount(rest, minlength=n_cells) / len(rest)
        mean = (h_f + h_b) / 2
        known = mean > 0
        evidence = np.zeros(n_cells)
        p_f, p_b = ((1 - EPSILON) * h[known] + EPSILON * mean[known] for h in (h_f, h_b))
        evidence[known] = np.log(p_f / p_b)
        return cls(evidence, channels)

    def evidence(self, image: ArrayLike) -> Array:
        """l of every pixel, (height, width)."""
        cells, channels = _cells(image)
        if channels != self.channels:
            raise InputError(f"learned from {self.channels} channels, the image has {channels}.")
        return np.asarray(self.evidence_of[cells])


@dataclass(frozen=True)
class ObservedColours:
    """The evidence of one view, summed along its rows like a mask."""

    evidence: Array
    """(height, width) l."""
    row_sums: NDArray[np.int32]
    """(height, width + 1) sums of l left of each column, in 1/256."""
    most: int
    """Sum of all positive l, in 1/256: what a perfect silhouette would collect."""

    @classmethod
    def of(cls, image: ArrayLike, model: ColourModel) -> ObservedColours:
        """Prepare a view."""
        evidence = model.evidence(image)
        whole = np.rint(evidence * UNIT).astype(np.int32)
        return cls(evidence, row_sums(whole), int(whole[whole > 0].sum()))


def _cells(image: ArrayLike) -> tuple[Ints, int]:
    """Cell of the histogram of every pixel, (height, width), and the number of channels."""
    seen: NDArray[Any] = np.asarray(image)
    seen = seen[..., None] if seen.ndim == 2 else seen
    if seen.dtype != np.uint8 or seen.ndim != 3 or seen.shape[2] not in BITS:
        raise InputError(
            "expected an 8-bit image (height, width) or (height, width, 3), got "
            f"{seen.dtype} of shape {np.shape(image)}."
        )
    channels = seen.shape[2]
    kept = seen.astype(np.int64) >> (8 - BITS[channels])
    return kept @ (1 << (BITS[channels] * np.arange(channels))), channels
