"""When an answer from pictures is limited, and when the pictures speak against it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.answers.picture_trust import counts, elsewhere_details, picture_trust
from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.images.elsewhere import Elsewhere
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.picture_weights import PictureWeights

GOOD = {0: 1.0, 1: 2.0}


def fit(
    used: int, of: int, unknowns: int = 2, contradiction: float = 1.0, masked: bool = True
) -> Any:
    weights = PictureWeights(
        np.where(np.arange(of) < used, 0.9, 0.05)[:, None], np.array([0.9, 0.3])
    )
    apart = SimpleNamespace(
        contradiction=contradiction, kappa=contradiction, by_piece=contradiction, by_moment=1.0,
        by_half=1.0, by_doubt=1.0, piece_shares=np.array([0.1, 0.9]), names=("upper", "fore"),
        masked=masked,
    )  # fmt: skip
    model = SimpleNamespace(
        wanted=range(unknowns), surface=SimpleNamespace(frames=("upper", "fore"))
    )
    shown: Any = SimpleNamespace(
        lost=False, matched=0.9, weights=weights, disagreement=apart, model=model
    )
    shown.agreed = MarkerlessFit.agreed.__get__(shown)
    return shown


def test_pictures_that_agree_are_good() -> None:
    trust = picture_trust(fit(10, 10), GOOD, GOOD)
    assert trust.level == "good"
    assert not trust.reasons


@pytest.mark.parametrize(
    ("found", "after", "level", "says"),
    [
        (fit(5, 10), GOOD, "contradicted", "Only 5 of 10 pictures show the body"),
        (fit(6, 10), GOOD, "limited", "6 of 10 pictures count"),
        (fit(8, 10), GOOD, "good", ""),
        (fit(2, 2), GOOD, "limited", "rests on 2 moments"),
        (fit(3, 3, unknowns=19), GOOD, "contradicted", "19 unknowns ask for 4 or more"),
        (fit(10, 10), {0: 4.0, 1: 5.0}, "contradicted", "4.5 pixels off after the correction"),
        (fit(10, 10, contradiction=2.2), GOOD, "good", ""),
        (fit(10, 10, contradiction=2.3), GOOD, "limited", "most of all 'fore' (perhaps its mesh"),
        (fit(10, 10, contradiction=8.9, masked=False), GOOD, "good", ""),
        (fit(10, 10, contradiction=9.1, masked=False), GOOD, "limited", "3.0 times"),
    ],
)
def test_what_speaks_against_an_answer(
    found: Any, after: dict[int, float], level: str, says: str
) -> None:
    trust = picture_trust(found, GOOD, after)
    assert trust.level == level
    assert says in " ".join(trust.reasons)


def test_a_body_that_was_not_found_is_contradicted() -> None:
    lost = fit(1, 10)
    lost.lost = True
    assert picture_trust(lost, GOOD, GOOD).level == "contradicted"


def test_counts_are_plain_numbers() -> None:
    found = counts(fit(8, 10), ["eye"])
    assert (found["used"], found["of"]) == (8, 10)
    assert found["pieces"] == {"upper": 0.9, "fore": 0.3}
    assert found["widened_by"] == 1.0


def freed(surprise: float, left: float, lens: float, meshes: float) -> Elsewhere:
    """A camera that the pictures move by 23 mm and 3 degrees."""
    body = bs.Body.random_chain(2, np.random.default_rng(0)).attach("eye", "base")
    place = bs.free_frame(body, "eye", 0.05, 0.1)
    x = np.array([0.023, 0.0, 0.0, 0.0, np.radians(3), 0.0])
    rivals = {"lens": lens, "meshes": meshes} if surprise > 15 else {}
    return Elsewhere(Estimate(body, place, x, np.eye(6)), ("eye",), surprise, 5, left, rivals)


@pytest.mark.parametrize(
    ("contradiction", "other", "level", "says"),
    [
        (9.0, freed(200.0, 1.0, 8.0, 5.0), "contradicted", "explains 100 % of what the pictures"),
        (9.0, freed(200.0, 1.0, 8.0, 5.0), "contradicted", "and wrong meshes 50 %"),
        (9.0, freed(200.0, 1.0, 1.5, 5.0), "limited", "perhaps it is elsewhere"),
        (9.0, freed(200.0, 1.0, 8.0, 2.0), "limited", "perhaps it is elsewhere"),
        (9.0, freed(200.0, 3.0, 8.0, 8.0), "limited", "perhaps it is elsewhere"),
        (1.0, freed(30.0, 1.0, 1.0, 1.0), "limited", "'eye' by 23 mm and 3.0 degrees"),
        (1.0, freed(15.2, 1.0, 1.0, 1.0), "limited", 'known = "roughly"'),
        (1.0, freed(15.0, 1.0, 1.0, 1.0), "good", ""),
    ],
)
def test_a_camera_elsewhere_contradicts_if_nothing_else_explains_it(
    contradiction: float, other: Elsewhere, level: str, says: str
) -> None:
    trust = picture_trust(fit(10, 10, contradiction=contradiction), GOOD, GOOD, other)
    assert trust.level == level
    assert says in (trust.reasons[0] if trust.reasons else "")


def test_what_freeing_a_camera_showed_is_plain_numbers() -> None:
    assert elsewhere_details(None) is None
    told = elsewhere_details(freed(200.0, 1.0, 8.0, 5.0))
    assert told is not None
    assert told["contradiction_left_by_rivals"] == {"lens": 8.0, "meshes": 5.0}
    assert told["shifts"] == {"eye": [0.023, pytest.approx(np.radians(3))]}
