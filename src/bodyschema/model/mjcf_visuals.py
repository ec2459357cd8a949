"""The visible shapes of a compiled MJCF, as those of a URDF; see `mjcf`.

Geoms of the groups that MuJoCo shows (0 to 2); of a body that has some which collide with nothing,
those alone. Capsules, ellipsoids and planes have no form in a URDF and are left out. MuJoCo moves
the vertices of a mesh into its own frame, v' = R^T (v - p), and the geom to where that frame is.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bodyschema import lie
from bodyschema.model.mjcf_tree import rotation
from bodyschema.model.tree import Visual

SHOWN = 2
"""The last group of geoms that is drawn."""


def mjcf_visuals(
    mujoco: Any, model: Any, frames: Sequence[str], folder: Path
) -> tuple[Visual, ...]:
    """The shapes of a model.

    Args:
        mujoco: the package.
        model: compiled.
        frames: name of the frame of each body.
        folder: of the file, which meshes are relative to.
    """
    shown = [i for i in range(model.ngeom) if model.geom_group[i] <= SHOWN]
    free = {i for i in shown if not (model.geom_contype[i] or model.geom_conaffinity[i])}
    drawn = {int(model.geom_bodyid[i]) for i in free}
    found = []
    for i in shown:
        body = int(model.geom_bodyid[i])
        shape = _shape(mujoco, model, i, folder) if i in free or body not in drawn else None
        if shape is not None:
            T = lie.transform(rotation(model.geom_quat[i]), model.geom_pos[i])
            kind, size, mesh, T_geom_shape = shape
            found.append(Visual(frames[body], T @ T_geom_shape, kind, size, mesh))
    return tuple(found)


def _shape(
    mujoco: Any, model: Any, i: int, folder: Path
) -> tuple[str, tuple[float, ...], str, Any] | None:
    """Kind, size, mesh file and T_geom_shape; None for what a URDF does not have."""
    kinds, a = mujoco.mjtGeom, [float(v) for v in model.geom_size[i]]
    kind = model.geom_type[i]
    if kind == kinds.mjGEOM_BOX:
        return "box", (2 * a[0], 2 * a[1], 2 * a[2]), "", np.eye(4)
    if kind == kinds.mjGEOM_SPHERE:
        return "sphere", (a[0],), "", np.eye(4)
    if kind == kinds.mjGEOM_CYLINDER:
        return "cylinder", (a[0], 2 * a[1]), "", np.eye(4)
    mesh = int(model.geom_dataid[i])
    if kind != kinds.mjGEOM_MESH or model.mesh_pathadr[mesh] < 0:
        return None
    path = bytes(model.paths[model.mesh_pathadr[mesh] :]).partition(b"\0")[0]
    T = lie.transform(rotation(model.mesh_quat[mesh]), model.mesh_pos[mesh])
    scale = tuple(float(v) for v in model.mesh_scale[mesh])
    return "mesh", scale, str((folder / path.decode("utf-8", "replace")).resolve()), lie.inverse(T)
