"""Files of others: odd places, sizes, encodings, depths and numbers, each in one sentence."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bodyschema.documents import (
    MOST_BYTES,
    file_text,
    is_file,
    is_folder,
    is_there,
    json_file,
    printable,
    regular_file,
    toml_file,
)
from bodyschema.errors import InputError, did_you_mean

ODD = ("a" * 300, "a\0b", "\ud800", "b/" * 3000)


@pytest.mark.parametrize("name", ODD)
def test_names_that_no_file_has(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    assert [is_file(path), is_folder(path), is_there(path)] == [False] * 3
    with pytest.raises(InputError, match=r"cannot be opened|is no name|nothing here"):
        regular_file(path, "nothing here")


def test_a_pipe_is_refused_and_never_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="is a pipe or a device"):
        file_text(tmp_path / "pipe", "nothing here")
    with pytest.raises(InputError, match="nothing here"):
        file_text(tmp_path, "nothing here")


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(InputError, match="has 67 MB, and at most 67 are read"):
        file_text(path, "nothing here")


def test_encodings(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes("a = 'ü'".encode("utf-8-sig"))
    assert toml_file(path, "", "no TOML") == {"a": "ü"}
    for form in ("utf-16", "latin-1"):
        path.write_bytes("a = 'ü'".encode(form))
        with pytest.raises(InputError, match=r"is no text in UTF-8 \(byte \d+\); save it"):
            toml_file(path, "", "no TOML")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "deep"),
        ("[" * 70 + "]" * 70, "more than 64 deep"),
        ("9" * 5000, "is no JSON"),
        (str(2**63), "whole number of"),
        ("NaN", "NaN is no number of JSON"),
        ('"\\ud800"', "half a character"),
        ('{"\\udfff": 1}', "half a character"),
        ('{"a"', "is no JSON"),
    ],
)
def test_json_that_nothing_can_hold(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        json_file(path, "", "no JSON")


@pytest.mark.parametrize(
    "text", ["a = " + "[" * 20_000, "a = " + "9" * 5000, f"a = {2**63}", ".".join("a" * 90) + "=1"]
)
def test_toml_that_nothing_can_hold(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"deep|is no TOML|whole number"):
        toml_file(path, "", "no TOML")


def test_escapes_are_shown() -> None:
    said = printable({"a\x1b[31m": ["\u202e", "[red]ü", 1.5, None]})
    assert said == {"a\\x1b[31m": ["\\u202e", "[red]ü", 1.5, None]}
    assert str(InputError("no joint 'a\x1b[2J'\nhere")) == "no joint 'a\\x1b[2J'\nhere"


def test_a_page_for_a_name_costs_nothing() -> None:
    known = [f"column_{i}" for i in range(200_000)]
    assert "did you mean 'column_17'" in did_you_mean("column_17x", ["column_17"])
    assert len(did_you_mean("x" * 10**6, known)) < 2000
