"""Reading a robot description of any form: URDF, xacro, MJCF, or a table.

.xacro                      xacro, with its arguments
.toml, .json                [[robot]]: several robots; [[joint]] with screws or axes: the product of
                            exponentials; other [[joint]]: Denavit and Hartenberg
anything else               XML, by its root: <robot> is a URDF, <mujoco> an MJCF
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from bodyschema.documents import is_file
from bodyschema.errors import InputError
from bodyschema.model.assembly import read_assembly
from bodyschema.model.dh import read_dh
from bodyschema.model.joint_tables import read_table
from bodyschema.model.meshes import Packages
from bodyschema.model.mjcf import read_mjcf
from bodyschema.model.screws import read_screws
from bodyschema.model.tree import Body
from bodyschema.model.urdf import read_urdf

TABLES = (".toml", ".json")
"""Suffixes of tables; any other description is XML."""

OF_SCREWS = ("screw", "axis", "point")
"""Keys of a [[joint]] that tables of Denavit and Hartenberg do not have."""

_PASSED = re.compile(rb"\A(?:[^<]|<\?.*?\?>|<!--.*?-->|<![^>-][^>]*>)*", re.DOTALL)
"""What may stand before the root of an XML file."""

_ROOT = re.compile(rb"<([A-Za-z_][^\s/>]*)")

HEAD = 1 << 16
"""Bytes in which the root of a file is looked for."""


def read_description(
    path: Path,
    packages: Packages | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Body:
    """Read a description; see the module's text.

    Args:
        path: the file.
        packages: folder of each ROS package that it names.
        arguments: of a xacro file, by name.

    Raises:
        InputError: it is missing, or cannot be read.
        MissingExtraError: a package that the form needs is not installed.
    """
    if path.suffix in TABLES and "robot" in _table(path):
        body = read_assembly(path, packages or {}, _one_robot)
    else:
        body = _one_robot(path, packages or {}, arguments or {})
    return replace(body, source=str(path.resolve()), arguments=dict(arguments or {}))


def _one_robot(path: Path, packages: Packages, arguments: Mapping[str, str]) -> Body:
    """One that is no table of several."""
    if path.suffix in TABLES:
        return _from_joints(path)
    if root_of(path) == "mujoco":
        return read_mjcf(path)
    return read_urdf(path, packages, arguments)


def _from_joints(path: Path) -> Body:
    """A table of joints, which screws and Denavit and Hartenberg write in different keys."""
    table = _table(path)
    if "robot" in table:
        raise InputError(f"'{path}' is a table of robots and stands in one; name its robots there.")
    listed = table.get("joint")
    rows = listed if isinstance(listed, list) else []
    of_screws = any(isinstance(row, dict) and {*row} & {*OF_SCREWS} for row in rows)
    return read_screws(path) if of_screws or "form" in table else read_dh(path)


def _table(path: Path) -> Any:
    """What a table holds; an empty one for what is none, which its reader refuses."""
    table = read_table(path, "robot description")
    return table if isinstance(table, dict) else {}


def is_urdf(path: Path) -> bool:
    """Whether a description is a URDF, or a xacro file that becomes one, so that it is patched."""
    return path.suffix not in TABLES and root_of(path) != "mujoco"


def is_mjcf(path: Path) -> bool:
    """Whether a description is an MJCF."""
    return path.suffix not in TABLES and root_of(path) == "mujoco"


def root_of(path: Path) -> str:
    """Name of the first element of an XML file; "" where there is none."""
    if not is_file(path):
        return ""
    with path.open("rb") as file:
        head = file.read(HEAD)
    passed = _PASSED.match(head)
    root = _ROOT.match(head, passed.end() if passed else 0)
    return root[1].decode("ascii", "replace") if root else ""
