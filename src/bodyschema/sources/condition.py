"""Which rows of a long table are meant: "marker == 3", "marker == 3 and quality > 0.5"."""

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

_PART = re.compile(r"\s*(.+?)\s*(==|!=|<=|>=|<|>)\s*(\S+)\s*")


def rows_where(table: Recording, condition: str) -> NDArray[np.bool_]:
    """The rows of a table that fulfil a condition, (n_rows,); an empty cell fulfils none.

    Args:
        table: the recording.
        condition: column, operator, number; several with "and" between them.

    Raises:
        InputError: it is no condition, the column is missing or no number, or no row fulfils it.
    """
    chosen = np.ones(len(table), dtype=bool)
    for part in re.split(r"\s+and\s+", condition):
        found = _PART.fullmatch(part)
        try:
            value = float(found[3]) if found else np.nan
        except ValueError:
            value = np.nan
        if found is None or not np.isfinite(value):
            raise InputError(
                f"where = '{condition}' is no condition; write a column, one of "
                f'{" ".join(OPERATORS)}, and a number: "marker == 3".'
            )
        cells, present = table.matrix([found[1]], "1")
        chosen &= present & OPERATORS[found[2]](cells[:, 0], value)
    if not chosen.any():
        raise InputError(f"no row of {table.source} fulfils where = '{condition}'.")
    return chosen
