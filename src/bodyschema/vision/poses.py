"""Where the pieces of the body stand before each camera, for many hypotheses at once.

    T_cam_piece = T_root_cam^-1 T_root_piece

Only the part of the tree that carries a camera or a piece is walked. A hypothesis of joint offsets
is a row of q that is shifted by them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model import kernels
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.model.rigid import IDENTITY, product, quotient, read, write
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def piece_poses(
    body: Body, q: ArrayLike, cameras: Sequence[Camera], frames: Sequence[str]
) -> Array:
    """T_cam_piece (n_hypotheses, n_cameras, n_pieces, 4, 4).

    Args:
        body: whose frames the cameras and pieces are.
        q: (n_hypotheses, n_joints) encoder readings, rad or m; a single row is one hypothesis.
        cameras: the views.
        frames: of the pieces, such as `Surface.frames`.

    Raises:
        InputError: a frame is unknown or q has the wrong number of columns.
    """
    readings = np.atleast_2d(np.asarray(q, dtype=np.float64))
    if readings.ndim != 2 or readings.shape[1] != len(body.joints):
        raise InputError(
            f"expected joint positions (n_hypotheses, {len(body.joints)}), got {readings.shape}."
        )
    seers = [body.frame_index(camera.frame) for camera in cameras]
    seen = [body.frame_index(frame) for frame in frames]
    nodes = _nodes_above(body, [*seers, *seen])
    row = {node: i for i, node in enumerate(nodes.tolist())}
    parent = np.array([row.get(int(k), -1) for k in body.parent[nodes]], dtype=np.int64)
    theta = np.zeros((len(readings), len(nodes)))
    kernels.joint_values(
        np.ascontiguousarray(readings), body.gear, body.offset, body.driver[nodes],
        body.rate[nodes], body.shift[nodes], theta,
    )  # fmt: skip
    T_root = np.empty((*theta.shape, 4, 4))
    kernels.tree_poses(
        parent, body.kind[nodes], body.axis[nodes], body.placement[nodes], theta, T_root
    )
    out = np.empty((len(theta), len(seers), len(seen), 4, 4))
    _between(T_root, np.array([row[k] for k in seers]), np.array([row[k] for k in seen]), out)
    return out


def _nodes_above(body: Body, nodes: Sequence[int]) -> Ints:
    """The given nodes and all above them, parents first."""
    found: set[int] = set()
    for node in nodes:
        while node >= 0 and node not in found:
            found.add(node)
            node = int(body.parent[node])
    return np.array(sorted(found), dtype=np.int64)


@kernel
def _between(T_root: Array, seers: Ints, seen: Ints, out: Array) -> None:
    """out[n, c, b] = T_root[n, seers[c]]^-1 T_root[n, seen[b]]."""
    for n in range(T_root.shape[0]):
        for c in range(seers.shape[0]):
            T_cam_root = quotient(IDENTITY, read(T_root[n, seers[c]]))
            for b in range(seen.shape[0]):
                write(product(T_cam_root, read(T_root[n, seen[b]])), out[n, c, b])
