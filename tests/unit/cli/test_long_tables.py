"""Long tables, of which a condition names the rows, and recordings with a rate instead of times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli.loading import load
from bodyschema.cli.run_file import read_run_file
from bodyschema.errors import InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.sources.tables import write_table

HEAD = """
robot = "robot.urdf"
recording = "{recording}"
{more}
[frames.eye]
parent = "base"
[frames.one]
parent = "tip"
[frames.two]
parent = "tip"
"""
SENSE = """
[[senses]]
kind = "points"
seen_from = "eye"
seen = "{seen}"
columns = {columns}
{more}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The same points of two markers, a column each and a row each; four joints."""
    rng = np.random.default_rng(2)
    arm = Body.random_chain(3, rng)
    (tmp_path / "robot.urdf").write_bytes(write_urdf(arm))
    q, seen = rng.uniform(-1, 1, (6, 3)), rng.standard_normal((2, 6, 3))
    wide = dict(zip(arm.joints, q.T, strict=True))
    wide |= {f"{axis}{k}": seen[k, :, i] for k in (0, 1) for i, axis in enumerate("xyz")}
    write_table(tmp_path / "wide.csv", wide)
    long = {name: np.repeat(values, 2) for name, values in zip(arm.joints, q.T, strict=True)}
    long |= {axis: seen[:, :, i].T.ravel() for i, axis in enumerate("xyz")}
    long |= {"marker": np.tile([7.0, 9.0], 6), "time": np.repeat(np.arange(6.0), 2)}
    write_table(tmp_path / "long.csv", long)
    return tmp_path


def senses(folder: Path, recording: str, more: str, entries: list[tuple[str, str]]) -> list[object]:
    text = HEAD.format(recording=recording, more=more)
    for k, (columns, own) in enumerate(entries):
        text += SENSE.format(seen=("one", "two")[k], columns=columns, more=own)
    (folder / "run.toml").write_text(text)
    return list(load(read_run_file(folder / "run.toml")).senses)


def test_a_row_a_marker_is_the_same_as_a_column_a_marker(folder: Path) -> None:
    wide = senses(folder, "wide.csv", "", [('["x0", "y0", "z0"]', ""), ('["x1", "y1", "z1"]', "")])
    own = [f'where = "marker == {number}"' for number in (7, 9)]
    long = senses(folder, "long.csv", 'time = ""', [('["x", "y", "z"]', where) for where in own])
    for first, second in zip(wide, long, strict=True):
        assert np.array_equal(first.q, second.q)  # type: ignore[attr-defined]
        assert np.array_equal(first.position, second.position)  # type: ignore[attr-defined]
    with pytest.raises(InputError, match=r"no row of 'long.csv' fulfils where = 'marker == 3'"):
        senses(folder, "long.csv", 'time = ""', [('["x", "y", "z"]', 'where = "marker == 3"')])


def test_a_rate_gives_times_where_there_are_none(folder: Path) -> None:
    (found,) = senses(folder, "wide.csv", "rate_hz = 4", [('["x0", "y0", "z0"]', "")])
    assert found.time.tolist() == [0, 0.25, 0.5, 0.75, 1, 1.25]  # type: ignore[attr-defined]
    with pytest.raises(InputError, match=r"rate_hz = 0 in 'run.toml' must be above 0"):
        senses(folder, "wide.csv", "rate_hz = 0", [('["x0", "y0", "z0"]', "")])
