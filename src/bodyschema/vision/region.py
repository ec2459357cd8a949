"""Sums of any image over imagined silhouettes: for evidence of colour, where there is no mask."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.vision.contours import NEAR
from bodyschema.vision.scratch import new_scratch
from bodyschema.vision.silhouette import trace
from bodyschema.vision.spans import new_spans, overlap, sweep
from bodyschema.vision.surface import Columns, Surface
from bodyschema.vision.views import over_views

Floats = NDArray[np.float32]
Ints = NDArray[np.int64]


def sums_inside(
    surface: Surface,
    T_cam_piece: ArrayLike,
    cameras: Sequence[Camera],
    row_sums: Sequence[NDArray[np.int32]],
    threads: int = 1,
    near: float = NEAR,
) -> Ints:
    """Sum of the pixels of an image inside the silhouette, (n_hypotheses, n_cameras).

    Args:
        surface: the visible body.
        T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 3 or 4, 4), see `piece_poses`.
        cameras: the views.
        row_sums: (height, width + 1) of each view: sums of the pixels left of each column.
        threads: how many work; the result is the same for any number.
        near: m, distance of the near plane.

    Raises:
        InputError: shapes do not fit each other.
    """
    for camera, table in zip(cameras, row_sums, strict=True):
        if table.shape != (camera.height, camera.width + 1):
            raise InputError(
                f"camera '{camera.name}' needs row sums ({camera.height}, {camera.width + 1}), "
                f"got {table.shape}."
            )

    def job(c: int, T: Floats, capacity: int, out: Ints, lost: Ints) -> None:
        lens = cameras[c].intrinsics.astype(np.float32)
        _views(surface.columns, T, lens, np.float32(near), row_sums[c], capacity, out, lost)

    return over_views(T_cam_piece, len(surface.frames), 1, threads, job)[..., 0]


@kernel
def _views(
    columns: Columns,
    T: Floats,
    lens: Floats,
    near: np.float32,
    P: NDArray[np.int32],
    capacity: int,
    out: Ints,
    lost: Ints,
) -> None:
    """Sums (n, 1) of n hypotheses in one view, and how many crossings found no place."""
    memory, spans = new_scratch(columns, P.shape[0], capacity), new_spans(P.shape[0], capacity)
    for h in range(T.shape[0]):
        lost[h] = trace(columns, T[h], lens, near, P.shape[1] - 1, memory)
        sweep(memory, spans)
        out[h, 0], _ = overlap(spans, P)
