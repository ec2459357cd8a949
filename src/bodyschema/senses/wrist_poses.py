"""Poses of a flange from columns, in any of the usual layouts, with or without a position."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean
from bodyschema.senses.layouts import ANGLES, LAYOUTS, poses_from_columns
from bodyschema.senses.wrist_declaration import PoseColumns
from bodyschema.sources.physical_units import factor
from bodyschema.sources.recording import UNITS

Array = NDArray[np.float64]

ORIENTATIONS = {
    "xyzw": "xyz_xyzw",
    "wxyz": "xyz_wxyz",
    "rpy": "xyz_rpy",
    "rotvec": "xyz_rotvec",
}
"""Layouts without a position, and the ones that they are a part of."""

FASTEST = 50.0
"""m/s, beyond any wrist."""


def pose_columns(values: Array, entry: PoseColumns) -> Array:
    """Transforms (n, 4, 4) of recorded columns; angles may be in degrees."""
    layout, wide = entry.layout, values
    length = factor(entry.unit, {k: UNITS[k] for k in ("m", "cm", "mm", "um", "in")})
    angle = factor(entry.angle_unit, {k: UNITS[k] for k in ("rad", "deg", "mrad")})
    everything = (*LAYOUTS, *ORIENTATIONS, "matrix3x3")
    if layout not in everything:
        raise InputError(f"unknown pose layout '{layout}'{did_you_mean(layout, everything)}")
    counts = {name: LAYOUTS[whole][0] - 3 for name, whole in ORIENTATIONS.items()}
    count = {"matrix3x3": 9, **counts}.get(layout)
    if count is not None and values.shape[1] != count:
        raise InputError(f"layout '{layout}' has {count} columns, {values.shape[1]} were named.")
    if layout in ORIENTATIONS:
        wide, layout = np.hstack([np.zeros((len(values), 3)), values]), ORIENTATIONS[layout]
    elif layout == "matrix3x3":
        matrices = values.reshape(-1, 3, 3)
        wide = np.concatenate([matrices, np.zeros((len(values), 3, 1))], axis=2)
        wide, layout = wide.reshape(-1, 12), "matrix3x4"
    if layout in ANGLES:
        wide = np.hstack([wide[:, :3], angle * wide[:, 3:]])
    T = poses_from_columns(wide, layout, length)
    skewed = np.abs(T[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2) - np.eye(3)).max(axis=(1, 2))
    if (skewed > 0.02).any():
        raise InputError(
            f"layout '{entry.layout}': row {int(np.argmax(skewed > 0.02))} is no rotation matrix; "
            "check the columns and their order (row by row, or matrix4x4_columns)."
        )
    return np.asarray((lie.inverse(T) if entry.inverse else T) @ lie.inverse(tool(entry)))


def tool(entry: PoseColumns) -> Array:
    """T_flange_tool (4, 4) of the frame that the columns hold."""
    return lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)


def check_speed(time: Array, position: Array) -> None:
    """Refuse positions (n, 3) m that fly, (n,) s: a wrong unit of length or time.

    Raises:
        InputError: half of the steps are quicker than any wrist.
    """
    ways = np.linalg.norm(np.diff(position, axis=0), axis=1)
    speed = float(np.median(ways / np.diff(time)))
    if speed > FASTEST:
        raise InputError(
            f"the sensor would move at {speed:.3g} m/s (median): check unit under [pose] (m, mm, "
            "...) and time_unit."
        )
