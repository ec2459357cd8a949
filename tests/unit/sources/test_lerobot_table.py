"""LeRobot data sets as recordings."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.lerobot_table import PAUSE
from bodyschema.sources.tables import open_recording
from lerobot_folder import FPS, FRAMES, states, version_2, version_3


@pytest.mark.parametrize("write", [version_2, version_3])
def test_all_episodes_in_order(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    found = open_recording(write(tmp_path))
    expected = np.vstack([states(episode) for episode in range(3)])
    values, _ = found.matrix(["shoulder", "elbow"])
    assert values == pytest.approx(expected)
    steps = np.diff(found.time())
    assert steps[FRAMES - 1] == PAUSE
    assert np.delete(steps, [FRAMES - 1, 2 * FRAMES - 1]) == pytest.approx(1 / FPS, abs=1e-6)


def test_other_features_have_their_names(tmp_path: Path) -> None:
    """A data set of pictures without videos; states of one joint; an action of two."""
    names = {"names": ["a.pos", "b.pos"], "dtype": "float32", "shape": [2]}
    features = {
        "observation.state": {"names": ["a.pos"], "dtype": "float32", "shape": [1]},
        "action": names,
        "tool_x": {"dtype": "float32", "shape": [1]},
        "observation.images.top": {"dtype": "image"},
    }
    info = {"codebase_version": "v2.1", "data_path": "x", "video_path": None, "features": features}
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(json.dumps(info))
    with pytest.raises(InputError, match=r"without a Parquet file under data; was it downloaded"):
        open_recording(tmp_path)
    (tmp_path / "data").mkdir()
    rows = {
        "observation.state": [[1.0], [2.0]], "action": [[3.0, 4.0], [5.0, 6.0]],
        "tool_x": [7.0, 8.0], "timestamp": [0.0, 0.1], "observation.images.top": ["p", "q"],
    }  # fmt: skip
    pq.write_table(pa.table(rows), tmp_path / "data" / "a.parquet")
    found = open_recording(tmp_path)
    assert {*found.columns} == {"a.pos", "action.a.pos", "action.b.pos", "tool_x", "timestamp"}
    assert found.columns["action.b.pos"].tolist() == [4, 6]


def test_a_clock_that_is_set_back_within_an_episode_is_said(tmp_path: Path) -> None:
    folder = version_2(tmp_path)
    path = sorted((folder / "data").rglob("*.parquet"))[1]
    table = pq.read_table(path)
    late = table["timestamp"].to_numpy().copy()
    late[7:] -= 500
    pq.write_table(table.set_column(1, "timestamp", pa.array(late)), path)
    with pytest.raises(InputError, match=r"goes back by 500 s in row 19 .* within episode 1"):
        open_recording(folder)
