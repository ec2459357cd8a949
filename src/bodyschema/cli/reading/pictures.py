"""Pictures of a sense of outlines: one file a row, as masks or as images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.sources.video import PLACE, numbered, read_picture


def picture_path(pattern: str, number: int) -> Path:
    """The file of one picture.

    Raises:
        InputError: the pattern has no {row} in it, or other names.
    """
    return Path(numbered(pattern, int(number)))


def read_pictures(pattern: str, numbers: NDArray[np.int64], masks: bool) -> list[NDArray[Any]]:
    """Pictures (height, width, 3) uint8, or masks (height, width) bool: not 0 on the robot.

    Raises:
        InputError: one is missing or cannot be read.
        MissingExtraError: OpenCV is not installed.
    """
    pictures = [read_picture(picture_path(pattern, number)) for number in numbers]
    return [np.asarray(picture.any(axis=-1)) for picture in pictures] if masks else list(pictures)


def files_of(pattern: str) -> list[str]:
    """The pictures of a pattern that are there."""
    path = Path(pattern)
    try:
        return sorted(str(found) for found in path.parent.glob(PLACE.sub("*", path.name)))
    except (OSError, ValueError, NotImplementedError):  # no name that a file can have
        return []
