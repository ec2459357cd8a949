"""Contour correspondences: what the outline of a body says about its joints and parameters.

A point X of the surface on the outer contour (the rim) is seen at pi(X), where the outline has the
outward normal n. The outline moves along n as the material point does,

    n^T d(contour) = n^T d pi/dX (v + w x X'),

(v, w) the twist of the piece in the camera and X' the vector from the origin of its frame to X:
where the rim slips along the surface it moves along the line of sight and along the outline, and
neither shows in the normal direction. So the rows of least squares are

    J_q = n^T P [1, -[X']x] T_q,     J_x = n^T P [1, -[X']x] T_x,
    P = 1/z [f_x, 0, -f_x x/z; 0, f_y, -f_y y/z]

with T_q, T_x the derivatives of T_cam_piece: of joints, of the body, and of the camera's own frame.
If the observed outline lies d pixels outward of the imagined one, d = J delta.

Which points are on the outer contour is told by `rim`; here their places are computed anew in
double precision. On an edge from A to B that is cut by a line of the image at the share t of its
length in the picture, X = A + s (B - A) with s = t z_A / (t z_A + (1 - t) z_B), as 1/z is linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import PoseDerivatives, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.vision.contours import NEAR
from bodyschema.vision.rim import collect
from bodyschema.vision.surface import Surface
from bodyschema.vision.views import CAPACITY

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Rim:
    """Points of the outer contour of a body in all views."""

    camera: Ints
    """(n,) index of the view."""
    piece: Ints
    """(n,) index of the piece that makes the contour there."""
    point: Array
    """(n, 3) m, in the frame of the piece."""
    pixel: Array
    """(n, 2)"""
    normal: Array
    """(n, 2) unit, outward."""
    length: Array
    """(n,) pixels of contour that the point stands for."""

    def __len__(self) -> int:
        return len(self.camera)


@dataclass(frozen=True)
class RimSlopes:
    """How the contour moves outward, pixels per unit."""

    by_joint: Array
    """(n, n_joints), with respect to the encoder readings."""
    by_parameter: Array
    """(n, n_parameters)."""


def find_rim(
    surface: Surface,
    T_cam_piece: ArrayLike,
    cameras: Sequence[Camera],
    step: int = 1,
    near: float = NEAR,
) -> Rim:
    """Points of the outer contour of one body, one for every row or column that cuts it.

    Args:
        surface: the visible body.
        T_cam_piece: (n_cameras, n_pieces, 3 or 4, 4), see `piece_poses`.
        cameras: the views.
        step: every how many rows and columns.
        near: m; nothing nearer to a camera is imagined.

    Raises:
        InputError: shapes do not fit each other.
    """
    T = np.asarray(T_cam_piece, dtype=np.float64)
    n_pieces = len(surface.frames)
    if T.shape[:2] != (len(cameras), n_pieces) or T.shape[2:] not in ((3, 4), (4, 4)):
        raise InputError(
            f"expected poses ({len(cameras)} cameras, {n_pieces} pieces, 3 or 4, 4), got an array "
            f"of shape {T.shape}."
        )
    parts = [
        _one_view(surface, T[c, :, :3], c, camera, columns_first, step, near)
        for c, camera in enumerate(cameras)
        for columns_first in (False, True)
    ]
    return Rim(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def rim_slopes(
    rim: Rim,
    surface: Surface,
    cameras: Sequence[Camera],
    reference: Body,
    variables: Variables,
    x: ArrayLike,
    q: ArrayLike,
) -> RimSlopes:
    """Derivatives of the outward displacement of each point of the contour.

    Args:
        rim: of the body that deviates from the reference by x, at q.
        surface: that it was found on.
        cameras: that it was found in.
        reference: the body round which the parameters are charted.
        variables: what may be wrong with it, mountings of cameras included.
        x: (n_parameters,) deviations.
        q: (n_joints,) encoder readings.
    """
    by_joint = np.zeros((len(rim), len(reference.joints)))
    by_parameter = np.zeros((len(rim), len(variables)))
    for c, camera in enumerate(cameras):
        for b in np.unique(rim.piece[rim.camera == c]):
            mine = (rim.camera == c) & (rim.piece == b)
            D = relative_pose_derivatives(
                reference, variables, x, q, camera.frame, surface.frames[b]
            )
            by_twist = _by_twist(rim.point[mine], rim.normal[mine], camera, D)
            by_joint[mine], by_parameter[mine] = by_twist @ D.by_joint, by_twist @ D.by_parameter
    return RimSlopes(by_joint, by_parameter)


def outward_gain(rim: Rim, T_cam_piece: ArrayLike, cameras: Sequence[Camera]) -> Array:
    """|n^T P|: how far the outline moves where the surface is thicker, (n,) pixels per m.

    The outward normal of the surface at a rim point is at right angles to the line of sight and to
    the outline, and so is n^T P: they are parallel.

    Args:
        rim: points of the outline.
        T_cam_piece: (n_cameras, n_pieces, 3 or 4, 4) that it was found at.
        cameras: that it was found in.
    """
    T = np.asarray(T_cam_piece, dtype=np.float64)[rim.camera, rim.piece]
    X = np.einsum("nij,nj->ni", T[:, :3, :3], rim.point) + T[:, :3, 3]
    f = np.array([camera.intrinsics[:2] for camera in cameras])[rim.camera]
    return np.asarray(np.linalg.norm(normal_slope(rim.normal, X, f), axis=1))


def normal_slope(normal: Array, X: Array, f: Array) -> Array:
    """n^T P at points X before the camera: (*batch, 2), (*batch, 3), f (2,) -> (*batch, 3)."""
    pull, plane = normal * f / X[..., 2:], X[..., :2] / X[..., 2:]
    return np.concatenate([pull, -np.sum(pull * plane, axis=-1, keepdims=True)], axis=-1)


def _by_twist(point: Array, normal: Array, camera: Camera, D: PoseDerivatives) -> Array:
    """n^T P [1, -[X']x], (n, 6)."""
    arm = point @ D.pose[:3, :3].T
    a = normal_slope(normal, arm + D.pose[:3, 3], camera.intrinsics[:2])
    return np.hstack([a, np.cross(arm, a)])


def _one_view(
    surface: Surface,
    T: Array,
    c: int,
    camera: Camera,
    columns_first: bool,
    step: int,
    near: float,
) -> tuple[Ints, Ints, Array, Array, Array, Array]:
    """The fields of a Rim for one view and one direction of lines."""
    lines, line = (1, 0) if columns_first else (0, 1)  # axis along the lines, and across them
    size = (camera.width, camera.height)
    lens, capacity, lost = camera.intrinsics.astype(np.float32), CAPACITY, 1
    while lost:
        found, lost = collect(
            surface.columns, T.astype(np.float32), lens, np.float32(near),
            (size[line] - 1) // step + 1, size[lines] - 1, columns_first, step, capacity,
        )  # fmt: skip
        capacity *= 2
    entry, at, side = found.T
    piece = np.searchsorted(surface.eo, entry, side="right") - 1
    ends = surface.vertices[surface.edges[entry, :2]]
    seen = np.einsum("nij,nkj->nki", T[piece, :, :3], ends) + T[piece, None, :, 3]
    depth, pixels = seen[..., 2], camera.intrinsics[:2] * seen[..., :2] / seen[..., 2:]
    pixels = pixels + camera.intrinsics[2:]
    along = pixels[:, 1] - pixels[:, 0]
    reach = np.linalg.norm(along, axis=1)
    t = (at - pixels[:, 0, line]) / along[:, line]
    s = t * depth[:, 0] / (t * depth[:, 0] + (1 - t) * depth[:, 1])
    normal = np.column_stack([along[:, 1], -along[:, 0]]) / reach[:, None]
    normal *= (side * np.sign(normal[:, lines]))[:, None]
    return (
        np.full(len(entry), c),
        piece,
        ends[:, 0] + s[:, None] * (ends[:, 1] - ends[:, 0]),
        pixels[:, 0] + t[:, None] * along,
        normal,
        step * reach / np.abs(along[:, line]),
    )
