"""Inertial parameters and the wrench of a load against Pinocchio and MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.model.inertia import Inertia, log_cholesky, phi_of_log_cholesky
from bodyschema.senses.wrenches import load_regressor

pin = pytest.importorskip("pinocchio")
mujoco = pytest.importorskip("mujoco")


def test_pinocchio_has_the_same_regressor_roots_and_frames():
    rng = np.random.default_rng(0)
    for _ in range(20):
        eta = 0.5 * rng.normal(size=10)
        phi, _ = phi_of_log_cholesky(eta)
        np.testing.assert_allclose(pin.LogCholeskyParameters(eta).toDynamicParameters(), phi)
        np.testing.assert_allclose(log_cholesky(phi), eta, atol=1e-9)
        load = Inertia.from_phi(phi)
        theirs = pin.Inertia(load.mass, load.com, load.moments)
        np.testing.assert_allclose(theirs.toDynamicParameters(), phi)
        T = pin.SE3.Random()
        moved = T.act(theirs).toDynamicParameters()
        np.testing.assert_allclose(load.in_frame(T.homogeneous).phi, moved, atol=1e-12)
        a, w, dw = rng.normal(size=(3, 3))
        Y = pin.bodyRegressor(pin.Motion(np.zeros(3), w), pin.Motion(a, dw))
        np.testing.assert_allclose(load_regressor(a, w, dw)[0], Y, atol=1e-12)


MODEL = """
<mujoco><option gravity="0 0 -9.81" integrator="Euler"/><worldbody>
<body name="wrist"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>
<body name="load" pos="0 0 0"><site name="sensor"/>
<inertial pos="0.02 -0.03 0.09" mass="0.6" fullinertia="3e-3 2.5e-3 1.5e-3 1e-4 -2e-4 3e-4"/>
</body></body></worldbody>
<sensor><force site="sensor"/><torque site="sensor"/>
<accelerometer site="sensor"/><gyro site="sensor"/></sensor></mujoco>
"""


def test_mujoco_feels_the_same_wrench_at_the_wrist():
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    moments = np.array([[3e-3, 1e-4, -2e-4], [1e-4, 2.5e-3, 3e-4], [-2e-4, 3e-4, 1.5e-3]])
    load = Inertia(0.6, np.array([0.02, -0.03, 0.09]), moments)
    rng = np.random.default_rng(1)
    for _ in range(5):
        data.qpos[:3] = rng.normal(size=3)
        data.qpos[3:] = np.roll(lie.quaternion_xyzw(lie.exp_so3(rng.normal(size=3))), 1)
        data.qvel[:] = rng.normal(size=6)
        data.qacc[:] = data.qfrc_applied[:] = rng.normal(size=6)
        mujoco.mj_forward(model, data)
        force, torque, specific, gyro = data.sensordata.reshape(4, 3)
        # The angular acceleration of a free body in its own frame is the joint's.
        Y = load_regressor(specific, gyro, data.qacc[3:6])[0]
        y = Y @ load.phi
        # MuJoCo tells what the parent exerts on the child, along the site's axes.
        np.testing.assert_allclose(y, np.concatenate([force, torque]), atol=1e-9)
