"""Frames of a run file that the robot description has itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.cli.loading import with_frames
from bodyschema.cli.run_file import run_from_table
from bodyschema.errors import InputError
from bodyschema.model.tree import Body

URDF = """<robot name="r"><link name="base"/><link name="arm"/><link name="camera"/>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/>
<limit lower="-1" upper="1"/>
</joint><joint name="m" type="fixed"><parent link="arm"/><child link="camera"/>
<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/></joint></robot>"""


def body_of(name: str, entry: dict[str, Any]) -> Body:
    table = {"robot": "r.urdf", "recording": "d.csv", "frames": {name: entry}}
    return with_frames(run_from_table(table, Path(), "'run.toml'"), Body.from_urdf(URDF))


def test_its_place_is_that_of_the_description() -> None:
    body = body_of("camera", {"parent": "arm", "known": "roughly"})
    expected = lie.transform(lie.rotation_from_rpy([0.1, 0.2, 0.3]), [1, 2, 3])
    assert body.placement[2] == pytest.approx(expected)
    assert body.frames == ("base", "arm", "camera")


def test_or_that_of_the_run_file() -> None:
    body = body_of("camera", {"parent": "arm", "xyz": [4.0, 5.0, 6.0]})
    assert body.placement[2] == pytest.approx(lie.transform(np.eye(3), [4, 5, 6]))


def test_others_are_attached() -> None:
    assert body_of("tool", {"parent": "arm"}).frames[-1] == "tool"


@pytest.mark.parametrize(
    ("name", "parent", "message"),
    [
        ("arm", "base", "which a joint moves; choose another name"),
        ("base", "arm", "which is its root"),
        ("camera", "base", r"hangs on 'base', and in the robot description on 'arm'"),
    ],
)
def test_what_is_no_mount_is_refused(name: str, parent: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        body_of(name, {"parent": parent})
