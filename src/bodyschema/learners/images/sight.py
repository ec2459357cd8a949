"""Sight: the pictures of one posture, ready to be searched for the outline of the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.camera import Camera
from bodyschema.senses.images import Images, Picture
from bodyschema.vision.colours import ColourModel
from bodyschema.vision.correspondences import Rim
from bodyschema.vision.normal_search import Gradient, Outline, search_edges, search_masks

Array = NDArray[np.float64]


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
