"""Skeletons drawn in space: links as lines, joint axes as darker sticks, markers as dots.

Everything is drawn in the frame that looks, so that a body whose root nobody has seen can stand
beside one whose root is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kernels import FIXED
from bodyschema.model.kinematics import frame_poses, relative_pose
from bodyschema.model.tree import Body
from bodyschema.report.figure import INK

Array = NDArray[np.float64]


def places(body: Body, q: ArrayLike, seen_from: str) -> tuple[Array, Array]:
    """Origins of all frames and directions of their axes in the frame that looks.

    Args:
        body: the body.
        q: (n_joints,) posture.
        seen_from: name of the frame.

    Returns:
        (n_frames, 3) m and (n_frames, 3) unit vectors.
    """
    T_root = frame_poses(body, q)
    T = relative_pose(body, q, seen_from, body.frames[0]) @ T_root
    return T[:, :3, 3], np.einsum("kij,kj->ki", T[:, :3, :3], body.axis)


def draw_skeleton(
    axes: Any,
    body: Body,
    q: ArrayLike,
    seen_from: str,
    markers: Sequence[str],
    colour: str,
    stick: float,
) -> None:
    """Draw a body into three-dimensional matplotlib axes.

    Args:
        axes: with projection "3d".
        body: the body.
        q: (n_joints,) posture.
        seen_from: the frame that looks; it is drawn as a ring.
        markers: frames that are drawn as dots.
        colour: of links and markers.
        stick: length of the sticks that show axes, m.
    """
    at, directions = places(body, q, seen_from)
    for k in range(1, len(at)):
        axes.plot(*np.stack([at[body.parent[k]], at[k]], axis=1), color=colour, lw=3.0, alpha=0.55)
    for k in np.flatnonzero(body.kind != FIXED).tolist():
        half = stick / 2 * directions[k]
        ends = np.stack([at[k] - half, at[k] + half], axis=1)
        axes.plot(*ends, color=INK, lw=2.2, solid_capstyle="round")
    dots = at[[body.frame_index(marker) for marker in markers]]
    axes.scatter(*dots.T, s=34, color=colour, edgecolor="white", linewidth=0.8, depthshade=False)
    eye = at[body.frame_index(seen_from)]
    axes.scatter(*eye[:, None], s=70, facecolor="white", edgecolor=colour, linewidth=1.8)


def frame_view(axes: Any, points: Array, elevation: float, azimuth: float) -> None:
    """Show a box round the points at one scale in all directions, without panes and ticks.

    Args:
        axes: with projection "3d".
        points: (n, 3) m.
        elevation: of the view, deg.
        azimuth: deg.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
    )
    axes.set_box_aspect((1, 1, 1), zoom=1.35)
    axes.view_init(elev=elevation, azim=azimuth)
    axes.set_axis_off()
