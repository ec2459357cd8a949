"""Denavit-Hartenberg tables, standard and modified, of chains and of trees, as bodies.

    standard   T_(i-1)_i = Rz(theta) Tz(d) Tx(a) Rx(alpha)
    modified   T_(i-1)_i = Rx(alpha) Tx(a) Rz(theta) Tz(d)          (Craig)

theta = theta0 + q for a revolute joint, d = d0 + q for a prismatic one. A row of four lengths and
angles is not a joint frame followed by a motion about its axis, as a Body wants: what a row does
after its motion goes into the placements of the rows that hang on it, and where none does into a
fixed "flange".

A table in TOML or JSON:

    name = "fr3"
    convention = "modified"             # or "standard"
    unit = "m"                          # optional: of lengths; or "mm", "cm", "in"
    angle_unit = "rad"                  # optional: of angles; or "deg"
    tool = [0.0, 0.0, 0.107]            # optional: flange after the last joint, xyz
    [[joint]]                           # one each, base to tip
    name = "joint_1"
    a = 0.0
    alpha = 0.0
    d = 0.333
    theta = 0.0                         # at zero of the encoder
    type = "revolute"                   # or "prismatic", "fixed"; optional
    limits = [-2.7, 2.7]                # optional
    parent = "base"                     # optional: joint or frame that it hangs on, the row before
    xyz = [0.0, 0.2, 1.1]               # optional: where the row begins in its parent's frame
    rpy = [0.0, 0.0, 1.57]              # optional: the same, fixed axes
    tool = [0.0, 0.0, 0.1]              # optional: of a row on which none hangs

One arm ends in the frame "flange", each of several in "flange_" and the name of its last joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.joint_tables import (
    ANGLES,
    BASE,
    LENGTHS,
    hung_on,
    joint_rows,
    numbers,
    one_of,
    read_table,
)
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
TABLE_KEYS = ("name", "convention", "unit", "angle_unit", "tool", "joint")
CONVENTIONS = ("standard", "modified")
TYPES = {"revolute": REVOLUTE, "prismatic": PRISMATIC, "fixed": FIXED}
NOWHERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class DHRow:
    """One joint of a Denavit-Hartenberg table."""

    name: str
    a: float = 0.0
    """m."""
    alpha: float = 0.0
    """rad."""
    d: float = 0.0
    """m."""
    theta: float = 0.0
    """rad, at zero of the encoder."""
    type: str = "revolute"
    limits: tuple[float, float] = (-np.inf, np.inf)
    """rad or m."""
    parent: str = ""
    """Joint or frame that it hangs on, or "base"; the row before when empty."""
    xyz: Sequence[float] = NOWHERE
    """m: where the row begins in its parent's frame."""
    rpy: Sequence[float] = NOWHERE
    """rad, fixed axes: the same."""
    tool: Sequence[float] | None = None
    """(3,) m, from the DH frame of a row on which none hangs to its flange."""


def read_dh(path: Path) -> Body:
    """Read a table in TOML or JSON (see the module's text).

    Raises:
        InputError: the file is missing, malformed, or has unknown keys.
    """
    table = read_table(path, "DH table")
    known = tuple(field.name for field in fields(DHRow))
    rows = [DHRow(**row) for row in joint_rows(table, TABLE_KEYS, known, path)]
    length = LENGTHS[one_of(table.get("unit", "m"), LENGTHS, "unknown unit")]
    angle = ANGLES[one_of(table.get("angle_unit", "rad"), ANGLES, "unknown angle_unit")]
    name = table.get("name", path.stem)
    tool = length * np.array(numbers(table.get("tool", NOWHERE), 3, f"tool of '{name}'"))
    rows = [_in_si(row, length, angle) for row in rows]
    return body_from_dh(rows, table.get("convention", "standard"), tool.tolist(), name)


def _in_si(row: DHRow, length: float, angle: float) -> DHRow:
    """A row in m and rad. Raises InputError for what are no numbers."""

    def scaled(key: str, unit: float) -> float:
        return unit * numbers(getattr(row, key), 1, f"{key} of joint '{row.name}'")[0]

    def place(key: str, unit: float) -> list[float]:
        return [unit * v for v in numbers(getattr(row, key), 3, f"{key} of joint '{row.name}'")]

    low, high = _limits(row)
    unit = length if row.type == "prismatic" else angle
    return replace(
        row,
        a=scaled("a", length),
        alpha=scaled("alpha", angle),
        d=scaled("d", length),
        theta=scaled("theta", angle),
        limits=(unit * low, unit * high),
        xyz=place("xyz", length),
        rpy=place("rpy", angle),
        tool=None if row.tool is None else place("tool", length),
    )


def _limits(row: DHRow) -> tuple[float, float]:
    low, high = numbers(row.limits, 2, f"limits of joint '{row.name}'", endless=True)
    return low, high


def body_from_dh(
    rows: Sequence[DHRow],
    convention: str = "standard",
    tool: Sequence[float] = NOWHERE,
    name: str = "robot",
) -> Body:
    """A body with frames "base", "link_1" .. "link_n" and a flange for every end.

    Args:
        rows: one row a joint, each below the one that it hangs on.
        convention: "standard" or "modified".
        tool: (3,) m, from the last DH frame of the only arm to its flange, in that frame.
        name: of the robot.

    Raises:
        InputError: an entry is not a finite number, or a word is unknown.
    """
    one_of(convention, CONVENTIONS, "unknown DH convention")
    parents = hung_on([row.name for row in rows], [row.parent for row in rows])
    placements, after = [np.eye(4)], [np.eye(4)]
    for row, parent in zip(rows, parents, strict=True):
        _check_row(row)
        mount = lie.transform(lie.rotation_from_rpy(row.rpy), row.xyz)
        along_x = _screw([1.0, 0.0, 0.0], row.alpha, row.a)
        along_z = _screw([0.0, 0.0, 1.0], row.theta, row.d)
        # Rotation about z and shift along z commute, so the motion may come after both.
        if convention == "standard":
            placements.append(after[parent + 1] @ mount @ along_z)
            after.append(along_x)
        else:
            placements.append(after[parent + 1] @ mount @ along_x @ along_z)
            after.append(np.eye(4))
    ends = _flanges(rows, parents, tool, name)
    placements += [after[i + 1] @ lie.transform(np.eye(3), at) for i, _, at in ends]
    n = len(rows)
    return Body.build(
        name=name,
        frames=[BASE, *(f"link_{i + 1}" for i in range(n)), *(frame for _, frame, _ in ends)],
        carriers=["", *(row.name for row in rows), *(f"{frame}_joint" for _, frame, _ in ends)],
        parent=[-1, *(k + 1 for k in parents), *(i + 1 for i, _, _ in ends)],
        kind=[FIXED, *(TYPES[row.type] for row in rows), *[FIXED] * len(ends)],
        axis=np.tile([0.0, 0.0, 1.0], (1 + n + len(ends), 1)),
        placement=placements,
        limits={row.name: _limits(row) for row in rows},
    )


def _flanges(
    rows: Sequence[DHRow], parents: Sequence[int], tool: Sequence[float], name: str
) -> list[tuple[int, str, list[float]]]:
    """Row, frame and place of the flange of every row on which none hangs."""
    ends = [i for i in range(len(rows)) if i not in parents]
    last = numbers(tool, 3, f"tool of '{name}'")
    if len(ends) > 1 and any(last):
        raise InputError(
            f"'{name}' has {len(ends)} arms and one tool; give the last row of each a tool."
        )
    inner = [row.name for i, row in enumerate(rows) if row.tool is not None and i not in ends]
    if inner:
        raise InputError(f"joint '{inner[0]}' has a tool, but others hang on it; leave it out.")
    found = []
    for i in ends:
        own: Any = rows[i].tool
        at = last if own is None else numbers(own, 3, f"tool of joint '{rows[i].name}'")
        found.append((i, "flange" if len(ends) == 1 else f"flange_{rows[i].name}", at))
    return found


def _check_row(row: DHRow) -> None:
    one_of(row.type, TYPES, f"joint '{row.name}' is of type")
    _in_si(row, 1.0, 1.0)


def _screw(axis: Sequence[float], angle: float, shift: float) -> Array:
    """Rotation about and shift along one axis of the frame."""
    direction = np.asarray(axis)
    return lie.transform(lie.exp_so3(angle * direction), shift * direction)
