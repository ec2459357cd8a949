"""One patch of a picture, sought in later pictures as it was when it was first seen.

The template T is cut out once, at birth, and never renewed: what is compared with it does not
drift. A later picture I shows it under an affine map of its grid of points g (about the middle),

    I(A g + t),    A (2, 2), t (2,)

and both are compared after their weighted mean and length are taken out, so brightness and contrast
may change. Inverse compositional descent (Baker and Matthews 2004): with the slopes of T,

    J = dT/dp, made orthogonal to the mean and to T itself,    H = J^T W J

once and for all, each step is p = H^-1 J^T W (I - T), and the map is composed with the inverse of
the step's map. W is a Gaussian: what lies at the rim, where the background may look in, counts
less.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Flags = NDArray[np.bool_]

SIDE = 15
"""px, side of a template."""
HALF = SIDE // 2
SPREAD = 4.5
"""px, standard deviation of the weights."""
STEPS = 6
"""Of the descent."""
LEAST_STEP = 0.003
"""px below which the descent has ended."""


def _grid() -> tuple[Array, Array]:
    """(289, 2) x, y of the template's points, and (289,) weights that sum to 1."""
    line = np.arange(-HALF, HALF + 1.0)
    x, y = np.meshgrid(line, line)
    W = np.exp(-(x**2 + y**2) / (2 * SPREAD**2)).ravel()
    return np.column_stack([x.ravel(), y.ravel()]), W / W.sum()


GRID, WEIGHT = _grid()


def templates(image: Grey, place: Array) -> tuple[Array, Array, Array]:
    """What patches look like, ready to be sought.

    Args:
        image: (height, width).
        place: (K, 2) px, their middles, at least `HALF` + 2 px from the border.

    Returns:
        (K, 289) templates of mean 0 and length 1, (K, 6, 289) the matrix H^-1 J^T W of each, and
        (K,) the variance of its grey values.
    """
    K = len(place)
    T, G, variance = np.empty((K, len(GRID))), np.empty((K, 6, len(GRID))), np.empty(K)
    x, y = GRID.T
    for k in range(K):
        big = _cut(image, place[k], HALF + 1)
        grey = big[1:-1, 1:-1].ravel()
        grey = grey - WEIGHT @ grey
        variance[k] = WEIGHT @ grey**2
        length = np.sqrt(max(variance[k], 1e-12))
        T[k] = grey / length
        du = (big[1:-1, 2:] - big[1:-1, :-2]).ravel() / (2 * length)
        dv = (big[2:, 1:-1] - big[:-2, 1:-1]).ravel() / (2 * length)
        J = np.column_stack([du * x, du * y, dv * x, dv * y, du, dv])
        J = J - WEIGHT @ J
        J = J - np.outer(T[k], (WEIGHT * T[k]) @ J)
        H = (J.T * WEIGHT) @ J
        ridge = 1e-9 * np.trace(H) * np.eye(6)
        G[k] = np.linalg.solve(H + ridge, J.T * WEIGHT)
    return T, G, variance


def _cut(image: Grey, middle: Array, half: int) -> Array:
    """(2 half + 1, 2 half + 1) grey values about a place between the pixels."""
    u, v = np.floor(middle).astype(int)
    a, b = middle - (u, v)
    block = image[v - half : v + half + 2, u - half : u + half + 2].astype(np.float64)
    rows = (1 - b) * block[:-1] + b * block[1:]
    return np.asarray((1 - a) * rows[:, :-1] + a * rows[:, 1:])


@kernel
def align(
    image: Grey, T: Array, G: Array, weight: Array, grid: Array, A: Array, place: Array,
    steps: int, alike: Array, variance: Array,
) -> None:  # fmt: skip
    """Seek each template; A (K, 2, 2) and place (K, 2) hold the beginning and are replaced.

    `alike` (K,) is the weighted correlation at the end, -2 where the patch left the picture;
    `variance` (K,) that of the grey values found.
    """
    height, width = image.shape
    n = grid.shape[0]
    seen = np.empty(n)
    for k in range(T.shape[0]):
        alike[k] = -2.0
        if not np.isfinite(place[k, 0]):
            continue
        settled = False
        for step in range(steps + 1):
            inside, mean = True, 0.0
            for i in range(n):
                x = A[k, 0, 0] * grid[i, 0] + A[k, 0, 1] * grid[i, 1] + place[k, 0]
                y = A[k, 1, 0] * grid[i, 0] + A[k, 1, 1] * grid[i, 1] + place[k, 1]
                if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
                    inside = False
                    break
                u, v = int(x), int(y)
                a, b = x - u, y - v
                seen[i] = (1 - b) * ((1 - a) * image[v, u] + a * image[v, u + 1]) + b * (
                    (1 - a) * image[v + 1, u] + a * image[v + 1, u + 1]
                )
                mean += weight[i] * seen[i]
            if not inside:
                alike[k] = -2.0
                break
            square, agree = 0.0, 0.0
            for i in range(n):
                seen[i] -= mean
                square += weight[i] * seen[i] * seen[i]
                agree += weight[i] * seen[i] * T[k, i]
            length = np.sqrt(max(square, 1e-12))
            alike[k], variance[k] = agree / length, square
            if settled or step == steps:
                break
            p = np.zeros(6)
            for j in range(6):
                for i in range(n):
                    p[j] += G[k, j, i] * (seen[i] / length - T[k, i])
            a00, a01, a10, a11 = 1 + p[0], p[1], p[2], 1 + p[3]
            det = a00 * a11 - a01 * a10
            if not 0.25 < det < 4.0:
                alike[k] = -2.0
                break
            b00, b01, b10, b11 = a11 / det, -a01 / det, -a10 / det, a00 / det
            c0, c1 = -(b00 * p[4] + b01 * p[5]), -(b10 * p[4] + b11 * p[5])
            A00, A01, A10, A11 = A[k, 0, 0], A[k, 0, 1], A[k, 1, 0], A[k, 1, 1]
            place[k, 0] += A00 * c0 + A01 * c1
            place[k, 1] += A10 * c0 + A11 * c1
            A[k, 0, 0], A[k, 0, 1] = A00 * b00 + A01 * b10, A00 * b01 + A01 * b11
            A[k, 1, 0], A[k, 1, 1] = A10 * b00 + A11 * b10, A10 * b01 + A11 * b11
            settled = abs(p[4]) + abs(p[5]) < LEAST_STEP
