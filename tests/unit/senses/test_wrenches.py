"""Wrenches of a load: the regressor, signs and frames."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrenches import Wrenches, load_regressor

LOAD = Inertia(0.6, np.array([0.02, -0.03, 0.09]), np.diag([3e-3, 2.5e-3, 1.5e-3]))


def momentum_rate(load, a_g, w, dw, step=1e-5):
    """Force and torque from differences of linear and angular momentum of points."""
    values, axes = np.linalg.eigh(load.moments)
    spread = np.sqrt(np.maximum(values.sum() / 2 - values, 0) / (2 * load.mass / 6))
    r = np.concatenate([load.com + s * axes.T * spread[:, None] for s in (1, -1)])
    m = np.full(6, load.mass / 6)

    def velocity(t):
        R = lie.exp_so3(w * t + dw * t * t / 2)
        return r @ R.T

    acceleration = (velocity(step) - 2 * velocity(0) + velocity(-step)) / step**2 + a_g
    force = m @ acceleration
    return force, (np.cross(r, acceleration) * m[:, None]).sum(axis=0)


def test_the_regressor_is_newton_and_euler_on_point_masses():
    rng = np.random.default_rng(0)
    a_g, w, dw = rng.normal(size=(3, 3))
    # exp(w t + dw t^2 / 2) has angular acceleration dw at t = 0, since w x w = 0.
    force, torque = momentum_rate(LOAD, a_g, w, dw)
    y = load_regressor(a_g, w, dw)[0] @ LOAD.phi
    np.testing.assert_allclose(y[:3], force, atol=1e-4)
    np.testing.assert_allclose(y[3:], torque, atol=1e-4)


def made(sign="on_object", **more):
    down = np.array([[0.0, 0, -9.81], [0, -9.81, 0]])
    y = load_regressor(-down, np.zeros((2, 3)), np.zeros((2, 3))) @ LOAD.phi
    s = 1 if sign == "on_object" else -1
    return Wrenches.make([0.0, 1.0], s * y[:, :3], s * y[:, 3:], down, sign, **more)


@pytest.mark.parametrize("sign", ["on_object", "on_sensor"])
def test_either_sign_leaves_nothing_over(sign):
    assert np.abs(made(sign).residual(LOAD)).max() < 1e-12
    assert made(sign).force[0, 2] == pytest.approx(0.6 * 9.81)


def test_axes_of_another_frame_are_turned():
    R = lie.exp_so3([0.3, -0.2, 0.5])
    plain = made()
    turned = Wrenches.make(
        plain.time, plain.force @ R, plain.torque @ R, plain.gravity, "on_object", R_sensor_frame=R
    )
    np.testing.assert_allclose(turned.y, plain.y, atol=1e-12)


def test_bad_samples_and_signs_are_refused_in_a_sentence():
    plain = made()
    with pytest.raises(InputError, match="force is not a finite number in sample 1"):
        Wrenches.make(
            [0, 1.0], plain.force * [[1], [np.nan]], plain.torque, plain.gravity, "on_object"
        )
    with pytest.raises(InputError, match="'on_object' or 'on_sensor', got 'up'"):
        Wrenches.make([0, 1.0], plain.force, plain.torque, plain.gravity, "up")
    with pytest.raises(InputError, match="torque should have shape"):
        Wrenches.make([0, 1.0], plain.force, plain.torque[:1], plain.gravity, "on_object")


def test_samples_are_taken_by_index():
    assert len(made().take([1])) == 1
    assert made().take([1]).gravity[0, 1] == -9.81
