"""Rotations and transforms: round trips, Jacobians, and two other libraries as oracles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bodyschema import lie

Array = NDArray[np.float64]

properties = settings(derandomize=True, deadline=None, database=None, max_examples=200)

ANGLES = st.one_of(
    st.floats(0, np.pi),
    st.floats(0, 1e-3),
    st.sampled_from([0.0, 1e-100, 1e-16, 1e-8, 1e-5, 9.9999e-5, 1e-4, 1.0001e-4, 1e-2, np.pi]),
    st.floats(1e-16, 1e-3).map(lambda gap: np.pi - gap),
)
"""rad, thickest where the formulas change: near 0 and near pi."""


@st.composite
def directions(draw: st.DrawFn) -> Array:
    """Unit vectors, with zero and tiny components as likely as any."""
    component = st.one_of(st.floats(-1, 1), st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-9, -1e-17]))
    v = np.array([draw(component) for _ in range(3)])
    length = np.linalg.norm(v)
    return v / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])


@st.composite
def rotation_vectors(draw: st.DrawFn) -> Array:
    return np.asarray(draw(directions()) * draw(ANGLES))


def differences(function: Callable[[Array], Array], step: float = 1e-6) -> Array:
    """Central differences at zero of a function of a 3-vector: columns d f / d v_i."""
    turns = step * np.eye(3)
    return np.stack([(function(d) - function(-d)) / (2 * step) for d in turns], axis=-1)


@properties
@given(rotation_vectors())
def test_log_undoes_exp(w: Array) -> None:
    back = lie.log_so3(lie.exp_so3(w))
    # At pi, w and -w are the same rotation.
    sign = -1.0 if np.linalg.norm(w) > 3 and np.dot(back, w) < 0 else 1.0
    assert np.abs(sign * back - w).max() < 1e-14 * (1 + np.linalg.norm(w))
    assert np.linalg.norm(back) <= np.pi + 1e-15


@properties
@given(rotation_vectors())
def test_small_angles_keep_their_relative_accuracy(w: Array) -> None:
    tiny = w * 1e-9
    assert np.abs(lie.log_so3(lie.exp_so3(tiny)) - tiny).max() <= 1e-14 * np.linalg.norm(tiny)


@properties
@given(rotation_vectors())
def test_exp_agrees_with_scipy_and_is_a_rotation(w: Array) -> None:
    R = lie.exp_so3(w)
    assert np.abs(R - Rotation.from_rotvec(w).as_matrix()).max() < 4e-15
    assert np.abs(R @ R.T - np.eye(3)).max() < 4e-15
    assert np.linalg.det(R) == pytest.approx(1.0, abs=4e-15)


@properties
@given(rotation_vectors())
def test_left_and_right_jacobian_against_differences(w: Array) -> None:
    R = lie.exp_so3(w)
    left = differences(lambda d: lie.log_so3(lie.exp_so3(w + d) @ R.T))
    right = differences(lambda d: lie.log_so3(R.T @ lie.exp_so3(w + d)))
    assert np.abs(left - lie.left_jacobian(w)).max() < 1e-9
    assert np.abs(right - lie.right_jacobian(w)).max() < 1e-9
    assert np.abs(R @ lie.right_jacobian(w) - lie.left_jacobian(w)).max() < 1e-14


@properties
@given(rotation_vectors())
def test_inverse_left_jacobian_is_the_inverse(w: Array) -> None:
    product = lie.inverse_left_jacobian(w) @ lie.left_jacobian(w)
    assert np.abs(product - np.eye(3)).max() < 1e-13


@properties
@given(st.floats(0, 3.0), directions())
def test_inverse_left_jacobian_against_differences(angle: float, direction: Array) -> None:
    w = angle * direction
    R = lie.exp_so3(w)
    slope = differences(lambda d: lie.log_so3(lie.exp_so3(d) @ R))
    assert np.abs(slope - lie.inverse_left_jacobian(w)).max() < 1e-7


@properties
@given(rotation_vectors())
def test_jacobians_agree_with_pytransform3d(w: Array) -> None:
    rotations = pytest.importorskip("pytransform3d.rotations")
    assert np.abs(lie.exp_so3(w) - rotations.matrix_from_compact_axis_angle(w)).max() < 1e-14
    if np.linalg.norm(w) > 1e-3:  # its own closed form loses digits below
        oracle = rotations.left_jacobian_SO3(w)
        assert np.abs(lie.left_jacobian(w) - oracle).max() < 1e-9
        inverse = rotations.left_jacobian_SO3_inv(w)
        assert np.abs(lie.inverse_left_jacobian(w) - inverse).max() < 1e-9


@properties
@given(rotation_vectors())
def test_quaternions_round_trip_and_agree_with_scipy(w: Array) -> None:
    R = lie.exp_so3(w)
    q = lie.quaternion_xyzw(R)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    assert q[3] >= 0
    assert np.abs(lie.rotation_from_xyzw(q) - R).max() < 2e-15
    oracle = Rotation.from_rotvec(w).as_quat()
    assert min(np.abs(q - oracle).max(), np.abs(q + oracle).max()) < 1e-15
    assert np.abs(lie.rotation_from_xyzw(-7.5 * q) - R).max() < 2e-15


@properties
@given(st.lists(st.floats(-np.pi, np.pi), min_size=3, max_size=3))
def test_rpy_is_the_fixed_axis_convention(rpy: list[float]) -> None:
    rotations = pytest.importorskip("pytransform3d.rotations")
    R = lie.rotation_from_rpy(rpy)
    assert np.abs(R - Rotation.from_euler("xyz", rpy).as_matrix()).max() < 2e-15
    oracle = rotations.matrix_from_euler(rpy, 0, 1, 2, extrinsic=True)
    assert np.abs(R - oracle).max() < 2e-15
    assert np.abs(lie.rotation_from_rpy(lie.rpy_from_rotation(R)) - R).max() < 3e-15


@properties
@given(
    st.floats(-np.pi, np.pi),
    st.floats(-np.pi, np.pi),
    st.sampled_from([0.0, 1e-14, 1e-13, 1e-11, 1e-9, 1e-7, 1e-4]),
    st.sampled_from([-1, 1]),
    directions(),
)
def test_rpy_round_trip_near_gimbal_lock(
    roll: float, yaw: float, gap: float, side: int, direction: Array
) -> None:
    # The way round a third frame leaves rounding errors as real rotations have them.
    detour = lie.exp_so3(direction)
    R = detour.T @ (detour @ lie.rotation_from_rpy([roll, side * (np.pi / 2 - gap), yaw]))
    back = lie.rpy_from_rotation(R)
    assert np.abs(lie.rotation_from_rpy(back) - R).max() < 2e-12
    if gap == 0.0:
        assert back[2] == 0.0


@properties
@given(directions(), st.sampled_from([0.0, -0.0, 1e-17, -1e-17, 1e-12, -1e-12]))
def test_tangent_basis_is_orthonormal_near_the_equator(axis: Array, z: float) -> None:
    a = np.array([axis[0], axis[1], z])
    a = a / np.linalg.norm(a) if np.linalg.norm(a) > 0.1 else axis
    assert_triad(a)
    assert_triad(axis)


@properties
@given(st.floats(0, 1e-6), st.floats(-np.pi, np.pi), st.sampled_from([-1.0, 1.0]))
def test_tangent_basis_has_no_pole(tilt: float, around: float, pole: float) -> None:
    a = np.array([np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around), pole])
    assert_triad(a / np.linalg.norm(a))


def assert_triad(axis: Array) -> None:
    triad = np.column_stack([lie.tangent_basis(axis), axis])
    assert np.abs(triad.T @ triad - np.eye(3)).max() < 1e-15
    assert np.linalg.det(triad) == pytest.approx(1.0, abs=2e-15)


def test_transform_and_inverse() -> None:
    rng = np.random.default_rng(0)
    R, t = lie.exp_so3(rng.normal(size=(4, 5, 3))), rng.normal(size=(4, 5, 3))
    T = lie.transform(R, t)
    assert np.abs(lie.inverse(T) @ T - np.eye(4)).max() < 1e-14
    assert np.abs(lie.inverse(T) - np.linalg.inv(T)).max() < 1e-14
    assert lie.transform(R[0, 0], t).shape == (4, 5, 4, 4)


def test_batches_equal_singles() -> None:
    rng = np.random.default_rng(1)
    w = rng.normal(size=(2, 3, 3)) * np.array([1e-6, 1.0, 2.0])[:, None]
    R = lie.exp_so3(w)
    for function, batch in (
        (lie.skew, w),
        (lie.exp_so3, w),
        (lie.left_jacobian, w),
        (lie.inverse_left_jacobian, w),
        (lie.rotation_from_rpy, w),
        (lie.tangent_basis, w / np.linalg.norm(w, axis=-1, keepdims=True)),
        (lie.log_so3, R),
        (lie.quaternion_xyzw, R),
        (lie.rpy_from_rotation, R),
    ):
        singles = np.array([[function(one) for one in row] for row in batch])
        assert np.abs(function(batch) - singles).max() < 1e-15
