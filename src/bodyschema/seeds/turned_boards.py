"""Which way round a board lay that looks the same turned: the robot's postures tell.

A pose T_i of picture i may as well be T_i F_k for one of the motions F_k that leave the pattern as
it is. Between two pictures hand and board turn by one angle, whatever the mounting (A X = X B):

    angle(K_j^-1 K_i) = angle((T_j F_k)^-1 T_i F_l)

From a few anchors, each taken as it is, the others are turned so that angles agree; frames X, Y of
K Y = X T F are fitted to that, all are turned to what these predict, and again until none turns.
The anchor whose smaller 40 % of errors are best wins: more than half may be of another board.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.seeds.pair_starts import QUANTILE, pair_starts

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ANCHORS = 6
ROUNDS = 6
DRAWS = 40
"""Fours of pictures for each fit of frames; see `pair_starts`."""

LEAST = 4
"""Pictures: with fewer nothing can be compared."""


def board_turns(K: Array, T: Array, F: Sequence[Array]) -> Ints:
    """Which F_k is right for each picture, (n,), up to one turn that all have in common.

    Args:
        K: (n, 4, 4) the robot between what carries the camera and what carries the board.
        T: (n, 4, 4) T_camera_board as the detector numbered it.
        F: motions (4, 4) of the board onto itself, the first the identity.
    """
    n = len(K)
    if len(F) < 2 or n < LEAST:
        return np.zeros(n, dtype=np.int64)
    turned = np.stack([T @ one for one in F])
    anchors = np.unique(np.linspace(0, n - 1, ANCHORS).astype(int))
    tried = [_settled(K, turned, _alike(K, turned, anchor)) for anchor in anchors]
    return min(tried, key=lambda one: one[0])[1]


def _alike(K: Array, turned: Array, anchor: int) -> Ints:
    """Turns with which every picture has moved from the anchor by the robot's angle."""
    moved = _angle(lie.inverse(K) @ K[anchor])
    seen = _angle(lie.inverse(turned) @ turned[0, anchor])
    return np.asarray(np.argmin(np.abs(seen - moved), axis=0))


def _settled(K: Array, turned: Array, turns: Ints) -> tuple[float, Ints]:
    """Turns that frames fitted to them predict, and the error that is left, m."""
    each, error = np.arange(len(K)), np.inf
    for _ in range(ROUNDS):
        (Y, X), *_ = pair_starts(K, turned[turns, each], draws=DRAWS)
        apart = np.linalg.norm((K @ Y - X @ turned)[..., :3, :], axis=(2, 3))
        found = np.argmin(apart, axis=0)
        error = float(np.quantile(apart[found, each], QUANTILE))
        if (found == turns).all():
            break
        turns = found
    return error, turns


def _angle(T: Array) -> Array:
    """Angle of rotation, (*b,) rad."""
    trace = np.trace(T[..., :3, :3], axis1=-2, axis2=-1)
    return np.asarray(np.arccos(np.clip((trace - 1) / 2, -1, 1)))
