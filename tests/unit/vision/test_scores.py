"""Scores: the truth wins, threads and room do not matter, and fast sums equal plain ones."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.vision import views
from bodyschema.vision.colours import ColourModel, ObservedColours
from bodyschema.vision.contours import silhouette
from bodyschema.vision.correspondences import find_rim
from bodyschema.vision.edge_image import CHANNELS, ObservedEdges
from bodyschema.vision.observed import UNIT, ObservedMask, row_sums
from bodyschema.vision.oriented import oriented_distances
from bodyschema.vision.region import sums_inside
from bodyschema.vision.scores import Chamfer, OrientedChamfer, Overlap, Region, Score
from bodyschema.vision.surface import Surface
from icub_arm import arm, eyes, hypotheses

cv2 = pytest.importorskip("cv2")

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

POSES = hypotheses(120)


def picture(mask: NDArray[np.bool_], rng: np.random.Generator) -> Pixels:
    """A bright arm before coloured blocks, with noise."""
    blocks = np.kron(rng.integers(0, 190, (15, 20, 3)), np.ones((16, 16, 1)))
    image = np.where(mask[..., None], [210, 200, 180], blocks)
    return np.clip(image + rng.normal(0, 8, image.shape), 0, 255).astype(np.uint8)


def everything() -> dict[str, Score]:
    """All scores of a picture in which hypothesis 0 is true; colours learned from hypothesis 1."""
    rng, cameras = np.random.default_rng(0), eyes()
    masks = [silhouette(arm(), POSES[0, c], camera) for c, camera in enumerate(cameras)]
    images = [picture(mask, rng) for mask in masks]
    near = [silhouette(arm(), POSES[1, c], camera) for c, camera in enumerate(cameras)]
    seen = [ObservedMask.of(mask) for mask in masks]
    colours = [
        ObservedColours.of(image, ColourModel.learn(image, mask))
        for image, mask in zip(images, near, strict=True)
    ]
    edges = [ObservedEdges.of(image) for image in images]
    return {
        "overlap": Overlap(arm(), cameras, seen),
        "chamfer": Chamfer(arm(), cameras, seen),
        "oriented": OrientedChamfer(arm(), cameras, edges),
        "region": Region(arm(), cameras, colours),
    }


SCORES = everything()


@pytest.mark.parametrize("name", SCORES)
def test_the_truth_wins_and_the_worse_score_the_less(name: str) -> None:
    scores = SCORES[name].score(POSES)
    assert scores.shape == (len(POSES), 2)
    assert np.isfinite(scores).all()
    total = scores.sum(axis=1)
    assert total.argmax() == 0
    overlap = SCORES["overlap"].score(POSES).sum(axis=1)
    assert np.corrcoef(overlap.argsort().argsort(), total.argsort().argsort())[0, 1] > 0.5


@pytest.mark.parametrize("name", SCORES)
def test_threads_and_order_change_nothing(name: str) -> None:
    alone = SCORES[name].score(POSES)
    np.testing.assert_array_equal(SCORES[name].score(POSES, threads=2), alone)
    np.testing.assert_array_equal(SCORES[name].score(POSES[::-1])[::-1], alone)


@pytest.mark.parametrize("name", SCORES)
def test_a_body_out_of_view_scores_worse_than_one_in_it(name: str) -> None:
    away = POSES[:1].copy()
    away[..., 0, 3] += 5.0
    assert np.isfinite(SCORES[name].score(away)).all()
    assert (SCORES[name].score(away) < SCORES[name].score(POSES[:1])).all()


@pytest.mark.parametrize("step", [1, 2, 3])
def test_oriented_sums_are_those_of_the_points_of_the_contour(step: int) -> None:
    """Every point of the rim reads its own channel, interpolated along its line."""
    seen, cameras = SCORES["oriented"].seen, eyes()  # type: ignore[attr-defined]
    distance, number = oriented_distances(arm(), POSES[:3], cameras, seen, step=step)
    for h in range(3):
        rim = find_rim(arm(), POSES[h], cameras, step=step)
        for c in range(2):
            mine = rim.camera == c
            tangent = np.arctan2(rim.normal[mine, 1], rim.normal[mine, 0]) + np.pi / 2
            channel = np.rint(tangent * CHANNELS / np.pi).astype(int) % CHANNELS
            low = np.floor(rim.pixel[mine] + 1e-9).astype(int)
            part = np.clip(rim.pixel[mine] - low, 0, 1)
            high = np.minimum(low + (part > 1e-6), [319, 239])
            part = part.max(axis=1)  # one coordinate is a whole number
            value = (1 - part) * seen[c].distance[channel, low[:, 1], low[:, 0]]
            value += part * seen[c].distance[channel, high[:, 1], high[:, 0]]
            assert step * number[h, c] / UNIT == pytest.approx(rim.length[mine].sum(), rel=2e-3)
            expected = np.sum(value * rim.length[mine]) / rim.length[mine].sum()
            assert distance[h, c] / number[h, c] == pytest.approx(expected, rel=0.01, abs=2)


def test_sums_inside_are_those_of_the_pixels() -> None:
    evidence = np.random.default_rng(1).integers(-900, 900, (240, 320)).astype(np.int32)
    tables = [row_sums(evidence)] * 2
    sums = sums_inside(arm(), POSES[:4], eyes(), tables)
    for h in range(4):
        for c, camera in enumerate(eyes()):
            assert sums[h, c] == evidence[silhouette(arm(), POSES[h, c], camera)].sum()


def test_lines_that_overflow_are_done_again(monkeypatch: pytest.MonkeyPatch) -> None:
    enough = {name: score.score(POSES[:20]) for name, score in SCORES.items()}
    monkeypatch.setattr(views, "CAPACITY", 3)
    for name in ("oriented", "region"):
        np.testing.assert_array_equal(SCORES[name].score(POSES[:20]), enough[name])


def test_an_edge_of_another_direction_counts_as_farther_away() -> None:
    """A long bar fits a bar that lies along it better than one across it, edge for edge."""
    camera = Camera.from_fov("", "", 64, 64, 1.0)
    image = np.zeros((64, 64), np.uint8)
    image[28:36, :] = 255
    seen = ObservedEdges.of(image)
    flat = seen.distance[0], seen.distance[CHANNELS // 2]
    on_edge = seen.edges & (np.abs(np.arange(64) - 32) < 20)
    assert set(seen.channel[on_edge]) == {0}
    assert flat[0][on_edge].max() == 0
    assert flat[1][on_edge].min() == round(6.0 * np.pi / 2 * UNIT)
    bar = np.array([[-9, -0.4, 6], [9, -0.4, 6], [9, 0.4, 6], [-9, 0.4, 6]])
    scores = [
        OrientedChamfer(Surface.build({"": (V, [[0, 1, 2], [0, 2, 3]])}), [camera], [seen]).score(
            np.eye(4)[None, None, None]
        )[0, 0]
        for V in (bar, bar[:, [1, 0, 2]])
    ]
    assert scores[0] > -2
    assert scores[1] < scores[0] - 5


def test_edge_images_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match="8-bit image"):
        ObservedEdges.of(np.zeros((4, 4)))
    with pytest.raises(InputError, match="truncation"):
        ObservedEdges.of(np.zeros((4, 4), np.uint8), truncation=200)
    small = ObservedEdges.of(np.zeros((4, 4), np.uint8))
    with pytest.raises(InputError, match="240 rows"):
        OrientedChamfer(arm(), eyes(), [small, small]).score(POSES)
    with pytest.raises(InputError, match="row sums"):
        sums_inside(arm(), POSES, eyes(), [np.zeros((4, 4), np.int32)] * 2)
    with pytest.raises(InputError, match="3 pieces"):
        SCORES["region"].score(POSES[:, :, :2])


def test_evidence_is_the_log_of_the_ratio_of_the_colours() -> None:
    image = np.full((20, 20), 40, np.uint8)
    image[:, 10:] = 200
    image[0, 0] = 120
    mask = np.zeros((20, 20), bool)
    mask[:, 10:] = True
    model = ColourModel.learn(image, mask, margin=1.0)
    evidence = model.evidence(image)
    most = np.log((0.95 + 0.025) / 0.025)
    assert evidence[5, 15] == pytest.approx(most)
    assert evidence[5, 5] < -most + 0.1
    assert model.evidence(np.full((2, 2), 250, np.uint8)).tolist() == [[0, 0], [0, 0]]
    seen = ObservedColours.of(image, model)
    assert seen.row_sums[:, -1].sum() == np.rint(evidence * UNIT).sum()
    with pytest.raises(InputError, match="0 pixels to the body"):
        ColourModel.learn(image, np.zeros((20, 20), bool))
    with pytest.raises(InputError, match="channels"):
        model.evidence(np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(InputError, match="8-bit"):
        model.evidence(np.zeros((4, 4)))
    with pytest.raises(InputError, match="silhouette"):
        ColourModel.learn(image, np.zeros((2, 2), bool))
