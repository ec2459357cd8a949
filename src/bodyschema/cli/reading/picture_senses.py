"""Senses of pictures: pixels of points, and outlines, from the columns and files of an entry."""

from __future__ import annotations

import numpy as np

from bodyschema.cli.reading.columns import columns_of, length
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import camera
from bodyschema.cli.reading.pictures import read_pictures
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.senses.outlines import DEFAULT_STD as OUTLINE_STD
from bodyschema.senses.outlines import Outlines
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense
from bodyschema.vision.surface import Surface


def pixels(entry: SenseEntry, at: Moments) -> Sense:
    """Points in the pictures of a camera. Raises InputError."""
    listed = entry.target if isinstance(entry.target, tuple) else ((0.0,),)
    target = np.array(listed or [(0.0, 0.0, 0.0)], dtype=np.float64)
    if target.ndim != 2 or target.shape[1] != 3:
        raise InputError("target of a sense of pixels is a list of points, [x, y, z] in m each.")
    pairs = _pairs(entry, len(target))
    if len(pairs[0]) == 5:
        values, rows = at.read(pairs[0])
        image, points = values[:, :2], length(entry) * values[:, 2:]
    else:
        parts = [at.read(pair) for pair in pairs]
        corner = np.repeat(np.arange(len(pairs)), [len(rows) for _, rows in parts])
        rows = np.concatenate([rows for _, rows in parts])
        order = np.argsort(rows, kind="stable")
        image, rows = np.concatenate([values for values, _ in parts])[order], rows[order]
        points = target[corner[order]]
    ends = entry.seen_from, entry.seen, entry.lens
    size = at.parts[entry.lens].size if entry.lens in at.parts else ()
    more = {"target": points, "scale": entry.scale, **at.more(entry, rows, [1.0])}
    more |= {"size": (size[0], size[1])} if len(size) == 2 else {}
    return Pixels.make(at.q[rows], image, *ends, **more)


def _pairs(entry: SenseEntry, corners: int) -> list[tuple[str, ...]]:
    """The columns of each corner; of five, the last three are the corner itself."""
    columns = entry.columns
    if len(columns) == 2 and all("{i}" in name for name in columns):
        return [tuple(name.replace("{i}", str(i)) for name in columns) for i in range(corners)]
    if len(columns) == 5 and not entry.target:
        return [columns]
    if len(columns) != 2 * corners:
        raise InputError(
            f"a sense of pixels has two columns for each of the {corners} points of target (or two "
            'names with {i} in them, as "u{i}"), or five with the point itself; '
            f"{len(columns)} were named."
        )
    return [columns[2 * i : 2 * i + 2] for i in range(corners)]


def outlines(entry: SenseEntry, at: Moments) -> Sense:
    """Where pictures show the edge of the body. Raises InputError."""
    _, rows = columns_of(entry, at, 0, 1)
    pattern = entry.masks or entry.images
    if bool(entry.masks) == bool(entry.images):
        raise InputError('a sense of outlines needs either masks or images = "left_{row}.png".')
    eye = camera(at.parts[entry.lens], entry.seen_from, f"[parts.{entry.lens}]")
    surface = Surface.of(at.body, entry.links or None, entry.faces)
    more = at.more(entry, rows, [1.0])
    std = float(more.pop("std", [OUTLINE_STD])[0])
    polarity = 0.0 if entry.darker is None else 1.0 if entry.darker else -1.0
    more |= {"lens": entry.lens, "edge": entry.edge, "polarity": polarity}
    more |= {"spacing": entry.spacing, "reach": entry.reach}
    if at.recording is None:
        count = len(at.body.joints)
        blank = {key: value for key, value in more.items() if key not in ("time", "rows", "rate")}
        rate = np.zeros((0, count)) if entry.clock else None
        return Outlines.blank(eye, surface, count, std, rate=rate, **blank)
    numbers = at.read(entry.columns)[0][:, 0].astype(np.int64) if entry.columns else rows
    pictures = read_pictures(pattern, numbers, bool(entry.masks))
    return Outlines.make(at.body, at.q[rows], pictures, eye, surface, std, **more)
