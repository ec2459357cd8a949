"""Numbers as people read them."""

from __future__ import annotations

import math

import pytest

from bodyschema.units import listed, millimetres, shown, signed, significant, with_error


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0.00"), (1.5432, "1.54"), (54.74, "54.7"), (1234.5, "1234"), (0.00123, "0.00123"),
     (9.999, "10.0"), (1e-12, "0.000000"), (math.nan, "–"), (None, "–")],
)  # fmt: skip
def test_significant(value: float | None, text: str) -> None:
    assert significant(value) == text


def test_shown_converts() -> None:
    assert shown(0.00154, "m") == "1.54 mm"
    assert shown(math.pi, "rad") == "180 deg"
    assert shown(0.013, "1", 2) == "1.3 %"


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_what_is_absent_has_no_unit(value: float | None) -> None:
    assert shown(value, "px") == "–"


@pytest.mark.parametrize(
    ("metres", "text"), [(0.01208, "12.08"), (1e-6, "0.00100"), (math.inf, "–"), (0.0, "0.00")]
)
def test_millimetres(metres: float, text: str) -> None:
    assert millimetres(metres) == text


def test_errors_decide_the_digits() -> None:
    assert with_error(0.098, 2.153) == ("+0.1", "2.2")
    assert with_error(-0.4, 20.3) == ("0", "20")
    assert with_error(4.0031, 0.0392) == ("+4.003", "0.039")


def test_zero_has_no_sign() -> None:
    assert signed(-0.0001, 2) == "0.00"
    assert signed(-0.01, 2) == "-0.01"


def test_listed_is_cut() -> None:
    assert listed([1, 2], 2) == "1, 2"
    assert listed([1, 2, 3, 4], 2) == "1, 2 and 2 more"
