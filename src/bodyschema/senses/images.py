"""Images: what the cameras of the robot saw at one moment, and what its encoders said then.

There is no closed-form residual: an image is compared with imagined ones (`bodyschema.vision`)
by the learner that uses it. A picture is either a mask of the body (bool), where the background can
be told apart, or the image itself (8 bit), of which edges or colours are used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera

Array = NDArray[np.float64]
Picture = NDArray[Any]
"""(height, width) bool, or (height, width) or (height, width, channels) uint8."""


@dataclass(frozen=True)
class Images:
    """One picture from each camera at one moment."""

    time: float
    """s"""
    q: Array
    """(n_joints,) encoder readings in the order of `body.joints`, rad or m."""
    cameras: tuple[Camera, ...]
    """Their frames are frames of the body; without distortion (`Camera.undistort`)."""
    pictures: tuple[Picture, ...]
    """One for each camera."""

    def __post_init__(self) -> None:
        if self.q.ndim != 1 or not np.isfinite(self.q).all():
            raise InputError(f"expected finite readings (n_joints,), got {self.q!r}.")
        if not self.cameras or len(self.cameras) != len(self.pictures):
            raise InputError(
                f"there are {len(self.cameras)} cameras and {len(self.pictures)} pictures; give "
                "one picture from each camera."
            )
        for camera, picture in zip(self.cameras, self.pictures, strict=True):
            _check(camera, picture)

    @property
    def masked(self) -> bool:
        """Whether the pictures are masks."""
        return all(picture.dtype == np.bool_ for picture in self.pictures)


def _check(camera: Camera, picture: Picture) -> None:
    if picture.dtype not in (np.bool_, np.uint8) or picture.ndim not in (2, 3):
        raise InputError(
            f"camera '{camera.name}' gave an array {picture.dtype} of shape {picture.shape}; give "
            "a mask (bool) or an 8-bit image."
        )
    if picture.shape[:2] != (camera.height, camera.width):
        raise InputError(
            f"camera '{camera.name}' has {camera.width} x {camera.height} pixels, and its picture "
            f"{picture.shape[1]} x {picture.shape[0]}; give the lens of these pictures."
        )
    if camera.bends:
        raise InputError(
            f"camera '{camera.name}' has lens distortion; straighten its pictures with "
            "Camera.undistort and give a camera without."
        )
