"""Several robots as one body: kinematics of each, names, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

HAND = """<robot name="hand"><link name="palm"><visual><geometry><sphere radius="0.1"/></geometry>
</visual></link><link name="thumb"/><link name="ring"/>
<joint name="t" type="revolute"><parent link="palm"/><child link="thumb"/><origin xyz="0 0 .1"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1"/><calibration rising="0.1"/></joint>
<joint name="r" type="revolute"><parent link="palm"/><child link="ring"/><mimic joint="t"
multiplier="-2" offset="0.1"/><limit lower="-1" upper="1"/></joint></robot>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A URDF of an arm and one of a hand."""
    arm = Body.random_chain(3, np.random.default_rng(0))
    (tmp_path / "arm.urdf").write_bytes(write_urdf(arm))
    (tmp_path / "hand.urdf").write_text(HAND)
    return tmp_path


def cell(folder: Path, table: Any) -> Body:
    path = folder / "cell.json"
    path.write_text(json.dumps(table))
    return Body.from_file(path)


def hands(**more: Any) -> list[dict[str, Any]]:
    hand = {
        "description": "hand.urdf",
        "parent": "tip",
        "xyz": [0, 0, 0.05],
        "rpy": [0.1, 0.2, 0.3],
    }
    return [
        {"description": "arm.urdf"},
        {**hand, "prefix": "left_"},
        {**hand, "prefix": "right_", **more},
    ]


def test_each_robot_moves_as_alone(folder: Path) -> None:
    body = cell(folder, {"name": "cell", "robot": hands(parent="left_thumb")})
    arm, hand = Body.from_urdf(folder / "arm.urdf"), Body.from_urdf(folder / "hand.urdf")
    assert body.name == "cell"
    assert body.joints == (*arm.joints, "left_t", "right_t")
    assert body.frames[-3:] == ("right_palm", "right_thumb", "right_ring")
    assert body.stated_zeros.keys() == {"left_t", "right_t"}
    assert [v.frame for v in body.visuals] == ["left_palm", "right_palm"]
    assert body.lower[-2:].tolist() == [-1, -1]
    mount = lie.transform(lie.rotation_from_rpy([0.1, 0.2, 0.3]), [0, 0, 0.05])
    q = np.random.default_rng(1).uniform(-1, 1, 5)
    expected = (
        relative_pose(arm, q[:3], "base", "tip")
        @ mount
        @ relative_pose(hand, q[3:4], "palm", "thumb")
        @ mount
        @ relative_pose(hand, q[4:], "palm", "ring")
    )
    assert relative_pose(body, q, "base", "right_ring") == pytest.approx(expected, abs=1e-15)


def test_the_joined_body_is_written_whole(folder: Path) -> None:
    body = cell(folder, {"robot": hands()})
    (folder / "cell.urdf").write_bytes(write_urdf(body))
    again = Body.from_urdf(folder / "cell.urdf")
    q = np.random.default_rng(1).uniform(-1, 1, 5)
    for frame in body.frames:
        one, other = (relative_pose(b, q, "base", frame) for b in (body, again))
        assert one == pytest.approx(other, abs=1e-14)
    assert again.visuals[0].size == (0.1,)
    assert replace(again.visuals[0], placement=body.visuals[0].placement) == body.visuals[0]


def test_in_python(folder: Path) -> None:
    arm, hand = Body.from_urdf(folder / "arm.urdf"), Body.from_urdf(HAND)
    body = arm.joined(hand, "tip")
    assert relative_pose(body, np.zeros(4), "tip", "palm") == pytest.approx(np.eye(4))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"robot": []}, r"needs 1 to 20 \[\[robot\]\]"),
        (
            {"robot": hands(prefix="left_")},
            "both have a frame 'left_palm'; give the second a prefix",
        ),
        ({"robot": hands(parent="tup")}, "no frame 'tup'"),
        ({"robot": hands(parent="")}, "needs the parent"),
        ({"robot": hands(xyz=[1])}, "xyz in .* should be 3 numbers"),
        ({"robot": hands(prefix=3)}, "prefix = 3 in .*; expected text"),
        ({"robot": hands(arguments=3)}, "arguments as a table"),
        ({"robot": hands(discription="")}, "unknown key 'discription'"),
        ({"robot": [{"parent": "x"}]}, "needs a description"),
        ({"robot": [{"description": "arm.urdf", "xyz": [0, 0, 1]}]}, "hangs on nothing"),
        ({"robot": [{"description": "cell.json"}]}, "is a table of robots and stands in one"),
        ({"robot": [{"description": "none.urdf"}]}, "no robot description at"),
        ({"robot": hands(), "packages": {"a": 1}}, "needs the folder of each package"),
    ],
)
def test_bad_tables_say_what_to_do(folder: Path, table: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        cell(folder, table)
