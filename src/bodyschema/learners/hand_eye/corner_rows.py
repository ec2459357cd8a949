"""What corners on carried things say about cameras: rows, and the sums that are left of them.

A corner k sits at r_k, which nobody knows, on something whose pose in the world T is known at every
moment: the hand, another link, or the world itself (T = 1: a corner of the wall). The camera at
T_world_cam = (R, t) sees it at

    c = R^T (R_T r_k + p_T - t),    u = c_x + f c_1 / c_3,  v = c_y + f c_2 / c_3,
    d = f B / c_3   (disparity)

Rows are (u, v, d), not (u_left, v, u_right): what is wrong with the left place is wrong with the
right one too, and d has a smaller error of its own. With the camera moved by a twist xi, linear
before angular, in its own frame, dc = -v + [c]x w, and dc = R^T R_T dr_k.

Each corner's place is taken out of its own rows (Schur complement), so that what is left is about
the cameras alone, one set of sums a corner:

    S_k = H_cc - H_cr H_rr^-1 H_rc,      s_k = g_c - H_cr H_rr^-1 g_r
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

FIRM = 1e-6
"""1/m^2 added to what is known of a place, so that one row alone can be taken out as well."""


@dataclass(frozen=True)
class CornerRows:
    """Where corners were seen, one row a corner and moment; sorted by corner."""

    corner: Ints
    """(N,) name."""
    moment: Ints
    """(N,) number of the moment."""
    camera: Ints
    """(N,) which camera pose was in force, from 0."""
    T_world_carrier: Array
    """(N, 4, 4)."""
    seen: Array
    """(N, 3) u, v, disparity, px."""

    @staticmethod
    def none() -> CornerRows:
        """No rows."""
        zero = np.zeros(0, dtype=np.int64)
        return CornerRows(zero, zero, zero, np.zeros((0, 4, 4)), np.zeros((0, 3)))

    def __len__(self) -> int:
        return len(self.corner)

    def only(self, kept: Flags) -> CornerRows:
        """Some of them, (N,)."""
        return CornerRows(
            self.corner[kept], self.moment[kept], self.camera[kept], self.T_world_carrier[kept],
            self.seen[kept],
        )  # fmt: skip

    def joined(self, more: CornerRows) -> CornerRows:
        """Both, sorted by corner, each corner's rows in their order."""
        corner = np.concatenate([self.corner, more.corner])
        order = np.argsort(corner, kind="stable")
        return CornerRows(
            corner[order],
            np.concatenate([self.moment, more.moment])[order],
            np.concatenate([self.camera, more.camera])[order],
            np.concatenate([self.T_world_carrier, more.T_world_carrier])[order],
            np.concatenate([self.seen, more.seen])[order],
        )

    def in_camera(self, camera: Ints | int) -> CornerRows:
        """The same rows, said to be of other camera poses."""
        return replace(self, camera=np.broadcast_to(camera, self.corner.shape).astype(np.int64))

    def grouped(self) -> tuple[Ints, Ints, Ints]:
        """Names of the K corners, (K,) the first row of each, and (N,) the number of each row's."""
        names, first, which = np.unique(self.corner, return_index=True, return_inverse=True)
        return names, first, which.astype(np.int64)


@dataclass(frozen=True)
class CornerSums:
    """All rows round an estimate, worked off corner by corner."""

    S: Array
    """(K, 6 C, 6 C) information of each corner about C camera poses."""
    s: Array
    """(K, 6 C) its gradient, of half the weighted squares."""
    bias: Array
    """(3, 6 C) gradient of an error of 1 px that all rows of a kind have in common."""
    shift: Array
    """(K, 3) m: by which each place moves at the cameras that the sums are about."""
    back: Array
    """(K, 3, 6 C) how much more each place moves with the cameras."""
    residual: Array
    """(N, 3) px, seen minus predicted."""
    spread: Array
    """(K, 3, 3) covariance of each place when the cameras are known, m^2."""


def predicted(
    rows: CornerRows, cameras: Array, place: Array, stereo: Stereo
) -> tuple[Array, Array]:
    """(N, 3) u, v, d and (N, 3) m in the camera, of places (N, 3) on their carriers."""
    T, pose = rows.T_world_carrier, cameras[rows.camera]
    world = np.einsum("nij,nj->ni", T[:, :3, :3], place) + T[:, :3, 3]
    c = np.einsum("nji,nj->ni", pose[:, :3, :3], world - pose[:, :3, 3])
    f, z = stereo.focal, np.where(np.abs(c[:, 2]) > 1e-3, c[:, 2], 1e-3)
    u, v = stereo.centre[0] + f * c[:, 0] / z, stereo.centre[1] + f * c[:, 1] / z
    return np.column_stack([u, v, f * stereo.baseline / z]), c


def triangulated(seen: Array, stereo: Stereo) -> Array:
    """(N, 3) m in the camera of u, v, disparity (N, 3)."""
    z = stereo.focal * stereo.baseline / seen[:, 2]
    x, y = (seen[:, :2] - stereo.centre).T / stereo.focal
    return np.column_stack([x * z, y * z, z])


def places(rows: CornerRows, cameras: Array, stereo: Stereo) -> Array:
    """(K, 3) m: where each corner sits on its carrier, the mean over its rows."""
    _, first, which = rows.grouped()
    T = lie.inverse(rows.T_world_carrier) @ cameras[rows.camera]
    c = triangulated(rows.seen, stereo)
    on = np.einsum("nij,nj->ni", T[:, :3, :3], c) + T[:, :3, 3]
    return np.asarray(np.add.reduceat(on, first) / np.bincount(which)[:, None])


def summed(
    rows: CornerRows, cameras: Array, place: Array, weight: Array, stereo: Stereo
) -> CornerSums:
    """The sums of all rows.

    Args:
        rows: N of them, about K corners.
        cameras: (C, 4, 4) T_world_cam.
        place: (K, 3) m, of the corners on their carriers.
        weight: (N, 3) of each row, 1/px^2.
        stereo: the lens.
    """
    _, first, which = rows.grouped()
    expected, c = predicted(rows, cameras, place[which], stereo)
    e = rows.seen - expected
    Jc, Jr = _slopes(rows, cameras, c, stereo)
    C, K = len(cameras), len(place)
    wJc, wJr = weight[..., None] * Jc, weight[..., None] * Jr
    Hrr = np.add.reduceat(np.swapaxes(Jr, 1, 2) @ wJr, first) + FIRM * np.eye(3)
    gr = np.add.reduceat(np.einsum("nij,ni->nj", wJr, e), first)
    cc, cr = np.swapaxes(Jc, 1, 2) @ wJc, np.swapaxes(Jc, 1, 2) @ wJr
    gc = np.einsum("nij,ni->nj", wJc, e)
    Hcc, Hcr = np.zeros((K, 6 * C, 6 * C)), np.zeros((K, 6 * C, 3))
    g, b, br = np.zeros((K, 6 * C)), np.zeros((K, 6 * C, 3)), np.add.reduceat(wJr, first)
    for i in range(C):
        mine, span = (rows.camera == i).astype(float), slice(6 * i, 6 * i + 6)
        Hcc[:, span, span] = np.add.reduceat(cc * mine[:, None, None], first)
        Hcr[:, span] = np.add.reduceat(cr * mine[:, None, None], first)
        g[:, span] = np.add.reduceat(gc * mine[:, None], first)
        b[:, span] = np.swapaxes(np.add.reduceat(wJc * mine[:, None, None], first), 1, 2)
    spread = np.asarray(np.linalg.inv(Hrr), dtype=np.float64)
    gain = Hcr @ spread
    bias = b - gain @ np.swapaxes(br, 1, 2)
    return CornerSums(
        S=Hcc - gain @ np.swapaxes(Hcr, 1, 2),
        s=g - np.einsum("kij,kj->ki", gain, gr),
        bias=bias.sum(axis=0).T,
        shift=np.einsum("kij,kj->ki", spread, gr),
        back=-np.swapaxes(gain, 1, 2),
        residual=e,
        spread=spread,
    )


def _slopes(rows: CornerRows, cameras: Array, c: Array, stereo: Stereo) -> tuple[Array, Array]:
    """(N, 3, 6) of the rows by the camera's twist, and (N, 3, 3) by the corner's place."""
    f, z = stereo.focal, np.where(np.abs(c[:, 2]) > 1e-3, c[:, 2], 1e-3)
    D = np.zeros((len(c), 3, 3))
    D[:, 0, 0] = D[:, 1, 1] = f / z
    D[:, 0, 2], D[:, 1, 2] = -f * c[:, 0] / z**2, -f * c[:, 1] / z**2
    D[:, 2, 2] = -f * stereo.baseline / z**2
    R = np.swapaxes(cameras[rows.camera][:, :3, :3], 1, 2)
    Jc = np.concatenate([-D, D @ lie.skew(c)], axis=2)
    return Jc, D @ R @ rows.T_world_carrier[:, :3, :3]
