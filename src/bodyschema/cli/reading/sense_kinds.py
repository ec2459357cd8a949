"""The kinds of [[senses]]: which columns and keys each has, and how it is made of them.

Numbers in the columns are in the units that the entry names, `std` likewise; points, distances and
heights that stand in the file itself are in m.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.reading.joints import column_of
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import camera
from bodyschema.cli.reading.pictures import read_pictures
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import Gravity
from bodyschema.senses.layouts import LAYOUTS, poses_from_columns
from bodyschema.senses.outlines import DEFAULT_STD as OUTLINE_STD
from bodyschema.senses.outlines import Outlines
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.planes import Planes
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.senses.torques import Torques
from bodyschema.senses.touches import Touches
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.sources.physical_units import ACCELERATIONS, FORCES, TORQUES, factor
from bodyschema.sources.recording import UNITS
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

COMMON = (
    "kind", "seen_from", "seen", "columns", "recording", "time", "std", "stated", "clock", "speeds",
)  # fmt: skip
"""Keys of every kind."""

LENGTHS = {unit: UNITS[unit] for unit in ("m", "cm", "mm", "um", "in")}

SIGNS = ("on_sensor", "on_object")

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
    return kind.make(entry, at)


def parts_of(entry: SenseEntry) -> Iterator[tuple[str, str]]:
    """Names of the parts that an entry names, and the kind that each must be."""
    for key, part in PARTS.items():
        if getattr(entry, key):
            yield getattr(entry, key), part
    loads = entry.loads.values() if isinstance(entry.loads, dict) else entry.loads
    yield from ((load, "load") for load in loads)


def _read(entry: SenseEntry, at: Moments, *counts: int) -> tuple[Array, Ints]:
    """The columns of an entry, which has one of these counts of them; see `Moments.read`."""
    if len(entry.columns) not in counts:
        allowed = " or ".join(map(str, counts))
        raise InputError(
            f"a sense of {entry.kind} has {allowed} columns, {len(entry.columns)} were named."
        )
    return at.read(entry.columns)


def _length(entry: SenseEntry) -> float:
    return factor(entry.unit or "m", LENGTHS)


def _point(values: tuple[float, ...], key: str) -> Array | None:
    """A point that stands in the file, (3,) m; None where none does."""
    if len(values) not in (0, 3):
        raise InputError(f"{key} = {list(values)} must be three numbers, m.")
    return np.array(values) if values else None


def _points(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 3)
    m = _length(entry)
    ends = entry.seen_from, entry.seen
    return Points.make(at.q[rows], m * values, *ends, **at.more(entry, rows, [m]))


def _poses(entry: SenseEntry, at: Moments) -> Sense:
    if entry.layout not in LAYOUTS:
        raise InputError(
            f"unknown pose layout '{entry.layout}'{did_you_mean(entry.layout, LAYOUTS)}"
        )
    count, m = LAYOUTS[entry.layout][0], _length(entry)
    if len(entry.columns) != count:
        raise InputError(
            f"layout '{entry.layout}' has {count} columns, {len(entry.columns)} were named."
        )
    values, rows = at.read(entry.columns)
    pose = poses_from_columns(values, entry.layout, m)
    pose = lie.inverse(pose) if entry.inverse else pose
    more = at.more(entry, rows, [m, 1.0])
    return Poses.make(at.q[rows], pose, entry.seen_from, entry.seen, **more)


def _touches(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 3, 6)
    m, ends = _length(entry), (entry.seen_from, entry.seen)
    if len(entry.columns) == 6 and entry.touching:
        raise InputError("a sense of touches has 6 columns or 3 and touching, not both.")
    given = _point(entry.touching, "touching")
    point = np.zeros(3) if given is None else given
    touching = m * values[:, 3:] if len(entry.columns) == 6 else point
    more = at.more(entry, rows, [m])
    return Touches.make(at.q[rows], m * values[:, :3], touching, *ends, **more)


def _pixels(entry: SenseEntry, at: Moments) -> Sense:
    target = np.array(entry.target or [(0.0, 0.0, 0.0)], dtype=np.float64)
    if target.ndim != 2 or target.shape[1] != 3:
        raise InputError("target of a sense of pixels is a list of points, [x, y, z] in m each.")
    pairs = _pairs(entry, len(target))
    if len(pairs[0]) == 5:
        values, rows = at.read(pairs[0])
        image, points = values[:, :2], _length(entry) * values[:, 2:]
    else:
        parts = [at.read(pair) for pair in pairs]
        corner = np.repeat(np.arange(len(pairs)), [len(rows) for _, rows in parts])
        rows = np.concatenate([rows for _, rows in parts])
        order = np.argsort(rows, kind="stable")
        image, rows = np.concatenate([values for values, _ in parts])[order], rows[order]
        points = target[corner[order]]
    ends = entry.seen_from, entry.seen, entry.lens
    more = {"target": points, "scale": entry.scale, **at.more(entry, rows, [1.0])}
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


def _outlines(entry: SenseEntry, at: Moments) -> Sense:
    _, rows = _read(entry, at, 0, 1)
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


def _distances(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 0, 1)
    if (entry.distance is None) != bool(entry.columns):
        raise InputError("a sense of distances has either one column, or a distance in m for all.")
    m, ends = _length(entry), (entry.seen_from, entry.seen)
    read = m * values[:, 0] if entry.columns else np.full(len(rows), float(entry.distance or 0.0))
    anchor, end = _point(entry.anchor, "anchor"), _point(entry.end, "end")
    return Distances.make(
        at.q[rows], read, *ends, anchor, end, entry.sensor, **at.more(entry, rows, [m])
    )


def _planes(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 0, 1)
    m, ends = _length(entry), (entry.seen_from, entry.seen)
    height = m * values[:, 0] if entry.columns else np.full(len(rows), entry.height)
    point = _point(entry.point, "point")
    return Planes.make(at.q[rows], *ends, height, point, **at.more(entry, rows, [m]))


def _gravity(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 3)
    g, ends = factor(entry.unit or "m/s^2", ACCELERATIONS), (entry.seen_from, entry.seen)
    more = at.more(entry, rows, [g])
    return Gravity.make(at.q[rows], g * values, *ends, entry.sensor, **more)


def _wrenches(entry: SenseEntry, at: Moments) -> Sense:
    values, rows = _read(entry, at, 6)
    if entry.sign not in SIGNS:
        raise InputError(
            f"sign = '{entry.sign}' of a sense of wrenches{did_you_mean(entry.sign, SIGNS)} The "
            'load\'s pull on the sensor is "on_sensor": its force points down at rest.'
        )
    if isinstance(entry.loads, dict):
        raise InputError('loads of a sense of wrenches are a list, such as ["gripper", "cup"].')
    scales = [factor(entry.force_unit, FORCES), factor(entry.torque_unit, TORQUES)]
    wrench = values * np.repeat(scales, 3) * (-1.0 if entry.sign == "on_sensor" else 1.0)
    more: dict[str, Any] = {"loads": entry.loads, "sensor": entry.sensor, "gravity": entry.gravity}
    more |= at.motion(entry, rows) | at.more(entry, rows, scales)
    return WristWrenches.make(at.q[rows], wrench, entry.seen_from, entry.seen, **more)


def _torques(entry: SenseEntry, at: Moments) -> Sense:
    if not isinstance(entry.loads, dict):
        raise InputError(
            'loads of a sense of torques are named by their links: { link_1 = "load_1" }.'
        )
    count = len(at.body.joints)
    scales = np.full(count, factor(entry.torque_unit, TORQUES))
    if entry.per_ampere:
        scales = np.array(entry.per_ampere, dtype=np.float64)
    one = len(entry.columns) == 1 and "{joint}" in entry.columns[0]
    names = [entry.columns[0].replace("{joint}", column_of(j, at.joints)) for j in at.body.joints]
    columns = replace(entry, columns=tuple(names)) if one else entry
    values, rows = _read(columns, at, count)
    if len(scales) != count:
        raise InputError(f"per_ampere has {len(scales)} numbers for {count} joints.")
    motors = np.array(entry.motors) if entry.motors else None
    more: dict[str, Any] = {"motors": motors, "drive": entry.drive}
    more |= {"gravity": entry.gravity, **at.motion(entry, rows), **at.more(entry, rows, scales)}
    ends = entry.seen_from, entry.seen
    return Torques.make(at.q[rows], values * scales, entry.loads, *ends, **more)


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
        "those of the layout", ("unit", "layout", "inverse"), ("seen", "columns"), _poses
    ),
    "touches": Kind(
        "x y z in seen_from, and x y z in seen", ("unit", "touching"), ("seen", "columns"), _touches
    ),
    "pixels": Kind(
        "u v of each point",
        ("unit", "lens", "target", "scale"),
        ("seen", "columns", "lens"),
        _pixels,
    ),
    "outlines": Kind(
        "none, or the number in the picture's name",
        ("lens", "masks", "images", "links", "faces", "spacing", "reach", "darker", "edge"),
        ("lens",),
        _outlines,
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
        _wrenches,
    ),
    "torques": Kind(
        "one of each joint", (*_FORCES, *_TORQUES), ("seen", "columns", "loads"), _torques
    ),
}
