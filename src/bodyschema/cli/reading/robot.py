"""The robot's description, whatever its form."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bodyschema.model.tree import Body


def read_robot(path: Path, packages: Mapping[str, str] | None = None) -> Body:
    """A URDF or xacro file, or a DH table in TOML or JSON."""
    if path.suffix in (".toml", ".json"):
        return Body.from_dh(path)
    return Body.from_urdf(path, packages)
