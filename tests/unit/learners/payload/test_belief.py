"""A load's fit as an estimate over parts: derivatives, masses, and what nothing tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.estimation.loads import com_covariance, free_loads, load_of
from bodyschema.learners.payload import belief
from bodyschema.learners.payload.belief import WristFrames, load_estimate, load_identifiability
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.model.inertia import phi_of_log_cholesky
from bodyschema.senses.wrench_means import Averaging, postures
from bodyschema.senses.wrenches import load_regressor
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.simulation.loads import Held, draw_motion, draw_sensor, record, wire_box

BOX = wire_box()
LEARNER = LoadLearner(turn_std=float(np.inf))
FRAMES = WristFrames.on(None, "", np.eye(4))


@pytest.fixture(scope="module")
def samples():
    rng = np.random.default_rng(5)
    motion, sensor = draw_motion(rng, 12.0, 0.5, 100.0), draw_sensor(rng, 0.3)
    return record(motion, [Held(0.0, BOX)], sensor, rng)


@pytest.fixture(scope="module")
def fit(samples) -> PayloadFit:
    return fit_payload([Part(Averaging().means(samples), ("load",))], LEARNER)


def test_derivatives_of_the_chart(fit: PayloadFit) -> None:
    values, J = belief._charted(fit)

    def moved(theta):
        guess = fit.solution.guess
        R, bias = lie.exp_so3(theta[:3]) @ guess.R, guess.bias + theta[3:9]
        # phi itself moves, not its roots: what is linear in the fit.
        _, slope = phi_of_log_cholesky(guess.eta[0])
        eta = guess.eta[0] + np.linalg.solve(slope, theta[9:])
        there = replace(guess, R=R, bias=bias, eta=eta[None])
        return belief._charted(replace(fit, solution=replace(fit.solution, guess=there)))[0]

    for i in range(19):
        step = 1e-6 * np.eye(19)[i]
        slope = (moved(step) - moved(-step)) / 2e-6
        np.testing.assert_allclose(J[:, i], slope, atol=2e-4 * max(1.0, np.abs(slope).max()))
    assert len(values) == 19


def test_mass_and_centre_keep_their_errors(fit: PayloadFit) -> None:
    estimate = load_estimate(fit, FRAMES, LEARNER)
    assert free_loads(estimate) == ("load",)
    load, P = load_of(estimate, "load")
    believed = fit.covariance("load")
    assert load.mass == pytest.approx(BOX.mass, rel=1e-3)
    np.testing.assert_allclose(fit.R @ load.com, fit.loads["load"].com, atol=1e-9)
    assert P[0, 0] == pytest.approx(believed[0, 0], rel=0.01)
    spread = np.trace(com_covariance(load, P))
    assert spread < 3 * np.trace(com_covariance(fit.loads["load"], believed)) + 1e-9
    assert not load_identifiability(fit, estimate).directions


def test_the_body_predicts_what_a_sense_of_wrenches_reads(fit: PayloadFit) -> None:
    """Loads, offset and turn stand in the frames that `WristWrenches` expects."""
    T_flange_up = lie.transform(lie.rotation_from_rpy([0.4, 0.2, 0.0]), np.zeros(3))
    body = load_estimate(fit, FRAMES, LEARNER).body.attach("up", "flange", T_flange_up)
    sense = WristWrenches.make(
        np.zeros((1, 0)), np.zeros((1, 6)), "sensor", "up", loads=("load",), sensor=belief.SENSOR
    )
    still = np.zeros((1, 3))
    felt = load_regressor(9.81 * T_flange_up[None, :3, 2], still, still)[0]
    read = felt @ fit.loads["load"].phi + fit.solution.guess.bias
    expected = (read.reshape(2, 3) @ fit.R).ravel()
    np.testing.assert_allclose(sense.predict(body)[0], expected, atol=1e-9)


def test_what_nothing_tells_is_left_to_the_prior(samples) -> None:
    part = samples.take(np.zeros(5, dtype=int))
    fit = fit_payload([Part(postures(part), ("load",))], LoadLearner())
    estimate = load_estimate(fit, FRAMES, LoadLearner())
    assert np.linalg.eigvalsh(estimate.data_information).min() > -1e-6
    said = load_identifiability(fit, estimate)
    assert said.rank < len(estimate.variables)
    assert any("tilt the sensor" in sentence for sentence in said.sentences)
