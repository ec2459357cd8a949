"""Columns, lengths and points of a [[senses]] entry, as its maker takes them."""

from __future__ import annotations

from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.sources.physical_units import factor
from bodyschema.sources.recording import UNITS

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ANGLES = {unit: UNITS[unit] for unit in ("rad", "deg", "mrad")}
LENGTHS = {unit: UNITS[unit] for unit in ("m", "cm", "mm", "um", "in")}


def expanded(columns: tuple[str, ...], known: tuple[str, ...]) -> tuple[str, ...]:
    """Columns with a * in them stand for all that match, in the order of the file."""
    found: list[str] = []
    for name in columns:
        matches = [column for column in known if fnmatchcase(column, name)]
        found += matches if "*" in name else [name]
    return tuple(found)


def columns_of(entry: SenseEntry, at: Moments, *counts: int) -> tuple[Array, Ints]:
    """The columns of an entry, which has one of these counts of them; see `Moments.read`."""
    if len(entry.columns) not in counts:
        allowed = " or ".join(map(str, counts))
        raise InputError(
            f"a sense of {entry.kind} has {allowed} columns, {len(entry.columns)} were named."
        )
    return at.read(entry.columns)


def length(entry: SenseEntry) -> float:
    """What one of an entry's unit is in m. Raises InputError."""
    return factor(entry.unit or "m", LENGTHS)


def turn(entry: SenseEntry) -> float:
    """What one of an entry's unit of angles is in rad. Raises InputError."""
    return factor(entry.angle_unit or "rad", ANGLES)


def point(values: tuple[float, ...], key: str) -> Array | None:
    """A point that stands in the file, (3,) m; None where none does."""
    if len(values) not in (0, 3):
        raise InputError(f"{key} = {list(values)} must be three numbers, m.")
    return np.array(values) if values else None
