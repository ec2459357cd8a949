"""Values of a TOML file against the types of the record that they are read into."""

from __future__ import annotations

from typing import Any

import pytest

from bodyschema.cli.entry_types import check_types, fits
from bodyschema.cli.reading.run_entries import FrameEntry
from bodyschema.errors import InputError


@pytest.mark.parametrize(
    ("value", "hint", "good"),
    [
        (3, float, True),
        (float("nan"), float, False),
        (True, float, False),
        (True, int, False),
        (3.5, int, False),
        (True, bool, True),
        (3, str, False),
        (None, float | None, True),
        ("x", float | None, False),
        ((1, 2.5), tuple[float, ...], True),
        ((1, "a"), tuple[float, ...], False),
        ("ab", tuple[str, ...], False),
        ({"a": "b"}, dict[str, str], True),
        ({"a": 1}, dict[str, str], False),
        (object(), Any, True),
    ],
)
def test_what_fits(value: object, hint: Any, good: bool) -> None:
    assert fits(value, hint) == good


def test_the_sentence_names_key_value_place_and_what_is_expected() -> None:
    with pytest.raises(InputError) as told:
        check_types(FrameEntry, {"parent": "base", "xyz": (0, "a", 0)}, "[frames.eye] of 'r.toml'")
    assert str(told.value) == (
        "xyz = [0, 'a', 0] in [frames.eye] of 'r.toml'; expected a list, each a finite number."
    )
