"""The robot's description, whatever its form."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile
    from bodyschema.model.tree import Body


def read_robot(
    path: Path,
    packages: Mapping[str, str] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Body:
    """A URDF or xacro file with its packages and arguments, or a DH table in TOML or JSON."""
    from bodyschema.model.tree import Body

    if path.suffix in (".toml", ".json"):
        return Body.from_dh(path)
    return Body.from_urdf(path, packages, arguments)


def robot_of(run: RunFile, path: Path | None = None) -> Body:
    """The robot of a run, or another description of it."""
    return read_robot(path or Path(run.robot), run.packages, run.robot_arguments)


def argument_words(table: Any) -> Any:
    """Arguments as xacro takes them; what is no table comes back, to be refused by its type."""
    return {k: _word(v) for k, v in table.items()} if isinstance(table, Mapping) else table


def _word(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return str(value) if isinstance(value, int | float) else value
