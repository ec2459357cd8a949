"""What is in a recording: streams, rates, gaps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.contents import contents
from bodyschema.sources.recording import seconds
from bodyschema.sources.tables import write_table
from lerobot_folder import FPS, FRAMES, version_3


def test_rate_and_gaps_of_a_table(tmp_path: Path) -> None:
    time = np.concatenate([np.arange(10), 20 + np.arange(10)]) / 50
    write_table(tmp_path / "a.csv", {"t_s": time, "a": np.zeros(20)})
    (found,) = contents(tmp_path / "a.csv").streams
    assert found.rate_hz == pytest.approx(50)
    many, longest = found.gaps
    assert many == 1
    assert longest == pytest.approx(11 / 50)
    assert (found.clock, found.samples) == ("t_s", 20)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6, 1e9])
def test_stamps_since_1970_are_told_by_their_size(tmp_path: Path, unit: float) -> None:
    time = 1.7e9 + np.arange(5) / 4
    write_table(tmp_path / "a.csv", {"time": unit * time, "a": np.zeros(5)})
    (found,) = contents(tmp_path / "a.csv").streams
    assert found.rate_hz == pytest.approx(4, rel=1e-5)
    assert found.recording is not None
    assert found.recording.time() == pytest.approx(time, abs=1e-6)
    assert seconds(np.array([0.0, 1e18])).tolist() == [0.0, 1e18], "no clock since 1970 begins at 0"


def test_a_table_without_names_begins_with_its_times(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0.5,1,2\n1.0,1,2\n1.5,0,2\n")
    (found,) = contents(tmp_path / "a.csv").streams
    assert (found.clock, found.rate_hz) == ("column_0", 2)


def test_a_data_set_has_its_features_and_calibration(tmp_path: Path) -> None:
    folder = version_3(tmp_path / "set")
    motors = {
        "elbow": {"id": 1, "drive_mode": 0, "homing_offset": 5, "range_min": 0, "range_max": 9}
    }
    (tmp_path / "arm.json").write_text(json.dumps(motors))
    found = contents(folder)
    assert found.kind == "lerobot"
    assert [stream.kind for stream in found.streams] == ["LeRobot states", "LeRobot video"]
    assert found.streams[0].samples == 3 * FRAMES
    assert found.streams[0].rate_hz == pytest.approx(FPS, rel=1e-3)
    assert found.more["episodes"] == 3
    assert found.more["calibration"] == [str(tmp_path / "arm.json")]


def test_a_folder_holds_what_is_in_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no recording, video or pictures; it has nothing"):
        contents(tmp_path)
    write_table(tmp_path / "a.csv", {"a": [1.0]})
    (tmp_path / "b.csv").write_text("a\nb\n")
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "0.png").touch()
    found = contents(tmp_path)
    assert [stream.kind for stream in found.streams] == ["table", "pictures"]
    assert len(found.notes) == 1
    assert "only texts" in found.notes[0]
