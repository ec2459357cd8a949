"""What tables of joints have in common, be they of Denavit and Hartenberg or of screws."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from bodyschema.documents import json_file, toml_file
from bodyschema.errors import InputError, did_you_mean

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
ANGLES = {"rad": 1.0, "deg": math.pi / 180}
"""Units of a table, in m and rad."""

BASE = "base"
"""The frame that every table begins at."""


def read_table(path: Path, what: str) -> Any:
    """What a TOML or JSON file holds.

    Args:
        path: of the file.
        what: it should be, such as "DH table".

    Raises:
        InputError: it is missing or malformed.
    """
    missing = f"no {what} at '{path}'; give the path of a TOML or JSON file."
    read = json_file if path.suffix == ".json" else toml_file
    return read(path, missing, f"not a readable {what}")


def joint_rows(table: Any, known: Sequence[str], row: Sequence[str], path: Path) -> list[Any]:
    """The [[joint]] rows of a table, each with a name.

    Args:
        table: as read.
        known: keys of the table.
        row: keys of a row.
        path: names it in messages.

    Raises:
        InputError: no rows, or a key that is unknown.
    """
    refuse_unknown(table, known, f"in '{path}'")
    listed = table.get("joint")
    if not isinstance(listed, list) or not listed:
        raise InputError(f"'{path}' has no [[joint]] rows; give one a joint.")
    if not isinstance(table.get("name", ""), str):
        raise InputError(f"name = {table['name']!r:.60} in '{path}'; expected text.")
    for number, one in enumerate(listed, start=1):
        refuse_unknown(one, row, f"in [[joint]] {number} of '{path}'")
    return [{"name": f"joint_{number}", **one} for number, one in enumerate(listed, start=1)]


def refuse_unknown(table: Any, known: Sequence[str], where: str) -> None:
    """Refuse what is no table, and keys that it does not have. Raises InputError."""
    if not isinstance(table, dict):
        raise InputError(f"expected keys and values {where}, got '{table}'.")
    for key in table:
        if key not in known:
            raise InputError(f"unknown key '{key}' {where}{did_you_mean(key, known)}")


def numbers(values: Any, count: int, what: str, endless: bool = False) -> list[float]:
    """So many numbers; text, true and NaN are refused, and infinity unless `endless`.

    Raises:
        InputError: they are others, or not as many.
    """
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


def one_of(word: Any, known: Mapping[str, Any] | Sequence[str], what: str) -> str:
    """A word, if it is one of those. Raises InputError with close ones."""
    if str(word) not in known:
        raise InputError(f"{what} '{word}'{did_you_mean(str(word), known)}")
    return str(word)


def hung_on(names: Sequence[Any], parents: Sequence[Any]) -> list[int]:
    """Which row each row hangs on, -1 for the base.

    Args:
        names: of the rows' joints; row i has the frame link_(i + 1).
        parents: what each row says: a joint, a frame, "base", or "" for the row before.

    Raises:
        InputError: a name is used twice or is none, or a parent does not stand above its row.
    """
    for name in names:
        if not isinstance(name, str) or names.count(name) > 1:
            raise InputError(f"joint name '{name}' must be text, and used once; rename one.")
    found = []
    for i, parent in enumerate(parents):
        above = {BASE: -1} | {f"link_{k + 1}": k for k in range(i)}
        above |= {name: k for k, name in enumerate(names[:i])}
        if parent and str(parent) not in above:
            raise InputError(
                f"joint '{names[i]}' hangs on '{parent}', which is no joint or frame above it"
                f"{did_you_mean(str(parent), above)}"
            )
        found.append(above[str(parent)] if parent else i - 1)
    return found
