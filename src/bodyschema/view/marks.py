"""What was seen, as dots in space: where, how far off, and which way."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.held_out import sizes
from bodyschema.judging.calibration import Calibration
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense
from bodyschema.units import read_as

Array = NDArray[np.float64]

MOST = 400
"""Samples of one sense that are drawn; more hide each other. Outliers are always drawn."""


@dataclass(frozen=True)
class Marks:
    """The samples of one sense, placed where the corrected body has what was looked at."""

    label: str
    unit: str
    """Of the errors, as people read it."""
    rows: NDArray[np.int64]
    places: Array
    """(n, 3) m, in the root frame."""
    before: Array
    """(n,) error as modelled, in `unit`."""
    after: Array
    """(n,) held-out error of the corrected body."""
    arrows: tuple[Array, Array] | None
    """(n, 3) m in the root frame, seen minus predicted, before and after; None where what is seen
    is no place in space."""
    bad: NDArray[np.bool_]
    """(n,) outliers."""


def marks_of(calibration: Calibration, senses: Sequence[Sense]) -> tuple[Marks, ...]:
    """Marks of every sense that looks at a frame of the body.

    Args:
        calibration: the answer, with the residuals of these samples.
        senses: what was seen; without samples there are no marks.
    """
    before, after = calibration.nominal_residuals, calibration.residuals
    if len(senses) != len(after) or len(senses) != len(before):
        return ()
    return tuple(
        _marks(calibration.body, sense, old, new, calibration.outliers)
        for sense, old, new in zip(senses, before, after, strict=True)
        if len(sense)
        and len(sense) == len(old) == len(new)
        and sense.seen in calibration.body.frames
    )


def _marks(
    body: Body, sense: Sense, before: Array, after: Array, outliers: Collection[int]
) -> Marks:
    component, unit, part = sense.components[0]
    bad = np.isin(sense.rows, list(outliers))
    even = np.linspace(0, len(bad) - 1, min(MOST, len(bad))).astype(int)
    kept = np.union1d(even, np.flatnonzero(bad)[:MOST])
    q, root = sense.q[kept], body.frames[0]
    places = relative_pose(body, q, root, sense.seen)[:, :3, 3]
    arrows = None
    if unit == "m" and part.stop - part.start == 3 and sense.seen_from in body.frames:
        R = relative_pose(body, q, root, sense.seen_from)[:, :3, :3]
        old, new = (np.einsum("nij,nj->ni", R, r[kept][:, part]) for r in (before, after))
        arrows = (old, new)
    scale, word = read_as(unit)
    old_size, new_size = (scale * sizes(sense, r, component)[kept] for r in (before, after))
    return Marks(sense.label, word, sense.rows[kept], places, old_size, new_size, arrows, bad[kept])
