"""The work of many hypotheses in many views, shared out among threads.

Kernels run outside the interpreter's lock and each call has working memory of its own. Their sums
are of integers, so the result is the same for any number of threads and any order of the work.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError

Floats = NDArray[np.float32]
Ints = NDArray[np.int64]

Job = Callable[[int, Floats, int, Ints, Ints], None]
"""What to do with some hypotheses of one view: (camera, T (n, n_pieces, 3, 4), capacity, out
(n, n_numbers), lost (n,)); it fills `out`, and `lost` with the crossings that found no place."""

CAPACITY = 64
"""Crossings that a line has room for at first; a view that needs more is done again with twice
as many."""

CHUNKS = 4
"""Pieces of work a thread, so that a thread that is held up does not hold up all."""


def over_views(T_cam_piece: ArrayLike, n_pieces: int, numbers: int, threads: int, job: Job) -> Ints:
    """Do a job for all hypotheses and views; (n_hypotheses, n_cameras, numbers).

    Args:
        T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 3 or 4, 4).
        n_pieces: of the surface.
        numbers: how many the job makes of each view.
        threads: how many work.
        job: see `Job`.

    Raises:
        InputError: the poses are not those of n_pieces pieces.
    """
    T = np.asarray(T_cam_piece)
    if T.ndim != 5 or T.shape[2] != n_pieces or T.shape[3:] not in ((3, 4), (4, 4)):
        raise InputError(
            f"expected poses (n_hypotheses, n_cameras, {n_pieces} pieces, 3 or 4, 4), got an array "
            f"of shape {T.shape}."
        )
    out = np.zeros((T.shape[1], len(T), numbers), dtype=np.int64)
    parts = 1 if threads == 1 else CHUNKS * threads
    cuts = np.linspace(0, len(T), parts + 1).astype(int)
    work = [
        (camera, T[a:b, camera, :, :3], out[camera, a:b], job)
        for camera in range(T.shape[1])
        for a, b in pairwise(cuts)
        if a < b
    ]
    if threads == 1:
        for part in work:
            _until_all_fit(*part)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda part: _until_all_fit(*part), work))
    return np.ascontiguousarray(np.swapaxes(out, 0, 1))


def _until_all_fit(camera: int, T: NDArray[np.floating], out: Ints, job: Job) -> None:
    """Do the job; for hypotheses whose lines overflow once more, with more room."""
    views = np.ascontiguousarray(T, dtype=np.float32)
    left, capacity = np.arange(len(views)), CAPACITY
    while len(left):
        found = np.zeros((len(left), out.shape[1]), dtype=np.int64)
        lost = np.zeros(len(left), dtype=np.int64)
        job(camera, views[left], capacity, found, lost)
        out[left] = found
        left, capacity = left[lost > 0], 2 * capacity
