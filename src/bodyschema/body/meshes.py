"""Where the mesh files of a robot description lie."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

Packages = Mapping[str, str | Path]
"""Folder of each ROS package that meshes name by package://."""


def resolve_mesh(address: str, urdf: Path, packages: Packages) -> str:
    """Path of a mesh named by package://, model://, file:// or relative to the URDF.

    A package is looked for in `packages`, then as a folder of that name in and above the URDF's
    own folder. An address that leads nowhere comes back unchanged: only drawing needs it.
    """
    scheme, _, rest = address.rpartition("://")
    if scheme == "file":
        return rest
    if not scheme:
        return str((urdf.parent / address).resolve())
    package, _, inside = rest.partition("/")
    if package in packages:
        return str(Path(packages[package]) / inside)
    for folder in urdf.resolve().parents:
        for candidate in (folder / package / inside, folder / "share" / package / inside):
            if candidate.is_file():
                return str(candidate)
        if folder.name == package and (folder / inside).is_file():
            return str(folder / inside)
    return address
