"""Screw axes against the product of matrix exponentials."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kernels import PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

HOME = lie.transform(lie.rotation_from_rpy([0.4, -1.2, 2.0]), [0.8, 0.1, 0.5])


def se3(S: Array) -> Array:
    """[S] of w and v, (4, 4)."""
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[:3, 3] = lie.skew(S[:3]), S[3:]
    return matrix


def random_screws(rng: np.random.Generator) -> Array:
    """Four turns about axes anywhere and a slide between them, (5, 6)."""
    w, p = rng.normal(size=(2, 5, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    S = np.hstack([w, -np.cross(w, p)])
    S[2] = [0, 0, 0, *w[2]]
    return S


def written(tmp_path: Path, table: Any) -> Body:
    path = tmp_path / "arm.json"
    path.write_text(json.dumps(table))
    return Body.from_file(path)


def table_of(S: Array) -> dict[str, Any]:
    frame = {"name": "tool", "matrix": HOME.tolist()}
    return {"joint": [{"screw": row.tolist()} for row in S], "frame": [frame]}


@pytest.mark.parametrize("form", ["space", "body"])
def test_they_equal_the_product_of_exponentials(tmp_path: Path, form: str) -> None:
    rng = np.random.default_rng(5)
    S = random_screws(rng)
    body = written(tmp_path, {**table_of(S), "form": form})
    assert body.kind[1:6].tolist() == [REVOLUTE, REVOLUTE, PRISMATIC, REVOLUTE, REVOLUTE]
    for q in rng.uniform(-2, 2, (10, 5)):
        T = np.eye(4) if form == "space" else HOME
        for screw, value in zip(S, q, strict=True):
            T = T @ expm(se3(screw) * value)
        T = T @ HOME if form == "space" else T
        assert np.abs(relative_pose(body, q, "base", "tool") - T).max() < 2e-14


def test_a_tree_and_an_axis_with_a_point(tmp_path: Path) -> None:
    table = {
        "name": "two arms",
        "joint": [
            {"name": "waist", "axis": [0, 0, 2], "point": [0, 0, 0], "limits": [-1, 1]},
            {"name": "left", "axis": [0, 1, 0], "point": [0, 0.2, 1.0]},
            {"name": "right", "axis": [1, 0, 0], "type": "prismatic", "parent": "waist"},
        ],
        "frame": [
            {"name": "left_hand", "joint": "left", "xyz": [0.5, 0.2, 1.0]},
            {"name": "right_hand", "xyz": [0.5, -0.2, 1.0], "rpy": [0, 0, 1]},
            {"name": "foot", "joint": "base"},
        ],
    }
    body = written(tmp_path, table)
    assert body.name == "two arms"
    assert body.upper.tolist() == [1, np.inf, np.inf]
    left = relative_pose(body, [0.0, np.pi / 2, 9.0], "base", "left_hand")
    assert left[:3, 3] == pytest.approx([0, 0.2, 0.5])
    right = relative_pose(body, [np.pi / 2, 9.0, 0.1], "base", "right_hand")
    assert right[:3, 3] == pytest.approx([0.2, 0.6, 1.0])


ROW = {"screw": [0, 0, 1, 0, 0, 0]}
FRAME = {"name": "tool"}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"joint": [ROW]}, r"no \[\[frame\]\]"),
        ({"joint": [ROW], "frame": [{}]}, r"\[\[frame\]\] 1 of .* needs a name"),
        ({"joint": [ROW], "frame": [{"name": "link_1"}]}, "needs a name, which is not"),
        ({"joint": [ROW], "frame": [FRAME, FRAME]}, "two .* of one name"),
        ({"joint": [{**ROW, "point": [0, 0, 0]}], "frame": [FRAME]}, "which says its point"),
        ({"joint": [{**ROW, "axis": [0, 0, 1]}], "frame": [FRAME]}, "one of them"),
        ({"joint": [{"axis": [0, 0, 1]}], "frame": [FRAME]}, "lacks the point"),
        ({"joint": [{"axis": [0, 0, 0], "point": [0, 0, 0]}], "frame": [FRAME]}, "no length"),
        ({"joint": [{"screw": [0, 0, 2, 0, 0, 0]}], "frame": [FRAME]}, "length 2, expected 1"),
        ({"joint": [{"screw": [0, 0, 1, 0, 0, 0.1]}], "frame": [FRAME]}, "turns and slides"),
        ({"joint": [{"screw": [0, 0, 1]}], "frame": [FRAME]}, "should be 6 numbers"),
        ({"joint": [{"screw": [0] * 6}], "frame": [FRAME]}, "length 0, expected 1"),
        ({"joint": [ROW], "frame": [{**FRAME, "joint": "j9"}]}, "hangs on 'j9'"),
        ({"joint": [ROW], "frame": [{**FRAME, "matrix": [[1]]}]}, "four rows"),
        ({"joint": [ROW], "frame": [{**FRAME, "matrix": np.ones((4, 4)).tolist()}]}, "orthonormal"),
        ({"joint": [ROW], "frame": [{**FRAME, "xyz": [0, 0, 0], "matrix": []}]}, "says xyz"),
        ({"joint": [ROW], "frame": [FRAME, {"name": "b"}], "form": "body"}, "body's form"),
        ({"joint": [ROW], "frame": [FRAME], "form": "hybrid"}, "unknown form 'hybrid'"),
        ({"joint": [{**ROW, "parent": [1]}], "frame": [FRAME]}, "no joint or frame above it"),
        ({"joint": [{**ROW, "limts": 1}], "frame": [FRAME]}, "unknown key 'limts'"),
    ],
)
def test_bad_tables_say_what_to_do(tmp_path: Path, table: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        written(tmp_path, table)
