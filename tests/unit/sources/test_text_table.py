"""Texts that hold tables: endings, separators, decimal commas, no header, a pipe."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from bodyschema.errors import InputError
from bodyschema.sources import text_table
from bodyschema.sources.tables import open_recording


@pytest.mark.parametrize("name", ["a.CSV", "a.tsv", "a.TXT", "a.Csv"])
def test_endings_in_any_case(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("a\tb\n1\t2\n")
    assert open_recording(tmp_path / name).columns["b"].tolist() == [2]


@pytest.mark.parametrize(
    ("text", "columns", "texts"),
    [
        ("a;b\n0,5;1\n;-1,25e-3\n", {"a": [0.5, None], "b": [1, -1.25e-3]}, set()),
        ('a,b\n"0,5",2\n"1,5",3\n', {"a": [0.5, 1.5], "b": [2, 3]}, set()),
        ("a;b\n1,234;0.5\n2,345;0.5\n", {"b": [0.5, 0.5]}, {"a"}),
        ("a;b\n1,234,5;1\n", {"b": [1]}, {"a"}),
        ("1.5,2\n3,4\n", {"column_0": [1.5, 3], "column_1": [2, 4]}, set()),
        ("0,5;1,5\n2;3\n", {"column_0": [0.5, 2], "column_1": [1.5, 3]}, set()),
        ("# a b\n1 2\n", {"a": [1], "b": [2]}, set()),
    ],
)
def test_decimal_commas_and_lines_of_names(
    tmp_path: Path, text: str, columns: dict[str, list[float | None]], texts: set[str]
) -> None:
    """A comma beside points may part thousands: such a column is left out, never guessed."""
    (tmp_path / "a.csv").write_text(text)
    found = open_recording(tmp_path / "a.csv")
    assert found.texts == texts
    for name, values in columns.items():
        blank = found.empty.get(name, [False] * len(found))
        read = [None if gone else v for v, gone in zip(found.columns[name], blank, strict=True)]
        assert read == values
    assert found.columns.keys() == columns.keys()


def test_what_is_piped_in_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Piped:
        buffer = io.BytesIO(b"t,a\n0,1\n1,2\n")

    text_table._piped.cache_clear()
    monkeypatch.setattr(sys, "stdin", Piped())
    monkeypatch.chdir(tmp_path)
    assert open_recording("-").columns["a"].tolist() == [1, 2]
    assert open_recording(tmp_path / "-").columns["a"].tolist() == [1, 2], "again, as a run file's"
    text_table._piped.cache_clear()
    with pytest.raises(InputError, match="'-' has no data"):
        open_recording("-")
    text_table._piped.cache_clear()
