"""The published filter, step by step, and that it brings the hand nearer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.published.body_errors import CartesianError
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.simulation import icub
from bodyschema.vision.scores import Overlap
from imagined_hand import BETA, hand, masks, posture, shifted

pytest.importorskip("icub_models")
pytest.importorskip("trimesh")
pytest.importorskip("cv2")

BODY = icub.nominal_icub()
SEEN = masks(posture())


def distance(offsets: np.ndarray, q: np.ndarray) -> float:
    """m between the hand as estimated and as it is."""
    from bodyschema.model.kinematics import relative_pose

    both = np.stack([shifted(q, offsets), shifted(q, BETA)])
    p = relative_pose(BODY, both, icub.LEFT_EYE, icub.HAND)[:, :3, 3]
    return float(np.linalg.norm(p[0] - p[1]))


def test_the_defaults_are_those_of_the_paper() -> None:
    learner = ParticleFilter(hand())
    assert learner.particles == 200
    degrees = np.rad2deg([learner.prior, learner.noise, learner.floor, learner.width])
    np.testing.assert_allclose(degrees, [5, 4, 0.08, 1])
    assert (learner.decay, learner.alpha) == (0.8, 500)
    state = learner.start(BODY, icub.RIGHT_ARM)
    assert state.beta.shape == (200, 7)
    assert np.rad2deg(state.beta.std()) == pytest.approx(5, rel=0.06)


def test_noise_falls_to_its_floor_at_frame_18() -> None:
    learner = ParticleFilter(hand(), particles=5)
    state, noise = learner.start(BODY, icub.RIGHT_ARM), []
    for _ in range(20):
        state, (info,) = learner.step(state, (SEEN,))
        noise.append(np.rad2deg(info.noise))
    np.testing.assert_allclose(noise[:3], [4, 3.2, 2.56])
    assert noise[17] > 0.08
    assert noise[18] == pytest.approx(0.08)


def test_the_choice_is_the_smoothed_maximum_before_resampling() -> None:
    """Weights from another path (scores), the kernel sum by brute force in degrees."""
    learner = ParticleFilter(hand(), particles=60, noise=0.0, floor=0.0)
    state = learner.start(BODY, icub.RIGHT_ARM)
    _, (info,) = learner.step(state, (SEEN,))
    T = state.error.piece_poses(BODY, SEEN.q, state.beta, SEEN.cameras, hand().frames)
    p = learner.likelihood(hand(), T, SEEN, 1)
    w = p / p.sum()
    beta = np.rad2deg(state.beta)
    d2 = ((beta[:, None] - beta) ** 2).sum(axis=2)
    smoothed = w + 500 / 60 * np.exp(-d2 / 2) @ w / np.sqrt(2 * np.pi)
    np.testing.assert_allclose(learner._smoothed(w, state.beta), smoothed, rtol=1e-12)
    np.testing.assert_array_equal(info.offsets, state.beta[np.argmax(smoothed)])
    assert info.effective_size == pytest.approx(1 / np.sum(w**2))
    np.testing.assert_allclose(info.covariance, np.cov(state.beta.T, aweights=w))


def test_particles_live_on_by_their_weight() -> None:
    learner = ParticleFilter(hand(), particles=60, prior=0.3, noise=0.0, floor=0.0)
    state = learner.start(BODY, icub.RIGHT_ARM)
    after, _ = learner.step(state, (SEEN,))
    T = state.error.piece_poses(BODY, SEEN.q, state.beta, SEEN.cameras, hand().frames)
    p = learner.likelihood(hand(), T, SEEN, 1)
    copies = (after.beta[:, None] == state.beta).all(axis=2).sum(axis=0)
    least = np.floor(60 * p / p.sum())
    assert copies.sum() == 60
    assert least.max() >= 2
    assert ((copies == least) | (copies == least + 1)).all()


def test_one_view_gives_the_jaccard_index_of_scores() -> None:
    from bodyschema.vision.observed import ObservedMask

    learner = ParticleFilter(hand(), particles=20)
    state = learner.start(BODY, icub.RIGHT_ARM)
    one = replace(SEEN, cameras=SEEN.cameras[:1], pictures=SEEN.pictures[:1])
    T = state.error.piece_poses(BODY, one.q, state.beta, one.cameras, hand().frames)
    seen = [ObservedMask.of(mask) for mask in one.pictures]
    log = Overlap(hand(), one.cameras, seen).score(T)[:, 0]
    p = learner.likelihood(hand(), T, one, 1)
    np.testing.assert_allclose(p[p > 0], np.exp(log)[p > 0], rtol=1e-12)


def test_same_seed_same_bytes_and_the_step_changes_nothing() -> None:
    learner = ParticleFilter(hand(), particles=30, seed=5)
    state = learner.start(BODY, icub.RIGHT_ARM)
    before = state.beta.copy()
    found = [learner.step(state, (SEEN,)) for _ in range(2)]
    found.append(replace(learner, threads=2).step(state, (SEEN,)))
    np.testing.assert_array_equal(state.beta, before)
    for other, (info,) in found[1:]:
        np.testing.assert_array_equal(other.beta, found[0][0].beta)
        np.testing.assert_array_equal(info.offsets, found[0][1][0].offsets)
    other = replace(learner, seed=6).start(BODY, icub.RIGHT_ARM)
    assert not np.array_equal(other.beta, before)


def test_a_hand_that_no_particle_shows_tells_nothing() -> None:
    corner = np.zeros_like(SEEN.pictures[0])
    corner[0, 0] = True
    seen = replace(SEEN, pictures=(corner, corner))
    learner = ParticleFilter(hand(), particles=15, prior=0.01, noise=0.01)
    _, (info,) = learner.step(learner.start(BODY, icub.RIGHT_ARM), (seen,))
    assert info.effective_size == pytest.approx(15)
    assert info.likelihood == 0
    assert np.isfinite(info.offsets).all()


def test_the_hand_is_found_within_a_third_of_what_it_was_off() -> None:
    """Two seeds, as a single one may be lucky; the paper gains a factor of eight."""
    ways = [posture(step) for step in np.linspace(0, 1, 20)]
    frames = [masks(q) for q in ways]
    ends = []
    for seed in range(2):
        learner = ParticleFilter(hand(), seed=seed)
        state = learner.start(BODY, icub.RIGHT_ARM)
        for frame in frames:
            state, (info,) = learner.step(state, (frame,))
        ends.append(distance(info.offsets, ways[-1]))
    without = distance(np.zeros(7), ways[-1])
    assert without > 0.03
    assert np.mean(ends) < without / 3


def test_cartesian_particles_come_nearer_too() -> None:
    q = posture()
    learner = ParticleFilter(hand())
    state = learner.start_from(BODY, CartesianError(icub.HAND))
    errors = []
    for _ in range(15):
        state, (info,) = learner.step(state, (SEEN,))
        T = state.error.hand_poses(BODY, q, info.offsets[None], icub.LEFT_EYE, icub.HAND)[0]
        true = state.error.hand_poses(
            BODY, shifted(q, BETA), np.zeros((1, 6)), icub.LEFT_EYE, icub.HAND
        )[0]
        errors.append(np.linalg.norm(T[:3, 3] - true[:3, 3]))
    assert errors[-1] < 0.5 * distance(np.zeros(7), q)


def test_unknown_joints_are_refused() -> None:
    with pytest.raises(InputError, match="no joint 'r_elbw'"):
        ParticleFilter(hand()).start(BODY, ["r_elbw"])
