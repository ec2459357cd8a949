"""Shapes of links within a budget, and what becomes of those that cannot be read."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from bodyschema.model.tree import Visual
from bodyschema.view.shapes import FEWEST, shapes_of, shares

pytest.importorskip("trimesh")

BOX = Visual("a", np.eye(4), "box", (0.1, 0.2, 0.3))


def test_small_links_are_kept_whole_and_large_ones_share_the_rest() -> None:
    kept = shares({"large": 90_000, "small": 12, "larger": 200_000}, 10_012)
    assert kept == {"large": 5_000, "small": 0, "larger": 5_000}
    assert shares({"a": 10, "b": 20}, 100) == {"a": 0, "b": 0}
    assert set(shares({str(k): 1000 for k in range(50)}, 100).values()) == {FEWEST}
    assert shares({}, 100) == {}


def test_a_box_in_its_links_frame() -> None:
    (shape,), notes = shapes_of([BOX])
    assert notes == ()
    assert len(shape.faces) == 12
    np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), [0.1, 0.2, 0.3], rtol=1e-6)


def test_the_budget_holds() -> None:
    pytest.importorskip("fast_simplification")
    balls = [Visual(name, np.eye(4), "sphere", (0.1,)) for name in "abc"]
    shapes, _ = shapes_of(balls, budget=600)
    assert 300 < sum(len(shape.faces) for shape in shapes) <= 600


def test_a_lost_mesh_is_said_and_the_others_are_drawn() -> None:
    lost = Visual("b", np.eye(4), "mesh", (1.0, 1.0, 1.0), "/nowhere/b.stl")
    shapes, (note,) = shapes_of([BOX, lost])
    assert [shape.frame for shape in shapes] == ["a"]
    assert "1 link is drawn as sticks (b)" in note
    assert "/nowhere/b.stl" in note


def test_without_the_extra_there_are_sticks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    shapes, (note,) = shapes_of([BOX])
    assert shapes == ()
    assert "bodyschema[mesh]" in note
    assert "sticks" in note
