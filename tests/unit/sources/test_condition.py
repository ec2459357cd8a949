"""Rows of a long table."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.condition import rows_where
from bodyschema.sources.recording import Recording

TABLE = Recording(
    "'a.csv'",
    {"marker": np.array([3.0, 4.0, 3.0, np.nan]), "my quality": np.array([0.1, 0.9, 0.9, 1.0])},
    {"marker": np.array([False, False, False, True])},
    frozenset({"camera", "who", "when"}),
    {"who": ("left", "right hand ", "left", "")},
)


@pytest.mark.parametrize(
    ("condition", "rows"),
    [
        ("marker == 3", [0, 2]), ("marker!=3", [1]), ("my quality >= .9", [1, 2, 3]),
        ("marker == 3 and my quality > 5e-1", [2]), ("marker <= 3.0", [0, 2]),
        ("my quality < 0.2", [0]), ("who == left", [0, 2]), ("who == 'right hand'", [1]),
        ('who != "left" and marker > 1', [1]),
    ],
)  # fmt: skip
def test_rows(condition: str, rows: list[int]) -> None:
    assert np.flatnonzero(rows_where(TABLE, condition)).tolist() == rows


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("marker = 3", 'is no condition; write a column, one of == .*: "marker == 3"'),
        ("marker == __import__('os')", "is no condition"),
        ("marker == nan", "is no condition"),
        ("markr == 3", "no column 'markr' in 'a.csv'; did you mean 'marker'"),
        ("camera == 3", "'camera' of 'a.csv' does not hold numbers"),
        ("who > left", "'who' of 'a.csv' holds texts, which are the same"),
        ("who == lef", "no row of 'a.csv' fulfils"),
        ("when == monday", "is no condition"),
        ("marker == 7", "no row of 'a.csv' fulfils where = 'marker == 7'"),
    ],
)
def test_what_is_no_condition_is_said(condition: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        rows_where(TABLE, condition)


@pytest.mark.parametrize(
    ("condition", "rows"),
    [
        ("who == 'salt and pepper'", [0, 2]), ('n > 1 and who == "salt and pepper"', [2]),
        ("who != 'salt and pepper' and n >= 2", [1]), ("who == 'salt' and n == 2", [1]),
        ("who == 'salt and pepper' and who != 'salt and n == 2' and n == 3", [2]),
    ],
)  # fmt: skip
def test_and_within_quotes_joins_nothing(condition: str, rows: list[int]) -> None:
    pair = "salt and pepper"
    words = {"who": (pair, "salt", pair)}
    table = Recording("'a.csv'", {"n": np.array([1.0, 2.0, 3.0])}, {}, frozenset({"who"}), words)
    assert np.flatnonzero(rows_where(table, condition)).tolist() == rows
