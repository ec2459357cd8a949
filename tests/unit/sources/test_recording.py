"""Times of a recording, and joining files row by row."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from bodyschema.errors import InputError
from bodyschema.sources.recording import Recording
from bodyschema.sources.tables import open_recording, write_table


@pytest.fixture
def csv(tmp_path: Path) -> Callable[[str], Recording]:
    """Read a CSV text."""

    def read(text: str) -> Recording:
        path = tmp_path / "robot.csv"
        path.write_text(text)
        return open_recording(path)

    return read


@pytest.mark.parametrize("name", ["time", "t", "timestamp"])
def test_time_is_found_by_name(csv: Callable[[str], Recording], name: str) -> None:
    table = csv(f"{name},a\n0.5,9\n0.7,9\n")
    assert table.time().tolist() == [0.5, 0.7]
    assert table.time("").tolist() == [0, 1]
    assert table.time(name).tolist() == [0.5, 0.7]


def test_rows_are_numbered_without_a_clock(csv: Callable[[str], Recording]) -> None:
    assert csv("a\n5\n5\n5\n").time().tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("time\n1\n2\n2\n", None, r"time repeats in row 2 of 'robot.csv' \(2.000000 s, then 2.0"),
        (
            "time\n1\n3\n2\n",
            None,
            "time goes back in row 2 .*; 1 such rows.*sort the rows and drop",
        ),
        ("time\n3\n2\n1\n", None, 'time goes back in row 1 .*; 2 such rows.*or set time = ""'),
        ("time,a\n1,1\n,1\n3,1\n", None, "time is empty in row 1 of 'robot.csv'; fill or drop"),
        ("time\n1\nnan\n3\n", None, "column 'time' of 'robot.csv' holds nan in row 1"),
        ("time,a\nnoon,1\nnight,2\n", None, "column 'time' of 'robot.csv' does not hold numbers"),
        ("stamp\n1\n2\n", "stmp", "no column 'stmp' in 'robot.csv'; did you mean 'stamp'"),
    ],
)
def test_times_that_do_not_advance_are_refused(
    csv: Callable[[str], Recording], text: str, column: str | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        csv(text).time(column)


def test_two_files_are_joined_by_row(tmp_path: Path) -> None:
    (tmp_path / "joints.csv").write_text("q1,q2,note\n1,2,x\n3,4,y\n")
    write_table(tmp_path / "camera.parquet", {"x": [5.0, float("nan")]})
    table = open_recording([tmp_path / "joints.csv", str(tmp_path / "camera.parquet")])
    assert len(table) == 2
    assert table.source == "'joints.csv' + 'camera.parquet'"
    assert table.matrix(["x"], "m")[1].tolist() == [True, False]
    assert table.matrix(["q2", "q1"], "m")[0].tolist() == [[2, 1], [4, 3]]
    with pytest.raises(InputError, match=r"'note' of .* does not hold numbers"):
        table.matrix(["note"])


def test_files_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    for name, columns in {
        "two": {"a": [1.0, 2.0]},
        "three": {"b": [1.0, 2.0, 3.0]},
        "same": {"a": [3.0, 4.0]},
    }.items():
        write_table(tmp_path / f"{name}.csv", columns)
    with pytest.raises(InputError, match=r"'two.csv' has 2 rows and 'three.csv' has 3;.*equally"):
        open_recording([tmp_path / "two.csv", tmp_path / "three.csv"])
    with pytest.raises(InputError, match=r"column 'a' is in 'same.csv' and before; rename one"):
        open_recording([tmp_path / "two.csv", tmp_path / "same.csv"])
