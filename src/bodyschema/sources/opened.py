"""One way to open whatever holds a recording, from Python."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bodyschema.errors import InputError
from bodyschema.sources.arrays import of_arrays, of_frame
from bodyschema.sources.recording import Recording, beside
from bodyschema.sources.tables import open_recording


def open(anything: Any) -> Recording:
    """A recording by its columns: of files, of data frames, of arrays.

    Args:
        anything: a path as `open_recording` takes it, a data frame of pandas or polars, a
            dictionary of arrays (see `sources.arrays`), or a list of these, whose rows belong
            together.

    Raises:
        InputError: it is none of these, or cannot be read.
        MissingExtraError: its kind of file needs an extra.
    """
    if isinstance(anything, Recording):
        return anything
    if isinstance(anything, str | Path):
        return open_recording(anything)
    if isinstance(anything, Mapping):
        return of_arrays(anything, "the arrays")
    if hasattr(anything, "columns") and hasattr(anything, "__getitem__"):
        return of_frame(anything)
    if isinstance(anything, list | tuple) and anything:
        return beside(open(one) for one in anything)
    raise InputError(
        f"cannot open {type(anything).__name__} as a recording; give the path of a file, a data "
        "frame, a dictionary of arrays, or a list of these."
    )
