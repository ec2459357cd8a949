"""The chart round a reference body: from a parameter vector x to axes, placements and back-slopes.

    axis    a(b) = a cos t + B b sin t / t,  t = |b|,  B the tangent basis of the reference axis a
            da/db = -a b^T s/t + B s/t + (B b) b^T (t c - s) / t^3
    turn    R(w) = R_0 exp(w);  a change of w turns the placement by J_right(w) in its own frame
            J_right(w) = 1 - (1-c)/t^2 W + (t-s)/t^3 W^2,  t = |w|,  W = [w]x
    link    l = l_0 + x

All at once in one compiled pass: this runs at every step of the recursive learner. Arrays are
copied by loops and made outside: an assignment of slices would have their shapes told in a message,
whose text alone takes the compiler four seconds, and each new array a tenth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.compiled import step
from bodyschema.model.kernels import AXIS, GEAR, LINK, OFFSET, PART, TURN, kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SERIES_BELOW = 1e-3
"""rad; under it the quotients of trigonometric functions use their series (error < 1e-15)."""


@step
def tilt(axis: Array, basis: Array, b: Array, slope: Array) -> None:
    """Move an axis (3,) over the sphere, in place; fills slope (3, 2) = d axis / d b."""
    t = np.hypot(b[0], b[1])
    if t < SERIES_BELOW:
        sine, cubic = 1.0 - t * t / 6.0, -1.0 / 3.0 + t * t / 30.0
    else:
        sine, cubic = np.sin(t) / t, (t * np.cos(t) - np.sin(t)) / t**3
    c = np.cos(t)
    length = 0.0
    for i in range(3):
        normal = basis[i, 0] * b[0] + basis[i, 1] * b[1]
        for j in range(2):
            slope[i, j] = -axis[i] * b[j] * sine + basis[i, j] * sine + normal * b[j] * cubic
        axis[i] = c * axis[i] + sine * normal
        length += axis[i] * axis[i]
    for i in range(3):
        axis[i] /= np.sqrt(length)


@step
def turn(w: Array, rotation: Array, slope: Array) -> None:
    """Fills rotation (3, 3) = exp(w) and slope (3, 3) = J_right(w)."""
    t2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    t = np.sqrt(t2)
    if t < SERIES_BELOW:
        sine, cosine, cubic = 1.0 - t2 / 6.0, 0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0
    else:
        sine, cosine, cubic = np.sin(t) / t, (1.0 - np.cos(t)) / t2, (t - np.sin(t)) / (t * t2)
    for i in range(3):
        for j in range(3):
            square = w[i] * w[j] - (t2 if i == j else 0.0)
            one = 1.0 if i == j else 0.0
            # W_ij = -w_k where i j k run as 0 1 2, w_k where they run backward.
            cross = 0.0 if i == j else -w[3 - i - j] if (j - i) % 3 == 1 else w[3 - i - j]
            rotation[i, j] = one + sine * cross + cosine * square
            slope[i, j] = one - cosine * cross + cubic * square


def deviate(
    code: Ints,
    index: Ints,
    component: Ints,
    x: Array,
    basis: Array,
    axis: Array,
    placement: Array,
    gear: Array,
    offset: Array,
    direction: Array,
) -> None:
    """Turn the reference into the body at x, in place, and fill direction (n_parameters, 3).

    `direction[p]` is the derivative of the axis, link or turn with respect to x[p], in the frame
    that `kernels.parameter_twist` expects; zero for offsets, gears and parts.
    """
    n = len(axis)
    local, seen, slope = np.zeros((n, 3)), np.zeros(n, np.int64), np.zeros((n, 3, 3))
    _deviate(
        code, index, component, x, basis, axis, placement, gear, offset, direction,
        local, seen, slope, np.zeros((3, 3)),
    )  # fmt: skip


@kernel
def _deviate(
    code: Ints,
    index: Ints,
    component: Ints,
    x: Array,
    basis: Array,
    axis: Array,
    placement: Array,
    gear: Array,
    offset: Array,
    direction: Array,
    local: Array,
    seen: Ints,
    slope: Array,
    rotation: Array,
) -> None:
    """See `deviate`; the last four are room for each frame's b or w (n, 3), which of them it is
    (n,), its slope (n, 3, 3), and one turn (3, 3). They come in as zeros."""
    for p in range(code.shape[0]):
        if code[p] >= PART:
            continue
        k, c = index[p], component[p]
        if code[p] == OFFSET:
            offset[k] += x[p]
        elif code[p] == GEAR:
            gear[k] += x[p]
        elif code[p] == LINK:
            placement[k, c, 3] += x[p]
            direction[p, c] = 1.0
        else:
            local[k, c] = x[p]
            seen[k] = code[p]
    for k in range(axis.shape[0]):
        if seen[k] == AXIS:
            tilt(axis[k], basis[k], local[k], slope[k])
        elif seen[k] == TURN:
            turn(local[k], rotation, slope[k])
            for i in range(3):
                a, b, c = placement[k, i, 0], placement[k, i, 1], placement[k, i, 2]
                for j in range(3):
                    placement[k, i, j] = (
                        a * rotation[0, j] + b * rotation[1, j] + c * rotation[2, j]
                    )
    for p in range(code.shape[0]):
        if code[p] == AXIS or code[p] == TURN:
            for i in range(3):
                direction[p, i] = slope[index[p], i, component[p]]
