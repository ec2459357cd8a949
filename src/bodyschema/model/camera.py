"""Cameras: pinhole or fisheye with OpenCV's distortion, fixed to a frame of the body.

A point (x, y, z) in the optical frame (z forward, x right, y down) has the normalised coordinates
a = x / z, b = y / z, r^2 = a^2 + b^2. The lens moves them to

    s  = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
    a' = s a + 2 p1 a b + p2 (r^2 + 2 a^2) + s1 r^2 + s2 r^4
    b' = s b + p1 (r^2 + 2 b^2) + 2 p2 a b + s3 r^2 + s4 r^4

and the pixel is K (a', b', 1). Coefficients come in OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2
s3 s4, of which the first 0, 4, 5, 8 or 12 are given; a fisheye has k1 k2 k3 k4 or none, and bends
as `distortion` says. Pixel (0, 0) is the centre of the top-left
pixel.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.distortion import FISHEYE, MODELS

Array = NDArray[np.float64]

COUNTS = (0, 4, 5, 8, 12)
"""How many distortion coefficients there may be."""

OF_FISHEYE = (0, 4)
"""The same of a fisheye."""


@dataclass(frozen=True)
class Camera:
    """What turns points before an optical frame into pixels."""

    name: str
    frame: str
    """Frame of the body that is the optical frame; `Body.attach` adds one that is missing."""
    width: int
    """pixels"""
    height: int
    """pixels"""
    matrix: Array
    """(3, 3) K: f_x, f_y, c_x, c_y in pixels, no skew."""
    distortion: Array = field(default_factory=lambda: np.zeros(0))
    """(k,) in OpenCV's order; empty for none."""
    fisheye: bool = False
    """Whether the lens is equidistant: then so is one without coefficients."""

    def __post_init__(self) -> None:
        K = np.array(self.matrix, dtype=np.float64)
        lens = np.array(self.distortion, dtype=np.float64).reshape(-1)
        if K.shape != (3, 3) or not np.isfinite(K).all() or K[0, 0] <= 0 or K[1, 1] <= 0:
            raise InputError(f"camera '{self.name}' needs a 3x3 matrix with f_x, f_y > 0; got {K}.")
        if K[0, 1] or K[1, 0] or (K[2] != (0, 0, 1)).any():
            raise InputError(
                f"the matrix of camera '{self.name}' has skew or a wrong last row: {K}."
            )
        if len(lens) not in (OF_FISHEYE if self.fisheye else COUNTS) or not np.isfinite(lens).all():
            raise InputError(
                f"camera '{self.name}' has {len(lens)} distortion coefficients; give "
                "0, 4, 5, 8 or 12 finite ones (k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4), of a fisheye "
                "0 or 4 (k1 k2 k3 k4)."
            )
        if self.width < 1 or self.height < 1:
            raise InputError(
                f"camera '{self.name}' has an image of {self.width} x {self.height} pixels."
            )
        object.__setattr__(self, "matrix", K)
        object.__setattr__(self, "distortion", lens)

    @classmethod
    def from_fov(cls, name: str, frame: str, width: int, height: int, fov: float) -> Camera:
        """An ideal camera with square pixels and the axis in the middle of the image.

        Args:
            name: of the camera.
            frame: its optical frame.
            width: pixels.
            height: pixels.
            fov: angle of view from the left to the right edge of the image, rad.
        """
        f = width / 2 / np.tan(fov / 2)
        K = np.array([[f, 0.0, (width - 1) / 2], [0.0, f, (height - 1) / 2], [0.0, 0.0, 1.0]])
        return cls(name, frame, width, height, K)

    @property
    def intrinsics(self) -> Array:
        """(4,) f_x, f_y, c_x, c_y in pixels."""
        return self.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]

    @property
    def bends(self) -> bool:
        """Whether straight lines look bent."""
        return self.fisheye or bool(self.distortion.any())

    def project(self, points: ArrayLike) -> Array:
        """Pixels of points in the optical frame, with distortion: (*b, 3) m -> (*b, 2).

        Points at z <= 0 are not in any image; what comes back for them has no meaning.
        """
        p = np.asarray(points, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = p[..., :2] / p[..., 2:]
            bent = self._distort(plane) if self.bends else plane
        f_x, f_y, c_x, c_y = self.intrinsics
        return np.asarray(bent * (f_x, f_y) + (c_x, c_y))

    def undistort(self, image: NDArray[Any]) -> NDArray[Any]:
        """The image that the same camera would take without distortion: same size, same K.

        The image is straightened once, instead of bending every imagined contour: in a straight
        image the edges of a mesh stay straight, so the rows of its silhouette are exact, and the
        cost does not grow with the number of hypotheses. Boolean masks take the nearest pixel,
        other images are interpolated; what was not seen is 0.

        Args:
            image: (height, width) or (height, width, channels).
        """
        if image.shape[:2] != (self.height, self.width):
            raise InputError(
                f"camera '{self.name}' has {self.width} x {self.height} pixels, and its picture "
                f"{' x '.join(map(str, image.shape[1::-1]))}; give the lens of these pictures."
            )
        if not self.bends:
            return image
        try:
            import cv2
        except ImportError:
            raise MissingExtraError("opencv-python-headless", "vision", "undistorting") from None
        v, u = np.mgrid[: self.height, : self.width].astype(np.float64)
        f_x, f_y, c_x, c_y = self.intrinsics
        rays = np.stack([(u - c_x) / f_x, (v - c_y) / f_y, np.ones_like(u)], axis=-1)
        columns, rows = np.moveaxis(self.project(rays).astype(np.float32), -1, 0)
        binary = image.dtype == np.bool_
        straight = cv2.remap(
            image.view(np.uint8) if binary else image,
            np.ascontiguousarray(columns),
            np.ascontiguousarray(rows),
            cv2.INTER_NEAREST if binary else cv2.INTER_LINEAR,
        )
        return np.asarray(straight.view(np.bool_) if binary else straight)

    def scaled(self, width: int, height: int) -> Camera:
        """The camera of the same image shrunk or stretched to another size in pixels."""
        a, b = width / self.width, height / self.height
        f_x, f_y, c_x, c_y = self.intrinsics
        K = np.diag([a * f_x, b * f_y, 1.0])
        K[:2, 2] = a * (c_x + 0.5) - 0.5, b * (c_y + 0.5) - 0.5
        return replace(self, width=width, height=height, matrix=K)

    def _distort(self, plane: Array) -> Array:
        """Normalised coordinates as the lens bends them, (*b, 2) -> (*b, 2)."""
        if self.fisheye:
            k = np.pad(self.distortion, (0, OF_FISHEYE[-1] - len(self.distortion)))
            flat = MODELS[FISHEYE].bend(k, plane.reshape(-1, 2))
            return np.asarray(flat.reshape(plane.shape))
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = np.pad(
            self.distortion, (0, COUNTS[-1] - len(self.distortion))
        )
        a, b = plane[..., 0], plane[..., 1]
        r2 = a * a + b * b
        s = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        bent_a = s * a + 2 * p1 * a * b + p2 * (r2 + 2 * a * a) + r2 * (s1 + r2 * s2)
        bent_b = s * b + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b + r2 * (s3 + r2 * s4)
        return np.stack([bent_a, bent_b], axis=-1)
