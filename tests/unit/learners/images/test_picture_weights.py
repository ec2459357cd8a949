"""Pictures that do not show the body fade by their own weight; none is thrown away."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.picture_weights import LEAST, PictureWeights
from bodyschema.learners.images.sight import Sight
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from imagined_hand import hand, masks, posture

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM).with_prior(np.full(7, 0.05))
BETA = np.array([0.02, -0.01, 0.015, 0.01, -0.02, 0.01, 0.015])
STEPS = (0.0, 0.25, 0.5, 0.75, 1.0)


def pictures(wrong: tuple[int, ...] = ()) -> list[Images]:
    """Masks of five postures; in wrong ones the left eye sees a hand that stands elsewhere."""
    seen = [masks(posture(step), BETA) for step in STEPS]
    for k in wrong:
        other = masks(posture(STEPS[k]), BETA + 0.15).pictures[0]
        seen[k] = replace(seen[k], pictures=(other, *seen[k].pictures[1:]))
    return seen


@cache
def fit(wrong: tuple[int, ...] = ()) -> MarkerlessFit:
    return Markerless(hand(), seeds=0).fit(BODY, OFFSETS, pictures(wrong))


def test_good_pictures_have_their_whole_weight() -> None:
    weights = fit().weights
    assert weights.pictures.shape == (5, 2)
    assert weights.pictures.min() > 0.8
    assert weights.pieces.min() > 0.8
    assert weights.used.all()
    assert fit().agreed


def test_one_wrong_picture_fades_and_hardly_moves_the_answer() -> None:
    weights = fit((2,)).weights
    assert weights.pictures[2, 0] < 0.1
    assert weights.used.sum() == 9
    assert weights.cameras[0] < weights.cameras[1]
    off = (fit((2,)).estimate.x - BETA) / fit((2,)).estimate.std
    assert np.abs(off).max() < 2.5


def test_rows_of_a_picture_weigh_as_it_does_and_as_their_piece_does() -> None:
    found = fit((2,))
    rows = [found.model.rows(Sight.of(seen), found.z, 4.0) for seen in pictures((2,))]
    weights, n_pieces = PictureWeights.of(rows), len(hand().frames)
    picture, piece = weights.pictures[2], weights.pieces
    for g in np.unique(rows[2].group):
        mine = rows[2].group == g
        now = weights.on(rows)[2].weight[mine] / rows[2].weight[mine]
        told = picture[g // n_pieces] / weights.pictures.max() * piece[g % n_pieces] / piece.max()
        np.testing.assert_allclose(now, max(told, LEAST))
    assert picture[0] < 0.1 < 0.8 < picture[1]


def test_the_majority_of_the_pictures_has_to_agree() -> None:
    empty = [
        replace(seen, pictures=tuple(np.zeros_like(p) for p in seen.pictures)) if k < 3 else seen
        for k, seen in enumerate(pictures())
    ]
    found = Markerless(hand(), seeds=0).fit(BODY, OFFSETS, empty)
    assert found.weights.used.sum() == 4
    assert not found.lost
    assert not found.agreed
