"""Pictures of imagined outlines over images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.vision.overlay import GREEN, RED, overlay, save_png
from bodyschema.vision.surface import Surface

cv2 = pytest.importorskip("cv2")

CAMERA = Camera("eye", "eye", 40, 30, np.array([[40.0, 0, 19.5], [0, 40.0, 14.5], [0, 0, 1]]))
SQUARE = Surface.build(
    {"": ([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])}
)


def at(x: float) -> np.ndarray:
    T = np.eye(4)[None]
    T[0, :3, 3] = x, 0, 1
    return T


def test_outlines_lie_where_the_body_is_seen_and_the_rest_stays() -> None:
    image = np.full((30, 40), 90, np.uint8)
    picture = overlay(image, CAMERA, SQUARE, [at(0.0), at(0.2)], magnify=2)
    assert picture.shape == (60, 80, 3)
    red, green = ((picture == colour).all(axis=2) for colour in (RED, GREEN))
    assert (picture[~red & ~green] == 90).all()
    rows, columns = np.nonzero(red)
    # The square spans 19.5 +- 4 pixels; the magnified pixel of u has its centre at 2 u + 0.5.
    assert abs(columns.min() - (2 * 15.5 + 0.5)) <= 1
    assert abs(columns.max() - (2 * 23.5 + 0.5)) <= 1
    assert abs(rows.min() - (2 * 10.5 + 0.5)) <= 1
    assert np.nonzero(green)[1].min() == columns.min() + 16
    assert not red[28:32, 36:44].any()
    assert (image == 90).all()


def test_a_picture_comes_back_as_it_was_written(tmp_path: Path) -> None:
    image = np.random.default_rng(0).integers(0, 255, (30, 40, 3)).astype(np.uint8)
    picture = overlay(image, CAMERA, SQUARE, [at(0.0)], magnify=1)
    save_png(picture, tmp_path / "new" / "picture.png")
    read = cv2.imread(str(tmp_path / "new" / "picture.png"))[..., ::-1]
    np.testing.assert_array_equal(read, picture)
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["picture.png"]


def test_what_cannot_be_drawn_is_refused() -> None:
    image = np.zeros((30, 40, 3), np.uint8)
    with pytest.raises(InputError, match="30 rows and 40 columns"):
        overlay(image[:20], CAMERA, SQUARE, [at(0.0)])
    with pytest.raises(InputError, match="8-bit"):
        overlay(image.astype(float), CAMERA, SQUARE, [at(0.0)])
    with pytest.raises(InputError, match="2 colours"):
        overlay(image, CAMERA, SQUARE, [at(0.0)] * 3)
