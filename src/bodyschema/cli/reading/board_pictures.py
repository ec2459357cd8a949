"""The photographs of a sense of a board: what was found in each, and why one is left out.

A picture is left out where no board was detected, where no edges meet at what was detected
(`vision.targets.spread`), and where it is far more blurred than the others: the arm moved while it
was taken, so that its joint readings are not those of the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.pictures import picture_path
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.sources.video import read_picture
from bodyschema.units import listed
from bodyschema.vision.targets.detection import LEAST, find_target
from bodyschema.vision.targets.found import Found
from bodyschema.vision.targets.target import Target

Ints = NDArray[np.int64]

RED_GREEN_BLUE = (0.299, 0.587, 0.114)
"""Weights of a grey level, those of OpenCV."""

BLURRED, SHARP = 1.6, 1.3
"""Times the middle picture's blur, and px, beyond which a picture is blurred: a smear of 9 pixels
has 1.4 to 1.9, of 5 pixels 1.0 to 1.2, which moves corners by 0.05."""

FEW = 5
"""Pictures: among fewer nothing is the usual blur."""

REMEMBERED = 4096
"""Pictures: they are asked for again when it is said and drawn what was found."""

NO_BOARD, NO_CORNERS, IS_BLURRED = "shows no board", "shows no corners", "is blurred"
REASONS = {
    NO_BOARD: "no board was found",
    NO_CORNERS: (
        "no edges meet where corners were detected (something is drawn over the board, it is "
        "another one, or much blurred)"
    ),
    IS_BLURRED: (
        f"edges {BLURRED:g} times as wide as usual and wider (let the arm come to rest, expose for "
        "a shorter time)"
    ),
}
"""Why a picture is left out, in words."""

MOST_NAMED = 10
"""Pictures in a sentence."""


@dataclass(frozen=True)
class Photograph:
    """One picture and what was found in it."""

    path: Path
    row: int
    """Of the recording, counted from 0 in it."""
    size: tuple[int, int]
    """Width and height, px."""
    found: Found | None
    why: str = ""
    """It is left out; "" for one that is used."""

    @property
    def used(self) -> bool:
        """Whether its corners are samples."""
        return not self.why


def photographs(
    entry: SenseEntry, target: Target, numbers: Ints, rows: Ints
) -> tuple[Photograph, ...]:
    """The pictures of a board, in the order of the rows.

    Args:
        entry: the sense.
        target: that it describes.
        numbers: (n,) in the names of the pictures.
        rows: (n,) of the recording.

    Raises:
        InputError: a picture is missing, or they differ in size.
    """
    taken: list[Photograph] = []
    for number, row in zip(numbers, rows, strict=True):
        path = picture_path(entry.images, int(number))
        size, found = _looked_at(str(path), _stamp(path), target)
        if taken and size != taken[0].size:
            raise InputError(
                f"the picture '{path.name}' has {size[0]} x {size[1]} pixels, those before it "
                f"{taken[0].size[0]} x {taken[0].size[1]}; a sense has pictures of one camera and "
                "one size."
            )
        taken.append(Photograph(path, int(row), size, found, _lack(found)))
    return without_blurred(taken)


def without_blurred(taken: Sequence[Photograph]) -> tuple[Photograph, ...]:
    """The same, with those left out that are far more blurred than the middle one."""
    usual = [one.found.blur for one in taken if one.used and one.found and one.found.blur]
    if len(usual) < FEW:
        return tuple(taken)
    limit = max(BLURRED * float(np.median(usual)), SHARP)
    return tuple(
        replace(one, why=IS_BLURRED)
        if one.used and one.found is not None and one.found.blur > limit
        else one
        for one in taken
    )


def left_out(taken: Sequence[Photograph]) -> list[str]:
    """A sentence for each reason why pictures were left out, with their names."""
    said = []
    for why, what in REASONS.items():
        named = [one.path.name for one in taken if one.why == why]
        if named:
            said.append(f"Left out, {what}: {listed(named, MOST_NAMED)}.")
    return said


def _lack(found: Found | None) -> str:
    if found is None:
        return NO_BOARD
    return NO_CORNERS if len(found) < LEAST else ""


def _stamp(path: Path) -> tuple[int, int]:
    """What changes with the file; zeros where it is not there, which reading it says."""
    try:
        stat = path.stat()
    except (OSError, ValueError):
        return 0, 0
    return stat.st_mtime_ns, stat.st_size


@lru_cache(maxsize=REMEMBERED)
def _looked_at(
    path: str, stamp: tuple[int, int], target: Target
) -> tuple[tuple[int, int], Found | None]:
    """Size of a picture, and the corners in it."""
    grey = grey_picture(Path(path))
    return (grey.shape[1], grey.shape[0]), find_target(target, grey)


def grey_picture(path: Path) -> NDArray[np.uint8]:
    """(height, width) of a picture file. Raises InputError."""
    grey: NDArray[np.uint8] = np.rint(read_picture(path) @ np.array(RED_GREEN_BLUE)).astype(
        np.uint8
    )
    return grey
