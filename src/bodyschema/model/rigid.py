"""Rigid transforms, vectors and twists as values of compiled loops.

A transform is a tuple of twelve numbers, the upper three rows of its 4x4 matrix; the last row is
0 0 0 1. The compiler keeps tuples in registers, while small arrays would be allocated anew at every
node of every row: the loops over joints run two to five times faster.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.compiled import step

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Twist = tuple[float, float, float, float, float, float]
"""Linear before angular."""
Rigid = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
"""Row by row: R_00 R_01 R_02 t_0, R_10 ..., R_20 ... t_2."""

IDENTITY: Rigid = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


@step
def read(T: Array) -> Rigid:
    """The values of a rigid 4x4 transform."""
    return (
        T[0, 0], T[0, 1], T[0, 2], T[0, 3],
        T[1, 0], T[1, 1], T[1, 2], T[1, 3],
        T[2, 0], T[2, 1], T[2, 2], T[2, 3],
    )  # fmt: skip


@step
def write(A: Rigid, out: Array) -> None:
    """Fill a 4x4 array; the last row of a rigid transform is 0 0 0 1."""
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = A[0], A[1], A[2], A[3]
    out[1, 0], out[1, 1], out[1, 2], out[1, 3] = A[4], A[5], A[6], A[7]
    out[2, 0], out[2, 1], out[2, 2], out[2, 3] = A[8], A[9], A[10], A[11]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0


@step
def row(a: float, b: float, c: float, B: Rigid) -> tuple[float, float, float, float]:
    """(a, b, c) times the upper three rows of B."""
    return (
        a * B[0] + b * B[4] + c * B[8],
        a * B[1] + b * B[5] + c * B[9],
        a * B[2] + b * B[6] + c * B[10],
        a * B[3] + b * B[7] + c * B[11],
    )


@step
def product(A: Rigid, B: Rigid) -> Rigid:
    """A B."""
    a, b, c, x = row(A[0], A[1], A[2], B)
    d, e, f, y = row(A[4], A[5], A[6], B)
    g, h, i, z = row(A[8], A[9], A[10], B)
    return a, b, c, x + A[3], d, e, f, y + A[7], g, h, i, z + A[11]


@step
def quotient(A: Rigid, B: Rigid) -> Rigid:
    """A B^-1: with R = R_A R_B^T, the translation is t_A - R t_B."""
    a, b, c = rotated(B, (A[0], A[1], A[2]))
    d, e, f = rotated(B, (A[4], A[5], A[6]))
    g, h, i = rotated(B, (A[8], A[9], A[10]))
    x, y, z = B[3], B[7], B[11]
    return (
        a, b, c, A[3] - a * x - b * y - c * z,
        d, e, f, A[7] - d * x - e * y - f * z,
        g, h, i, A[11] - g * x - h * y - i * z,
    )  # fmt: skip


@step
def rotated(A: Rigid, v: Vector) -> Vector:
    """R v with the rotation part of a transform."""
    x, y, z = v
    return (
        A[0] * x + A[1] * y + A[2] * z,
        A[4] * x + A[5] * y + A[6] * z,
        A[8] * x + A[9] * y + A[10] * z,
    )


@step
def vector(v: Array) -> Vector:
    """The values of a 3-vector."""
    return v[0], v[1], v[2]


@step
def shifting(v: Vector) -> Twist:
    """The twist of a shift by v."""
    return v[0], v[1], v[2], 0.0, 0.0, 0.0


@step
def turning(w: Vector, joint: Rigid, tip: Rigid) -> Twist:
    """(w x (tip - joint), w): the twist at the tip of a rotation about a line through the joint."""
    a, b, c = w
    x, y, z = tip[3] - joint[3], tip[7] - joint[7], tip[11] - joint[11]
    return b * z - c * y, c * x - a * z, a * y - b * x, a, b, c
