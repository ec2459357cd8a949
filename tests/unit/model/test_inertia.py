"""Ten inertial parameters: frames, positivity, and their free root."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.inertia import (
    Inertia,
    is_physical,
    log_cholesky,
    nearest_physical,
    phi_of_log_cholesky,
    phi_of_pseudo,
    pseudo_inertia,
)


def points(rng, count=6):
    """A rigid body of point masses: the truth behind every formula here."""
    return rng.uniform(0.1, 1.0, count), rng.normal(size=(count, 3))


def phi_of_points(mass, r):
    about = sum(m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(mass, r, strict=True))
    six = about[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return np.concatenate([[mass.sum()], mass @ r, six])


def test_parameters_are_those_of_point_masses_in_every_frame():
    rng = np.random.default_rng(0)
    mass, r = points(rng)
    load = Inertia.from_phi(phi_of_points(mass, r))
    assert load.physical
    T = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
    moved = phi_of_points(mass, r @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(load.in_frame(T).phi, moved, rtol=1e-12, atol=1e-12)


def test_principal_axes_are_right_handed_and_diagonal():
    rng = np.random.default_rng(1)
    load = Inertia.from_phi(phi_of_points(*points(rng)))
    values, axes = load.principal()
    assert np.linalg.det(axes) == pytest.approx(1)
    np.testing.assert_allclose(axes @ np.diag(values) @ axes.T, load.moments, atol=1e-12)


def test_the_root_reaches_the_parameters_and_its_slope_is_that_of_differences():
    rng = np.random.default_rng(2)
    phi = phi_of_points(*points(rng))
    np.testing.assert_allclose(phi_of_pseudo(pseudo_inertia(phi)), phi, atol=1e-13)
    eta = log_cholesky(phi)
    again, J = phi_of_log_cholesky(eta)
    np.testing.assert_allclose(again, phi, rtol=1e-12, atol=1e-12)
    step = 1e-6
    for k in range(10):
        d = step * np.eye(10)[k]
        slope = (phi_of_log_cholesky(eta + d)[0] - phi_of_log_cholesky(eta - d)[0]) / (2 * step)
        np.testing.assert_allclose(J[:, k], slope, rtol=1e-7, atol=1e-7)


def test_every_root_is_a_body_and_some_parameters_are_none():
    rng = np.random.default_rng(3)
    for _ in range(50):
        assert is_physical(phi_of_log_cholesky(rng.normal(size=10))[0])
    # Moments break the triangle inequality: no body.
    impossible = Inertia(1.0, np.zeros(3), np.diag([1.0, 1.0, 3.0]))
    assert not impossible.physical
    with pytest.raises(InputError, match="not positive definite"):
        log_cholesky(impossible.phi)
    mended = nearest_physical(impossible.phi)
    assert is_physical(mended)
    np.testing.assert_allclose(mended[:4], impossible.phi[:4])
    assert not Inertia(-1.0, np.zeros(3), np.eye(3)).physical


def test_a_massless_body_is_refused():
    with pytest.raises(InputError, match="not zero"):
        Inertia.from_phi(np.zeros(10))
