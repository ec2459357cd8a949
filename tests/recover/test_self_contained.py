"""Two arms that calibrate themselves, judged by a tracker that the fit never saw; made small."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("pinocchio")

from self_contained import FOUR, trial

SIZE = 0.3


@pytest.fixture(scope="module", params=[0, 1])
def found(request: pytest.FixtureRequest) -> dict[str, dict[str, Any]]:
    return trial(request.param, SIZE, sets=(*FOUR, "four"))


def test_all_senses_together_bring_the_hands_home(found: dict[str, dict[str, Any]]) -> None:
    together = found["four"]
    assert together["tells"]
    # 30 to 40 mm before; 0.1 of it would already be the tenth part of the robot's error.
    assert together["after_mm"] < 0.05 * together["nominal_mm"]
    assert together["after_mm"] < 3 * together["stated_mm"]


def test_no_sense_ends_worse_without_saying_so(found: dict[str, dict[str, Any]]) -> None:
    for row in found.values():
        assert row["after_mm"] < row["nominal_mm"] or not row["tells"]


def test_more_senses_leave_less_open(found: dict[str, dict[str, Any]]) -> None:
    alone = [found[name] for name in FOUR]
    assert found["four"]["open"] < min(row["open"] for row in alone)
    assert found["four"]["stated_mm"] < min(row["stated_mm"] for row in alone)
    assert not found["planes"]["tells"]


def test_a_robot_that_is_nearly_right_is_told_apart_from_one_that_is_not() -> None:
    found = trial(0, SIZE, errors=0.1, sets=("planes", "distances"))
    assert not any(row["tells"] for row in found.values())
