"""LeRobot data sets: the states and one camera's video of one episode, read from their files.

A data set is a folder. `meta/info.json` holds the version, the patterns of the paths and the
features with their names. In version 2 each episode has a Parquet file and a video per camera of
its own; in version 3 many episodes share a file, and `meta/episodes/*/*.parquet` says which file,
and at which second of the video the episode begins.

The format states no units: the states stay as they were recorded; whoever knows the robot says what
they are when asking the recording for them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]

INFO = Path("meta/info.json")
STATE = "observation.state"

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
    return (folder / INFO).is_file()


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
    count = int(info.get("total_episodes", episode + 1))
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
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"'{folder}' is no LeRobot data set: it has no {INFO}.") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"'{path}' is no readable JSON: {error}.") from None
    version = str(info.get("codebase_version", "unknown"))
    if not version.startswith(("v2", "v3")):
        raise InputError(
            f"'{folder}' is a LeRobot data set of version {version}; versions 2 and 3 can be read."
        )
    absent = [name for name in needed if not info.get(name)]
    if absent:
        way = PICTURES if absent[0] == "video_path" else ""
        raise InputError(f"'{path}' does not state '{absent[0]}'{way}.")
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
    try:
        if str(info["codebase_version"]).startswith("v2"):
            chunk = episode // int(info.get("chunks_size", 1000))
            place = {"episode_index": episode, "episode_chunk": chunk, "video_key": key}
            return _Files(folder / data.format(**place), folder / video.format(**place), 0.0)
        found = _listed(folder, episode, key)
        states = {name: int(found[f"data/{name}"]) for name in ("chunk_index", "file_index")}
        seen = {name: int(found[f"videos/{key}/{name}"]) for name in states}
    except (KeyError, ValueError) as error:
        raise InputError(f"'{folder / INFO}' has a path with an unknown part: {error}.") from None
    begin = float(found[f"videos/{key}/from_timestamp"])
    path = folder / video.format(**seen, video_key=key)
    return _Files(folder / data.format(**states), path, begin)


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
    time = np.ravel(np.asarray(columns["timestamp"], dtype=np.float64))
    try:
        states = np.array([np.ravel(row) for row in columns[STATE]], dtype=np.float64)
    except ValueError:
        raise InputError(f"the rows of '{STATE}' in '{path}' differ in length.") from None
    return time - time[0], states


def _read(path: Path, names: Sequence[str], episode: int) -> dict[str, list[Any]]:
    """Columns of a Parquet file, of one episode's rows."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingExtraError("pyarrow", "data", "reading LeRobot data sets") from None
    try:
        with pq.ParquetFile(there(path)) as file:
            known = file.schema_arrow.names
            absent = [name for name in ("episode_index", *names) if name not in known]
            if absent:
                raise InputError(f"'{path}' has no column '{absent[0]}'.")
            table = file.read(columns=["episode_index", *names])
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise InputError(f"'{path}' is no whole Parquet file: {reason}.") from None
    rows = np.flatnonzero(np.ravel(table.column("episode_index").to_numpy()) == episode)
    taken = table.take(rows)
    return {name: taken.column(name).to_pylist() for name in names}


def there(path: Path) -> Path:
    """The path, if a file is there that holds more than a reference to what Git LFS stores."""
    if not path.is_file():
        raise InputError(f"no file at '{path}', which the data set names; was it downloaded whole?")
    with path.open("rb") as file:
        if file.read(40).startswith(b"version https://git-lfs"):
            raise InputError(f"'{path}' is only a Git LFS reference; run 'git lfs pull' there.")
    return path


def state_names(stated: Any, count: int) -> tuple[str, ...]:
    """Names of the states; data sets state them flat, nested in a list or under one key."""
    while isinstance(stated, Mapping) and len(stated) == 1:
        stated = next(iter(stated.values()))
    if isinstance(stated, list) and len(stated) == 1 and isinstance(stated[0], list):
        stated = stated[0]
    if isinstance(stated, list) and len(stated) == count and len(set(stated)) == count:
        return tuple(str(name) for name in stated)
    return tuple(f"state_{i}" for i in range(count))
