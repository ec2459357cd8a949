"""Denavit-Hartenberg tables, standard and modified, as bodies.

    standard   T_(i-1)_i = Rz(theta) Tz(d) Tx(a) Rx(alpha)
    modified   T_(i-1)_i = Rx(alpha) Tx(a) Rz(theta) Tz(d)          (Craig)

theta = theta0 + q for a revolute joint, d = d0 + q for a prismatic one. A row of four lengths and
angles is not a joint frame followed by a motion about its axis, as a Body wants: what a row does
after its motion goes into the placement of the next row, and after the last into a fixed "flange".

A table in TOML or JSON:

    name = "fr3"
    convention = "modified"             # or "standard"
    tool = [0.0, 0.0, 0.107]            # optional: flange after the last joint, xyz in m
    [[joint]]                           # one each, base to tip
    name = "joint_1"
    a = 0.0                             # m
    alpha = 0.0                         # rad
    d = 0.333                           # m
    theta = 0.0                         # rad
    type = "revolute"                   # or "prismatic"; optional
    limits = [-2.7, 2.7]                # rad or m; optional
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.documents import json_file, toml_file
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
TABLE_KEYS = ("name", "convention", "tool", "joint")
CONVENTIONS = ("standard", "modified")
TYPES = {"revolute": REVOLUTE, "prismatic": PRISMATIC}


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


def read_dh(path: Path) -> Body:
    """Read a table in TOML or JSON (see the module's text).

    Raises:
        InputError: the file is missing, malformed, or has unknown keys.
    """
    missing = f"no DH table at '{path}'; give the path of a TOML or JSON file."
    read = json_file if path.suffix == ".json" else toml_file
    table = read(path, missing, "not a readable DH table")
    _refuse_unknown(table, TABLE_KEYS, f"in '{path}'")
    listed = table.get("joint")
    if not isinstance(listed, list) or not listed:
        raise InputError(f"'{path}' has no [[joint]] rows; give one a joint.")
    if not isinstance(table.get("name", ""), str):
        raise InputError(f"name = {table['name']!r:.60} in '{path}'; expected text.")
    rows = []
    for number, row in enumerate(listed, start=1):
        _refuse_unknown(
            row, tuple(DHRow.__dataclass_fields__), f"in [[joint]] {number} of '{path}'"
        )
        rows.append(DHRow(**{"name": f"joint_{number}", **row}))
    tool = table.get("tool", (0.0, 0.0, 0.0))
    return body_from_dh(
        rows, table.get("convention", "standard"), tool, table.get("name", path.stem)
    )


def _refuse_unknown(table: Any, known: Sequence[str], where: str) -> None:
    if not isinstance(table, dict):
        raise InputError(f"expected keys and values {where}, got '{table}'.")
    for key in table:
        if key not in known:
            raise InputError(f"unknown key '{key}' {where}{did_you_mean(key, known)}")


def _numbers(values: Any, count: int, what: str, endless: bool = False) -> list[float]:
    # Text, true and NaN are refused, and infinity unless `endless`.
    listed = list(values) if isinstance(values, Sequence | np.ndarray) else [values]
    good = [
        isinstance(v, Real)
        and not isinstance(v, bool)
        and (math.isfinite(v) or (endless and math.isinf(v)))
        for v in listed
    ]
    if len(listed) != count or not all(good):
        raise InputError(f"{what} should be {count} number{'s' * (count > 1)}, it is '{values}'.")
    return [float(v) for v in listed]


def _check_row(row: DHRow, times: Mapping[str, int]) -> None:
    if not isinstance(row.name, str) or times[row.name] > 1:
        raise InputError(f"joint name '{row.name}' must be text, and used once; rename one.")
    if str(row.type) not in TYPES:
        raise InputError(
            f"joint '{row.name}' is of type '{row.type}'{did_you_mean(str(row.type), TYPES)}"
        )
    for key in ("a", "alpha", "d", "theta"):
        _numbers(getattr(row, key), 1, f"{key} of joint '{row.name}'")


def body_from_dh(
    rows: Sequence[DHRow],
    convention: str = "standard",
    tool: Sequence[float] = (0.0, 0.0, 0.0),
    name: str = "robot",
) -> Body:
    """A serial body with frames "base", "link_1" .. "link_n" and "flange".

    Args:
        rows: one row a joint, base to tip.
        convention: "standard" or "modified".
        tool: (3,) m, from the last DH frame to the flange, in the last DH frame.
        name: of the robot.

    Raises:
        InputError: an entry is not a finite number, or a word is unknown.
    """
    if str(convention) not in CONVENTIONS:
        raise InputError(
            f"unknown DH convention '{convention}'{did_you_mean(str(convention), CONVENTIONS)}"
        )
    flange = _numbers(tool, 3, f"tool of '{name}'")
    after = np.eye(4)
    placements = [np.eye(4)]
    limits: dict[str, tuple[float, float]] = {}
    times = Counter(row.name for row in rows if isinstance(row.name, str))
    for row in rows:
        _check_row(row, times)
        low, high = _numbers(row.limits, 2, f"limits of joint '{row.name}'", endless=True)
        limits[row.name] = low, high
        along_x = _screw([1.0, 0.0, 0.0], row.alpha, row.a)
        along_z = _screw([0.0, 0.0, 1.0], row.theta, row.d)
        # Rotation about z and shift along z commute, so the motion may come after both.
        if convention == "standard":
            placements.append(after @ along_z)
            after = along_x
        else:
            placements.append(after @ along_x @ along_z)
    placements.append(after @ lie.transform(np.eye(3), flange))
    n = len(rows)
    return Body.build(
        name=name,
        frames=["base", *(f"link_{i + 1}" for i in range(n)), "flange"],
        carriers=["", *(row.name for row in rows), "flange_joint"],
        parent=range(-1, n + 1),
        kind=[FIXED, *(TYPES[row.type] for row in rows), FIXED],
        axis=np.tile([0.0, 0.0, 1.0], (n + 2, 1)),
        placement=placements,
        limits=limits,
    )


def _screw(axis: Sequence[float], angle: float, shift: float) -> Array:
    """Rotation about and shift along one axis of the frame."""
    direction = np.asarray(axis)
    return lie.transform(lie.exp_so3(angle * direction), shift * direction)
