"""What columns may be, by their names and ranges: poses, points, joints, and their units.

These are guesses, and are called so wherever they are shown: 90 may be degrees, percent or ticks,
and nothing in a number says whether it is the camera in the board or the board in the camera.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.sources.contents import Stream

Array = NDArray[np.float64]

WHOLE_TURN, LARGEST_DEG, LARGEST_M = 7.0, 400.0, 20.0
"""Of joint readings in rad and deg, of positions in m: what is larger is in a smaller unit."""

TICKS = 4096
"""A turn of the encoders that most servos have."""

PERCENT = 100.0
"""Where readings in percent of a range end."""

SHAPES: Mapping[str, Sequence[tuple[str, tuple[str, ...]]]] = {
    "poses": (
        ("xyz_xyzw", ("x", "y", "z", "qx", "qy", "qz", "qw")),
        ("matrix4x4", tuple(f"{i}{j}" for i in range(4) for j in range(4))),
        ("matrix3x4", tuple(f"{i}{j}" for i in range(3) for j in range(4))),
        ("xyz_rpy", ("x", "y", "z", "roll", "pitch", "yaw")),
        ("xyz_rpy", ("x", "y", "z", "c", "b", "a")),
        ("xyz_rotvec", ("x", "y", "z", "rx", "ry", "rz")),
        ("xyz_rotvec", ("tx", "ty", "tz", "rx", "ry", "rz")),
    ),
    "wrenches": (("", ("fx", "fy", "fz", "tx", "ty", "tz")),),
    "pixels": (("", ("u", "v")),),
    "points": (("", ("x", "y", "z")),),
}
"""Kind -> layouts, and how the names of their columns end, the fullest first."""

UNNAMED = tuple(f"column_{i}" for i in range(8))
"""Columns of a table without names that is taken for times and poses."""

JOINT = re.compile(
    r"(.*[_.])?(joint|j|q)[_.]?\d+.*|.*joint.*|.*\.pos|q_.*|.*_(rad|deg)_\d+", re.IGNORECASE
)

_ENDS = re.compile(r"([._](pos|position|rad|deg|mrad))+$")
_STARTS = re.compile(r"^(q|pos|position|joint_states?|observation\.state)[._]")


@dataclass(frozen=True)
class Group:
    """Columns that belong together."""

    kind: str
    """Of the sense that they may be."""
    layout: str
    """Of poses."""
    columns: tuple[str, ...]
    unit: str
    """Of its lengths, by their size."""
    angle_unit: str = ""
    """Of its angles, likewise; "" where it has none."""

    @property
    def name(self) -> str:
        """What all its columns' names begin with, "" for nothing."""
        letters = zip(*self.columns, strict=False)
        same = itertools.takewhile(lambda place: len({*place}) == 1, letters)
        return "".join(place[0] for place in same).rstrip("._-/")


def groups_of(stream: Stream) -> tuple[Group, ...]:
    """Poses, points, pixels and wrenches among the columns of a stream."""
    table = stream.recording
    if table is None:
        return ()
    if tuple(table.columns) == UNNAMED and stream.clock:
        return (_group(table.columns, "poses", "xyz_xyzw", UNNAMED[1:]),)
    taken = {stream.clock}
    found = []
    for kind, layout, columns in _candidates(tuple(table.columns)):
        if not taken & {*columns}:
            taken |= {*columns}
            found.append(_group(table.columns, kind, layout, columns))
    return tuple(found)


def joints_of(stream: Stream, named: Sequence[str] = ()) -> dict[str, str]:
    """Joint -> column: those of a robot that are found, or what looks like joints.

    Args:
        stream: with numbers, or without.
        named: joints of the robot; none where nobody knows it.
    """
    if stream.recording is None:
        return {}
    columns = [name for name in stream.recording.columns if name != stream.clock]
    own = {plain(name): name for name in reversed(columns)}
    if named:
        found = {joint: own[plain(joint)] for joint in named if plain(joint) in own}
        if found:
            return found
    taken = {c for group in groups_of(stream) for c in group.columns}
    speeds = {name for name in columns if name.startswith(("d_", "effort_", "action."))}
    states = stream.kind.endswith("JointState")
    alike = [c for c in columns if c not in taken | speeds and (states or JOINT.fullmatch(c))]
    if named:
        return dict(zip(named, alike, strict=True)) if len(named) == len(alike) else {}
    return {plain(column): column for column in alike}


def plain(name: str) -> str:
    """A joint's name without what recorders add: elbow.pos, q_elbow, elbow_deg."""
    return _STARTS.sub("", _ENDS.sub("", name)).lower() or name


def angle_unit(columns: Mapping[str, Array], names: Sequence[str]) -> str:
    """Unit of joints by their names and the largest of their readings: rad, deg, percent, ticks."""
    for unit in ("deg", "mrad", "rad"):
        if names and all(re.fullmatch(rf".*_{unit}(_\d+)?", n.lower()) for n in names):
            return unit
    values = [columns[name][np.isfinite(columns[name])] for name in names]
    largest = max((float(np.abs(v).max(initial=0.0)) for v in values), default=0.0)
    if largest <= WHOLE_TURN:
        return "rad"
    if largest == PERCENT:
        return "percent"
    return "deg" if largest <= LARGEST_DEG else "ticks"


def _candidates(names: Sequence[str]) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Every set of columns that has the endings of a kind behind one beginning."""
    own = {name.lower(): name for name in names}
    for kind, shapes in SHAPES.items():
        for layout, ends in shapes:
            starts = [low[: -len(ends[0])] for low in own if low.endswith(ends[0])]
            for start in starts:
                columns = [own.get(start + end) for end in ends]
                if None not in columns and _apart(start):
                    yield kind, layout, tuple(c for c in columns if c)
    numbers = sorted({n[1:] for n in own if re.fullmatch(r"x_?\d+", n)}, key=lambda n: (len(n), n))
    for number in numbers:
        columns = [own.get(axis + number) for axis in "xyz"]
        if None not in columns:
            yield "points", "", tuple(c for c in columns if c)


def _apart(start: str) -> bool:
    """Whether a beginning ends as words do: board_x, not max."""
    return not start or start[-1] in "._-/"


def _group(columns: Mapping[str, Array], kind: str, layout: str, names: tuple[str, ...]) -> Group:
    lengths = [3, 7, 11] if layout.startswith("matrix") else [0, 1, 2][: len(names)]
    sizes = [columns[names[i]][np.isfinite(columns[names[i]])] for i in lengths]
    largest = max(float(np.abs(values).max(initial=0.0)) for values in sizes)
    angles = ""
    if layout in ("xyz_rpy", "xyz_rotvec"):
        turns = [float(np.nanmax(np.abs(columns[name]))) for name in names[3:]]
        angles = "rad" if max(turns) <= WHOLE_TURN else "deg"
    unit = {"pixels": "px", "wrenches": "N"}.get(kind, "m" if largest <= LARGEST_M else "mm")
    return Group(kind, layout, names, unit, angles)
