"""Rows of a load's fit, what inflates it, and its rivals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrench_means import Averaging, WrenchMeans
from bodyschema.simulation.loads import Held, draw_motion, draw_sensor, record, wire_box
from bodyschema.trust.wrench_doubt import doubt, foretold, repair
from bodyschema.trust.wrench_inflation import inflations
from bodyschema.trust.wrench_rivals import TORQUE
from bodyschema.trust.wrench_rows import WrenchRows, blocks, central_slope, slopes

LEARNER = LoadLearner()


@pytest.fixture(scope="module")
def means() -> WrenchMeans:
    """Twelve seconds of the box."""
    rng = np.random.default_rng(5)
    motion, sensor = draw_motion(rng, 12.0, 0.5, 100.0), draw_sensor(rng, 0.02)
    return Averaging().means(record(motion, [Held(0.0, wire_box())], sensor, rng))


def fitted(means: WrenchMeans) -> PayloadFit:
    return fit_payload([Part(means, ("load",))], LEARNER)


def test_slopes_of_the_central_moments() -> None:
    load = wire_box()
    J, found = central_slope(load.phi), np.zeros((6, 10))
    for k, d in enumerate(1e-6 * np.eye(10)):
        ends = [Inertia.from_phi(load.phi + s * d).moments for s in (1, -1)]
        step = (ends[0] - ends[1]) / 2e-6
        found[:, k] = [step[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    np.testing.assert_allclose(J, found, atol=1e-8)


def test_a_stretch_is_foretold_as_by_a_fit_without_it(means: WrenchMeans) -> None:
    everything = WrenchRows.of(fitted(means), LEARNER)
    rows = everything.take(everything.counts)
    some = blocks(next(rows.clusters()))[3]
    rest = np.setdiff1d(np.arange(len(rows)), some)
    A, z = rows.A[rest].reshape(-1, 19), rows.z[rest].ravel()
    # The fit lies at the minimum of all rows and the prior together.
    pull = rows.A.reshape(-1, 19).T @ rows.z.ravel()
    step = np.linalg.solve(A.T @ A + np.diag(rows.precision), A.T @ z - pull)
    left = rows.z[some] - rows.A[some] @ step
    assert foretold(rows)[3] == pytest.approx(float(np.sum(left**2)), rel=1e-3)


def test_white_noise_inflates_little_and_what_is_common_much(means: WrenchMeans) -> None:
    fit = fitted(means)
    everything = WrenchRows.of(fit, LEARNER)
    rows = everything.take(everything.counts)
    asked, rng = slopes(fit, 0), np.random.default_rng(0)
    alike = next(rows.clusters())
    clean, common = [], []
    for _ in range(20):
        z = rng.normal(size=rows.z.shape)
        clean.append(inflations(replace(rows, z=z), asked)["centre"])
        z = z + rng.normal(size=(alike.max() + 1, 6))[alike]
        common.append(inflations(replace(rows, z=z), asked)["centre"])
    assert np.median(clean) < 1.5
    assert np.median(common) > 2.0


def test_a_drift_is_found_and_taken_off(means: WrenchMeans) -> None:
    share = (means.time - means.time[0]) / np.ptp(means.time)
    by = np.array([0.3, -0.2, 0.1, 0.3 * TORQUE, 0.0, 0.1 * TORQUE])
    off = np.outer(1 - np.exp(-3 * share), by)
    fit = fitted(replace(means, y=means.y + off))
    made = repair(fit, LEARNER, None, ("drift",))
    assert made is not None
    R = fit.R
    wanted = np.hstack([off[:, :3] @ R.T, off[:, 3:] @ R.T])
    apart = made[1] - wanted
    # A constant belongs to the offset.
    assert np.std(apart, axis=0)[:3].max() < 0.1 * 0.3
    assert repair(fit, LEARNER, None, ("tilt",)) is None
    left = doubt(fit, LEARNER, None)
    assert left.left[0].family == "drift"
    assert np.trace(left.whole - left.core) > 0


def test_nothing_is_found_in_a_good_recording(means: WrenchMeans) -> None:
    fit = fitted(means)
    found = doubt(fit, LEARNER, None)
    assert not found.left
    assert repair(fit, LEARNER, None, ("drift", "jump", "lag", "gains")) is None
    assert np.linalg.eigvalsh(found.whole)[0] > -1e-12
