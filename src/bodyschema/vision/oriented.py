"""The oriented chamfer distance of imagined contours: to edges of the same direction.

For the points i of the outer contour that the lines of the image cut (see `rim`), with the channel
k_i of the contour's direction there and the length l_i of contour from one line to the next,

    D = sum l_i D(x_i, k_i),      N = sum l_i,      mean distance D / (256 N) pixels

in whole numbers. A point lies on a line, so interpolating D along the line is exact.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.vision.contours import NEAR
from bodyschema.vision.edge_image import ObservedEdges
from bodyschema.vision.rim import (
    PLACE,
    SEGMENT,
    Cuts,
    belongs,
    cut_contour,
    new_cuts,
    turned,
)
from bodyschema.vision.surface import Columns, Surface
from bodyschema.vision.views import over_views

Floats = NDArray[np.float32]
Ints = NDArray[np.int64]
Shorts = NDArray[np.int16]

STEP = 2
"""Every second row and column is enough for a mean over the contour."""

FIRST_TURN, SECOND_TURN = np.float32(np.tan(np.pi / 16)), np.float32(np.tan(3 * np.pi / 16))
"""Slopes at which the direction changes from one of eight channels to the next."""


def oriented_distances(
    surface: Surface,
    T_cam_piece: ArrayLike,
    cameras: Sequence[Camera],
    observed: Sequence[ObservedEdges],
    threads: int = 1,
    step: int = STEP,
    near: float = NEAR,
) -> tuple[Ints, Ints]:
    """D and N, (n_hypotheses, n_cameras) each, in 1/256 of a pixel and of a pixel's length.

    Args:
        surface: the visible body.
        T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 3 or 4, 4), see `piece_poses`.
        cameras: the views.
        observed: the edges of each view.
        threads: how many work; the result is the same for any number.
        step: every how many rows and columns the contour is looked at.
        near: m, distance of the near plane.

    Raises:
        InputError: shapes do not fit each other.
    """
    for camera, seen in zip(cameras, observed, strict=True):
        if seen.edges.shape != (camera.height, camera.width):
            raise InputError(
                f"camera '{camera.name}' has {camera.height} rows and {camera.width} columns, its "
                f"edges have the shape {seen.edges.shape}."
            )

    def job(c: int, T: Floats, capacity: int, out: Ints, lost: Ints) -> None:
        lens = cameras[c].intrinsics.astype(np.float32)
        field = observed[c].distance
        _views(surface.columns, T, lens, np.float32(near), field, step, capacity, out, lost)

    sums = over_views(T_cam_piece, len(surface.frames), 2, threads, job)
    return sums[..., 0], sums[..., 1]


@kernel
def _views(
    columns: Columns,
    T: Floats,
    lens: Floats,
    near: np.float32,
    field: Shorts,
    step: int,
    capacity: int,
    out: Ints,
    lost: Ints,
) -> None:
    """D and N (n, 2) of n hypotheses in one view, and how many crossings found no place."""
    height, width = field.shape[1], field.shape[2]
    rows = new_cuts(columns, (height - 1) // step + 1, capacity)
    cols = new_cuts(columns, (width - 1) // step + 1, capacity)
    flat = field.reshape(-1)
    for h in range(T.shape[0]):
        T_view, lens_view = turned(T[h], lens, step, False)
        made, over = cut_contour(columns, T_view, lens_view, near, width - 1, rows)
        lost[h] += over
        _add(rows, made, width - 1, step, False, flat, height * width, step * width, 1, out[h])
        T_view, lens_view = turned(T[h], lens, step, True)
        made, over = cut_contour(columns, T_view, lens_view, near, height - 1, cols)
        lost[h] += over
        _add(cols, made, height - 1, step, True, flat, height * width, step, width, out[h])


@kernel
def _add(
    cuts: Cuts,
    made: int,
    last: int,
    step: int,
    columns_first: bool,
    field: Shorts,
    layer: int,
    to_line: int,
    to_next: int,
    out: Ints,
) -> None:
    """Add the points on the lines of one view to D and N, and leave the lines empty.

    The field is flat: a channel every `layer`, a line every `to_line`, a pixel every `to_next`.
    """
    crossings, held, border = cuts.crossings, cuts.held, np.int64(last) * 256
    capacity = crossings.shape[0] // held.shape[0]
    per_line, half = np.float32(1) / np.float32(step), np.float32(0.5)
    distance, number = np.int64(0), np.int64(0)
    for line in range(held.shape[0]):
        for j in range(line * capacity, line * capacity + held[line]):
            i, x = crossings[j] & SEGMENT, crossings[j] >> PLACE
            g = cuts.memory.g[i] * per_line
            if not (i >= made and belongs(g, columns_first) and 0 < x < border):
                continue
            at = _channel(g, columns_first) * layer + line * to_line + (x >> 8) * to_next
            right = x & 255
            value = (field[at] * (256 - right) + field[at + to_next] * right) >> 8
            length = np.int64(np.float32(256) * np.sqrt(np.float32(1) + g * g) + half)
            distance += value * length
            number += length
        held[line] = 0
    out[0] += distance
    out[1] += number


@kernel
def _channel(g: np.float32, columns_first: bool) -> int:
    """Channel of the tangent of a contour: atan(g) for (1, g) in columns, pi/2 - it for (g, 1)."""
    turns = (
        np.int64(g > FIRST_TURN)
        + np.int64(g > SECOND_TURN)
        - np.int64(g < -FIRST_TURN)
        - np.int64(g < -SECOND_TURN)
    )
    return int(turns & 7 if columns_first else (4 - turns) & 7)
