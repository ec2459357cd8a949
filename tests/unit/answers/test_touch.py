"""What speaks against touches, and against their absence."""

from __future__ import annotations

from typing import Any

import pytest

from bodyschema.answers.touch import Felt


def felt(*verdicts: str, why: str = "", outside: float = 0.0, beside: float = 0.0) -> Felt:
    touches: list[dict[str, Any]] = [
        {"verdict": verdict, "beside": 60.0 if verdict == "beside" else beside}
        for verdict in verdicts
    ]
    refused = [{"why": why, "force": [0.0, 0.0, 1.0]}] if why else []
    return Felt(touches, refused, outside, 0.3)


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (felt("point", "beside", "point"), "1 of 3 touches meet beside the surface"),
        (felt("point", beside=5.5), "1 of 1 touches meet beside the surface"),
        (felt("point", "moving", beside=6.7), "1 of 2 touches meet beside the surface"),
        (felt("point", why="crept"), "crept in 1 time"),
        (felt(why="load"), "as well explained by another load"),
        (felt("point", outside=0.6), "0.6 s of the recording"),
    ],
)
def test_what_limits_touches(found: Felt, says: str) -> None:
    assert found.trust.level == "limited"
    assert says in found.trust.reasons[0]


def test_touches_on_the_surface_are_good() -> None:
    assert felt("point", "moving", "twist", outside=0.4).trust.level == "good"
    assert felt("point", "point", beside=6.6).trust.level == "good"
