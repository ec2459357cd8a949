"""Layouts in which recordings write poses, and their transforms."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean

Array = NDArray[np.float64]


def _from_matrix(values: Array) -> Array:
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3] = values[:, :12].reshape(-1, 3, 4)
    return T


def _from_xyzw(values: Array) -> Array:
    return lie.transform(lie.rotation_from_xyzw(values[:, 3:]), values[:, :3])


def _from_wxyz(values: Array) -> Array:
    return lie.transform(lie.rotation_from_xyzw(values[:, [4, 5, 6, 3]]), values[:, :3])


def _from_rpy(values: Array) -> Array:
    return lie.transform(lie.rotation_from_rpy(values[:, 3:]), values[:, :3])


def _from_rotation_vector(values: Array) -> Array:
    return lie.transform(lie.exp_so3(values[:, 3:]), values[:, :3])


def _from_columns(values: Array) -> Array:
    """Matrices written column by column: three or four numbers of each."""
    rows = values.shape[1] // 4
    return _from_matrix(values.reshape(-1, 4, rows).swapaxes(1, 2).reshape(len(values), -1))


def _from_order(order: str) -> Callable[[Array], Array]:
    """Three turns one after the other, about fixed axes xyz or moving axes XYZ."""
    axes = [np.eye(3)["xyz".index(letter)] for letter in order.lower()]

    def make(values: Array) -> Array:
        turns = [lie.exp_so3(values[:, 3 + i, None] * axis) for i, axis in enumerate(axes)]
        first, second, third = turns if order.isupper() else turns[::-1]
        return lie.transform(first @ second @ third, values[:, :3])

    return make


ORDERS = tuple(
    f"xyz_{order}" if fixed else f"xyz_{order.upper()}"
    for fixed in (False, True)
    for order in map("".join, itertools.product("xyz", repeat=3))
    if order[0] != order[1] != order[2]
)
"""Layouts of three angles in the order of their columns: lower case about fixed axes, upper case
about axes that move along. "xyz_rpy" is "xyz_xyz"; KUKA's A B C are "xyz_ZYX"."""

LAYOUTS: dict[str, tuple[int, list[int], Callable[[Array], Array]]] = {
    "matrix3x4": (12, [3, 7, 11], _from_matrix),
    "matrix4x4": (16, [3, 7, 11], _from_matrix),
    "xyz_xyzw": (7, [0, 1, 2], _from_xyzw),
    "xyz_wxyz": (7, [0, 1, 2], _from_wxyz),
    "xyz_rpy": (6, [0, 1, 2], _from_rpy),
    "xyz_rotvec": (6, [0, 1, 2], _from_rotation_vector),
    "matrix3x4_columns": (12, [9, 10, 11], _from_columns),
    "matrix4x4_columns": (16, [12, 13, 14], _from_columns),
    **{order: (6, [0, 1, 2], _from_order(order.removeprefix("xyz_"))) for order in ORDERS},
}
"""Name -> number of columns, which of them are lengths, and the maker; angles in rad.

Matrices are written row by row, or column by column where the name says so; xyzw and wxyz are
quaternions; rpy are URDF's fixed axes.
"""


ANGLES = ("xyz_rpy", "xyz_rotvec", *ORDERS)
"""Layouts whose last three columns are angles."""

COLUMNS = ("matrix3x4_columns", "matrix4x4_columns")
"""Layouts that are written column by column."""

NO_UNIT = 0.1
"""How far from 1 the usual length of quaternions may be: rounding of columns is far less."""

WHOLE_TURN = 6.6
"""rad; no angle of a pose is larger, a little more than a turn."""


def poses_from_columns(
    values: Array, layout: str, length_scale: float, angle_scale: float = 1.0
) -> Array:
    """Transforms (n, 4, 4) of recorded columns.

    Args:
        values: (n, columns of the layout) as recorded.
        layout: a key of `LAYOUTS`.
        length_scale: m per recorded unit of length.
        angle_scale: rad per recorded unit of angle.

    Raises:
        InputError: unknown layout, wrong number of columns, no transform, quaternions that are
            none, or angles that can be no rad.
    """
    if layout not in LAYOUTS:
        raise InputError(f"unknown pose layout '{layout}'{did_you_mean(layout, LAYOUTS)}")
    count, lengths, make = LAYOUTS[layout]
    if values.shape[1] != count:
        raise InputError(f"layout '{layout}' has {count} columns, {values.shape[1]} were named.")
    last = slice(3, None, 4) if layout in COLUMNS else slice(12, None)
    if count == 16 and (np.abs(values[:, last] - [0.0, 0.0, 0.0, 1.0]) > 1e-6).any():
        way, other = ("column by column", "matrix4x4") if layout in COLUMNS else (
            "row by row", "matrix4x4_columns"
        )  # fmt: skip
        raise InputError(
            f"layout '{layout}': the last row is not 0 0 0 1; name columns {way}, or set layout = "
            f'"{other}".'
        )
    scaled = values.copy()
    scaled[:, lengths] *= length_scale
    if layout in ANGLES:
        scaled[:, 3:] *= angle_scale
        widest = np.abs(scaled[:, 3:]).max(initial=0.0)
        if widest > WHOLE_TURN:
            raise InputError(
                f"layout '{layout}': an angle of {widest:.4g} rad is more than a turn; if the "
                'columns are in degrees, set angle_unit = "deg" for them.'
            )
    if count == 7 and len(scaled):
        sizes = np.linalg.norm(scaled[:, 3:], axis=1)
        if (sizes < 0.5).any():
            raise InputError(
                f"layout '{layout}': a quaternion has no length; check the column order."
            )
        if abs(np.median(sizes) - 1) > NO_UNIT:
            raise InputError(
                f"layout '{layout}': half of the quaternions are {np.median(sizes):.3g} long or "
                "more, where 1 is expected; check the column order."
            )
    return make(scaled)
