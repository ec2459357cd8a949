"""Photographs of boards in an answer: which the fit held off, and each with its corners drawn in.

Every photograph becomes a file of the result folder, overlay_0007.jpg for that of row 7, or
overlay_2_0007.jpg for that of the second board or camera; the report shows them smaller.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.answer import Answer
from bodyschema.cli.reading.board_pictures import Photograph
from bodyschema.report.boards import BoardPicture, BoardPictures
from bodyschema.senses.sense import Sense
from bodyschema.sources.video import read_picture
from bodyschema.units import listed
from bodyschema.vision.overlay import jpeg_bytes
from bodyschema.vision.targets.drawing import Marks, drawn

Array = NDArray[np.float64]
Photographs = Mapping[str, tuple[Photograph, ...]]
"""Of each sense by its label, rows numbered as its samples are."""

ON_THE_PAGE = 40
"""Photographs of the report: about 40 kB each."""

PANEL, SMALL = 800, 800
"""px: a panel's width in a file, and that of both in the report."""

MOST_NAMED = 10


def with_held_off(answer: Answer, taken: Photographs) -> Answer:
    """The answer with a sentence on the photographs that the fit held off."""
    outliers = set(answer.outliers)
    names = [
        one.path.name for some in taken.values() for one in some if one.used and one.row in outliers
    ]
    if not names:
        return answer
    said = (
        f"Held off by the fit: {listed(names, MOST_NAMED)}. They show another board, a board or a "
        "camera that was moved, or their joint readings are those of another moment."
    )
    return replace(answer, notes=(*answer.notes, said))


def with_overlays(answer: Answer, taken: Photographs) -> Answer:
    """The answer with every photograph drawn, as a file and on the page."""
    files, shown = dict(answer.files), list[BoardPicture]()
    for number, (label, some) in enumerate(taken.items(), start=1):
        which = f"{number}_" if len(taken) > 1 else ""
        for one, marks, says in _marked(answer, label, some):
            picture = drawn(read_picture(one.path), marks, PANEL)
            files[f"overlay_{which}{one.row:04}.jpg"] = jpeg_bytes(picture, 2 * PANEL)
            shown.append(BoardPicture(says, jpeg_bytes(picture, SMALL)))
    chosen = np.unique(np.linspace(0, len(shown) - 1, min(len(shown), ON_THE_PAGE)).astype(int))
    page = BoardPictures([shown[k] for k in chosen], len(shown) - len(chosen))
    return replace(answer, files=files, sections=(*answer.sections, page))


def _marked(
    answer: Answer, label: str, taken: tuple[Photograph, ...]
) -> Iterator[tuple[Photograph, Marks, str]]:
    """Each photograph of a sense with its marks and its caption."""
    place = [sense.label for sense in answer.senses].index(label)
    sense = answer.senses[place]
    before, after = (
        _predicted(sense, some[place] if some else None)
        for some in (answer.nominal_residuals, answer.residuals)
    )
    for one in taken:
        mine = sense.rows == one.row
        nothing = np.empty((0, 2))
        if not one.used:
            detected = nothing if one.found is None else one.found.image
            rejected = nothing if one.found is None else one.found.rejected
            marks = Marks(nothing, nothing, nothing, np.concatenate([detected, rejected]))
            yield one, marks, f"{one.path.name}: {one.why}; left out."
            continue
        off = one.row in answer.outliers
        rejected = nothing if one.found is None else one.found.rejected
        marks = Marks(sense.observed[mine], before[mine], after[mine], rejected, off)
        errors = " to ".join(
            f"{_rms(told[mine] - sense.observed[mine]):.2f}" for told in (before, after)
        )
        held = "; held off by the fit" if off else ""
        yield one, marks, f"{one.path.name}: {mine.sum()} corners, {errors} px rms{held}."


def _predicted(sense: Sense, residual: Array | None) -> Array:
    """Where corners were predicted, (n, 2) px."""
    if residual is None or residual.shape != sense.observed.shape:
        return np.full_like(sense.observed, np.nan)
    return np.asarray(sense.observed - residual)


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))
