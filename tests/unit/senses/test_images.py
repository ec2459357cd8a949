"""The record of images refuses what does not belong together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.senses.images import Images

EYE = Camera.from_fov("eye", "eye", 8, 6, 1.0)


def images(**changed: Any) -> Images:
    fields: dict[str, Any] = {
        "time": 0.0, "q": np.zeros(2), "cameras": (EYE,), "pictures": (np.zeros((6, 8), bool),),
    }  # fmt: skip
    return Images(**(fields | changed))


def test_masks_and_images_are_told_apart() -> None:
    assert images().masked
    assert not images(pictures=(np.zeros((6, 8, 3), np.uint8),)).masked


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"q": np.array([0.0, np.nan])}, "finite readings"),
        ({"cameras": ()}, "one picture from each camera"),
        ({"pictures": (np.zeros((8, 6), bool),)}, "8 x 6 pixels, and its picture 6 x 8"),
        ({"pictures": (np.zeros((6, 8)),)}, "8-bit"),
        ({"cameras": (Camera("eye", "eye", 8, 6, EYE.matrix, np.full(4, 0.1)),)}, "undistort"),
    ],
)
def test_what_does_not_belong_together_is_refused(changed: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        images(**changed)
