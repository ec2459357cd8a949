"""What was found as a data frame."""

from __future__ import annotations

import importlib.util
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from bodyschema import InputError
from bodyschema.answers.answer import Answer
from pose_fits import result


@pytest.fixture(scope="module")
def answer() -> Answer:
    return Answer(**vars(result(0)))


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_a_row_for_each_number(
    answer: Answer, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if importlib.util.find_spec(package) is None:
        monkeypatch.setitem(sys.modules, package, SimpleNamespace(DataFrame=dict))
    frame: Any = answer.to_frame(package)
    assert list(frame["name"])[:2] == ["joint_1.offset", "joint_2.offset"]
    assert list(frame["value"]) == pytest.approx(list(answer.estimate.x))
    assert list(frame["std"]) == pytest.approx(list(answer.estimate.std))
    assert next(iter(frame["unit"])) == "rad"


def test_what_is_not_there(answer: Answer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(InputError, match="pip install polars"):
        answer.to_frame("polars")
    with pytest.raises(InputError, match="did you mean 'pandas'"):
        answer.to_frame("panda")
