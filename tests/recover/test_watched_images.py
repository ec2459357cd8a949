"""The monitor round particles and outlines: a joint zero jumps before the robot's own eyes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.learners.watched_images import WatchedImages, WatchedOutline
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM)
TRUTH = np.deg2rad([5, 4, 3, -2, 3, -7, 3])
LEARNER = WatchedImages(BODY, icub.RIGHT_ARM, icub.HAND, ParticleFilter(arm(), particles=100))
ELBOW = icub.RIGHT_ARM.index("r_elbow")


def look(offsets: Array, q: Array) -> Images:
    """Masks of the arm in both eyes."""
    cameras = tuple(eyes())
    T = piece_poses(BODY.with_variables(OFFSETS, offsets), q, cameras, arm().frames)[0]
    masks = tuple(silhouette(arm(), pose, c) for pose, c in zip(T, cameras, strict=True))
    return Images(0.0, q, cameras, masks)


def way(images: int) -> Iterator[Array]:
    """Readings on the way through some postures."""
    corners = readings(20)
    for i in range(images):
        k, share = divmod(i / 8, 1)
        yield (1 - share) * corners[int(k) % 20] + share * corners[(int(k) + 1) % 20]


def known() -> WatchedOutline:
    """A belief that is right, to 0.02 degrees."""
    sure = np.eye(7) / np.deg2rad(0.02) ** 2
    return WatchedOutline(None, TRUTH, sure, images=100, rows=700.0)


def test_pictures_in_place_of_masks_are_refused() -> None:
    masks = look(TRUTH, readings(20)[3])
    colours = tuple(np.repeat(np.uint8(255) * mask[..., None], 3, 2) for mask in masks.pictures)
    for ask in (LEARNER.step, LEARNER.innovation):
        with pytest.raises(bs.InputError, match="masks"):
            ask(known(), (replace(masks, pictures=colours),))


def test_the_slope_of_an_innovation_is_its_derivative() -> None:
    q = readings(20)[3]
    J, h = LEARNER.innovation(known(), (look(TRUTH, q),)).J, np.deg2rad(0.4)
    for k in range(7):
        step = h * (np.arange(7) == k)
        ahead, back = (
            LEARNER.innovation(known(), (look(x, q),)).e for x in (TRUTH + step, TRUTH - step)
        )
        # Masks have pixels: the outline moves by about one.
        assert np.linalg.norm((ahead - back) / (2 * h) - J[:, k]) < 0.2 * np.linalg.norm(J[:, k])


def test_forgetting_a_joint_keeps_what_is_known_of_the_others() -> None:
    mixed = np.random.default_rng(0).normal(size=(7, 20))
    state = WatchedOutline(None, TRUTH, 1e6 * mixed @ mixed.T, images=100)
    before = np.linalg.inv(state.information)
    after = np.linalg.inv(LEARNER.forget(state, "r_elbow").information)
    rest = np.delete(np.arange(7), ELBOW)
    assert after[np.ix_(rest, rest)] == pytest.approx(before[np.ix_(rest, rest)], rel=1e-6)
    assert after[ELBOW, ELBOW] == pytest.approx(LEARNER.finder.prior**2)
    assert after[rest, ELBOW] == pytest.approx(0, abs=1e-15)


def test_particles_and_outlines_certify_a_body_that_is_right() -> None:
    monitor = Monitor(LEARNER)
    state = monitor.start()
    for q in way(75):
        state, report = monitor.step(state, (look(TRUTH, q),))
        if report.event:
            break
    assert report.event == "identified"
    assert np.abs(state.belief.x - TRUTH).max() < np.deg2rad(0.3)


def test_a_jump_is_noticed_at_once_blamed_and_learned_again() -> None:
    monitor = Monitor(LEARNER)
    state = monitor.observing(known())
    now, events = TRUTH.copy(), []
    for i, q in enumerate(way(60)):
        if i == 15:
            now[ELBOW] += np.deg2rad(2)
        state, report = monitor.step(state, (look(now, q),))
        events += [(i, report.event, report.block)] if report.event else []
    assert [event for _, event, _ in events] == ["alarm", "changed", "identified"]
    assert 15 <= events[0][0] <= 20
    assert events[1][2] == "r_elbow"
    assert np.abs(state.belief.x - now).max() < np.deg2rad(0.2)
