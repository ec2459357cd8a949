"""Corners on a moving hand as a tracker reports them: each with a life, and errors that last."""

from __future__ import annotations

import numpy as np

from bodyschema import lie
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.learners.hand_eye.stereo_points import Stereo

STEREO = Stereo(600.0, (319.5, 239.5), 0.1, 0.1)
"""The lens of all of them."""


def world_camera(rng: np.random.Generator) -> np.ndarray:
    """(4, 4) T_world_cam."""
    return lie.transform(lie.exp_so3(rng.normal(size=3)), 0.3 * rng.normal(size=3))


def hand_poses(n: int, rng: np.random.Generator, slow: float = 1.0) -> np.ndarray:
    """(n, 4, 4) T_cam_hand, ten a second: turns of 20 degrees and ways of 6 cm about 1 m away."""
    time = np.arange(n)[:, None] / 10 / slow
    wave = np.sin(2 * np.pi * rng.uniform(0.1, 0.3, 6) * time + rng.uniform(0, 6, 6))
    return lie.transform(
        lie.exp_so3(np.deg2rad(20) * wave[:, :3]), 0.06 * wave[:, 3:] + [0.0, 0.0, 1.0]
    )


def rows_of(
    T_world_cam: np.ndarray, T_cam_hand: np.ndarray, rng: np.random.Generator,
    life: int = 20, at_a_time: int = 12, white: float = 0.05, lasting: float = 0.08,
) -> CornerRows:  # fmt: skip
    """Rows of corners that come and go, on a ball of 6 cm about the hand.

    Args:
        T_world_cam: (4, 4).
        T_cam_hand: (n, 4, 4).
        rng: of places, lives and errors.
        life: moments that a corner lives on average.
        at_a_time: corners in view.
        white: px, error of each row.
        lasting: px, error that wanders over a corner's life.
    """
    n, rows, name = len(T_cam_hand), CornerRows.none(), 0
    for _ in range(at_a_time):
        begin = 0
        while begin < n:
            name += 1
            span = np.arange(begin, min(n, begin + 5 + rng.poisson(life)))
            begin = int(span[-1]) + 1
            place = 0.06 * rng.normal(size=3)
            c = T_cam_hand[span][:, :3, :3] @ place + T_cam_hand[span][:, :3, 3]
            pixel = STEREO.project(c)
            seen = np.column_stack([pixel[:, :2], pixel[:, 0] - pixel[:, 2]])
            drift = np.cumsum(rng.normal(size=(len(span), 3)), axis=0) / np.sqrt(20)
            seen += white * rng.normal(size=seen.shape) + lasting * drift * [1, 1, 0.5]
            rows = rows.joined(
                CornerRows(
                    np.full(len(span), name), span, np.zeros(len(span), dtype=np.int64),
                    T_world_cam @ T_cam_hand[span], seen,
                )
            )  # fmt: skip
    return rows
