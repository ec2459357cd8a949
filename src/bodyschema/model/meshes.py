"""The visible shapes of a robot description: where their files lie, and their triangles."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.documents import is_file, regular_file
from bodyschema.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from bodyschema.model.tree import Visual

Packages = Mapping[str, str | Path]
"""Folder of each ROS package that meshes name by package://."""

Triangles = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (n, 3) m and faces (m, 3), rows of the vertices, counter-clockwise from outside."""

KINDS = (".stl", ".dae", ".obj", ".ply", ".off", ".glb", ".gltf")
"""Of mesh files; no archives, which may hold more than fits the memory."""

MOST_BYTES = 1 << 30
"""Of a mesh file."""

ROUND = 48
"""Sides of what stands for a circle: its outline is at most 0.2 % of the radius too narrow."""


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
            if is_file(candidate):
                return str(candidate)
        if folder.name == package and is_file(folder / inside):
            return str(folder / inside)
    return address


def triangles_of(visual: Visual) -> Triangles:
    """The triangles of one visible shape, in the frame of its link.

    Meshes are of one of `KINDS`. The unit that a DAE file states is heeded and its "up" axis is
    not, as ROS does it.

    Raises:
        InputError: the mesh file is missing or cannot be read.
        MissingExtraError: trimesh is not installed.
    """
    try:
        import trimesh
    except ImportError:
        raise MissingExtraError("trimesh", "mesh", "the shape of the links") from None
    size, T = visual.size, visual.placement
    if visual.shape == "mesh":
        mesh = _read(trimesh, visual)
    elif visual.shape == "box":
        mesh = trimesh.creation.box(extents=size)
    elif visual.shape == "cylinder":
        mesh = trimesh.creation.cylinder(radius=size[0], height=size[1], sections=ROUND)
    else:
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=size[0])
    vertices = np.array(mesh.vertices, dtype=np.float64)
    faces = np.array(mesh.faces, dtype=np.int64)
    if visual.shape == "mesh":
        vertices *= size
        if np.prod(size) < 0:  # a mirrored mesh is inside out
            faces = faces[:, ::-1].copy()
    return vertices @ T[:3, :3].T + T[:3, 3], faces


def _read(trimesh: Any, visual: Visual) -> Any:
    path = Path(visual.mesh)
    missing = (
        f"the mesh '{visual.mesh}' of link '{visual.frame}' was not found; name the folder of its "
        "package when the robot is read, or leave the link out."
    )
    regular_file(path, missing, MOST_BYTES)
    if path.suffix.lower() not in KINDS:
        raise _unreadable(visual, f"it is of kind '{path.suffix}'")
    try:
        scene = trimesh.load_scene(path)
        if path.suffix.lower() == ".dae":
            scene = scene.convert_units("meters")
        mesh = scene.to_mesh()
        readable = len(mesh.faces) > 0 and bool(np.isfinite(mesh.vertices).all())
    except Exception as error:  # readers of many formats, each with errors of its own
        raise _unreadable(visual, str(error)) from None
    if not readable:
        raise _unreadable(visual, "it has no triangles, or coordinates that are no numbers")
    return mesh


def _unreadable(visual: Visual, reason: str) -> InputError:
    return InputError(
        f"the mesh '{visual.mesh}' of link '{visual.frame}' cannot be read ({reason}); give an "
        "STL, DAE or OBJ file with triangles, or leave the link out."
    )
