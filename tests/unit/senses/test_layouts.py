"""Poses as recordings write them: every layout reads back the same transforms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.senses.layouts import LAYOUTS, ORDERS, poses_from_columns

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def T() -> Array:
    rng = np.random.default_rng(0)
    return lie.transform(Rotation.random(20, rng=1).as_matrix(), rng.normal(size=(20, 3)))


def columns(T: Array, layout: str) -> Array:
    """What a recorder that counts in mm writes, by scipy's conventions."""
    R, mm = Rotation.from_matrix(T[:, :3, :3]), 1e3 * T[:, :3, 3]
    if layout.startswith("matrix"):
        big = T.copy()
        big[:, :3, 3] = mm
        if layout.endswith("_columns"):
            count = int(layout[6])
            return np.swapaxes(big[:, :count], 1, 2).reshape(-1, 4 * count)
        return big.reshape(-1, 16)[:, : LAYOUTS[layout][0]]
    parts = {
        "xyz_xyzw": R.as_quat(),
        "xyz_wxyz": R.as_quat(scalar_first=True),
        "xyz_rpy": R.as_euler("xyz"),
        "xyz_rotvec": R.as_rotvec(),
    }
    turned = parts[layout] if layout in parts else R.as_euler(layout.removeprefix("xyz_"))
    return np.hstack([mm, turned])


def test_orders_of_angles() -> None:
    """Twelve of them, each about fixed and about moving axes."""
    assert len(ORDERS) == len({*ORDERS}) == 24
    assert {"xyz_zyz", "xyz_ZYX", "xyz_XYX"} < {*ORDERS}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_reads_back(T: Array, layout: str) -> None:
    values = columns(T, layout)
    before = values.copy()
    assert poses_from_columns(values, layout, 1e-3) == pytest.approx(T, abs=1e-14)
    assert (values == before).all(), "the recording must not change"


def test_quaternions_of_any_length_and_sign(T: Array) -> None:
    values = columns(T, "xyz_xyzw")
    values[:, 3:] *= -1.001
    assert poses_from_columns(values, "xyz_xyzw", 1e-3) == pytest.approx(T, abs=1e-14)


@pytest.mark.parametrize(
    ("layout", "width", "message"),
    [
        ("xyz_xywz", 7, "unknown pose layout 'xyz_xywz'; did you mean 'xyz_"),
        ("xyz_rpy", 7, "layout 'xyz_rpy' has 6 columns, 7 were named"),
        ("xyz_wxyz", 7, "'xyz_wxyz': a quaternion has no length; check the column order"),
        ("matrix4x4", 16, "'matrix4x4': the last row is not 0 0 0 1; name columns row by row"),
    ],
)
def test_refusals_say_what_to_do(layout: str, width: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        poses_from_columns(np.zeros((3, width)), layout, 1.0)


@pytest.mark.parametrize("layout", ["xyz_rpy", "xyz_rotvec"])
def test_angles_in_degrees(T: Array, layout: str) -> None:
    values = columns(T, layout)
    values[:, 3:] = np.rad2deg(values[:, 3:])
    degree = float(np.deg2rad(1))
    assert poses_from_columns(values, layout, 1e-3, degree) == pytest.approx(T, abs=1e-12)
    with pytest.raises(InputError, match=r"is more than a turn; .*angle_unit = \"deg\""):
        poses_from_columns(values, layout, 1e-3)


def test_quaternions_that_are_none(T: Array) -> None:
    values = columns(T, "xyz_xyzw")
    values[:, 3:] *= 3
    with pytest.raises(InputError, match="half of the quaternions are 3 long or more, where 1"):
        poses_from_columns(values, "xyz_xyzw", 1e-3)
