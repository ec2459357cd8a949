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

from bodyschema.errors import InputError
from bodyschema.sources.lerobot import PURPOSE, STATE, numbers, read_info, state_names, there
from bodyschema.sources.parquet import parquet_table
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
    episode = made.get(EPISODE, np.zeros(lengths.pop()))
    _refuse_back(made[TIME], episode, folder)
    order = np.lexsort((made[TIME], episode))
    made = {name: values[order] for name, values in made.items()}
    made[TIME] = _onward(made[TIME])
    return Recording(f"'{folder.name}'", made, {})


def _columns(path: Path, features: Mapping[str, Any]) -> Iterator[tuple[str, Array]]:
    """Columns of numbers of one file, features of several numbers apart."""
    table = parquet_table(
        there(path), PURPOSE, lambda known: [name for name in known if _numeric(features, name)]
    )
    for name in table.column_names:
        values = numbers(table.column(name).to_pylist(), name, path)
        values = values.reshape(len(values), -1) if values.size else values.reshape(len(values), 1)
        if values.shape[1] == 1 and name != STATE:
            yield name, values[:, 0]
            continue
        stated = _feature(features, name).get("names")
        inner = state_names(stated, values.shape[1])
        for i, own in enumerate(inner):
            yield own if name == STATE else f"{name}.{own}", values[:, i]


def _refuse_back(time: Array, episode: Array, folder: Path) -> None:
    """Sorting would hide that a clock was set back in the middle of an episode."""
    back = np.flatnonzero((np.diff(time) < 0) & (np.diff(episode) == 0))
    if len(back):
        row = int(back[0])
        raise InputError(
            f"{TIME} goes back by {time[row] - time[row + 1]:.3g} s in row {row + 1} of "
            f"'{folder.name}', within episode {episode[row]:.0f}; leave that episode out, or "
            "repair its times."
        )


def _numeric(features: Mapping[str, Any], name: str) -> bool:
    kind = str(_feature(features, name).get("dtype", ""))
    return name in (TIME, EPISODE) or kind.startswith(("float", "int"))


def _feature(features: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found: Mapping[str, Any] = features.get(name, {})
    return found


def _onward(time: Array) -> Array:
    """Times that go on over the episodes, each of which begins anew."""
    steps = np.diff(time, prepend=time[:1])
    steps[steps < 0] = PAUSE
    return np.asarray(time[:1] + np.cumsum(steps))
