"""How well imagined bodies fit observed masks: thousands of hypotheses in milliseconds.

For each hypothesis and view, in whole pixels:

    I  pixels that are imagined and observed         Jaccard index       I / (A + B - I)
    A  pixels that are imagined                      chamfer distance    D / (256 N) pixels
    D  sum of the distances from the imagined contour to the observed one, 1/256 pixel
    N  pixels of the imagined contour
    B  pixels that are observed

All sums are of integers: the result is the same for any number of threads (see `views`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.vision.observed import UNIT, ObservedMask
from bodyschema.vision.scratch import new_scratch
from bodyschema.vision.silhouette import trace
from bodyschema.vision.spans import Spans, boundary, new_spans, overlap, sweep
from bodyschema.vision.surface import Columns, Surface
from bodyschema.vision.views import CAPACITY, over_views

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

NEAR = 0.01
"""m; what is nearer to the plane of a camera is not imagined."""


@dataclass(frozen=True)
class ContourFit:
    """Counts of pixels for every hypothesis and view."""

    inside: Ints
    """(n_hypotheses, n_cameras) I."""
    area: Ints
    """(n_hypotheses, n_cameras) A."""
    distance: Ints
    """(n_hypotheses, n_cameras) D, in 1/256 pixel; 0 if it was not asked for."""
    boundary: Ints
    """(n_hypotheses, n_cameras) N; 0 if it was not asked for."""
    observed: Ints
    """(n_cameras,) B."""

    @property
    def jaccard(self) -> Array:
        """(n_hypotheses, n_cameras) overlap, 0 to 1; nan where there is neither body."""
        union = self.area + self.observed - self.inside
        with np.errstate(invalid="ignore"):
            return np.asarray(self.inside / union)

    @property
    def chamfer(self) -> Array:
        """(n_hypotheses, n_cameras) mean distance, pixels; nan where the body is out of view."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.distance / (UNIT * self.boundary))


def fit_contours(
    surface: Surface,
    T_cam_piece: ArrayLike,
    cameras: Sequence[Camera],
    observed: Sequence[ObservedMask],
    chamfer: bool = True,
    threads: int = 1,
    near: float = NEAR,
) -> ContourFit:
    """Compare imagined bodies with what each camera saw.

    Args:
        surface: the visible body.
        T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 3 or 4, 4), see `piece_poses`.
        cameras: the views; images must be free of distortion (`Camera.undistort`).
        observed: the mask of each view.
        chamfer: whether D and N are wanted; the Jaccard index alone takes less time.
        threads: how many work; the result is the same for any number.
        near: m, distance of the near plane.

    Raises:
        InputError: shapes do not fit each other.
    """
    T = _checked(T_cam_piece, surface, len(cameras), near)
    _check_masks(cameras, observed)

    def job(c: int, T: Floats, capacity: int, out: Ints, lost: Ints) -> None:
        _fit_views(
            surface.columns, T, cameras[c].intrinsics.astype(np.float32), np.float32(near),
            observed[c].row_sums, observed[c].distance_sums, chamfer, capacity, out, lost,
        )  # fmt: skip

    counts = over_views(T, len(surface.frames), 4, threads, job)
    inside, area, distance, number = np.moveaxis(counts, -1, 0)
    return ContourFit(inside, area, distance, number, np.array([seen.area for seen in observed]))


def silhouette_spans(
    surface: Surface, T_cam_piece: ArrayLike, camera: Camera, near: float = NEAR
) -> NDArray[np.int32]:
    """The silhouette of one hypothesis in one view as spans: rows (r, a, b) for pixels a .. b - 1.

    Args:
        surface: the visible body.
        T_cam_piece: (n_pieces, 3 or 4, 4).
        camera: the view.
        near: m, distance of the near plane.
    """
    T = _checked(np.asarray(T_cam_piece)[None, None], surface, 1, near)[0, 0]
    views, lens = T[:, :3].astype(np.float32), camera.intrinsics.astype(np.float32)
    capacity, lost = CAPACITY, 1
    while lost:
        spans, lost = _view_spans(
            surface.columns, views, lens, np.float32(near), camera.width, camera.height, capacity
        )
        capacity *= 2
    taken = np.arange(1, spans.ends.shape[1]) <= spans.kept[:, None]
    rows = np.repeat(np.arange(camera.height), spans.kept)[::2]
    return np.column_stack([rows, spans.ends[:, 1:][taken].reshape(-1, 2)]).astype(np.int32)


def silhouette(
    surface: Surface, T_cam_piece: ArrayLike, camera: Camera, near: float = NEAR
) -> Flags:
    """The silhouette of one hypothesis in one view as a mask, (height, width); see its spans."""
    r, a, b = silhouette_spans(surface, T_cam_piece, camera, near).T
    steps = np.zeros((camera.height, camera.width + 1), dtype=np.int8)
    steps[r, a] += 1  # spans neither meet nor touch, so no place is named twice
    steps[r, b] -= 1
    return np.cumsum(steps[:, :-1], axis=1, dtype=np.int8).view(np.bool_)


@kernel
def _fit_views(
    columns: Columns,
    T: Floats,
    lens: Floats,
    near: np.float32,
    P: NDArray[np.int32],
    PD: NDArray[np.int32],
    chamfer: bool,
    capacity: int,
    out: Ints,
    lost: Ints,
) -> None:
    """I, A, D, N (n, 4) of n hypotheses in one view, and how many crossings found no place."""
    height, width = P.shape[0], P.shape[1] - 1
    memory, spans = new_scratch(columns, height, capacity), new_spans(height, capacity)
    for h in range(T.shape[0]):
        lost[h] = trace(columns, T[h], lens, near, width, memory)
        sweep(memory, spans)
        out[h, 0], out[h, 1] = overlap(spans, P)
        if chamfer:
            out[h, 2], out[h, 3] = boundary(spans, PD)


@kernel
def _view_spans(
    columns: Columns,
    T: Floats,
    lens: Floats,
    near: np.float32,
    width: int,
    height: int,
    capacity: int,
) -> tuple[Spans, int]:
    """The spans of one view, and how many crossings found no place."""
    memory, spans = new_scratch(columns, height, capacity), new_spans(height, capacity)
    lost = trace(columns, T, lens, near, width, memory)
    sweep(memory, spans)
    return spans, lost


def _checked(T_cam_piece: ArrayLike, surface: Surface, n_cameras: int, near: float) -> Array:
    T = np.asarray(T_cam_piece, dtype=np.float64)
    pieces = len(surface.frames)
    if T.ndim != 5 or T.shape[1:3] != (n_cameras, pieces) or T.shape[3:] not in ((3, 4), (4, 4)):
        raise InputError(
            f"expected poses (n_hypotheses, {n_cameras} cameras, {pieces} pieces, 3 or 4, 4), "
            f"got an array of shape {T.shape}."
        )
    if not near > 0:
        raise InputError(f"the near plane must lie before the camera, not at {near} m.")
    return T


def _check_masks(cameras: Sequence[Camera], observed: Sequence[ObservedMask]) -> None:
    if len(cameras) != len(observed):
        raise InputError(f"there are {len(cameras)} cameras and {len(observed)} observed masks.")
    for camera, seen in zip(cameras, observed, strict=True):
        if seen.mask.shape != (camera.height, camera.width):
            raise InputError(
                f"camera '{camera.name}' has {camera.height} rows and {camera.width} columns, its "
                f"mask has the shape {seen.mask.shape}."
            )
