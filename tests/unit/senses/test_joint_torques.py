"""Joint torques of an arm: the regressor, what it can tell, and links that can exist."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.export.urdf_writer import write_urdf
from bodyschema.learners.payload.arm import arm_covariance, fit_arm
from bodyschema.model.inertia import is_physical
from bodyschema.model.motion import Motion
from bodyschema.senses.joint_torques import (
    arm_regressor,
    base_directions,
    motor_regressor,
    moved_links,
)
from bodyschema.simulation.katana import katana


def moving(n, seed=0):
    rng = np.random.default_rng(seed)
    return Motion(*(scale * rng.normal(size=(n, 5)) for scale in (1.0, 1.5, 4.0)))


def test_pinocchio_has_the_same_regressor(tmp_path):
    pin = pytest.importorskip("pinocchio")
    path = tmp_path / "arm.urdf"
    path.write_bytes(write_urdf(katana()))
    model = pin.buildModelFromUrdf(str(path))
    data, motion = model.createData(), moving(4)
    W = arm_regressor(katana(), motion)
    for k in range(4):
        theirs = pin.computeJointTorqueRegressor(
            model, data, motion.q[k], motion.dq[k], motion.ddq[k]
        )
        np.testing.assert_allclose(W[k], theirs, atol=1e-11)


def test_base_directions_span_all_that_torques_show():
    W = arm_regressor(katana(), moving(60)).reshape(300, -1)
    directions, members = base_directions(W)
    length = np.where(np.linalg.norm(W, axis=0) > 0, np.linalg.norm(W, axis=0), 1.0)
    scaled = W / length
    np.testing.assert_allclose(scaled @ directions @ directions.T, scaled, atol=1e-6)
    assert directions.shape[1] == len(members) == np.linalg.matrix_rank(scaled, tol=1e-6)
    assert directions.shape[1] < W.shape[1]


def test_a_coupled_motor_brakes_both_joints():
    G = np.eye(5)
    G[4, 3] = 1.0
    W = motor_regressor(moving(3), G)
    assert W.shape == (3, 5, 20)
    np.testing.assert_allclose(W[:, 3, 16:], W[:, 4, 16:])


def test_torques_give_real_links_and_brakes_back():
    motion, G = moving(400, 1), np.eye(5)
    W = np.concatenate([arm_regressor(katana(), motion), motor_regressor(motion, G)], axis=2)
    rng = np.random.default_rng(2)
    links = len(moved_links(katana()))
    truth = fit_arm(W[:1], rng.normal(size=(1, 5)), links, rounds=1)  # some arm that can exist
    tau = W @ truth.x + 0.02 * rng.normal(size=(400, 5))
    found = fit_arm(W[:300], tau[:300], links)
    left = tau[300:] - W[300:] @ found.x
    assert np.sqrt(np.mean(left**2)) < 0.024
    assert all(is_physical(phi) for phi in found.x[: 10 * links].reshape(-1, 10))
    assert (found.x[10 * links :].reshape(-1, 4)[:, :3] > 0).all()


def test_error_bars_hold_the_torque_and_grow_with_what_errs_in_common():
    motion, G = moving(200, 4), np.eye(5)
    W = np.concatenate([arm_regressor(katana(), motion), motor_regressor(motion, G)], axis=2)
    rng, links = np.random.default_rng(5), len(moved_links(katana()))
    truth = fit_arm(W[:1], rng.normal(size=(1, 5)), links, rounds=1)
    tau = W @ truth.x + 0.05 * rng.normal(size=(200, 5))
    slow = 0.05 * np.repeat(rng.normal(size=(10, 5)), 20, axis=0)
    stds, z = [], []
    for observed in (tau, tau + slow):
        found = fit_arm(W, observed, links)
        C = arm_covariance(W, observed, found)
        std = np.sqrt(np.einsum("njp,pq,njq->nj", W, C, W))
        stds.append(std.mean())
        z.append(np.sqrt(np.mean(((W @ (found.x - truth.x)) / std) ** 2)))
    assert 0.6 < z[0] < 1.4
    assert z[1] < 1.4
    assert stds[1] > 1.5 * stds[0]
