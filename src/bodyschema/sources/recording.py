"""Recording: a table of named columns, one row a moment, checked when a column is asked for.

An empty cell (CSV) or a null (Parquet) means "not seen in this row"; the text "nan" or a NaN is a
fault of the recorder and is refused with its row.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean

Array = NDArray[np.float64]

UNITS = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "in": 0.0254,
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": np.pi / 180,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
}
"""What one of the unit is in SI."""

LARGEST = 1e30
"""Of a number in a column, in its unit: squares of larger ones are none any more."""

TIME_COLUMNS = ("time", "t", "timestamp")

SINCE_1970 = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
"""From which size on times are ns, us or ms since 1970: in s it is the year 5138 and later."""


@dataclass(frozen=True)
class Recording:
    """Named columns of equal length."""

    source: str
    """Where it came from, for messages."""
    columns: Mapping[str, Array]
    """Column -> (n_rows,) float64; columns that hold no numbers are absent."""
    empty: Mapping[str, NDArray[np.bool_]]
    """Column -> (n_rows,) True where the cell was empty; absent when none was."""
    texts: frozenset[str] = frozenset()
    """Columns that were left out because they hold something other than numbers."""
    words: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Column of texts -> its cells, where they are kept: rows are chosen by them."""
    remarks: tuple[str, ...] = ()
    """What to know of how it was read, a sentence each."""

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def matrix(self, names: Sequence[str], unit: str = "m") -> tuple[Array, NDArray[np.bool_]]:
        """Columns side by side in SI units, and which rows are filled.

        Args:
            names: the columns.
            unit: what they are recorded in; a key of `UNITS`, or "1".

        Returns:
            values (n_rows, n_names) and present (n_rows,); a row with all cells empty is absent.

        Raises:
            InputError: a column is missing or no number, a cell is NaN, or only a part of a row is
                filled.
        """
        scale = 1.0 if unit == "1" else UNITS.get(unit)
        if scale is None:
            raise InputError(f"unknown unit '{unit}'{did_you_mean(unit, UNITS)}")
        for name in names:
            self._require(name)
        values = np.column_stack([self.columns[name] for name in names])
        nothing = np.zeros(len(self), dtype=bool)
        blank = np.column_stack([self.empty.get(name, nothing) for name in names])
        wrong = ~(np.abs(values) < LARGEST) & ~blank
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            raise InputError(
                f"column '{names[column]}' of {self.source} holds {values[row, column]} in row "
                f"{row} (the first is 0); drop or repair the {int(wrong.any(axis=1).sum())} such "
                "rows."
            )
        partly = blank.any(axis=1) & ~blank.all(axis=1)
        if partly.any():
            row = int(np.flatnonzero(partly)[0])
            raise InputError(
                f"row {row} of {self.source} has only some of {', '.join(names)}; "
                "fill the row or leave all of them empty."
            )
        return values * scale, np.logical_not(blank.any(axis=1))

    def time(self, column: str | None = None) -> Array:
        """Times of the rows in s, (n_rows,), strictly increasing; 0, 1, 2, ... without a column.

        Args:
            column: its name; None takes "time", "t" or "timestamp" if there is one, "" numbers
                the rows.

        Raises:
            InputError: times repeat or go back, a cell is empty, or the column holds no numbers.
        """
        known = {*self.columns, *self.texts}
        name = next((c for c in TIME_COLUMNS if c in known), "") if column is None else column
        if not name:
            return np.arange(len(self), dtype=np.float64)
        values, present = self.matrix([name], "s")
        if not present.all():
            row = int(np.argmin(present))
            raise InputError(f"time is empty in row {row} of {self.source}; fill or drop the row.")
        times = seconds(values[:, 0])
        back = np.flatnonzero(np.diff(times) <= 0)
        if len(back):
            row = int(back[0]) + 1
            fault = "repeats" if times[row] == times[row - 1] else "goes back"
            raise InputError(
                f"time {fault} in row {row} of {self.source} ({times[row - 1]:.6f} s, then "
                f"{times[row]:.6f} s; {len(back)} such rows); sort the rows and drop repeated "
                'ones, or set time = "" if the rows are single postures without a clock.'
            )
        return times

    def paced(self, rate_hz: float | None, time: str | None) -> Recording:
        """The same with times, (n_rows,) s from 0 on, where it has none and its rate is known.

        Args:
            rate_hz: rows a second; None leaves it as it is.
            time: its column of times as the run file names it; see `time`.
        """
        named = {*self.columns, *self.texts} & {*TIME_COLUMNS} if time is None else True
        if rate_hz is None or named:
            return self
        stamps = np.arange(len(self)) / rate_hz
        return replace(self, columns={**self.columns, TIME_COLUMNS[0]: stamps})

    def _require(self, name: str) -> None:
        if name in self.columns:
            return
        if name in self.texts:
            raise InputError(f"column '{name}' of {self.source} does not hold numbers.")
        raise InputError(f"no column '{name}' in {self.source}{did_you_mean(name, self.columns)}")


def seconds(time: Array) -> Array:
    """Times in s, (n,): stamps since 1970 in ns, us or ms are told by size; see SINCE_1970."""
    least = float(np.min(time, initial=np.inf))
    return time * next((unit for size, unit in SINCE_1970 if size <= least < np.inf), 1.0)


def beside(recordings: Iterable[Recording]) -> Recording:
    """Join recordings row by row: row i of every one belongs to the same moment.

    A column that is the same in both, such as the stamps of topics that were sent together, is one.

    Raises:
        InputError: they differ in length, or share the name of columns that differ.
    """
    parts = list(recordings)
    first = parts[0]
    columns, empty = dict(first.columns), dict(first.empty)
    for other in parts[1:]:
        if len(other) != len(first):
            raise InputError(
                f"{first.source} has {len(first)} rows and {other.source} has {len(other)}; "
                "files that are joined row by row must be equally long. Streams of rates of their "
                'own are joined by their times: join = "time".'
            )
        shared = sorted(
            name
            for name in set(columns) & set(other.columns)
            if not np.array_equal(columns[name], other.columns[name], equal_nan=True)
        )
        if shared:
            raise InputError(
                f"column '{shared[0]}' is in {other.source} and before; rename one, or "
                "if the files are recordings of other times name them under append = [...]."
            )
        columns |= other.columns
        empty |= other.empty
    texts = frozenset().union(*(part.texts for part in parts))
    words = {name: cells for part in parts for name, cells in part.words.items()}
    remarks = tuple(remark for part in parts for remark in part.remarks)
    source = " + ".join(part.source for part in parts)
    return Recording(source, columns, empty, texts, words, remarks)
