"""Whatever holds a recording: paths, arrays, data frames by the names of their columns."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.errors import InputError


class Frame:
    """A table as pandas and polars have it, as far as it is looked at."""

    def __init__(self, columns: dict[str, Any], index: Any = ()) -> None:
        self._columns, self.columns, self.index = columns, list(columns), index

    def __getitem__(self, name: str) -> Any:
        return self._columns[name]


def test_arrays_by_name(tmp_path: Path) -> None:
    poses = np.arange(48.0).reshape(3, 4, 4)
    arrays: dict[str, Any] = {
        "t": np.arange(3),
        "q": np.arange(6.0).reshape(3, 2),
        "T": poses,
        "gain": [1.0],
    }
    np.savez(tmp_path / "a.npz", note=np.array(["x", "y", "z"]), **arrays)
    for found in (bs.open(tmp_path / "a.npz"), bs.open(arrays)):
        assert list(found.columns)[:4] == ["t", "q_0", "q_1", "T_00"] or found.texts == {
            "note",
            "gain",
        }
        assert found.columns["q_1"].tolist() == [1, 3, 5]
        assert found.columns["T_23"].tolist() == poses[:, 2, 3].tolist()
        assert "gain" in found.texts
    np.save(tmp_path / "q.npy", arrays["q"])
    assert list(bs.open(tmp_path / "q.npy").columns) == ["q_0", "q_1"]


def test_frames_by_the_names_of_their_columns() -> None:
    time = np.array(["2026-01-01T00:00:00", "2026-01-01T00:00:00.5"], dtype="datetime64[us]")
    columns = {
        "x": np.array([1.0, np.nan]),
        "n": np.array([1, None], dtype=object),
        "s": ["a", "b"],
    }
    found = bs.open(Frame(columns, index=time))
    assert np.diff(found.time()) == pytest.approx(0.5)
    assert found.time()[0] == 1767225600
    assert found.empty["x"].tolist() == found.empty["n"].tolist() == [False, True]
    assert found.texts == {"s"}
    assert bs.open([found, {"y": [1.0, 2.0]}]).columns["y"].tolist() == [1, 2]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda _: 3, "cannot open int as a recording; give the path of a file, a data frame"),
        (lambda _: [], "cannot open list as a recording"),
        (lambda _: {"a": "text"}, r"the arrays holds no array of numbers .* it has a \(\)"),
        (lambda _: {"a": np.zeros((3, 2)), "a_1": np.zeros(3)}, "two columns named 'a_1'"),
    ],
)
def test_what_holds_none_is_said(make: Callable[[Any], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        bs.open(make(None))


def test_a_broken_file_of_arrays_is_said(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.arange(1000.0))
    whole = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(whole[:900])
    with pytest.raises(InputError, match="is no whole file of numpy arrays"):
        bs.open(tmp_path / "a.npz")
    np.save(tmp_path / "b.npy", np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="is no whole file of numpy arrays: Object arrays"):
        bs.open(tmp_path / "b.npy")
