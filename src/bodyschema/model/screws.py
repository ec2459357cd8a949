"""Screw axes, the product of exponentials, as bodies.

With the screw S = (w, v) of each joint in the frame of the base, and the home pose M of a frame
where every joint is at zero (Lynch and Park, Modern Robotics 2017, Eq. 4.14 and 4.16),

    T_base_frame = exp([S_1] q_1) ... exp([S_n] q_n) M                                     "space"
    T_base_frame = M exp([B_1] q_1) ... exp([B_n] q_n),   S_i = Ad_M B_i                   "body"

A revolute joint has |w| = 1 and v = -w x p for a point p of its axis, a prismatic one w = 0 and
|v| = 1. Frames of links are parallel to the base at zero, at the point w x v of the axis that is
nearest to it; of a prismatic joint, where the link before has it.

A table in TOML or JSON:

    name = "ur5"
    form = "space"                      # optional; or "body", of a chain with one frame
    [[joint]]                           # one each, base to tip
    name = "shoulder_pan"
    screw = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]          # w and v, m
    limits = [-6.2, 6.2]                # optional: rad or m
    parent = "base"                     # optional: joint that it hangs on, the row before
    [[joint]]
    name = "lift"
    axis = [0.0, 1.0, 0.0]              # instead of screw: direction of any length, and
    point = [0.0, 0.0, 0.089]           # a point of the axis, m
    type = "revolute"                   # optional; or "prismatic", which needs no point
    [[frame]]                           # home poses, in the base at zero
    name = "tool0"
    joint = "lift"                      # optional: that carries it, the last one
    xyz = [0.817, 0.191, -0.005]        # m
    rpy = [-1.57, 0.0, 0.0]             # optional: rad, fixed axes
    # matrix = [[...], [...], [...], [0.0, 0.0, 0.0, 1.0]]      instead of both, row by row
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.body_check import refuse_bent
from bodyschema.model.joint_tables import (
    BASE,
    hung_on,
    joint_rows,
    numbers,
    one_of,
    read_table,
    refuse_unknown,
)
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
TABLE_KEYS = ("name", "form", "joint", "frame")
ROW_KEYS = ("name", "screw", "axis", "point", "type", "limits", "parent")
FRAME_KEYS = ("name", "joint", "xyz", "rpy", "matrix")
FORMS = ("space", "body")
TYPES = {"revolute": REVOLUTE, "prismatic": PRISMATIC}

ROUNDING = 1e-6
"""By which a screw may miss the length of 1, and a revolute one be pitched."""


def read_screws(path: Path) -> Body:
    """Read a table of screw axes in TOML or JSON (see the module's text).

    Raises:
        InputError: the file is missing, malformed, or has unknown keys.
    """
    table = read_table(path, "table of screw axes")
    rows = joint_rows(table, TABLE_KEYS, ROW_KEYS, path)
    names = [row["name"] for row in rows]
    parents = hung_on(names, [row.get("parent", "") for row in rows])
    homes = [_home(entry, path) for entry in _frames(table, path)]
    screws = np.array([_screw(row) for row in rows])
    if one_of(table.get("form", "space"), FORMS, "unknown form") == "body":
        if len(homes) != 1 or parents != list(range(-1, len(rows) - 1)):
            raise InputError(
                f"'{path}' has screws in the body's form, which are of one frame at the end of "
                'one chain; give those in the base, form = "space".'
            )
        screws = screws @ _adjoint(homes[0]).T
    carried = [_carrier(entry, names, path) for entry in _frames(table, path)]
    limits = {row["name"]: _pair(row.get("limits", (-np.inf, np.inf)), row["name"]) for row in rows}
    frames = [str(entry["name"]) for entry in _frames(table, path)]
    return _body(
        str(table.get("name", path.stem)), names, screws, parents, limits, frames, carried, homes
    )


def _body(
    name: str, joints: list[str], screws: Array, parents: list[int],
    limits: dict[str, tuple[float, float]], frames: list[str], carried: list[int],
    homes: list[Array],
) -> Body:  # fmt: skip
    """The body of screws (n, 6) in the base and home poses (4, 4) each."""
    origin = [np.zeros(3)]
    for (w, v), parent in zip(screws.reshape(-1, 2, 3), parents, strict=True):
        origin.append(np.cross(w, v) if w.any() else origin[parent + 1])
    turns = [bool(w.any()) for w in screws[:, :3]]
    axis = [w if turn else v for (w, v), turn in zip(screws.reshape(-1, 2, 3), turns, strict=True)]
    here = [origin[i + 1] - origin[k + 1] for i, k in enumerate(parents)]
    placements = [np.eye(4), *(lie.transform(np.eye(3), p) for p in here)]
    placements += [
        lie.transform(M[:3, :3], M[:3, 3] - origin[k + 1])
        for M, k in zip(homes, carried, strict=True)
    ]
    z = [0.0, 0.0, 1.0]
    return Body.build(
        name=name,
        frames=[BASE, *(f"link_{i + 1}" for i in range(len(joints))), *frames],
        carriers=["", *joints, *(f"{frame}_joint" for frame in frames)],
        parent=[-1, *(k + 1 for k in parents), *(k + 1 for k in carried)],
        kind=[FIXED, *(REVOLUTE if t else PRISMATIC for t in turns), *[FIXED] * len(frames)],
        axis=[z, *axis, *[z] * len(frames)],
        placement=placements,
        limits=limits,
    )


def _screw(row: Any) -> Array:
    """(6,) w and v of a row, of length 1."""
    name = row["name"]
    if ("screw" in row) == ("axis" in row):
        raise InputError(f"joint '{name}' needs a screw, or an axis with a point; one of them.")
    if "axis" in row:
        return _screw_of_axis(row)
    for key in ("point", "type"):
        if key in row:
            raise InputError(f"joint '{name}' has a screw, which says its {key}; leave that out.")
    S = np.array(numbers(row["screw"], 6, f"screw of joint '{name}'"))
    w, v = S[:3], S[3:]
    length = float(np.linalg.norm(w if w.any() else v))
    if abs(length - 1) > ROUNDING:
        raise InputError(
            f"the {'w' if w.any() else 'v'} of the screw of joint '{name}' has the length "
            f"{length:.6g}, expected 1; or give its axis and a point."
        )
    if abs(w @ v) > ROUNDING:
        raise InputError(
            f"joint '{name}' turns and slides at once (w . v = {w @ v:.3g}); give two joints."
        )
    return S / length


def _screw_of_axis(row: Any) -> Array:
    name = row["name"]
    axis = np.array(numbers(row["axis"], 3, f"axis of joint '{name}'"))
    length = np.linalg.norm(axis)
    if length < ROUNDING:
        raise InputError(f"the axis of joint '{name}' has no length.")
    kind = one_of(row.get("type", "revolute"), TYPES, f"joint '{name}' is of type")
    if kind == "prismatic":
        return np.concatenate([np.zeros(3), axis / length])
    if "point" not in row:
        raise InputError(f"joint '{name}' lacks the point of its axis: point = [x, y, z], m.")
    point = numbers(row["point"], 3, f"point of joint '{name}'")
    return np.concatenate([axis / length, -np.cross(axis / length, point)])


def _frames(table: Any, path: Path) -> list[Any]:
    listed = table.get("frame")
    if not isinstance(listed, list) or not listed:
        raise InputError(f"'{path}' has no [[frame]]; give the home pose of what is to be found.")
    for number, entry in enumerate(listed, start=1):
        refuse_unknown(entry, FRAME_KEYS, f"in [[frame]] {number} of '{path}'")
        name = entry.get("name")
        if not isinstance(name, str) or not name or name == BASE or name.startswith("link_"):
            raise InputError(
                f"[[frame]] {number} of '{path}' needs a name, which is not that of the base or a "
                "link."
            )
    names = [entry["name"] for entry in listed]
    if len({*names}) != len(names):
        raise InputError(f"'{path}' has two [[frame]] of one name; rename one.")
    return listed


def _home(entry: Any, path: Path) -> Array:
    """M of a [[frame]]."""
    what = f"of [[frame]] '{entry['name']}'"
    if "matrix" in entry:
        if "xyz" in entry or "rpy" in entry:
            raise InputError(f"the matrix {what} says xyz and rpy already; leave them out.")
        rows: Sequence[Any] = entry["matrix"]
        if not isinstance(rows, list) or len(rows) != 4:
            raise InputError(f"the matrix {what} in '{path}' needs four rows of four numbers.")
        M = np.array([numbers(row, 4, f"a row of the matrix {what}") for row in rows])
        refuse_bent(M[None], f"the matrix {what}")
        return M
    xyz = numbers(entry.get("xyz", (0.0, 0.0, 0.0)), 3, f"xyz {what}")
    rpy = numbers(entry.get("rpy", (0.0, 0.0, 0.0)), 3, f"rpy {what}")
    return lie.transform(lie.rotation_from_rpy(rpy), xyz)


def _carrier(entry: Any, names: Sequence[str], path: Path) -> int:
    """Row of the joint that carries a frame, -1 for the base."""
    joint = entry.get("joint", names[-1])
    if joint == BASE:
        return -1
    if joint not in names:
        raise InputError(f"[[frame]] '{entry['name']}' of '{path}' hangs on '{joint}', which is no "
                         f"joint{did_you_mean(str(joint), names)}")  # fmt: skip
    return list(names).index(joint)


def _pair(limits: Any, name: str) -> tuple[float, float]:
    low, high = numbers(limits, 2, f"limits of joint '{name}'", endless=True)
    return low, high


def _adjoint(T: Array) -> Array:
    """(6, 6) that takes (w, v) from one frame to another."""
    Ad = np.zeros((6, 6))
    Ad[:3, :3] = Ad[3:, 3:] = T[:3, :3]
    Ad[3:, :3] = lie.skew(T[:3, 3]) @ T[:3, :3]
    return Ad
