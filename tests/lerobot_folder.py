"""LeRobot data sets made on the spot: two joints, a few grey frames."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from bodyschema.sources.video_writer import video_writer

FPS, FRAMES = 30, 12
CAMERA = "observation.images.head"
STATE = {"dtype": "float32", "shape": [2], "names": [["shoulder", "elbow"]]}
VERSION_2 = {
    "codebase_version": "v2.1",
    "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
    "video_path": "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4",
}
VERSION_3 = {
    "codebase_version": "v3.0",
    "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
}


def states(episode: int) -> np.ndarray:
    """(FRAMES, 2): the elbow tells which episode it is."""
    return np.column_stack([np.linspace(0, 1, FRAMES), np.full(FRAMES, float(episode))])


def write_info(folder: Path, version: dict[str, str], **changes: object) -> None:
    features = {"observation.state": STATE, CAMERA: {"dtype": "video"}}
    info = {**version, "total_episodes": 3, "chunks_size": 2, "features": features, **changes}
    (folder / "meta").mkdir(parents=True, exist_ok=True)
    (folder / "meta" / "info.json").write_text(json.dumps(info))


def write_video(path: Path, brightness: list[int]) -> None:
    """One plain frame for each brightness."""
    with video_writer(path, (32, 32), FPS) as write:
        for value in brightness:
            write(np.full((32, 32, 3), value, dtype=np.uint8))


def write_rows(path: Path, rows: np.ndarray, episodes: list[int]) -> None:
    """Rows (n, 2) float32 of several equally long episodes, one after the other."""
    path.parent.mkdir(parents=True, exist_ok=True)
    count = len(rows) // len(episodes)
    columns = {
        "observation.state": pa.FixedSizeListArray.from_arrays(rows.ravel(), 2),
        "timestamp": np.tile(np.arange(count) / FPS, len(episodes)).astype(np.float32),
        "episode_index": np.repeat(episodes, count),
    }
    pq.write_table(pa.table(columns), path)


def write_states(path: Path, episodes: list[int]) -> None:
    """The states of `states`."""
    write_rows(path, np.vstack([states(e) for e in episodes]).astype(np.float32), episodes)


def version_2(folder: Path) -> Path:
    """Three episodes, two to a chunk."""
    write_info(folder, VERSION_2)
    for episode in range(3):
        place = {"episode_index": episode, "episode_chunk": episode // 2, "video_key": CAMERA}
        write_states(folder / VERSION_2["data_path"].format(**place), [episode])
        video = folder / VERSION_2["video_path"].format(**place)
        write_video(video, [40 + 60 * episode] * FRAMES)
    return folder


def version_3(folder: Path) -> Path:
    """Three episodes in one table and one video."""
    write_info(folder, VERSION_3)
    first = {"chunk_index": 0, "file_index": 0}
    write_states(folder / VERSION_3["data_path"].format(**first), [0, 1, 2])
    video = folder / VERSION_3["video_path"].format(**first, video_key=CAMERA)
    write_video(video, [40 + 60 * (k // FRAMES) for k in range(3 * FRAMES)])
    rows = {
        "episode_index": [0, 1, 2],
        "data/chunk_index": [0, 0, 0],
        "data/file_index": [0, 0, 0],
        f"videos/{CAMERA}/chunk_index": [0, 0, 0],
        f"videos/{CAMERA}/file_index": [0, 0, 0],
        f"videos/{CAMERA}/from_timestamp": [k * FRAMES / FPS for k in range(3)],
    }
    path = folder / "meta" / "episodes" / "chunk-000" / "file-000.parquet"
    path.parent.mkdir(parents=True)
    pq.write_table(pa.table(rows), path)
    return folder
