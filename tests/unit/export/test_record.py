"""Records as JSON and back: every type that they may hold, and refusals that name the field."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.export.record import decoded, encoded
from same import same


@dataclass(frozen=True)
class Inner:
    """A record in a record."""

    at: tuple[str, ...]
    size: float = 1.0


@dataclass(frozen=True)
class Bare:
    """One array."""

    q: NDArray[np.float64]


@dataclass(frozen=True)
class Whole:
    """One field of every type."""

    word: str
    count: int
    size: float
    yes: bool
    level: Literal["low", "high"]
    row: NDArray[np.float64]
    grid: NDArray[np.float64]
    steps: NDArray[np.int64]
    marks: NDArray[np.bool_]
    pair: tuple[str, float]
    many: tuple[Inner, ...]
    inner: Inner
    maybe: Inner | None
    number: float | None
    nothing: Inner | None
    choice: int | str
    by_name: Mapping[str, NDArray[np.float64]]
    by_pair: Mapping[tuple[str, str], Inner]
    anything: Mapping[str, Any] = field(default_factory=dict)
    later: int = 7


WHOLE = Whole(
    word="käfer \"x\"\n",
    count=10**17 + 1,
    size=1.0 / 3.0,
    yes=True,
    level="high",
    row=np.array([np.inf, -np.inf, np.nan, 5e-324, 0.1 + 0.2]),
    grid=np.random.default_rng(0).normal(size=(2, 3, 4)),
    steps=np.array([2**60 + 1, -3]),
    marks=np.array([[True, False]]),
    pair=("m", -0.0),
    many=(Inner(("a", "b")), Inner((), np.inf)),
    inner=Inner(("x",), np.nan),
    maybe=Inner(("y",)),
    number=np.inf,
    nothing=None,
    choice="three",
    by_name={"q": np.eye(2), "none": np.zeros((3, 0))},
    by_pair={("position", "m"): Inner(("z",)), ("force", "N/m"): Inner(())},
    anything={"list": [1, "a", None], "deep": {"yes": False}},
)  # fmt: skip


def as_text(record: Any) -> Any:
    """Through the text of a file."""
    return json.loads(json.dumps(encoded(record), allow_nan=False))


def test_every_type_comes_back_to_the_last_bit() -> None:
    back = decoded(Whole, as_text(WHOLE))
    assert same(WHOLE, back)
    assert (back.row.dtype, back.steps.dtype, back.marks.dtype) == (
        np.float64, np.int64, np.bool_
    )  # fmt: skip
    assert back.grid.shape == (2, 3, 4)
    assert type(back.size) is float
    assert type(back.many) is tuple
    assert np.signbit(back.pair[1])


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan, 1e308, 5e-324, 3])
def test_numbers_that_json_has_not(value: float) -> None:
    back = decoded(Inner, as_text(Inner((), value))).size
    assert back == value or (np.isnan(back) and np.isnan(value))
    assert type(back) is float


def test_numpy_numbers_are_plain() -> None:
    assert encoded((np.float64(0.5), np.int32(3), np.bool_(True), np.float64("nan"))) == [
        0.5, 3, True, "nan"
    ]  # fmt: skip


def test_fields_may_be_left_out_everywhere() -> None:
    record = encoded({"a": (Inner(("x",), 2.0),)}, frozenset({"size"}))
    assert record == {"a": [{"at": ["x"]}]}
    assert decoded(Inner, record["a"][0]) == Inner(("x",), 1.0)


def test_keys_of_two_words_are_one_word_between() -> None:
    record = as_text(WHOLE)
    assert set(record["by_pair"]) == {"position|m", "force|N/m"}


@pytest.mark.parametrize("value", [object(), {1, 2}, 1j, b"bytes", Inner])
def test_what_is_no_plain_value_is_not_written(value: Any) -> None:
    with pytest.raises(TypeError, match=f"a {type(value).__name__} cannot be written"):
        encoded({"x": value})


def test_a_missing_field_takes_its_default_and_a_new_one_is_passed_over() -> None:
    record = as_text(WHOLE)
    del record["later"]
    assert decoded(Whole, {**record, "unheard_of": 3}).later == 7


def test_a_missing_field_without_default_is_named() -> None:
    record = as_text(WHOLE)
    del record["inner"]["at"]
    with pytest.raises(InputError, match=r"^Whole\.inner lacks 'at'; it was not written by"):
        decoded(Whole, record)


REFUSED: dict[str, tuple[tuple[str | int, ...], Any]] = {
    "Whole.word": (("word",), 3),
    "Whole.count": (("count",), 2.5),
    "Whole.size": (("size",), "big"),
    "Whole.yes": (("yes",), "true"),
    "Whole.level": (("level",), "middle"),
    "Whole.row": (("row",), ["one", 2.0]),
    "Whole.grid": (("grid",), [[1.0], [2.0, 3.0]]),
    "Whole.steps": (("steps",), [{}]),
    "Whole.pair": (("pair",), ["m"]),
    "Whole.pair[1]": (("pair",), ["m", True]),
    "Whole.many": (("many",), {"at": []}),
    "Whole.many[1].at[0]": (("many", 1), {"at": [4]}),
    "Whole.inner": (("inner",), None),
    "Whole.maybe": (("maybe",), 3),
    "Whole.number": (("number",), "much"),
    "Whole.choice": (("choice",), None),
    "Whole.by_name": (("by_name",), [1]),
    "Whole.by_name[q]": (("by_name", "q"), "x"),
    "Whole.by_pair[position|m].size": (("by_pair", "position|m", "size"), [1]),
}


@pytest.mark.parametrize("where", REFUSED)
def test_another_type_is_refused_by_the_name_of_the_field(where: str) -> None:
    path, wrong = REFUSED[where]
    record = as_text(WHOLE)
    place = record
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = wrong
    with pytest.raises(InputError) as error:
        decoded(Whole, record)
    assert str(error.value).startswith(f"{where} cannot be ")


def test_what_is_refused_is_shown_in_short() -> None:
    with pytest.raises(InputError, match=r"^Inner cannot be 'x{59}\.\.\.\.$"):
        decoded(Inner, "x" * 200)


@pytest.mark.parametrize("wrong", [None, 1.0, "nan", [1.5, 2.0], [None], ["7"], [2**80], [True]])
def test_an_array_is_a_list_of_its_own_numbers(wrong: Any) -> None:
    """Numpy would take each of them for numbers, and cut 1.5 down to 1."""
    with pytest.raises(InputError, match=r"^Whole\.steps cannot be "):
        decoded(Whole, {**as_text(WHOLE), "steps": wrong})


@pytest.mark.parametrize("wrong", [None, "x", [None], ["7"], [1.0, [2.0]], [True]])
def test_an_array_of_floats_likewise(wrong: Any) -> None:
    with pytest.raises(InputError, match=r"^Whole\.row cannot be "):
        decoded(Whole, {**as_text(WHOLE), "row": wrong})


@pytest.mark.parametrize("shape", [(0,), (0, 3), (2, 0), (0, 4, 4)])
def test_an_array_without_a_number_keeps_its_shape(shape: tuple[int, ...]) -> None:
    text = as_text(Bare(np.zeros(shape)))
    assert decoded(Bare, text).q.shape == shape


@pytest.mark.parametrize(
    "value",
    [{"empty": [3]}, {"empty": [0, -1]}, {"empty": [0, 2**40]}, {"empty": [0, 2**30, 2**30, 2**30]},
     {"empty": [True, 0]}, {"empty": 0}, {"empty": [0], "more": 1}, {}, [[1.0], [2.0, 3.0]], 3, "x",
     [10**400]],
)  # fmt: skip
def test_what_is_no_array(value: Any) -> None:
    with pytest.raises(InputError, match=r"Bare\.q"):
        decoded(Bare, {"q": value})


def test_true_is_no_number_and_a_pair_has_two_words() -> None:
    with pytest.raises(InputError, match=r"Whole\.count cannot be True"):
        decoded(Whole, {**as_text(WHOLE), "count": True})
    with pytest.raises(InputError, match="by_pair"):
        decoded(Whole, {**as_text(WHOLE), "by_pair": {"alone": {"at": []}}})
