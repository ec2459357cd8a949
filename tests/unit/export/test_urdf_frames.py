"""Frames that are added to a URDF: a link and a fixed joint each, and not one byte more."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.urdf_frames import with_frames
from bodyschema.judging.places import FramePlace
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf

T = lie.transform(lie.rotation_from_rpy([0.1, -0.2, 1.5]), [0.03, -0.05, 0.08])


def place(parent: str, frame: str) -> FramePlace:
    return FramePlace(parent, frame, T, np.zeros(6), 0.0, 0.0)


def read(text: bytes) -> Body:
    return parse_urdf(text, Path("robot.urdf"), {})


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_the_robot_has_them_where_they_were_found(robot: bytes, end: str) -> None:
    source = robot.replace(b"\n", end.encode())
    added = with_frames(source, [place("fore", "camera"), place("camera", "lens & <glass>")])
    body = read(added)
    nominal = read(source).attach("camera", "fore", T).attach("lens & <glass>", "camera", T)
    q = np.random.default_rng(0).uniform(-1, 1, (5, len(body.joints)))
    rows = [body.frame_index(frame) for frame in nominal.frames]
    assert frame_poses(body, q)[:, rows] == pytest.approx(frame_poses(nominal, q), abs=1e-12)
    at = source.index(b"</robot>")
    assert added.startswith(source[:at])
    assert added.endswith(source[at:])
    new = added[at : len(added) - len(source) + at]
    assert new.count(end.encode()) == new.count(b"\n") == 12
    assert b'\n  <link name="camera"/>' in source[:at][-1:] + new


def test_nothing_to_add_is_nothing_added(robot: bytes) -> None:
    assert with_frames(robot, []) == robot


@pytest.mark.parametrize(
    ("parent", "frame", "message"),
    [
        ("fore", "mount", "has a link or joint of the name of 'mount' already"),
        ("fore", "rail", ""),
        ("arm", "camera", "has no link 'arm' for 'camera'"),
    ],
)
def test_names_that_are_taken_or_missing(
    robot: bytes, parent: str, frame: str, message: str
) -> None:
    if not message:  # a frame may be called like a joint: its own joint is rail_joint
        assert read(with_frames(robot, [place(parent, frame)])).frames[-1] == frame
        return
    with pytest.raises(InputError, match=message):
        with_frames(robot, [place(parent, frame)])


def test_files_that_cannot_be_added_to(robot: bytes) -> None:
    with pytest.raises(InputError, match="cannot read the URDF as XML"):
        with_frames(robot[:-20], [place("fore", "camera")])
    with pytest.raises(InputError, match=r"UTF-8 or ASCII that has </robot>"):
        with_frames(b'<robot name="a"><link name="fore"/></robot>'.decode().encode("utf-16"),
                    [place("fore", "camera")])  # fmt: skip
