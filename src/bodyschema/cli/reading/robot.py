"""The robot's description, whatever its form."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema import lie
from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.cli.reading.run_entries import FrameEntry
    from bodyschema.cli.run_file import RunFile
    from bodyschema.model.tree import Body


def read_robot(
    path: Path,
    packages: Mapping[str, str] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Body:
    """A description of any form, or the one that was recorded, `run.mcap#/robot_description`.

    Args:
        path: of a file, or of a topic of a bag.
        packages: folder of each ROS package that it names.
        arguments: of a xacro file, by name.
    """
    from bodyschema.model.tree import Body
    from bodyschema.sources.bags import MARK, is_bag

    if MARK in str(path) and is_bag(path):
        from bodyschema.sources.bag_text import bag_text

        return Body.from_urdf(bag_text(path), packages)
    return Body.from_file(path, packages, arguments)


def robot_of(run: RunFile, path: Path | None = None) -> Body:
    """The robot of a run, or another description of it."""
    return read_robot(path or Path(run.robot), run.packages, run.robot_arguments)


def with_frame(body: Body, name: str, entry: FrameEntry) -> Body:
    """The body with a frame of a run file, or with its own where it has one that is doubted.

    Args:
        body: of the description, and of the frames named before.
        name: of the frame.
        entry: a place of zeros is that of the description, where this has the frame.

    Raises:
        InputError: the description has such a frame which a joint moves, or on another parent.
    """
    from bodyschema.model.kernels import FIXED  # its compiler is not for the help

    T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
    if name not in body.frames:
        return body.attach(name, entry.parent, T)
    k = body.frame_index(name)
    if body.kind[k] != FIXED or not k:
        raise InputError(
            f"[frames.{name}]: {body.name} has a frame '{name}', which "
            f"{'is its root' if not k else 'a joint moves'}; choose another name."
        )
    parent = body.frames[body.parent[k]]
    if entry.parent != parent:
        raise InputError(
            f"[frames.{name}] hangs on '{entry.parent}', and in the robot description on "
            f"'{parent}'; name that one, or choose another name."
        )
    return body.with_placement(name, T) if any((*entry.xyz, *entry.rpy)) else body


def argument_words(table: Any) -> Any:
    """Arguments as xacro takes them; what is no table comes back, to be refused by its type."""
    return {k: _word(v) for k, v in table.items()} if isinstance(table, Mapping) else table


def _word(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return str(value) if isinstance(value, int | float) else value
