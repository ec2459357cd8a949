"""The chart round a reference body: from a parameter vector x to axes, placements and back-slopes.

    axis    a(b) = a cos t + B b sin t / t,  t = |b|,  B the tangent basis of the reference axis a
            da/db = -a b^T s/t + B s/t + (B b) b^T (t c - s) / t^3
    turn    R(w) = R_0 exp(w);  a change of w turns the placement by J_right(w) in its own frame
            J_right(w) = 1 - (1-c)/t^2 W + (t-s)/t^3 W^2,  t = |w|,  W = [w]x
    link    l = l_0 + x

All at once in one compiled pass: this runs at every step of the recursive learner.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import AXIS, GEAR, LINK, OFFSET, PART, TURN, kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SERIES_BELOW = 1e-3
"""rad; under it the quotients of trigonometric functions use their series (error < 1e-15)."""


@kernel
def tilt(axis: Array, basis: Array, b: Array, moved: Array, slope: Array) -> None:
    """Move an axis over the sphere: fills moved (3,) and slope (3, 2) = d moved / d b."""
    t = np.hypot(b[0], b[1])
    if t < SERIES_BELOW:
        sine, cubic = 1.0 - t * t / 6.0, -1.0 / 3.0 + t * t / 30.0
    else:
        sine, cubic = np.sin(t) / t, (t * np.cos(t) - np.sin(t)) / t**3
    c = np.cos(t)
    length = 0.0
    for i in range(3):
        normal = basis[i, 0] * b[0] + basis[i, 1] * b[1]
        moved[i] = c * axis[i] + sine * normal
        length += moved[i] * moved[i]
        for j in range(2):
            slope[i, j] = -axis[i] * b[j] * sine + basis[i, j] * sine + normal * b[j] * cubic
    for i in range(3):
        moved[i] /= np.sqrt(length)


@kernel
def turn(w: Array, rotation: Array, slope: Array) -> None:
    """Fills rotation (3, 3) = exp(w) and slope (3, 3) = J_right(w)."""
    t2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    t = np.sqrt(t2)
    if t < SERIES_BELOW:
        sine, cosine, cubic = 1.0 - t2 / 6.0, 0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0
    else:
        sine, cosine, cubic = np.sin(t) / t, (1.0 - np.cos(t)) / t2, (t - np.sin(t)) / (t * t2)
    cross = np.zeros((3, 3))
    cross[0, 1], cross[0, 2], cross[1, 2] = -w[2], w[1], -w[0]
    cross[1, 0], cross[2, 0], cross[2, 1] = w[2], -w[1], w[0]
    for i in range(3):
        for j in range(3):
            square = w[i] * w[j] - (t2 if i == j else 0.0)
            one = 1.0 if i == j else 0.0
            rotation[i, j] = one + sine * cross[i, j] + cosine * square
            slope[i, j] = one - cosine * cross[i, j] + cubic * square


@kernel
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
    frames = axis.shape[0]
    local = np.zeros((frames, 3))
    seen = np.zeros(frames, np.int64)
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
    moved, slope = np.empty(3), np.zeros((frames, 3, 3))
    rotation, old = np.empty((3, 3)), np.empty((3, 3))
    for k in range(frames):
        if seen[k] == AXIS:
            tilt(axis[k], basis[k], local[k], moved, slope[k])
            axis[k] = moved
        elif seen[k] == TURN:
            turn(local[k], rotation, slope[k])
            old[:] = placement[k, :3, :3]
            for i in range(3):
                for j in range(3):
                    placement[k, i, j] = (
                        old[i, 0] * rotation[0, j]
                        + old[i, 1] * rotation[1, j]
                        + old[i, 2] * rotation[2, j]
                    )
    for p in range(code.shape[0]):
        if code[p] == AXIS or code[p] == TURN:
            for i in range(3):
                direction[p, i] = slope[index[p], i, component[p]]
