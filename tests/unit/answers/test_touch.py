"""What speaks against touches, and against their absence."""

from __future__ import annotations

from typing import Any

import pytest

from bodyschema.answers.touch import Felt


def felt(*verdicts: str, why: str = "", outside: float = 0.0) -> Felt:
    touches: list[dict[str, Any]] = [{"verdict": verdict} for verdict in verdicts]
    refused = [{"why": why, "force": [0.0, 0.0, 1.0]}] if why else []
    return Felt(touches, refused, outside, 0.3)


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (felt("point", "beside", "point"), "1 of 3 touches meet beside the surface"),
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
