"""Views: pictures of one camera, each ready to be searched for the outline of the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.senses.images import Picture
from bodyschema.vision.correspondences import Rim
from bodyschema.vision.normal_search import Gradient, Outline, search_edges, search_masks

Array = NDArray[np.float64]

STILL = 2e-4
"""m and 1: poses nearer than this draw the same pixels, about a tenth of one at arm's length."""


@dataclass(frozen=True)
class View:
    """One picture, and where the joints were."""

    picture: Picture | Gradient | None
    """A mask of the body, or the slopes of an image; None for a view that is only imagined."""
    time: float
    """s"""
    row: int
    """In the recording, for messages."""
    q: Array
    """(n_joints,) encoder readings."""
    rate: Array | None
    """(n_joints,) dq/dt."""

    def search(self, rim: Rim, reach: float, polarity: float) -> Outline:
        """Look for the outline within `reach` pixels of the rim; an imagined one lies on it."""
        if self.picture is None:
            return Outline(np.zeros(len(rim)), np.ones(len(rim), dtype=bool))
        if isinstance(self.picture, Gradient):
            return search_edges(rim, [self.picture], reach, polarity)
        return search_masks(rim, [self.picture], reach)


def ready(picture: Picture | Gradient, camera: Camera) -> Picture | Gradient:
    """A picture without distortion: a mask as it is, an image by its slopes.

    Raises:
        InputError: neither a mask nor an 8-bit image of the camera's size.
    """
    if isinstance(picture, Gradient):
        return picture
    if picture.dtype not in (np.bool_, np.uint8) or picture.ndim not in (2, 3):
        raise InputError(
            f"camera '{camera.name}' gave an array {picture.dtype} of shape {picture.shape}; give "
            "a mask (bool) or an 8-bit image."
        )
    straight = camera.undistort(picture)
    return straight if straight.dtype == np.bool_ else Gradient.of(straight)


def moved(T: Array, before: Sequence[Array]) -> NDArray[np.bool_]:
    """Which pieces, posed as T (n_pieces, 4, 4), stand as in none of the pictures before."""
    still = [(np.abs(T - other) < STILL).all(axis=(1, 2)) for other in before]
    return np.asarray(~np.any([np.zeros(len(T), dtype=bool), *still], axis=0))
