"""Parquet files (extra `data`), opened in one place so that what is broken is said in one way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from bodyschema.documents import regular_file
from bodyschema.errors import InputError, MissingExtraError

MOST_CELLS = 10**9
"""8 GB of numbers: a file of a few bytes may say that it has more, all of them alike."""


def parquet_table(
    path: Path, purpose: str = "", chosen: Callable[[Sequence[str]], list[str]] = list
) -> Any:
    """The columns of a Parquet file, as pyarrow has them.

    Args:
        path: of the file.
        purpose: what for, in the message of a package that is missing.
        chosen: which of the file's columns are read, by their names.

    Raises:
        InputError: missing, no whole Parquet file, or one that says it is larger than memory.
        MissingExtraError: pyarrow is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        purpose = purpose or f"reading '{path.name}'"
        raise MissingExtraError("pyarrow", "data", purpose) from None
    regular_file(path, f"no recording at '{path}'; give the path of a Parquet file.")
    try:
        with pq.ParquetFile(path) as file:
            names = chosen(file.schema_arrow.names)
            twice = next((name for name, n in Counter(names).items() if n > 1), None)
            if twice is not None:
                raise InputError(f"'{path}' has two columns named '{twice}'; rename one.")
            cells = file.metadata.num_rows * len(names)
            if not 0 <= cells <= MOST_CELLS:
                raise InputError(f"'{path}' says that it has {cells:.3g} cells; it is damaged.")
            table = file.read(columns=names)
            table.validate(full=True)
            return table
    except (pa.ArrowException, OSError, ValueError, KeyError, IndexError, OverflowError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
        raise InputError(f"'{path}' is no whole Parquet file: {reason}.") from None
