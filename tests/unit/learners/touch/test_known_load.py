"""What is left of a wrench: its slopes, gains that are found again, and noise that is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.touch.known_load import BIAS, GAIN, PHI, TURN, UNKNOWNS, KnownLoad, root_of
from bodyschema.learners.touch.noise import measured_noise
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.senses.wrench_means import WrenchMeans
from bodyschema.senses.wrenches import load_regressor
from bodyschema.simulation.held_objects import held_object

STD = np.array([5e-3, 5e-3, 1e-2, 2e-4, 2e-4, 2e-4])
BOX = held_object("box").load


def means_of(load, rng, count=400, gain=None):
    """Readings of a box in many postures, by a sensor that `load` knows all about."""
    down = rng.normal(size=(count, 3))
    down *= 9.81 / np.linalg.norm(down, axis=1, keepdims=True)
    Y = load_regressor(-down, 0.5 * rng.normal(size=(count, 3)), rng.normal(size=(count, 3)))
    w = Y @ load.phi + load.bias
    R = load.R_mount_sensor
    y = np.hstack([w[:, :3] @ R, w[:, 3:] @ R]) / (1 + load.gain)
    y = y + STD * rng.normal(size=y.shape)
    return WrenchMeans(np.arange(count) / 8, y, Y, STD)


def draw_load(rng, gain_std=0.0):
    """A sensor with an offset, turned by a degree, and the box."""
    bias = np.repeat([0.5, 0.02], 3) * rng.normal(size=6)
    R = lie.exp_so3(np.radians(1) * rng.normal(size=3))
    return KnownLoad(BOX.phi, bias, R, gain_std * rng.normal(size=6))


def test_slopes_are_those_of_small_changes():
    rng = np.random.default_rng(0)
    load = draw_load(rng, 0.01)
    means = means_of(load, rng, 5)
    w, J = load.unexplained(means)
    h = 1e-6
    for i in range(UNKNOWNS):
        step = np.zeros(UNKNOWNS)
        step[i] = h
        R = lie.exp_so3(step[TURN]) @ load.R_mount_sensor
        moved = replace(load, R_mount_sensor=R, bias=load.bias + step[BIAS],
                        phi=load.phi + step[PHI], gain=load.gain + step[GAIN])  # fmt: skip
        slope = (moved.unexplained(means)[0] - w) / h
        assert J[:, :, i] == pytest.approx(slope, rel=1e-4, abs=1e-4)


def test_a_known_load_leaves_noise_alone():
    rng = np.random.default_rng(1)
    load = draw_load(rng, 0.01)
    left = Unexplained.of(means_of(load, rng), load)
    assert left.factor.shape == (400, 6, 0)
    assert np.sqrt(np.mean(left.wrench**2, axis=0)) == pytest.approx(STD, rel=0.25)


def test_gains_are_found_and_stay_as_uncertain_as_they_are():
    rng = np.random.default_rng(2)
    scaled = []
    for _ in range(40):
        truth = draw_load(rng, 0.01)
        quiet = means_of(truth, rng)
        known = np.diag(np.repeat([1e-6, 1e-6, 1e-8], [3, 6, 16]))
        believed = replace(truth, gain=np.zeros(6), covariance=known)
        found = believed.with_gains(quiet, 0.01)
        ratio = found.gain[:3] - found.gain[:3].mean() - truth.gain[:3] + truth.gain[:3].mean()
        assert np.abs(ratio).max() < 1.5e-3
        left = Unexplained.of(quiet, found).wrench
        assert np.sqrt(np.mean(left**2, axis=0)) == pytest.approx(STD, rel=0.3)
        e = found.gain - truth.gain
        scaled.append(e @ np.linalg.solve(found.covariance[GAIN, GAIN], e))
    # Six gains; what is common to forces or to torques stays at its prior.
    assert 3.5 < np.mean(scaled) < 8.5


def test_no_length_of_free_motion_tells_the_common_gain():
    rng = np.random.default_rng(5)
    truth = replace(draw_load(rng), covariance=np.diag(np.repeat([1e-6, 1e-6, 1e-8], [3, 6, 16])))
    for count in (200, 8000):
        P = truth.with_gains(means_of(truth, rng, count), 0.01).covariance[GAIN, GAIN]
        # Three independent gains of 1 % have a mean of 0.58 %.
        assert np.sqrt(np.ones(3) @ P[:3, :3] @ np.ones(3)) / 3 == pytest.approx(0.0057, rel=0.15)


def test_a_root_is_a_root():
    rng = np.random.default_rng(3)
    A = rng.normal(size=(5, 3)) * np.array([1, 1e-4, 1e2, 1e-6, 1])[:, None]
    root = root_of(A @ A.T)
    assert root.shape == (5, 3)
    assert root @ root.T == pytest.approx(A @ A.T, rel=1e-9, abs=1e-20)


def test_noise_is_measured_through_touches_and_with_its_memory():
    rng = np.random.default_rng(4)
    white = rng.normal(size=(4000, 6))
    slow = white.copy()
    for k in range(1, len(slow)):
        slow[k] = 0.5 * slow[k - 1] + np.sqrt(0.75) * white[k]
    touched = slow * STD
    touched[1000:1200] += 100 * STD
    time, none = np.arange(4000) / 8, np.zeros((4000, 6, 0))
    found = measured_noise(Unexplained(time, touched, none))
    # (1 + r) / (1 - r) = 3 for r = 0.5.
    assert np.sqrt(np.diag(found.covariance) / 3) == pytest.approx(STD, rel=0.1)
    assert 3700 < found.samples <= 3800
    plain = measured_noise(Unexplained(time, white * STD, none))
    assert np.sqrt(np.diag(plain.covariance)) == pytest.approx(STD, rel=0.1)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="30 samples"):
        measured_noise(Unexplained(np.arange(5.0), np.zeros((5, 6)), np.zeros((5, 6, 0))))
    with pytest.raises(InputError, match="phi"):
        KnownLoad(np.zeros(9))
    with pytest.raises(InputError, match="share"):
        KnownLoad(BOX.phi).with_gains(means_of(KnownLoad(BOX.phi), np.random.default_rng(0)), 1.5)
