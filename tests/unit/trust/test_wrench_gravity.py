"""Gravity that points elsewhere than is declared, as far as sixty degrees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.senses.wrench_means import postures
from bodyschema.senses.wrenches import load_regressor
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.loads import wire_box
from bodyschema.trust.wrench_doubt import doubt, repair
from bodyschema.trust.wrench_gravity import lean
from bodyschema.trust.wrench_rivals import GRAVITY, noise_beside, tilts, way_down, wrench_rivals
from bodyschema.trust.wrench_rows import WrenchRows

LEARNER, BOX = LoadLearner(), wire_box()
NOISE = np.repeat([0.1, 0.005], 3)


def leaning(
    degrees: float, seed: int = 0, n: int = 40, gain: float = 0.0
) -> tuple[PayloadFit, np.ndarray]:
    """Postures on a base that leans towards x, fitted as if it did not; and R_world."""
    rng = np.random.default_rng([31, seed])
    R = lie.exp_so3(rng.uniform(-1.5, 1.5, size=(n, 3)))
    down = way_down(np.array([np.tan(np.radians(degrees)), 0.0]))
    a_g = -GRAVITY * np.einsum("nji,j->ni", R, down)
    y = load_regressor(a_g, np.zeros((n, 3)), np.zeros((n, 3))) @ BOX.phi
    mixing = np.diag(1 + gain * np.array([1, -1, 1, -1, 1, -1]))
    y = y @ mixing + NOISE * rng.normal(size=(n, 6))
    samples = WristSamples(np.arange(float(n)), y, rotation=R, position=np.zeros((n, 3)))
    return fit_payload([Part(postures(samples), ("load",))], LEARNER), R


def test_slopes_of_the_way_down() -> None:
    fit, R = leaning(10.0)
    rows, gamma, h = WrenchRows.of(fit, LEARNER), np.array([0.3, -0.2]), 1e-6
    still = np.zeros((len(R), 3))

    def wrench(gamma: np.ndarray) -> np.ndarray:
        a_g = -GRAVITY * np.einsum("nji,j->ni", R, way_down(gamma))
        Y = load_regressor(a_g, still, still)
        return np.asarray(np.einsum("nij,nj->ni", Y, rows.carried))

    found = tilts(rows, R, gamma)
    for k, d in enumerate(h * np.eye(2)):
        slope = (wrench(gamma + d) - wrench(gamma - d)) / (2 * h)
        np.testing.assert_allclose(found[:, :, k], slope, atol=1e-7)


@pytest.mark.parametrize("degrees", [3.0, 30.0, 55.0])
def test_a_base_that_leans_is_found_by_the_wrench(degrees: float) -> None:
    fit, R = leaning(degrees)
    found = lean(fit, LEARNER, R)
    assert found is not None
    off = way_down(found.gamma) @ way_down(np.array([np.tan(np.radians(degrees)), 0.0]))
    assert np.degrees(np.arccos(min(float(off), 1.0))) < 1.0
    assert found.fit.loads["load"].mass == pytest.approx(BOX.mass, rel=0.01)
    left = np.concatenate(
        [found.fit.residuals(0)[:, :3] / 0.1, found.fit.residuals(0)[:, 3:] / 5e-3]
    )
    assert np.sqrt(np.mean(left**2)) < 1.1


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("degrees", [10.0, 30.0, 55.0])
def test_it_beats_its_rivals(degrees: float, seed: int) -> None:
    """Seen from where the fit rests, drift or gains explain a large one better."""
    fit, R = leaning(degrees, seed)
    made = repair(fit, LEARNER, R, ("tilt", "lag"))
    assert made is not None
    assert made[0].family == "tilt"
    assert np.degrees(np.arctan(np.linalg.norm(made[0].gamma))) == pytest.approx(degrees, abs=1.5)
    assert doubt(fit, LEARNER, R).left[0].family == "tilt"


@pytest.mark.parametrize("seed", range(4))
def test_seven_postures_tell_it(seed: int) -> None:
    """In the levels of the fit as declared it is noise."""
    fit, R = leaning(10.0, seed, n=7)
    made = repair(fit, LEARNER, R, ("tilt",))
    assert made is not None
    assert made[0].p_value < 1e-6
    level, far = leaning(0.0, seed, n=7)
    assert repair(level, LEARNER, far, ("tilt",)) is None


@pytest.mark.parametrize("degrees", [66.0, 80.0])
def test_one_that_lies_on_its_side_is_not_put_right(degrees: float) -> None:
    fit, R = leaning(degrees)
    assert repair(fit, LEARNER, R, ("tilt",)) is None


def test_gains_are_no_lean() -> None:
    fit, R = leaning(0.0, gain=0.1)
    assert repair(fit, LEARNER, R, ("tilt",)) is None


def test_gains_do_not_explain_noise() -> None:
    """Shares of the wrench that was read, one each, would leave nothing of it."""
    fit, R = leaning(30.0)
    everything = WrenchRows.of(fit, LEARNER)
    (gains,) = (one for one in wrench_rivals(everything, R) if one.family == "gains")
    noisy = replace(everything, wrench=everything.wrench + 1.0)
    (same,) = (one for one in wrench_rivals(noisy, R) if one.family == "gains")
    np.testing.assert_array_equal(gains.Z, same.Z)
    rows = everything.take(everything.counts)
    rivals = [one.take(everything.counts) for one in wrench_rivals(everything, R)]
    assert np.all(noise_beside(rivals, rows) > 0.5 * NOISE)
