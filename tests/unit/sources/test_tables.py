"""CSV and Parquet tables: exact round trips, units, and faults named by row and column."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.sources.recording import Recording
from bodyschema.sources.tables import open_recording, write_table

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

Array = NDArray[np.float64]

properties = settings(derandomize=True, deadline=None, database=None, max_examples=40)
both_kinds = pytest.mark.parametrize("kind", ["csv", "parquet"])


@pytest.fixture
def csv(tmp_path: Path) -> Callable[[str], Recording]:
    """Read a CSV text."""

    def read(text: str) -> Recording:
        path = tmp_path / "robot.csv"
        path.write_text(text, encoding="utf-8")
        return open_recording(path)

    return read


@both_kinds
@properties
@given(
    columns=st.integers(1, 4).flatmap(
        lambda n: st.lists(
            st.lists(st.floats(allow_nan=False), min_size=n, max_size=n), min_size=1, max_size=3
        )
    )
)
def test_numbers_read_back_exactly(kind: str, columns: list[list[float]]) -> None:
    table = {f"c{i}": np.array(values) for i, values in enumerate(columns)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"t.{kind}"
        write_table(path, table)
        back = open_recording(path)
    assert list(back.columns) == list(table)
    assert len(back) == len(columns[0])
    for name, values in table.items():
        assert back.columns[name].tobytes() == values.tobytes()


@both_kinds
def test_nan_is_written_as_an_empty_cell(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"t.{kind}"
    write_table(path, {"a": [1.0, np.nan, 3.0], "b": [np.nan, np.nan, 0.5]})
    back = open_recording(str(path))
    assert back.empty["a"].tolist() == [False, True, False]
    values, present = back.matrix(["a"], "mm")
    assert present.tolist() == [True, False, True]
    assert values[present, 0].tolist() == [1e-3, 3e-3]
    with pytest.raises(InputError, match=r"row 0 of .* has only some of a, b; fill the row or"):
        back.matrix(["a", "b"])


def test_a_single_column_keeps_its_empty_rows(tmp_path: Path) -> None:
    write_table(tmp_path / "t.csv", {"a": [np.nan, 1.0, np.nan]})
    assert open_recording(tmp_path / "t.csv").empty["a"].tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("unit", "value"),
    [("deg", np.pi / 180), ("mm", 1e-3), ("in", 0.0254), ("us", 1e-6), ("1", 1.0), ("m", 1.0)],
)
def test_units(csv: Callable[[str], Recording], unit: str, value: float) -> None:
    values, present = csv("x,y\n1,2\n3,4\n").matrix(["y", "x"], unit)
    assert values == pytest.approx(value * np.array([[2, 1], [4, 3]]), rel=1e-15)
    assert present.all()


@pytest.mark.parametrize(
    ("names", "unit", "message"),
    [
        (["elbw"], "rad", r"no column 'elbw' in 'robot.csv'; did you mean 'elbow'\?"),
        (["elbow"], "degree", r"unknown unit 'degree'; did you mean 'deg'\?"),
        (["note"], "m", "column 'note' of 'robot.csv' does not hold numbers"),
        (["elbow", "wrist"], "m", r"'wrist' of 'robot.csv' holds nan in row 1 \(the first is 0\)"),
        (["tip"], "m", "'tip' .* holds inf in row 2 .*; drop or repair the 1 such rows"),
    ],
)
def test_what_cannot_be_used_is_named(
    csv: Callable[[str], Recording], names: list[str], unit: str, message: str
) -> None:
    table = csv("elbow,wrist,tip,note\n0,1,2,a\n0,nan,2,b\n0,1,inf,c\n")
    with pytest.raises(InputError, match=message):
        table.matrix(names, unit)


@pytest.mark.parametrize("mark", [";", "\t", " ", "  ", ", "])
def test_other_separators_are_seen(csv: Callable[[str], Recording], mark: str) -> None:
    table = csv("\ufeff" + "\n".join(mark.join(row) for row in (("t", "q1", "z"), "123", "456")))
    assert {name: list(v) for name, v in table.columns.items()} == {
        "t": [1.0, 4.0],
        "q1": [2.0, 5.0],
        "z": [3.0, 6.0],
    }


def test_a_single_column_with_a_space_in_its_name_is_one(csv: Callable[[str], Recording]) -> None:
    assert list(csv("joint angle\n0.5\n").columns) == ["joint angle"]


def test_spaces_quotes_blank_lines_and_byte_order_marks(csv: Callable[[str], Recording]) -> None:
    table = csv('\ufeff a , "b"\r\n 1 , 2\r\n\r\n3,\r\n')
    assert table.columns["a"].tolist() == [1, 3]
    assert table.empty["b"].tolist() == [False, True]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n3\n", "row 1 of .* has 1 cells where the header names 2; the file may be cut"),
        ("a,b\n1,2,3\n", "row 0 of .* has 3 cells"),
        ("a,b,a\n1,2,3\n", "has two columns named 'a'; rename one"),
        ("a,b\n", "has no data; expected a line of column names, then rows"),
        ("", "has no data"),
    ],
)
def test_broken_csv_is_refused(csv: Callable[[str], Recording], text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        csv(text)


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.log").touch()
    (tmp_path / "a.npz").write_bytes(b"PK")
    (tmp_path / "latin.csv").write_bytes(b"gr\xf6\xdfe\n1\n")
    for name, message in (
        ("a.log", r"unknown kind '.log'; expected .csv, .tsv, .txt, .npz, .npy or .parquet, a ROS"),
        ("a.xlsx", r"is no table of columns: write its numbers into a CSV table"),
        ("a.npz", "is no whole file of numpy arrays"),
        ("shots/*.PNG", r"nothing here finds a board in them; .*docs/board_photographs.md"),
        ("none.csv", "no recording at .*; give the path of a table, a bag"),
        ("latin.csv", "is no readable CSV text"),
    ):
        with pytest.raises(InputError, match=message):
            open_recording(tmp_path / name)
    with pytest.raises(InputError, match="no recording was given; name at least one file"):
        open_recording([])


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
def test_truncated_parquet_is_refused(tmp_path: Path, share: float) -> None:
    path = tmp_path / "t.parquet"
    write_table(path, {"a": np.arange(1000.0)})
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match="is no whole Parquet file"):
        open_recording(path)


def test_parquet_of_other_writers(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    stamps = [1_700_000_000_123_456_789, 1_700_000_001_123_456_789]
    pq.write_table(
        pa.table(
            {
                "stamp": pa.array(stamps, pa.int64()),
                "count": pa.array([1, None], pa.int32()),
                "half": pa.array([0.5, 0.25], pa.float32()),
                "name": pa.array(["a", "b"]),
            }
        ),
        path,
    )
    table = open_recording(path)
    assert table.columns["stamp"] == pytest.approx(stamps, rel=1e-15)
    assert table.empty["count"].tolist() == [False, True]
    assert table.columns["half"].tolist() == [0.5, 0.25]
    assert table.texts == {"name"}
    pq.write_table(pa.Table.from_arrays([pa.array([1.0])] * 2, names=["a", "a"]), path)
    with pytest.raises(InputError, match="has two columns named 'a'; rename one"):
        open_recording(path)
    pq.write_table(pa.table({"a": pa.array([], pa.float64())}), path)
    with pytest.raises(InputError, match="has no data"):
        open_recording(path)


def test_parquet_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "t.parquet"
    write_table(path, {"a": [1.0]})
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"reading 't.parquet' .*'bodyschema\[data\]'"):
        open_recording(path)
    with pytest.raises(MissingExtraError, match=r"'bodyschema\[data\]'"):
        write_table(tmp_path / "u.parquet", {"a": [1.0]})
    assert [p.name for p in tmp_path.iterdir()] == ["t.parquet"]


@both_kinds
def test_a_failed_write_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    path = tmp_path / f"t.{kind}"
    write_table(path, {"a": [1.0]})
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(f"bodyschema.sources.tables._write_{kind}", fail)
    with pytest.raises(InputError, match=r"No space left.*what was there is as it was"):
        write_table(path, {"a": [2.0]})
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "columns", "message"),
    [
        ("t.csv", {"a": [1.0, 2.0], "b": [1.0]}, "flat and equally long; .* shapes"),
        ("t.csv", {"a": [[1.0, 2.0]]}, "flat and equally long"),
        ("t.csv", {}, "flat and equally long"),
        ("t.xlsx", {"a": [1.0]}, "cannot write .*; expected a name ending in .csv or .parquet"),
    ],
)
def test_tables_that_cannot_be_written(
    tmp_path: Path, name: str, columns: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        write_table(tmp_path / name, columns)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())
