"""Which rows of a long table are meant: "marker == 3 and quality > 0.5", "who == 'left hand'"."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.sources.recording import Recording

OPERATORS: dict[str, Callable[..., NDArray[np.bool_]]] = {
    "==": operator.eq, "!=": operator.ne, "<=": operator.le, ">=": operator.ge,
    "<": operator.lt, ">": operator.gt,
}  # fmt: skip

_AND = re.compile(r"\s+and\s+")

_QUOTED = re.compile(r"[=!]=\s*('[^']*'|\"[^\"]*\")(?=\s+and\s|\s*\Z)")
"""A text that a cell is compared with; "and" in it joins no conditions."""

_PART = re.compile(r"\s*(.+?)\s*(==|!=|<=|>=|<|>)\s*('[^']*'|\"[^\"]*\"|\S+)\s*")


def rows_where(table: Recording, condition: str) -> NDArray[np.bool_]:
    """The rows of a table that fulfil a condition, (n_rows,); an empty cell fulfils none.

    Args:
        table: the recording.
        condition: column, operator, number; several with "and" between them.

    Raises:
        InputError: it is no condition, the column is missing or no number, or no row fulfils it.
    """
    chosen = np.ones(len(table), dtype=bool)
    for part in _parts(condition):
        found = _PART.fullmatch(part)
        if found is None:
            raise _none(condition)
        name, sign, value = found.groups()
        if name in table.words:
            chosen &= _texts(table, condition, name, sign, value.strip("'\""))
        else:
            chosen &= _numbers(table, condition, name, sign, value)
    if not chosen.any():
        raise InputError(f"no row of {table.source} fulfils where = '{condition}'.")
    return chosen


def _parts(condition: str) -> list[str]:
    """What stands between the "and" that are in no quotes."""
    hidden = _QUOTED.sub(lambda found: "." * len(found[0]), condition)
    cuts = [0, *(end for found in _AND.finditer(hidden) for end in found.span()), len(hidden)]
    return [condition[a:b] for a, b in zip(cuts[::2], cuts[1::2], strict=True)]


def _texts(table: Recording, condition: str, name: str, sign: str, value: str) -> NDArray[np.bool_]:
    if sign not in ("==", "!="):
        raise InputError(
            f"where = '{condition}': '{name}' of {table.source} holds texts, which are the same "
            "(==) or not (!=)."
        )
    cells = np.array([cell.strip() for cell in table.words[name]])
    return np.asarray((cells != "") & OPERATORS[sign](cells, value))


def _numbers(
    table: Recording, condition: str, name: str, sign: str, value: str
) -> NDArray[np.bool_]:
    try:
        number = float(value)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise _none(condition)
    cells, present = table.matrix([name], "1")
    return np.asarray(present & OPERATORS[sign](cells[:, 0], number))


def _none(condition: str) -> InputError:
    return InputError(
        f"where = '{condition}' is no condition; write a column, one of {' '.join(OPERATORS)}, and "
        'a number: "marker == 3"; or a text in a column of texts: "who == \'left\'".'
    )
