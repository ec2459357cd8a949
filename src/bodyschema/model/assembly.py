"""Several robots as one body: each after the first is mounted on a frame of those before.

A table in TOML or JSON, paths relative to it:

    name = "cell"
    [[robot]]
    description = "arm.urdf"            # URDF, xacro, MJCF, or a table of joints
    [[robot]]
    description = "hand.urdf.xacro"
    parent = "tool0"                    # frame that its root is fixed to
    prefix = "left_"                    # optional: before the names of its frames and joints
    xyz = [0.0, 0.0, 0.02]              # optional: m, of its root in the parent
    rpy = [0.0, 0.0, 1.57]              # optional: rad, fixed axes
    arguments = { side = "left" }       # optional: of a xacro file
    [packages]                          # optional: folder of each ROS package that they name
    hand_description = "../hand_description"
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.joint_tables import numbers, read_table, refuse_unknown
from bodyschema.model.meshes import Packages
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

TABLE_KEYS = ("name", "robot", "packages")
ROBOT_KEYS = ("description", "parent", "prefix", "xyz", "rpy", "arguments")

MOST = 20
"""Robots of one table."""


Reader = Callable[[Path, Packages, Mapping[str, str]], Body]
"""Of the description of one robot, with its packages and arguments."""


def read_assembly(path: Path, packages: Packages, read: Reader) -> Body:
    """Read a table of robots (see the module's text).

    Args:
        path: of the table.
        packages: folder of each ROS package that the descriptions name, besides those in it.
        read: reads each of them.

    Raises:
        InputError: the file is missing or malformed, a description cannot be read, or two things
            have one name.
    """
    table = read_table(path, "table of robots")
    refuse_unknown(table, TABLE_KEYS, f"in '{path}'")
    listed = table.get("robot")
    if not isinstance(listed, list) or not 0 < len(listed) <= MOST:
        raise InputError(f"'{path}' needs 1 to {MOST} [[robot]] sections.")
    folders = {**packages, **_packages(table.get("packages", {}), path)}
    whole: Body | None = None
    for number, entry in enumerate(listed, start=1):
        where = f"[[robot]] {number} of '{path}'"
        one, prefix = _robot(entry, where, path, folders, read)
        parent = _text(entry, "parent", where)
        if whole is None:
            _refuse_mount(entry, where)
            whole = _prefixed(one, prefix)
        elif not parent:
            raise InputError(f"{where} needs the parent: the frame that it is fixed to.")
        else:
            whole = joined(whole, one, parent, _mount(entry, where), prefix)
    assert whole is not None
    return replace(whole, name=_text(table, "name", f"'{path}'") or path.stem)


def _robot(
    entry: Any, where: str, path: Path, packages: Packages, read: Reader
) -> tuple[Body, str]:
    """One robot as it is described, and the prefix of its names."""
    refuse_unknown(entry, ROBOT_KEYS, f"in {where}")
    named, arguments = _text(entry, "description", where), entry.get("arguments", {})
    if not named or not isinstance(arguments, dict):
        raise InputError(f"{where} needs a description, and arguments as a table.")
    given = {name: str(value) for name, value in arguments.items()}
    return read(path.parent / named, packages, given), _text(entry, "prefix", where)


def _mount(entry: Mapping[str, Any], where: str) -> Array:
    """T_parent_root of an entry."""
    rpy = numbers(entry.get("rpy", (0.0, 0.0, 0.0)), 3, f"rpy in {where}")
    xyz = numbers(entry.get("xyz", (0.0, 0.0, 0.0)), 3, f"xyz in {where}")
    return lie.transform(lie.rotation_from_rpy(rpy), xyz)


def joined(
    body: Body, other: Body, parent: str, T_parent_root: ArrayLike | None = None, prefix: str = ""
) -> Body:
    """One body of two, the root of the second fixed to a frame of the first.

    Args:
        body: the first; its root stays the root.
        other: the second.
        parent: frame of the first.
        T_parent_root: (4, 4) m, of the second's root; identity when None.
        prefix: before the names of the second's frames and joints.

    Raises:
        InputError: no such frame, or two things of one name.
    """
    second = _prefixed(other, prefix)
    root = second.frames[0]
    for mine, its, what in (
        (body.frames, second.frames, "frame"),
        (body.carriers, (f"{root}_joint", *second.carriers[1:]), "joint"),
        (tuple(body.parts), tuple(second.parts), "part"),
    ):
        both = [name for name in its if name in mine]
        if both:
            raise InputError(
                f"{body.name} and {other.name} both have a {what} '{both[0]}'; give the second a "
                'prefix, such as "left_".'
            )
    above, n, count = body.frame_index(parent), len(body.frames), len(body.joints)
    placement = second.placement.copy()
    placement[0] = np.eye(4) if T_parent_root is None else np.asarray(T_parent_root)
    hung = np.where(second.parent < 0, above, second.parent + n)
    driver = np.where(second.driver < 0, -1, second.driver + count)
    stacked: dict[str, Any] = {
        key: np.concatenate([getattr(body, key), getattr(second, key)])
        for key in ("kind", "axis", "rate", "shift", "lower", "upper", "gear", "offset")
    }
    listed: dict[str, Any] = {
        key: getattr(body, key) + getattr(second, key)
        for key in ("frames", "joints", "visuals", "remarks")
    }
    return replace(
        body,
        carriers=(*body.carriers, f"{root}_joint", *second.carriers[1:]),
        parent=np.concatenate([body.parent, hung]),
        placement=np.concatenate([body.placement, placement]),
        driver=np.concatenate([body.driver, driver]),
        parts={**body.parts, **second.parts},
        stated_zeros={**body.stated_zeros, **second.stated_zeros},
        **listed,
        **stacked,
    )


def _prefixed(body: Body, prefix: str) -> Body:
    """The body with other names of its frames and joints."""
    if not prefix:
        return body
    return replace(
        body,
        frames=tuple(prefix + name for name in body.frames),
        carriers=("", *(prefix + name for name in body.carriers[1:])),
        joints=tuple(prefix + name for name in body.joints),
        visuals=tuple(replace(one, frame=prefix + one.frame) for one in body.visuals),
        stated_zeros={prefix + name: said for name, said in body.stated_zeros.items()},
    )


def _refuse_mount(entry: Mapping[str, Any], where: str) -> None:
    mounted = [key for key in ("parent", "xyz", "rpy") if key in entry]
    if mounted:
        raise InputError(
            f"{mounted[0]} in {where}: the first robot hangs on nothing; leave it out."
        )


def _packages(table: Any, path: Path) -> dict[str, str]:
    if not isinstance(table, dict) or not all(isinstance(v, str) for v in table.values()):
        raise InputError(f"[packages] of '{path}' needs the folder of each package, as text.")
    return {name: str(path.parent / folder) for name, folder in table.items()}


def _text(table: Mapping[str, Any], key: str, where: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{key} = {value!r:.60} in {where}; expected text.")
    return value
