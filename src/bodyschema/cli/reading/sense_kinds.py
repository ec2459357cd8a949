"""The kinds of [[senses]]: which columns and keys each has, and how it is made of them.

Numbers in the columns are in the units that the entry names, `std` likewise; points, distances and
heights that stand in the file itself are in m.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.reading.board_senses import board
from bodyschema.cli.reading.columns import columns_of, expanded, length, point, turn
from bodyschema.cli.reading.force_senses import torques, wrenches
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.picture_senses import outlines, pixels
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import Gravity
from bodyschema.senses.layouts import LAYOUTS, poses_from_columns
from bodyschema.senses.planes import Planes
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.senses.touches import Touches
from bodyschema.sources.physical_units import ACCELERATIONS, factor

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

COMMON = (
    "kind", "seen_from", "seen", "columns", "recording", "time", "std", "stated", "clock", "speeds",
    "where",
)  # fmt: skip
"""Keys of every kind."""

PARTS = {"lens": "lens", "scale": "target", "sensor": "sensor", "drive": "drive", "clock": "clock",
         "edge": "edge"}  # fmt: skip
"""Keys that name a part, and the kind of part that it must be; `loads` name parts "load"."""


def make_sense(entry: SenseEntry, at: Moments) -> Sense:
    """The sense of an entry, read from a recording.

    Raises:
        InputError: anything that cannot be used; rows are numbered through all recordings.
    """
    kind = KINDS[entry.kind]
    for name, part in parts_of(entry):
        found = at.body.part(name).kind
        if found != part:
            raise InputError(
                f"'{name}' is a part of kind '{found}' where a sense of {entry.kind} needs one of "
                f"kind '{part}'."
            )
    known = () if at.recording is None else tuple(at.recording.columns)
    return kind.make(replace(entry, columns=expanded(entry.columns, known)), at)


def parts_of(entry: SenseEntry) -> Iterator[tuple[str, str]]:
    """Names of the parts that an entry names, and the kind that each must be."""
    for key, part in PARTS.items():
        if getattr(entry, key):
            yield getattr(entry, key), part
    loads = entry.loads.values() if isinstance(entry.loads, dict) else entry.loads
    yield from ((load, "load") for load in loads)


def _points(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = columns_of(entry, at, 3)
    m = length(entry)
    ends = entry.seen_from, entry.seen
    return Points.make(at.q[rows], m * values, *ends, **at.more(entry, rows, [m]))


def _poses(entry: SenseEntry, at: Moments) -> Sense:
    if entry.layout not in LAYOUTS:
        raise InputError(
            f"unknown pose layout '{entry.layout}'{did_you_mean(entry.layout, LAYOUTS)}"
        )
    count, m = LAYOUTS[entry.layout][0], length(entry)
    if len(entry.columns) != count:
        raise InputError(
            f"layout '{entry.layout}' has {count} columns, {len(entry.columns)} were named."
        )
    values, rows = at.read(entry.columns)
    pose = poses_from_columns(values, entry.layout, m, turn(entry))
    pose = lie.inverse(pose) if entry.inverse else pose
    more = at.more(entry, rows, [m, turn(entry)])
    return Poses.make(at.q[rows], pose, entry.seen_from, entry.seen, **more)


def _touches(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = columns_of(entry, at, 3, 6)
    m, ends = length(entry), (entry.seen_from, entry.seen)
    if len(entry.columns) == 6 and entry.touching:
        raise InputError("a sense of touches has 6 columns or 3 and touching, not both.")
    given = point(entry.touching, "touching")
    fixed = np.zeros(3) if given is None else given
    touching = m * values[:, 3:] if len(entry.columns) == 6 else fixed
    more = at.more(entry, rows, [m])
    return Touches.make(at.q[rows], m * values[:, :3], touching, *ends, **more)


def _distances(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = columns_of(entry, at, 0, 1)
    if (entry.distance is None) != bool(entry.columns):
        raise InputError("a sense of distances has either one column, or a distance in m for all.")
    m, ends = length(entry), (entry.seen_from, entry.seen)
    read = m * values[:, 0] if entry.columns else np.full(len(rows), float(entry.distance or 0.0))
    anchor, end = point(entry.anchor, "anchor"), point(entry.end, "end")
    return Distances.make(
        at.q[rows], read, *ends, anchor, end, entry.sensor, **at.more(entry, rows, [m])
    )


def _planes(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = columns_of(entry, at, 0, 1)
    m, ends = length(entry), (entry.seen_from, entry.seen)
    height = m * values[:, 0] if entry.columns else np.full(len(rows), entry.height)
    tip = point(entry.point, "point")
    return Planes.make(at.q[rows], *ends, height, tip, **at.more(entry, rows, [m]))


def _gravity(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = columns_of(entry, at, 3)
    g, ends = factor(entry.unit or "m/s^2", ACCELERATIONS), (entry.seen_from, entry.seen)
    more = at.more(entry, rows, [g])
    return Gravity.make(at.q[rows], g * values, *ends, entry.sensor, **more)


class Kind(NamedTuple):
    """One kind of sense."""

    columns: str
    """How many and what they hold, in words."""
    keys: tuple[str, ...]
    """That it uses besides `COMMON`."""
    needed: tuple[str, ...]
    """Without which nothing can be read."""
    make: Callable[[SenseEntry, Moments], Sense]


_FORCES = ("loads", "gravity", "moving", "accelerations", "torque_unit")
_TORQUES = ("per_ampere", "drive", "motors")

KINDS: dict[str, Kind] = {
    "points": Kind("x y z", ("unit",), ("seen", "columns"), _points),
    "poses": Kind(
        "those of the layout",
        ("unit", "angle_unit", "layout", "inverse"),
        ("seen", "columns"),
        _poses,
    ),
    "touches": Kind(
        "x y z in seen_from, and x y z in seen", ("unit", "touching"), ("seen", "columns"), _touches
    ),
    "pixels": Kind(
        "u v of each point",
        ("unit", "lens", "target", "scale"),
        ("seen", "columns", "lens"),
        pixels,
    ),
    "board": Kind(
        "none, or the number in the picture's name",
        ("images", "lens", "target", "scale"),
        ("seen", "images", "lens", "target"),
        board,
    ),
    "outlines": Kind(
        "none, or the number in the picture's name",
        ("lens", "masks", "images", "links", "faces", "spacing", "reach", "darker", "edge"),
        ("lens",),
        outlines,
    ),
    "distances": Kind(
        "the distance", ("unit", "distance", "anchor", "end", "sensor"), ("seen",), _distances
    ),
    "planes": Kind("none, or the height", ("unit", "height", "point"), ("seen",), _planes),
    "gravity": Kind("x y z, up at rest", ("unit", "sensor"), ("seen", "columns"), _gravity),
    "wrenches": Kind(
        "f_x f_y f_z t_x t_y t_z",
        (*_FORCES, "force_unit", "sensor", "sign"),
        ("seen", "columns", "loads", "sign"),
        wrenches,
    ),
    "torques": Kind(
        "one of each joint", (*_FORCES, *_TORQUES), ("seen", "columns", "loads"), torques
    ),
}
