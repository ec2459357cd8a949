"""Outlines found along normals: a disc of known size, by mask, by edge and by colour."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.vision.colours import ColourModel
from bodyschema.vision.correspondences import Rim
from bodyschema.vision.normal_search import Gradient, search_edges, search_masks

pytest.importorskip("cv2")

Array = NDArray[np.float64]

CENTRE, RADIUS = np.array([61.3, 47.6]), 30.0
TURN = np.linspace(0, 2 * np.pi, 200, endpoint=False)
NORMAL = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)


def ring(radius: float) -> Rim:
    """An imagined outline of another radius than the disc has."""
    n = len(TURN)
    return Rim(
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros((n, 3)),
        CENTRE + radius * NORMAL,
        NORMAL,
        np.ones(n),
    )


def distances() -> Array:
    """Of every pixel from the centre of the disc."""
    v, u = np.mgrid[:96, :128]
    return np.hypot(u - CENTRE[0], v - CENTRE[1])


def soft(inside: float, outside: float) -> NDArray[np.uint8]:
    """A disc whose edge pixels are mixed, as a lens does it."""
    share = np.clip(RADIUS - distances() + 0.5, 0, 1)
    return np.rint(outside + (inside - outside) * share).astype(np.uint8)


@pytest.mark.parametrize("imagined", [20.0, 29.5, 38.0])
def test_the_outline_of_a_mask_is_found_to_fractions_of_a_pixel(imagined: float) -> None:
    seen = search_masks(ring(imagined), [distances() < RADIUS])
    assert seen.found.all()
    assert np.abs(seen.distance - (RADIUS - imagined)).max() < 0.45
    assert seen.distance.mean() == pytest.approx(RADIUS - imagined, abs=0.03)


def test_nothing_is_found_out_of_reach_or_out_of_the_image() -> None:
    assert not search_masks(ring(15.0), [distances() < RADIUS], reach=8).found.any()
    outside = ring(RADIUS)
    moved = Rim(
        outside.camera, outside.piece, outside.point, outside.pixel + 500, NORMAL, outside.length
    )
    assert not search_masks(moved, [distances() < RADIUS]).found.any()
    assert not search_edges(moved, [Gradient.of(soft(200, 50))]).found.any()


def test_the_nearest_of_several_outlines_is_taken() -> None:
    two = (distances() < 12) | ((distances() > 20) & (distances() < RADIUS))
    assert search_masks(ring(27.0), [two]).distance.mean() == pytest.approx(3, abs=0.1)
    assert search_masks(ring(14.0), [two]).distance.mean() == pytest.approx(-2, abs=0.1)


@pytest.mark.parametrize("imagined", [24.0, 31.0])
def test_an_edge_is_found_to_a_tenth_of_a_pixel(imagined: float) -> None:
    seen = search_edges(ring(imagined), [Gradient.of(soft(200, 50))])
    assert seen.found.all()
    assert np.abs(seen.distance - (RADIUS - imagined)).max() < 0.1
    assert seen.distance.mean() == pytest.approx(RADIUS - imagined, abs=0.03)


def test_an_edge_must_have_the_polarity_asked_for() -> None:
    """Inside a bright disc a much stronger edge, but with the dark side within."""
    image = soft(200, 90)
    image[distances() < 22] = 0
    gradient, imagined = Gradient.of(image), ring(26.0)
    assert search_edges(imagined, [gradient]).distance.mean() == pytest.approx(-4, abs=0.3)
    bright = search_edges(imagined, [gradient], polarity=-1)
    assert bright.distance.mean() == pytest.approx(4, abs=0.1)
    dark = search_edges(imagined, [gradient], polarity=np.ones(len(TURN)))
    assert dark.distance.mean() == pytest.approx(-4, abs=0.3)


def test_an_edge_across_the_outline_is_not_taken() -> None:
    stripes = np.where(np.mgrid[:96, :128][1] // 8 % 2 == 0, 0, 255).astype(np.uint8)
    seen = search_edges(ring(RADIUS), [Gradient.of(stripes)])
    flat = np.abs(NORMAL[:, 1]) > 0.8
    assert not seen.found[flat].any()
    assert seen.found[np.abs(NORMAL[:, 0]) > 0.9].all()


def test_evidence_of_colour_shows_the_outline_where_grey_shows_clutter() -> None:
    """Bright blocks around a disc of another hue: edges everywhere, one outline."""
    rng = np.random.default_rng(0)
    blocks = np.kron(rng.integers(60, 250, (12, 16)), np.ones((8, 8)))[..., None]
    image = np.where((distances() < RADIUS)[..., None], [180, 60, 60], blocks * [1, 1, 1])
    image = np.clip(image + rng.normal(0, 5, image.shape), 0, 255).astype(np.uint8)
    imagined = ring(26.0)
    model = ColourModel.learn(image, distances() < 26.0)
    by_colour = search_edges(imagined, [Gradient.of_evidence(model.evidence(image))], polarity=-1)
    by_grey = search_edges(imagined, [Gradient.of(image.mean(axis=2).astype(np.uint8))])
    errors = [np.abs(seen.distance - 4)[seen.found] for seen in (by_colour, by_grey)]
    assert np.median(errors[0]) < 0.4
    assert np.mean(errors[0] > 1) < 0.05
    assert np.mean(errors[1] > 1) > 0.3


def test_a_view_without_an_image_is_refused() -> None:
    with pytest.raises(InputError, match="0 images"):
        search_masks(ring(RADIUS), [])
