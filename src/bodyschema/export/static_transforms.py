"""transforms.yaml: where the estimated cameras, trackers and tools sit, ready for TF."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.documents import yaml_text
from bodyschema.export.joint_edit import clean
from bodyschema.judging.calibration import Calibration
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

PREFIX = "frame:"
"""Of the parameter group of a frame that was freed."""

HEADING = """\
Estimated fixed frames that the robot description does not have, written by bodyschema.
xyz in m in the parent frame; rpy in rad about fixed axes; run a command to publish it to ROS 2."""


def estimated_frames(variables: Variables) -> tuple[str, ...]:
    """Names of the frames that were free, in order."""
    groups = dict.fromkeys(variables.groups)
    return tuple(group.removeprefix(PREFIX) for group in groups if group.startswith(PREFIX))


def attached_frames(calibration: Calibration, nominal: Body) -> tuple[str, ...]:
    """The estimated frames that the robot description does not have."""
    estimated = estimated_frames(calibration.estimate.variables)
    return tuple(frame for frame in estimated if frame not in nominal.frames)


def transforms_text(calibration: Calibration, nominal: Body) -> str:
    """transforms.yaml; see `transforms_document`."""
    return yaml_text(transforms_document(calibration, nominal), HEADING)


def transforms_document(calibration: Calibration, nominal: Body) -> dict[str, Any]:
    """{"transforms": [...]}, one entry for each estimated frame that is not in the description.

    Args:
        calibration: the answer.
        nominal: as described, without the frames that were attached.
    """
    frames, variables = attached_frames(calibration, nominal), calibration.estimate.variables
    return {"transforms": placed_frames(calibration.body, variables, frames)}


def placed_frames(body: Body, variables: Variables, frames: Sequence[str]) -> list[dict[str, Any]]:
    """An entry of transforms.yaml for each of some frames of a body.

    Args:
        body: with the frames where they came to be.
        variables: what was free.
        frames: their names.
    """
    listed = []
    for frame in frames:
        k = body.frame_index(frame)
        turned = f"{frame}.turn_x" in variables.names
        listed.append(_transform(body.frames[body.parent[k]], frame, body.placement[k], turned))
    return listed


def _transform(parent: str, child: str, T_parent_child: Array, turned: bool) -> dict[str, Any]:
    R, xyz = T_parent_child[:3, :3], _numbers(T_parent_child[:3, 3])
    quaternion = _numbers(lie.quaternion_xyzw(R))
    return {
        "parent": parent,
        "child": child,
        "xyz": xyz,
        "quaternion_xyzw": quaternion,
        "rpy": _numbers(lie.rpy_from_rotation(R)),
        # A point is seen without its orientation, which then stays as it was given.
        "rotation_estimated": turned,
        "command": publisher_command(parent, child, xyz, quaternion),
    }


def publisher_command(
    parent: str, child: str, xyz: list[float], quaternion_xyzw: list[float]
) -> str:
    """The shell command that publishes T_parent_child (m, unit quaternion) in ROS 2."""
    names = ("x", "y", "z", "qx", "qy", "qz", "qw")
    numbers = zip(names, [*xyz, *quaternion_xyzw], strict=True)
    words = " ".join(f"--{name} {value!r}" for name, value in numbers)
    frames = f"--frame-id {shlex.quote(parent)} --child-frame-id {shlex.quote(child)}"
    return f"ros2 run tf2_ros static_transform_publisher {words} {frames}"


def _numbers(values: Array) -> list[float]:
    return [clean(float(value)) for value in values]
