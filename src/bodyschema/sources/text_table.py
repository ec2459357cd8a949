"""Tables as text: CSV and its kin, whatever stands between the cells and before the decimals.

Cells are parted by commas, semicolons, tabs or spaces; decimals begin with a point, or with a comma
where no number of the table has a point. A first line of numbers alone names no columns: they are
column_0, column_1 and so on. "-" is the text that is piped in, which is read once.
"""

from __future__ import annotations

import csv
import io
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ENDINGS = (".csv", ".tsv", ".txt")

PIPED = "-"
"""Stands for what is piped in, where a file may be named."""


def read_text(path: Path) -> Recording:
    """Read a table from a file that is there, or from what is piped in.

    Raises:
        InputError: it is no table, or a row has more or fewer cells than the header.
    """
    return _table(path, text_columns(path))


def text_columns(path: Path) -> dict[str, tuple[str, ...]]:
    """The cells of a table as they are written, by the names of their columns; see `read_text`."""
    try:
        with io.StringIO(_piped()) if path.name == PIPED else _file(path) as file:
            rows = _cells(file)
    except (csv.Error, UnicodeDecodeError, OSError) as error:
        raise InputError(f"'{path}' is no readable CSV text: {error}.") from None
    if rows and all(_is_number(cell) for cell in rows[0]):
        rows.insert(0, [f"column_{i}" for i in range(len(rows[0]))])
    if len(rows) < 2:
        raise InputError(f"'{path}' has no data; expected a line of column names, then rows.")
    header = [name.strip() for name in rows[0]]
    refuse_repeated(header, path)
    for number, row in enumerate(rows[1:]):
        if len(row) != len(header):
            raise InputError(
                f"row {number} of '{path}' has {len(row)} cells where the header names "
                f"{len(header)}; the file may be cut off."
            )
    return dict(zip(header, zip(*rows[1:], strict=True), strict=True))


def of_numbers(
    path: Path,
    columns: Mapping[str, Array],
    empty: Mapping[str, Flags],
    texts: Mapping[str, Sequence[str] | None],
) -> Recording:
    """The recording of a table, which has a column of numbers at least.

    Args:
        path: of the table.
        columns: of numbers.
        empty: which of their cells are.
        texts: other columns, with their cells where these are texts.

    Raises:
        InputError: it has none.
    """
    if not columns:
        raise InputError(f"'{path}' has no column of numbers alone, only texts.")
    words = {name: cells for name, cells in texts.items() if cells is not None}
    return Recording(f"'{path.name}'", columns, empty, frozenset(texts), words)


def refuse_repeated(header: Sequence[str], path: Path) -> None:
    """Refuse a table with two columns of one name. Raises InputError."""
    repeated = [name for name, times in Counter(header).items() if times > 1]
    if repeated:
        raise InputError(f"'{path}' has two columns named '{repeated[0]}'; rename one.")


def _file(path: Path) -> TextIO:
    return path.open(newline="", encoding="utf-8-sig")


@cache
def _piped() -> str:
    """What is piped in, which comes but once."""
    return sys.stdin.buffer.read().decode("utf-8-sig")


def _cells(file: TextIO) -> list[list[str]]:
    """The rows that are not blank; a # before the header, as of numpy, is dropped."""
    first = file.readline()
    header = first[1:].lstrip() if first.startswith("#") else first
    second = file.readline()
    mark = _separator(header, second)
    lines = _lines((header, second), file)
    return [row for row in csv.reader(lines, delimiter=mark, skipinitialspace=True) if row]


def _lines(first: Iterable[str], rest: Iterable[str]) -> Iterable[str]:
    yield from (line for line in first if line)
    yield from rest


def _separator(header: str, first: str) -> str:
    """A comma, or what else cuts a header without commas and the first row into equal counts."""
    numbers = ";" in header and all(_is_number(cell) for cell in header.split(";"))
    for mark in () if "," in header and not numbers else (";", "\t", " "):
        cut = [
            len(row) for row in csv.reader([header, first], delimiter=mark, skipinitialspace=True)
        ]
        if len(cut) == 2 and cut[0] == cut[1] > 1:
            return mark
    return ","


def _table(path: Path, cells_of: Mapping[str, Sequence[str]]) -> Recording:
    columns = {name: _floats(cells) for name, cells in cells_of.items()}
    known = [name for name, values in columns.items() if values is not None]
    if not any("." in cell for name in known for cell in cells_of[name]):
        for name in columns.keys() - known:  # decimals may begin with a comma
            columns[name] = _floats([cell.replace(",", ".", 1) for cell in cells_of[name]])
    made = {name: values for name, values in columns.items() if values is not None}
    blank = {name: np.array([not cell.strip() for cell in cells_of[name]]) for name in made}
    empty = {name: flags for name, flags in blank.items() if flags.any()}
    texts = {name: cells_of[name] for name in columns if name not in made}
    return of_numbers(path, made, empty, texts)


def _floats(cells: Sequence[str]) -> Array | None:
    """The numbers, nan where a cell is empty; None where one is something else."""
    try:
        return np.array([float(cell) if cell.strip() else np.nan for cell in cells])
    except ValueError:
        return None


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().replace(",", ".", 1))
    except ValueError:
        return False
    return True
