"""The motion that a turning camera gives the whole view, fitted past what moves by itself.

A small rotation of a camera, whatever its focal length, moves the image point (x, y) by

    u = a1 + a2 x + a3 y + a7 x^2 + a8 x y
    v = a4 + a5 x + a6 y + a7 x y + a8 y^2

(Longuet-Higgins and Prazdny 1980, with a plane's parallax in the linear terms). The eight numbers
are fitted to the cells with Tukey's weights. The fit begins at the mode of the flow, the motion
that most of the textured cells share, and the radius within which cells count shrinks from round to
round: a large arm near the camera is no part of it. A camera that stands may still shake, but not
much: then the radius is small from the beginning.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STILL = 0.03
"""pixels/frame; a camera whose view shifts by less stands still."""
BIN = 0.3
"""pixels/frame: side of the bins in which the mode is looked for, radius within which it counts."""
LEAST_SHARE = 0.25
"""Of all cells, that share what the camera's motion makes; an arm before a plain wall has fewer."""
ROUNDS = 8
WIDE = (0.6, 0.3)
"""a, b: the first round has the radius a + b |mode|, pixels/frame."""
SHRINKING = 0.75
"""Of the radius from round to round, down to BIN."""


def background_flow(v: Array, texture: Array, turns: bool) -> Array:
    """What the camera's own motion explains of the flow.

    Args:
        v: (rows, cols, 2) pixels/frame.
        texture: (rows, cols) weights.
        turns: whether the camera may turn; otherwise it shakes at most.

    Returns:
        (rows, cols, 2) pixels/frame.
    """
    flow, weight = v.reshape(-1, 2), texture.ravel()
    mode = _mode(flow, weight)
    for _ in range(ROUNDS):
        w = weight * _tukey(flow - mode, BIN)
        mode = w @ flow / max(float(w.sum()), 1e-9) if w.any() else mode
    radius = WIDE[0] + WIDE[1] * float(np.hypot(*mode)) if turns else BIN
    shared = (texture.ravel() > 0.1) & (_tukey(flow - mode, radius) > 0)
    if float(np.hypot(*mode)) < STILL or shared.mean() < LEAST_SHARE:
        return np.zeros_like(v)
    fitted = np.tile(mode, (len(flow), 1))
    fitted = _turning(flow, weight, fitted, radius, (v.shape[0], v.shape[1]))
    return np.asarray(fitted.reshape(v.shape))


def _mode(flow: Array, weight: Array) -> Array:
    """(2,) the fullest bin's centre."""
    place = np.rint(flow / BIN).astype(np.int64)
    bins, member = np.unique(place, axis=0, return_inverse=True)
    full = np.bincount(member.ravel(), weights=weight)
    return np.asarray(BIN * bins[int(np.argmax(full))], dtype=np.float64)


def _turning(
    v: Array, weight: Array, fitted: Array, radius: float, shape: tuple[int, int]
) -> Array:
    """(n, 2) the eight numbers' flow, fitted from a first guess."""
    A = _columns(*shape)
    for _ in range(ROUNDS):
        w = np.repeat(weight * _tukey(v - fitted, radius), 2)
        H = A.T @ (w[:, None] * A) + 1e-6 * np.eye(8)
        a = np.linalg.solve(H, A.T @ (w * v.ravel()))
        fitted = np.asarray((A @ a).reshape(v.shape))
        radius = max(SHRINKING * radius, BIN)
    return fitted


def _columns(rows: int, cols: int) -> Array:
    """(2 * cells, 8) derivative of the flow by a, x and y from -1 to 1."""
    down, across = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, cols), indexing="ij")
    x, y = np.ravel(across), np.ravel(down)
    one, none = np.ones(x.size), np.zeros(x.size)
    u = np.stack([one, x, y, none, none, none, x * x, x * y], axis=1)
    v = np.stack([none, none, none, one, x, y, x * y, y * y], axis=1)
    return np.asarray(np.stack([u, v], axis=1).reshape(-1, 8))


def _tukey(away: Array, radius: float) -> Array:
    """(n,) weights of residuals (n, 2)."""
    return np.asarray(np.maximum(0.0, 1 - np.sum(away * away, axis=1) / radius**2) ** 2)
