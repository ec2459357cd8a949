"""A LeRobot data set as one recording: the states, and every other feature of numbers.

States have the names that the data set states; columns of other features have that of the feature
before them, action.elbow for the elbow of "action". Episodes follow one another, `PAUSE` apart in
time, with their numbers in the column episode_index. Units are not stated: servos of LeRobot are in
degrees or in percent of their range.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.lerobot import STATE, read_info, state_names, there
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]

PAUSE = 10.0
"""s between the end of an episode and the beginning of the next: nothing is interpolated there."""

TIME, EPISODE = "timestamp", "episode_index"


def read_lerobot_table(folder: Path) -> Recording:
    """Read all episodes of a data set.

    Raises:
        InputError: files are missing or broken.
        MissingExtraError: pyarrow is not installed.
    """
    features = read_info(folder, ("features", "data_path"))["features"]
    files = sorted((folder / "data").rglob("*.parquet"))
    if not files:
        raise InputError(
            f"'{folder}' is a LeRobot data set without a Parquet file under data; was it "
            "downloaded whole?"
        )
    columns: dict[str, list[Array]] = {}
    for path in files:
        for name, values in _columns(path, features):
            columns.setdefault(name, []).append(values)
    made = {name: np.concatenate(parts) for name, parts in columns.items()}
    lengths = {len(values) for values in made.values()}
    if len(lengths) != 1 or TIME not in made:
        raise InputError(f"the Parquet files of '{folder}' do not have the same columns.")
    order = np.lexsort((made[TIME], made.get(EPISODE, np.zeros(lengths.pop()))))
    made = {name: values[order] for name, values in made.items()}
    made[TIME] = _onward(made[TIME])
    return Recording(f"'{folder.name}'", made, {})


def _columns(path: Path, features: Mapping[str, Any]) -> Iterator[tuple[str, Array]]:
    """Columns of numbers of one file, features of several numbers apart."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingExtraError("pyarrow", "data", "reading LeRobot data sets") from None
    try:
        with pq.ParquetFile(there(path)) as file:
            known = file.schema_arrow.names
            table = file.read([name for name in known if _numeric(features, name)])
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise InputError(f"'{path}' is no whole Parquet file: {reason}.") from None
    for name in table.column_names:
        try:
            values = np.array(table.column(name).to_pylist(), dtype=np.float64)
        except ValueError:
            raise InputError(f"the rows of '{name}' in '{path}' differ in length.") from None
        values = values.reshape(len(values), -1)
        if values.shape[1] == 1 and name != STATE:
            yield name, values[:, 0]
            continue
        stated = features.get(name, {}).get("names")
        inner = state_names(stated, values.shape[1])
        for i, own in enumerate(inner):
            yield own if name == STATE else f"{name}.{own}", values[:, i]


def _numeric(features: Mapping[str, Any], name: str) -> bool:
    kind = str(features.get(name, {}).get("dtype", ""))
    return name in (TIME, EPISODE) or kind.startswith(("float", "int"))


def _onward(time: Array) -> Array:
    """Times that go on over the episodes, each of which begins anew."""
    steps = np.diff(time, prepend=time[:1])
    steps[steps < 0] = PAUSE
    return np.asarray(time[:1] + np.cumsum(steps))
