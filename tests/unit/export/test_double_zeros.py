"""Zeros that a URDF states itself beside corrected origins."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema.export.double_zeros import double_zeros
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints

ARM = """<robot name="arm"><link name="base"/><link name="upper"/><link name="hand"/>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/>{a}</joint>
<joint name="b" type="revolute"><parent link="upper"/><child link="hand"/></joint>
{more}</robot>"""

STATED = {
    "calibration": ('<calibration rising="0.2"/>', "", 'rising="0.2"'),
    "two": ('<calibration falling="0.1" rising="0.2"/>', "", 'rising="0.2"> and <calibration fall'),
    "ros2_control": (
        "",
        '<ros2_control><joint name="a"><param name="offset">0.2</param></joint></ros2_control>',
        "offset 0.2 in <ros2_control>",
    ),
    "transmission": (
        "",
        '<transmission><joint name="a"><offset>0.2</offset></joint></transmission>',
        "<offset> 0.2 in <transmission>",
    ),
}


def read(folder: Path, a: str, more: str) -> Body:
    path = folder / "arm.urdf"
    path.write_text(ARM.format(a=a, more=more))
    return Body.from_urdf(path)


@pytest.mark.parametrize("case", STATED)
def test_a_stated_zero_beside_a_corrected_one_is_named(tmp_path: Path, case: str) -> None:
    inside, more, written = STATED[case]
    body = read(tmp_path, inside, more)
    free = free_joints(body)
    at = dict.fromkeys(free.names, 0.0) | {"a.offset": 0.2, "b.offset": 0.1}
    (sentence,) = double_zeros(body, body.with_variables(free, list(at.values())))
    assert "'a'" in sentence
    assert written in sentence
    assert "+0.2000" in sentence
    at |= {"a.offset": 0.0, "a.link_x": 0.1}
    moved = body.with_variables(free, list(at.values()))
    assert double_zeros(body, moved) == [], "another link does not turn the joint twice"


@pytest.mark.parametrize("inside", ["", '<calibration rising="0.0"/>', '<calibration rising=""/>'])
def test_a_zero_that_is_zero_is_none(tmp_path: Path, inside: str) -> None:
    body = read(tmp_path, inside, '<transmission><joint name="a"/></transmission>')
    assert body.stated_zeros == {}
    free = free_joints(body)
    assert double_zeros(body, body.with_variables(free, np.full(len(free), 0.01))) == []
