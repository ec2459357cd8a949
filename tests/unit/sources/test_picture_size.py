"""Sizes of pictures from their headers, and pictures that say they are too large."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.picture_size import picture_size
from bodyschema.sources.video import numbered, read_picture

cv2 = pytest.importorskip("cv2")


@pytest.mark.parametrize("ending", ["png", "jpg", "bmp", "webp", "tiff", "ppm"])
def test_every_kind(ending: str) -> None:
    content = cv2.imencode(f".{ending}", np.zeros((24, 37, 3), np.uint8))[1].tobytes()
    assert picture_size(content) == (37, 24)
    for cut in range(0, min(len(content), 60)):
        picture_size(content[:cut])  # whatever it says, it says it


def test_a_picture_of_eleven_gigabytes_is_refused(tmp_path: Path) -> None:
    content = cv2.imencode(".png", np.zeros((4, 4), np.uint8))[1].tobytes()
    head = b"IHDR" + struct.pack(">II", 60_000, 60_000) + content[24:29]
    large = content[:12] + head + struct.pack(">I", zlib.crc32(head)) + content[33:]
    (tmp_path / "a.png").write_bytes(large)
    with pytest.raises(InputError, match="60000 x 60000 pixels; at most 134 million"):
        read_picture(tmp_path / "a.png")


@pytest.mark.parametrize(
    "pattern", ["a.png", "{row:100000000d}.png", "{row.__class__}", "{row!r}", "{row}{", "{x}{row}"]
)
def test_patterns_have_a_number_and_nothing_else(pattern: str) -> None:
    with pytest.raises(InputError, match="is no pattern"):
        numbered(pattern, 3)


def test_a_pattern_is_filled() -> None:
    assert numbered("a_{row:03}_{row}.png", 7) == "a_007_7.png"
