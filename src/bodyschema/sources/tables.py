"""Tables in files: `open_recording` reads them, `write_table` writes CSV and Parquet."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.atomic import new_file
from bodyschema.documents import is_there, regular_file
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.arrays import ENDINGS as ARRAYS
from bodyschema.sources.arrays import read_arrays
from bodyschema.sources.bags import is_bag, read_bag
from bodyschema.sources.conversions import conversion
from bodyschema.sources.lerobot import is_lerobot
from bodyschema.sources.lerobot_table import read_lerobot_table
from bodyschema.sources.parquet import parquet_table
from bodyschema.sources.recording import Recording, beside
from bodyschema.sources.text_table import ENDINGS, PIPED, of_numbers, read_text, refuse_repeated

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

WRITERS = (".csv", ".parquet")


def open_recording(path: str | Path | Sequence[str | Path]) -> Recording:
    """Read a recording, or several files whose rows belong together.

    Args:
        path: a .csv, .tsv, .txt, .parquet, .npz or .npy file, the folder of a LeRobot data set, a
            topic of a ROS bag or MCAP file (see `bags`), "-" for a table that is piped in, or a
            sequence of them.

    Raises:
        InputError: a file is missing, broken, or of another kind.
        MissingExtraError: Parquet without the extra `data`.
    """
    if isinstance(path, str | Path):
        return _open_one(Path(path))
    if not path:
        raise InputError("no recording was given; name at least one file.")
    return beside(_open_one(Path(one)) for one in path)


def _open_one(path: Path) -> Recording:
    if is_lerobot(path):
        return read_lerobot_table(path)
    if is_bag(path):
        return read_bag(path)
    way = conversion(path)
    if way:
        raise InputError(f"'{path}' is no table of columns: {way}")
    kind = path.suffix.lower()
    if path.name == PIPED and not is_there(path):
        return read_text(Path(PIPED))
    regular_file(
        path, f"no recording at '{path}'; give the path of a table, a bag or a LeRobot folder."
    )
    if kind in ENDINGS:
        return read_text(path)
    if kind == ".parquet":
        return _read_parquet(path)
    if kind in ARRAYS:
        return read_arrays(path)
    known = ", ".join((*ENDINGS, *ARRAYS))
    raise InputError(
        f"'{path}' is of unknown kind '{path.suffix}'; expected {known} or .parquet, a ROS bag, an "
        "MCAP file, or the folder of a LeRobot data set."
    )


def _read_parquet(path: Path) -> Recording:
    table = parquet_table(path)
    import pyarrow as pa

    refuse_repeated(table.column_names, path)
    if not table.num_rows:
        raise InputError(f"'{path}' has no data; expected named columns with rows.")
    columns: dict[str, Array] = {}
    empty: dict[str, Flags] = {}
    texts: dict[str, list[str] | None] = {}
    for name in table.column_names:
        column = table.column(name)
        kind = column.type
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
            words = pa.types.is_string(kind) or pa.types.is_large_string(kind)
            texts[name] = [cell or "" for cell in column.to_pylist()] if words else None
            continue
        blank = column.is_null().to_numpy()
        # Whole numbers above 2^53, such as ns since 1970, are rounded rather than refused.
        columns[name] = column.cast(pa.float64(), safe=False).to_numpy().astype(np.float64)
        if blank.any():
            empty[name] = blank
    return of_numbers(path, columns, empty, texts)


def write_table(path: str | Path, columns: Mapping[str, ArrayLike], overwrite: bool = True) -> None:
    """Write columns of equal length to a .csv or .parquet file, whole or not at all.

    Numbers are written so that they read back exactly; NaN is written as an empty cell.

    Args:
        path: of the file.
        columns: by name.
        overwrite: replace a file that is there; otherwise it is refused.

    Raises:
        InputError: no columns, columns of unequal length or of more than one axis, an unknown kind
            of file, or an unwritable place.
    """
    target = Path(path)
    arrays = {name: np.asarray(values, dtype=np.float64) for name, values in columns.items()}
    shapes = sorted({array.shape for array in arrays.values()})
    if len(shapes) != 1 or len(shapes[0]) != 1:
        raise InputError(f"columns must be flat and equally long; they have the shapes {shapes}.")
    if target.suffix not in WRITERS:
        raise InputError(f"cannot write '{target}'; expected a name ending in .csv or .parquet.")
    with new_file(target, overwrite) as temporary:
        if target.suffix == ".csv":
            _write_csv(temporary, arrays)
        else:
            _write_parquet(temporary, arrays)


def _write_csv(path: Path, arrays: Mapping[str, Array]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(arrays)
        for row in zip(*arrays.values(), strict=True):
            writer.writerow(["" if np.isnan(value) else repr(float(value)) for value in row])


def _write_parquet(path: Path, arrays: Mapping[str, Array]) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingExtraError("pyarrow", "data", f"writing '{path.name}'") from None
    pq.write_table(pa.table({k: pa.array(v, from_pandas=True) for k, v in arrays.items()}), path)
