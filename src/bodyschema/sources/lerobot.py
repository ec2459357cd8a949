"""LeRobot data sets: the states and one camera's video of one episode, read from their files.

A data set is a folder. `meta/info.json` holds the version, the patterns of the paths and the
features with their names. In version 2 each episode has a Parquet file and a video per camera of
its own; in version 3 many episodes share a file, and `meta/episodes/*/*.parquet` says which file,
and at which second of the video the episode begins.

The format states no units: the states stay as they were recorded; whoever knows the robot says what
they are when asking the recording for them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.documents import is_file, json_file, regular_file
from bodyschema.errors import InputError, did_you_mean
from bodyschema.sources.parquet import parquet_table
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]

INFO = Path("meta/info.json")
STATE = "observation.state"
PURPOSE = "reading LeRobot data sets"

NAMED = 3
"""Files that a message names."""

FIELD = re.compile(r"\{(\w+)(?::0?([1-9])d?)?\}")
"""What a path may have in braces: a name, and to how many digits its number is filled up."""

PICTURES = (
    "; a video per camera is needed. Where its pictures are single files, make a video of those of "
    "one camera (ffmpeg), and give that with a table of the joints as --encoders"
)


@dataclass(frozen=True)
class Episode:
    """What one episode says of the joints, and where its video is."""

    recording: Recording
    """Columns `timestamp`, s since the episode began, and one per joint, as recorded."""
    joints: tuple[str, ...]
    """Names of the states, which are columns of the recording."""
    video: Path
    """The file that holds the episode's frames."""
    begin: float
    """s in the video at which the episode begins."""


class _Files(NamedTuple):
    states: Path
    video: Path
    begin: float
    """s"""


def is_lerobot(folder: Path) -> bool:
    """Whether the folder holds a LeRobot data set."""
    return is_file(folder / INFO)


def open_episode(folder: Path, episode: int = 0, camera: str | None = None) -> Episode:
    """Read one episode.

    Args:
        folder: that holds `meta/info.json`.
        episode: its index.
        camera: key of the video, or its end ("cam_high"); None where there is only one.

    Raises:
        InputError: no such data set, version, episode or camera; a file is missing or broken.
        MissingExtraError: pyarrow is not installed.
    """
    info = read_info(folder)
    count = _whole(info, "total_episodes", episode + 1, folder)
    if not 0 <= episode < count:
        raise InputError(f"no episode {episode} in '{folder}'; there are 0 to {count - 1}.")
    features = info["features"]
    key = _camera(features, camera, folder)
    if STATE not in features:
        raise InputError(f"'{folder}' has no feature '{STATE}'{did_you_mean(STATE, features)}")
    files = _files(folder, info, episode, key)
    time, states = _read_states(files.states, episode)
    joints = state_names(features[STATE].get("names"), states.shape[1])
    columns = {"timestamp": time, **dict(zip(joints, states.T, strict=True))}
    recording = Recording(f"episode {episode} of '{folder.name}'", columns, {})
    return Episode(recording, joints, there(files.video), files.begin)


def read_info(
    folder: Path, needed: Sequence[str] = ("features", "data_path", "video_path")
) -> dict[str, Any]:
    """What the data set states of itself.

    Args:
        folder: that holds `meta/info.json`.
        needed: keys that it must state.

    Raises:
        InputError: no data set, another version, or a key is missing.
    """
    path = folder / INFO
    missing = f"'{folder}' is no LeRobot data set: it has no {INFO}."
    info = json_file(path, missing, "no readable JSON")
    if not isinstance(info, Mapping):
        raise InputError(f"'{path}' holds no table of keys, so it is no LeRobot data set.")
    version = str(info.get("codebase_version", "unknown"))
    if not version.startswith(("v2", "v3")):
        raise InputError(
            f"'{folder}' is a LeRobot data set of version {version}; versions 2 and 3 can be read."
        )
    stored = str(info.get("storage_format", "parquet")).lower()
    if stored != "parquet":
        raise InputError(
            f"'{folder}' is a LeRobot data set whose rows are stored as {stored[:20]} "
            "(storage_format in its info.json), and Parquet is what is read; write it again as "
            "Parquet with LeRobot, or give a table of its states and times."
        )
    absent = [name for name in needed if not info.get(name)]
    if absent:
        way = PICTURES if absent[0] == "video_path" else ""
        raise InputError(f"'{path}' does not state '{absent[0]}'{way}.")
    features = info.get("features", {})
    if not isinstance(features, Mapping) or not all(
        isinstance(feature, Mapping) for feature in features.values()
    ):
        raise InputError(f"the features in '{path}' must be a table of tables, one of each column.")
    return dict(info)


def _camera(features: Mapping[str, Any], camera: str | None, folder: Path) -> str:
    """The full key of the camera that is meant."""
    keys = [key for key, feature in features.items() if feature.get("dtype") == "video"]
    if camera is None and len(keys) == 1:
        return keys[0]
    if camera is None:
        listed = ", ".join(f"'{key}'" for key in keys) or "none"
        raise InputError(f"'{folder}' has {len(keys)} cameras; name one of them: {listed}.")
    fitting = [key for key in keys if key == camera or key.endswith(f".{camera}")]
    if len(fitting) != 1:
        raise InputError(f"no camera '{camera}' with a video in '{folder}'" + _known(camera, keys))
    return fitting[0]


def _known(camera: str, keys: Sequence[str]) -> str:
    return did_you_mean(camera, [key.rpartition(".")[2] for key in keys])


def _files(folder: Path, info: Mapping[str, Any], episode: int, key: str) -> _Files:
    """Where the states and the video of an episode are."""
    data, video = str(info["data_path"]), str(info["video_path"])
    if str(info["codebase_version"]).startswith("v2"):
        size = _whole(info, "chunks_size", 1000, folder)
        chunk = episode // max(size, 1)
        place: dict[str, int | str] = {
            "episode_index": episode,
            "episode_chunk": chunk,
            "video_key": key,
        }
        return _Files(_inside(folder, data, place), _inside(folder, video, place), 0.0)
    found = _listed(folder, episode, key)
    try:
        states = {name: int(found[f"data/{name}"]) for name in ("chunk_index", "file_index")}
        seen = {name: int(found[f"videos/{key}/{name}"]) for name in states}
        begin = float(found[f"videos/{key}/from_timestamp"])
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"the tables of '{folder / 'meta' / 'episodes'}' do not say in numbers where episode "
            f"{episode} is."
        ) from None
    path = _inside(folder, video, {**seen, "video_key": key})
    return _Files(_inside(folder, data, states), path, begin)


def _whole(info: Mapping[str, Any], key: str, usual: int, folder: Path) -> int:
    """A whole number that the data set states, or the usual one."""
    value = info.get(key, usual)
    if not isinstance(value, int) or isinstance(value, bool):
        raise InputError(f"{key} = {value!r:.60} in '{folder / INFO}'; expected a whole number.")
    return value


def _inside(folder: Path, pattern: str, place: Mapping[str, int | str]) -> Path:
    """A path of the data set; `place` says what stands in its braces.

    Raises:
        InputError: other things in braces, or a place outside of the folder.
    """

    def filled(match: re.Match[str]) -> str:
        if match[1] not in place or (match[2] and isinstance(place[match[1]], str)):
            raise InputError(f"'{folder / INFO}' has a path with an unknown part: {match[0]}.")
        return str(place[match[1]]).zfill(int(match[2] or 0))

    if re.search(r"[{}]", FIELD.sub("", pattern)):
        raise InputError(
            f"'{folder / INFO}' has the path '{pattern[:100]}'; only {{name}} and {{name:03d}} may "
            "stand in it."
        )
    inner = Path(FIELD.sub(filled, pattern))
    if inner.is_absolute() or ".." in inner.parts:
        raise InputError(
            f"'{folder / INFO}' names '{str(inner)[:100]}', which is outside of its folder; a data "
            "set has all its files inside."
        )
    return folder / inner


def _listed(folder: Path, episode: int, key: str) -> dict[str, float]:
    """Version 3: the row of the tables of episodes that says where an episode is."""
    names = [f"data/{name}" for name in ("chunk_index", "file_index")]
    names += [f"videos/{key}/{name}" for name in ("chunk_index", "file_index", "from_timestamp")]
    for path in sorted((folder / "meta" / "episodes").glob("*/*.parquet")):
        rows = _read(path, names, episode)
        if len(rows[names[0]]):
            return {name: rows[name][0] for name in names}
    raise InputError(f"'{folder / 'meta' / 'episodes'}' does not list episode {episode}.")


def _read_states(path: Path, episode: int) -> tuple[Array, Array]:
    """Times (n,) s since the begin and states (n, n_joints) of one episode."""
    columns = _read(path, ["timestamp", STATE], episode)
    if not len(columns["timestamp"]):
        raise InputError(f"'{path}' has no rows of episode {episode}.")
    time = np.ravel(numbers(columns["timestamp"], "timestamp", path))
    states = numbers(columns[STATE], STATE, path).reshape(len(columns[STATE]), -1)
    if len(time) != len(states):
        raise InputError(f"the times in '{path}' are lists of several; expected one a row.")
    return time - time[0], states


def numbers(rows: Sequence[Any], name: str, path: Path) -> Array:
    """Rows of a column as an array of numbers, nothing being nan.

    Raises:
        InputError: texts, or rows of several lengths.
    """
    try:
        return np.array(rows, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        raise InputError(
            f"the rows of '{name}' in '{path}' differ in length, or are no numbers."
        ) from None


def _read(path: Path, names: Sequence[str], episode: int) -> dict[str, list[Any]]:
    """Columns of a Parquet file, of one episode's rows."""
    wanted = ["episode_index", *names]

    def chosen(known: Sequence[str]) -> list[str]:
        absent = [name for name in wanted if known.count(name) != 1]
        if absent:
            raise InputError(f"'{path}' has no column '{absent[0]}', or several.")
        return wanted

    table = parquet_table(there(path), PURPOSE, chosen)
    numbers_of = table.column("episode_index").to_pylist()
    rows = np.array([i for i, number in enumerate(numbers_of) if number == episode], dtype=np.int64)
    taken = table.take(rows)
    return {name: taken.column(name).to_pylist() for name in names}


def there(path: Path) -> Path:
    """The path, if a file is there that holds more than a reference to what Git LFS stores."""
    missing = f"no file at '{path}', which the data set names; was it downloaded whole?"
    regular_file(path, missing + ("" if is_file(path) else _beside(path)))
    try:
        with path.open("rb") as file:
            start = file.read(40)
    except OSError as error:
        raise InputError(f"'{path}' cannot be read: {error.strerror}.") from None
    if start.startswith(b"version https://git-lfs"):
        raise InputError(f"'{path}' is only a Git LFS reference; run 'git lfs pull' there.")
    return path


def _beside(path: Path) -> str:
    """Which files of its kind are there instead."""
    try:
        here = sorted(other.name for other in path.parent.glob(f"*{path.suffix}"))
    except OSError:
        return ""
    names = ", ".join(f"'{name}'" for name in here[:NAMED]) + (" ..." if len(here) > NAMED else "")
    return f" In its place there are {names}: name another episode." if here else ""


def state_names(stated: Any, count: int) -> tuple[str, ...]:
    """Names of the states; data sets state them flat, nested in a list or under one key."""
    while isinstance(stated, Mapping) and len(stated) == 1:
        stated = next(iter(stated.values()))
    if isinstance(stated, list) and len(stated) == 1 and isinstance(stated[0], list):
        stated = stated[0]
    names = tuple(str(name) for name in stated) if isinstance(stated, list) else ()
    if len(names) == count and len(set(names)) == count:
        return names
    return tuple(f"state_{i}" for i in range(count))
