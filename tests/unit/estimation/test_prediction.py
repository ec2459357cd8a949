"""Predicted errors: quantiles of the length of Gaussian vectors, and their mixture."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema import Body, Poses, Solver, free_frame, free_joints, join
from bodyschema.estimation.prediction import (
    degrees_of_freedom,
    length_quantile,
    length_quantiles,
    predict_error,
)
from bodyschema.model.kinematics import relative_pose


def test_an_isotropic_vector_is_exact() -> None:
    expected = 0.002 * np.sqrt(chi2.ppf(0.95, 3))
    assert length_quantile([4e-6 * np.eye(3)], np.inf, 0.95) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("sizes", [(1, 1, 1), (1, 0.1, 0.1), (1, 1, 0), (3, 2, 1)])
@pytest.mark.parametrize("probability", [0.5, 0.95])
def test_against_random_draws(sizes: tuple[float, ...], probability: float) -> None:
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    S = turn @ np.diag(np.square(sizes)) @ turn.T
    drawn = np.linalg.norm(rng.normal(size=(200_000, 3)) * sizes, axis=1)
    share = np.mean(drawn < length_quantile([S], np.inf, probability))
    assert share == pytest.approx(probability, abs=0.015)


def test_a_mixture_of_postures() -> None:
    rng = np.random.default_rng(1)
    scales = np.array([0.5, 1.0, 4.0])
    drawn = rng.choice(scales, 200_000)[:, None] * rng.normal(size=(200_000, 3))
    bound = length_quantile([s**2 * np.eye(3) for s in scales], np.inf, 0.95)
    assert np.mean(np.linalg.norm(drawn, axis=1) < bound) == pytest.approx(0.95, abs=0.003)


def test_an_uncertain_noise_level_widens_the_bound() -> None:
    bounds = [length_quantile([np.eye(3)], nu, 0.95) for nu in (3, 10, 100, np.inf)]
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[2] == pytest.approx(bounds[3], rel=0.05)


def test_no_uncertainty_is_no_error() -> None:
    assert length_quantile([np.zeros((3, 3))], 10, 0.95) == 0


def test_degrees_of_freedom_count_what_the_data_determine() -> None:
    rng = np.random.default_rng(2)
    body = Body.random_chain(4, rng).attach("tracker", "base").attach("hand", "tip")
    q = rng.uniform(-1, 1, size=(50, 4))
    pose = relative_pose(body, q, "tracker", "hand")
    pose[:, :3, 3] += 1e-3 * rng.normal(size=(50, 3))
    seen = Poses.make(q, pose, "tracker", "hand")
    frames = [free_frame(body, name) for name in ("tracker", "hand")]
    fit = Solver().fit(body, join(free_joints(body, ("offsets",)), *frames), [seen])
    # The first and the last of the four zeros cannot be told from the frames.
    assert degrees_of_freedom(fit, [seen]) == 300 - 14
    said = predict_error(fit, q, "tracker", "hand", 286)
    assert said.position.shape == (50,)
    assert said.position.min() < said.position_overall < said.position.max()


@pytest.mark.parametrize("freedom", [1.5, 30.0, 1e6, np.inf])
def test_quantiles_of_many_are_those_of_each(freedom: float) -> None:
    A = np.random.default_rng(0).normal(size=(20, 3, 3))
    covariances = A @ np.swapaxes(A, 1, 2)
    covariances[0] = 0.0
    each = [length_quantile([S], freedom, 0.95) for S in covariances]
    assert length_quantiles(covariances, freedom, 0.95) == pytest.approx(each, rel=1e-8)
