"""Hand and eye from tracked points are found again, inside their own stated uncertainty."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.clock import ClockSearch, LatePoints
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import StereoPoints
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation.katana import (
    Noise,
    delayed,
    katana,
    project_points,
    stereo,
)
from bodyschema.studies.nabeshima_peers import batch_likelihood
from watched import errors, learned, seen, truth

RUNS = 10


@pytest.fixture(scope="module")
def runs():
    """Scenes, streams and beliefs after 20 s at half a pixel."""
    learner = HandEyePoints(stereo())
    pairs = [seen(seed, 20) for seed in range(RUNS)]
    return [(scene, stream, learned(learner, stream)) for scene, stream in pairs]


def test_exact_pixels_give_the_exact_answer():
    scene, stream = seen(0, 12)
    clean = project_points(scene, stream.T_world_hand, stereo())
    # The noise matrix stands for the declared noise: next to none here.
    learner = HandEyePoints(stereo(1e-5))
    state = learner.start()
    for i, T in enumerate(stream.T_world_hand):
        state, _ = learner.step(state, (StereoPoints(i / 30, T, clean[i]),))
    assert max(errors(state.theta, scene)) < 1e-6


def test_errors_are_what_the_covariance_says(runs):
    nees = []
    for scene, _, state in runs:
        away = truth(scene).away_from(state.theta)
        nees.append(float(away @ np.linalg.solve(state.covariance, away)))
    low, high = chi2.ppf([0.0005, 0.9995], 9 * RUNS) / RUNS
    assert low < np.mean(nees) < high


def test_as_good_as_all_the_data_stored(runs):
    ours, stored = [], []
    for scene, stream, state in runs:
        batch = batch_likelihood(state.theta, stream.T_world_hand, stream.pixels, stereo())
        ours.append(errors(state.theta, scene))
        stored.append(errors(batch, scene))
    rms = [np.sqrt(np.mean(np.square(e), axis=0)) for e in (ours, stored)]
    assert (rms[0] < 1.15 * rms[1]).all()
    assert (rms[0] < [0.06, 1.2, 0.6]).all()


def test_correlated_noise_widens_the_covariance():
    learner = HandEyePoints(stereo())
    nees = []
    for seed in range(5):
        scene, stream = seen(100 + seed, 25, wrong=Noise(correlation=0.9))
        state = learned(learner, stream)
        assert 0.8 < state.correlation < 0.95
        away = truth(scene).away_from(state.theta)
        nees.append(float(away @ np.linalg.solve(state.covariance, away)))
    # Without tau, about 19, the mean would be near 170.
    assert np.mean(nees) < 30


def test_a_tenth_of_wild_samples_does_no_harm():
    learner = HandEyePoints(stereo())
    found = []
    for seed in range(4):
        scene, stream = seen(200 + seed, 20, wrong=Noise(wild=0.1))
        state = learned(learner, stream)
        assert 0.05 < state.rejected / (state.seen + state.rejected) < 0.16
        found.append(errors(state.theta, scene))
    assert (np.median(found, axis=0) < [0.03, 0.8, 0.4]).all()
    assert np.max(found, axis=0)[1] < 3


def test_slow_motion_is_never_certified_in_a_wrong_basin():
    learner = HandEyePoints(stereo())
    for seed in range(4):
        scene, stream = seen(300 + seed, 20, speed=0.125)
        state = learner.start()
        for i in range(len(stream)):
            state, _ = learner.step(state, (stream.sample(i),))
            if i % 3 == 2 and learner.certificate(state).holds:
                assert errors(state.theta, scene)[0] < 0.5
                break


def test_four_points_share_a_camera():
    learner = HandEyePoints(stereo(), points=4)
    scene, stream = seen(7, 12, points=4)
    state = learned(learner, stream)
    away = truth(scene).away_from(state.theta)
    assert away @ np.linalg.solve(state.covariance, away) < chi2.ppf(0.999, 18)
    alone = learned(HandEyePoints(stereo()), seen(7, 12)[1])
    assert np.trace(state.covariance[:6, :6]) < np.trace(alone.covariance[:6, :6])


def test_a_forgotten_block_leaves_the_schur_prior_of_the_rest(runs):
    learner = HandEyePoints(stereo())
    _, _, state = runs[0]
    prior = learner.forget(state, "tool").prior
    # What remains of the camera's information is the inverse of its marginal covariance.
    assert np.allclose(
        np.linalg.inv(prior.information[:6, :6]), state.covariance[:6, :6], rtol=1e-4
    )
    assert not prior.information[6:].any()


def test_the_certificate_names_what_is_missing():
    learner = HandEyePoints(stereo())
    _, stream = seen(0, 3)
    state = learner.start()
    assert "too few samples" in learner.certificate(state).missing[0]
    for i in range(60):
        state, _ = learner.step(state, (stream.sample(i),))
    words = " ".join(learner.certificate(state).missing)
    assert "wanted 0.2 deg" in words
    assert "wanted 5 mm" in words


def test_the_lag_of_the_camera_is_found_to_half_a_millisecond():
    from bodyschema.simulation.katana import draw_scene, stream

    rng = np.random.default_rng(0)
    moving = stream(draw_scene(rng), 20, stereo(), rng, lag=0.033)
    clock = ClockSearch(HandEyePoints(stereo()))
    for search in (clock, clock.finer(0.033)):
        body, state = katana(), search.start()
        ways = [delayed(moving.time, moving.q, lag) for lag in search.lags]
        poses = np.stack([relative_pose(body, q, "base", "hand") for q in ways], axis=1)
        for T, pixels in zip(poses, moving.pixels, strict=True):
            state, _ = search.step(state, (LatePoints(T, pixels),))
        lag = search.solve(state)
        assert lag.seconds == pytest.approx(0.033, abs=1e-3)
    assert lag.seconds == pytest.approx(0.033, abs=min(5 * lag.std, 5e-4))
    with pytest.raises(InputError, match="evenly spaced"):
        ClockSearch(HandEyePoints(stereo()), (0.0, 0.01))
