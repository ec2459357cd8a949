"""Which reader a description goes to."""

from __future__ import annotations

from pathlib import Path

import pytest

from bodyschema.errors import InputError
from bodyschema.model.description import is_urdf, root_of
from bodyschema.model.tree import Body

URDF = '<robot name="r"><link name="base"/></robot>'


@pytest.mark.parametrize(
    ("text", "root"),
    [
        (URDF, "robot"),
        ('\ufeff<?xml version="1.0"?>\n<!-- <mujoco> -->\n<robot name="r">', "robot"),
        ("<!DOCTYPE x><mujoco/>", "mujoco"),
        ("<!-- a -- b --><mujoco model='x'>", "mujoco"),
        ("String value is: <robot>", "robot"),
        ("", ""),
        ("<!-- never closed", ""),
    ],
)
def test_the_root_of_a_file(tmp_path: Path, text: str, root: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    assert root_of(path) == root
    assert is_urdf(path) == (root != "mujoco")


def test_the_text_of_a_robot(tmp_path: Path) -> None:
    """As a parameter has it, in Python and saved from the command line."""
    assert Body.from_urdf(URDF).frames == ("base",)
    assert Body.from_urdf(f"String value is: {URDF}").frames == ("base",)
    path = tmp_path / "saved.urdf"
    path.write_text(f"String value is: {URDF}\n")
    assert Body.from_file(path).frames == ("base",)
    with pytest.raises(InputError, match="not well-formed XML"):
        Body.from_urdf("<robot><link></robot>")


def test_tables_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text('[[joint]]\nname = "j"\na = 0.3\n')
    assert Body.from_file(path).frames == ("base", "link_1", "flange")
    path.write_text(
        '[[joint]]\nname = "j"\naxis = [0, 0, 1]\npoint = [0, 0, 0]\n[[frame]]\nname = "t"\n'
    )
    assert Body.from_file(path).frames == ("base", "link_1", "t")
    assert Body.from_file(path).source == str(path)
    path.write_text("3")
    with pytest.raises(InputError):
        Body.from_file(path)
