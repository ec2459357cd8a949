"""Averaged wrenches and regressors: exact for a true load, whatever the motion and its source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.senses.wrench_means import WIDTH, Averaging, at_moments, postures, sensor_noise
from bodyschema.senses.wrenches import Wrenches
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.senses.wrist_twists import twists
from bodyschema.simulation.loads import Held, Sensor, draw_motion, feel, record, wire_box

BOX = wire_box()
EXACT = Sensor(np.zeros(6), np.eye(3), np.full(6, 1e-9))


@pytest.fixture(scope="module")
def motion():
    return draw_motion(np.random.default_rng(0), 6.0, 1.0, 100.0)


@pytest.fixture(scope="module")
def samples(motion):
    return record(motion, [Held(0.0, BOX)], EXACT, np.random.default_rng(1), encoder=0.0)


def worst(means):
    left = means.y - means.Y @ BOX.phi
    return np.abs(left).max(axis=0) / np.abs(means.y).max(axis=0)


def test_poses_alone_explain_the_wrench_of_a_moving_load(samples):
    assert worst(Averaging().means(samples)).max() < 2e-4


def test_neglected_acceleration_would_not(samples):
    still = replace(samples, position=np.zeros_like(samples.position))
    assert worst(Averaging().means(still)).max() > 1e-2


def test_an_accelerometer_and_a_gyroscope_do_as_well(motion):
    wrench = feel(motion, [Held(0.0, BOX)], EXACT, np.random.default_rng(2))
    felt = WristSamples(
        motion.time, wrench, gravity=-motion.a_g, angular_velocity=motion.w, carried=True
    )
    assert worst(Averaging().means(felt)).max() < 2e-4


def test_recorded_velocities_take_the_place_of_poses(motion, samples):
    recorded = replace(
        samples,
        acceleration=np.einsum("nij,nj->ni", motion.R, motion.a_g) + np.asarray(samples.down),
        angular_velocity=motion.w,
        angular_acceleration=motion.dw,
        position=None,
    )
    assert worst(Averaging().means(recorded)).max() < 2e-4


def test_uneven_time_stamps_and_gaps_are_no_error(samples):
    rng = np.random.default_rng(3)
    rows = np.sort(rng.choice(len(samples), 500, replace=False))
    rows = rows[(rows < 200) | (rows > 260)]
    means = Averaging().means(samples.take(rows))
    assert not ((means.time > 2.0) & (means.time < 2.6)).any()
    assert 5 < len(means) < len(Averaging().means(samples))
    assert worst(means).max() < 5e-3


def test_too_few_samples_are_refused_with_a_remedy(samples):
    with pytest.raises(InputError, match="longer window"):
        Averaging().means(samples.take(slice(0, 600, 20)))


def test_noise_is_seen_and_its_memory_is_that_of_the_window():
    rng = np.random.default_rng(4)
    n = 60_000
    noise = np.array([0.02, 0.02, 0.04, 5e-4, 5e-4, 5e-4])
    samples = WristSamples(
        np.arange(n) / 100, noise * rng.normal(size=(n, 6)), rotation=np.tile(np.eye(3), (n, 1, 1))
    )
    np.testing.assert_allclose(sensor_noise(samples.wrench), noise, rtol=0.03)
    means = Averaging().means(samples)
    np.testing.assert_allclose(means.y.std(axis=0), means.std, rtol=0.05)
    blocks = means.y[: len(means) // 50 * 50].reshape(-1, 50, 6).mean(axis=1)
    slow = 50 * (blocks.var(axis=0) / means.y.var(axis=0))
    assert slow.mean() == pytest.approx(means.memory, rel=0.15)
    assert means.memory == pytest.approx(3 * WIDTH)


def test_postures_are_rows_at_rest(samples):
    rows = samples.take(slice(0, 10))
    means = postures(rows)
    expected = -np.einsum("nji,j->ni", rows.rotation, np.asarray(rows.down))
    np.testing.assert_allclose(means.Y[:, :3, 0], expected, atol=1e-12)


def test_known_accelerations_need_no_mean(motion):
    y = feel(motion, [Held(0.0, BOX)], EXACT, np.random.default_rng(5))
    still = motion.a_g * 0
    felt = Wrenches.make(
        motion.time, y[:, :3], y[:, 3:], still, "on_object",
        acceleration=motion.a_g, angular_velocity=motion.w, angular_acceleration=motion.dw,
    )  # fmt: skip
    assert worst(at_moments(felt)).max() < 1e-6


def test_the_way_down_must_be_known():
    with pytest.raises(InputError, match="way down"):
        WristSamples(np.arange(3.0), np.zeros((3, 6)))


def test_velocities_do_not_reach_over_a_gap(samples):
    rows = np.r_[0:150, 350:353, 360:400]
    split = samples.take(rows)
    later = replace(split, time=split.time + 600.0 * ((rows >= 350) + 1.0 * (rows >= 360)))
    for got, wanted in zip(twists(later), twists(samples), strict=True):
        np.testing.assert_allclose(got, wanted[rows], atol=0.02 * np.abs(wanted).max())
