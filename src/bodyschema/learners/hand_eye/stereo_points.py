"""Points on the hand or in the room, tracked by a rectified stereo camera: rows linear in unknowns.

A point at r in the hand is seen at c in the camera while the hand is at T_world_hand = (R_h, p):

    R c + r_o = R_h r + p,   T_world_cam = (R, r_o)                                        (1)

which the paper writes as [c_x 1, c_y 1, c_z 1, 1, -R_h, -p] [vec R; r_o; r; 1] = 0 (Nabeshima and
Kuniyoshi, Eq. 34): `triangulated_rows`, N = 16. The noise of c sits in nine columns.

Forty monomials avoid triangulation. With M = R^T and u = M r_o the point in the camera is

    y = M p + sum_k r_k M R_h[:, k] - u = (k_X^T x, k_Y^T x, k_Z^T x),
    x = [vec M, r_1 vec M, r_2 vec M, r_3 vec M, u, 1]       (vec by rows, 40 entries)

and each measured coordinate of a camera with focal length f and baseline B gives one row,

    a_1 = k_X - l k_Z,  a_2 = k_Y - v k_Z,  a_3 = k_X - B e_1 - r k_Z,   times f / (sigma Z_w),

l, v, r the normalised pixels, sigma their noise, Z_w any depth near the true one, used as a weight.
At the true x each row is pixel noise over sigma, independent if the pixels are. A pixel error n
enters a row as n k_Z / Z_w, so sum A^T A carries sum 3 k_Z k_Z^T / Z_w^2 on average (3 rows).

A camera on a moving head that looks at a fixed point q of the room is the same equation with
T_world_hand replaced by T_head_world, R by the camera's rotation in the head, r by q: `head_eye`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MONOMIALS = 40

NEAREST = 1.0
"""pixels of disparity below which a point counts as not seen in stereo."""


@dataclass(frozen=True)
class Stereo:
    """A rectified pair of cameras; the left one carries the camera frame."""

    focal: float
    """pixels"""
    centre: tuple[float, float]
    """pixels: (c_x, c_y) of both."""
    baseline: float
    """m"""
    noise: float
    """pixels: standard deviation of every measured coordinate."""

    def __post_init__(self) -> None:
        if not all(0 < size < np.inf for size in (self.focal, self.baseline, self.noise)):
            raise InputError(
                "a stereo camera needs focal length, baseline and noise above zero; got "
                f"{self.focal}, {self.baseline} and {self.noise}."
            )

    @property
    def numbers(self) -> Array:
        """(5,) f, c_x, c_y, B, sigma for the kernels."""
        return np.array([self.focal, *self.centre, self.baseline, self.noise])

    def project(self, c: Array) -> Array:
        """Pixels (*batch, 3) u_left, v, u_right of points (*batch, 3) in the camera, in m."""
        scale = self.focal / c[..., 2]
        return np.stack(
            [
                self.centre[0] + scale * c[..., 0],
                self.centre[1] + scale * c[..., 1],
                self.centre[0] + scale * (c[..., 0] - self.baseline),
            ],
            axis=-1,
        )

    def depth(self, pixels: Array) -> Array:
        """(*batch,) m from the disparity; nan where there is hardly any."""
        disparity = pixels[..., 0] - pixels[..., 2]
        with np.errstate(invalid="ignore"):
            useful = np.where(disparity > NEAREST, disparity, np.nan)
        return np.asarray(self.focal * self.baseline / useful)

    def triangulate(self, pixels: Array) -> Array:
        """(*batch, 3) m: the point in the camera; nan where there is no depth."""
        z = self.depth(pixels)
        x = (pixels[..., 0] - self.centre[0]) / self.focal
        y = (pixels[..., 1] - self.centre[1]) / self.focal
        return np.stack([x * z, y * z, z], axis=-1)


@dataclass(frozen=True)
class StereoPoints:
    """One moment: where the hand was and where its tracked points were seen."""

    time: float
    """s"""
    T_world_hand: Array
    """(4, 4)."""
    pixels: Array
    """(K, 3) u_left, v, u_right of each point; nan where it was not seen."""


def head_eye(time: float, T_world_head: Array, pixels: Array) -> StereoPoints:
    """A moment of a camera on a moving head that watches fixed points of the room.

    What is learned from such moments is T_head_cam and the points in the world.
    """
    return StereoPoints(time, lie.inverse(T_world_head), pixels)


def without(sample: StereoPoints, lost: Flags) -> StereoPoints:
    """The moment without some of its points, (K,)."""
    return replace(sample, pixels=np.where(lost[:, None], np.nan, sample.pixels))


def triangulated_rows(T_world_hand: Array, c: Array) -> Array:
    """A of Eq. 34, (3, 16), in m, from a triangulated point c (3,) in the camera."""
    one = np.eye(3)
    R_h, p = T_world_hand[:3, :3], T_world_hand[:3, 3:]
    return np.hstack([c[0] * one, c[1] * one, c[2] * one, one, -R_h, -p])


@kernel
def monomial_rows(T: Array, pixel: Array, depth: float, stereo: Array, A: Array) -> None:
    """The three white rows of one point into A (3, 40); `stereo` is `Stereo.numbers`."""
    f, B = stereo[0], stereo[3]
    weight = f / (stereo[4] * depth)
    seen = np.empty(3)
    seen[0] = (pixel[0] - stereo[1]) / f
    seen[1] = (pixel[1] - stereo[2]) / f
    seen[2] = (pixel[2] - stereo[1]) / f
    A[:] = 0.0
    for row in range(3):
        slot = 1 if row == 1 else 0
        for i in range(3):
            A[row, 3 * slot + i] += weight * T[i, 3]
            A[row, 6 + i] -= weight * seen[row] * T[i, 3]
            for k in range(3):
                A[row, 9 + 9 * k + 3 * slot + i] += weight * T[i, k]
                A[row, 9 + 9 * k + 6 + i] -= weight * seen[row] * T[i, k]
        A[row, 36 + slot] -= weight
        A[row, 38] += weight * seen[row]
    A[2, 39] = -weight * B


@kernel
def depth_row(T: Array, k_Z: Array) -> None:
    """k_Z (40,) of the module's text: depth in the camera = k_Z^T x."""
    k_Z[:] = 0.0
    for i in range(3):
        k_Z[6 + i] = T[i, 3]
        for k in range(3):
            k_Z[9 + 9 * k + 6 + i] = T[i, k]
    k_Z[38] = -1.0
