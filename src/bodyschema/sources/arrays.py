"""Arrays with names as a recording: .npz and .npy files, data frames, dictionaries of arrays.

An array of one axis is a column. One of two is as many columns as it has, q_0, q_1, ... of "q"; one
of matrices (n, 3, 4) or (n, 4, 4) is T_00, T_01, ... of "T", row by row. All have as many rows as
most of the arrays; others, and what holds no numbers, are left out. Times of dates are in s since
1970. A NaN of a data frame is an empty cell; that of an array is a fault, as in a file.
"""

from __future__ import annotations

import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.documents import regular_file
from bodyschema.errors import InputError
from bodyschema.sources.recording import TIME_COLUMNS, Recording

Array = NDArray[np.float64]

ENDINGS = (".npz", ".npy")

TIME = TIME_COLUMNS[0]

MATRICES = ((3, 4), (4, 4), (3, 3))


def read_arrays(path: Path) -> Recording:
    """The arrays of a .npz or .npy file.

    Raises:
        InputError: it is missing, broken, or holds no array of numbers.
    """
    regular_file(path, f"no recording at '{path}'; give the path of a .npz file.")
    try:
        with path.open("rb") as file:
            loaded: Any = np.load(file, allow_pickle=False)
            named = hasattr(loaded, "files")
            arrays = {n: _array(loaded, n) for n in loaded.files} if named else {path.stem: loaded}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        reason = str(error).partition("\n")[0].rstrip(".")
        raise InputError(f"'{path}' is no whole file of numpy arrays: {reason}.") from None
    return of_arrays(arrays, f"'{path.name}'")


def _array(loaded: Any, name: str) -> Any:
    """One array of a file; an array of objects, which may be a program, is not read."""
    try:
        return loaded[name]
    except ValueError:
        return np.array("objects")


def of_frame(frame: Any) -> Recording:
    """A data frame of pandas or polars, or any table that has columns by name.

    Raises:
        InputError: no column of it holds numbers.
    """
    columns = {str(name): _plain(frame[name]) for name in frame.columns}
    index = np.asarray(getattr(frame, "index", ()))
    if index.dtype.kind in "mM" and not {*columns} & {*TIME_COLUMNS}:
        columns = {TIME: index, **columns}
    made = of_arrays(columns, "the data frame")
    empty = {name: np.isnan(values) for name, values in made.columns.items()}
    words = {name: _words(columns[name]) for name in made.texts}
    return Recording(
        made.source, made.columns, {k: v for k, v in empty.items() if v.any()}, made.texts,
        {name: cells for name, cells in words.items() if cells},
    )  # fmt: skip


def _words(values: NDArray[Any]) -> list[str]:
    """The cells of a column of texts, nothing being ""; none where it holds other things."""
    cells = ["" if value is None or value != value else value for value in values.tolist()]
    return [str(cell) for cell in cells] if all(isinstance(c, str) for c in cells) else []


def _plain(column: Any) -> NDArray[Any]:
    """A column as an array; numbers that pandas or polars holds as objects as numbers."""
    values = np.asarray(column)
    if values.dtype.kind != "O":
        return values
    try:
        absent = [value is None or value != value for value in values]
    except TypeError:  # pandas.NA is neither
        absent = [not isinstance(value, int | float | np.number) for value in values]
    try:
        return np.array(
            [np.nan if gone else float(v) for v, gone in zip(values, absent, strict=True)]
        )
    except (TypeError, ValueError):
        return values


def of_arrays(arrays: Mapping[str, Any], source: str) -> Recording:
    """A recording of arrays by name; see the module's text.

    Args:
        arrays: (n,), (n, k) or (n, r, c) each.
        source: where they came from, for messages.

    Raises:
        InputError: none holds numbers, or two would make one column.
    """
    made = {str(name): _array_of(values) for name, values in arrays.items()}
    counts = Counter(len(values) for values in made.values() if _numeric(values))
    if not counts:
        there = ", ".join(f"{name} {values.shape}" for name, values in made.items()) or "nothing"
        raise InputError(f"{source} holds no array of numbers with rows; it has {there}.")
    rows = max(counts, key=lambda length: (counts[length], length))
    columns: dict[str, Array] = {}
    texts = set()
    for name, values in made.items():
        if not _numeric(values) or len(values) != rows:
            texts.add(name)
            continue
        for own, column in _apart(name, values):
            if own in columns:
                raise InputError(f"{source} has two columns named '{own}'; rename an array.")
            columns[own] = column
    return Recording(source, columns, {}, frozenset(texts))


def _array_of(values: Any) -> NDArray[Any]:
    """Values as an array; transforms of scipy as their matrices."""
    return lie.matrices(values) if hasattr(values, "as_matrix") else np.asarray(values)


def _numeric(values: NDArray[Any]) -> bool:
    """Whether an array has rows of numbers, or of times."""
    fits = values.ndim in (1, 2) or (values.ndim == 3 and values.shape[1:] in MATRICES)
    return fits and len(values) > 0 and values.dtype.kind in "biufmM"


def _apart(name: str, values: NDArray[Any]) -> Iterator[tuple[str, Array]]:
    """The columns that an array is."""
    if values.dtype.kind in "mM":
        unit = values.dtype.kind + "8[ns]"
        values = np.where(np.isnat(values), np.nan, values.astype(unit).astype(np.int64) / 1e9)
    numbers = values.astype(np.float64)
    if numbers.ndim == 1:
        yield name, numbers
    elif numbers.ndim == 2:
        for i in range(numbers.shape[1]):
            yield f"{name}_{i}", numbers[:, i]
    else:
        for i, j in np.ndindex(numbers.shape[1:]):
            yield f"{name}_{i}{j}", numbers[:, i, j]
