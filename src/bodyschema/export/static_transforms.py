"""transforms.yaml: where the estimated cameras, trackers and tools sit, ready for TF."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.documents import rounded, yaml_text
from bodyschema.export.joint_edit import clean
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.places import PREFIX, FramePlace, places
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

DECIMALS = 7
"""Of a line that is to be copied: 0.1 um, 0.1 urad; no calibration knows more."""

HEADING = """\
Estimated fixed frames that the robot description does not have, written by bodyschema.
xyz in m in the parent frame; rpy in rad about fixed axes; run a command to publish it to ROS 2.
std: of x, y, z and of the turns about the parent's axes, whatever else may be wrong with the robot;
not_determined: what the place goes along with, if it is not known by itself."""


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
    return {"transforms": [_transform(place) for place in added_frames(calibration, nominal)]}


def added_frames(calibration: Calibration, nominal: Body) -> list[FramePlace]:
    """The estimated frames that the description does not have, each in what it hangs on."""
    found = {place.frame: place for place in reversed(places(calibration))}
    return [found[frame] for frame in attached_frames(calibration, nominal)]


def _transform(place: FramePlace) -> dict[str, Any]:
    R, xyz = place.T[:3, :3], _numbers(place.T[:3, 3])
    quaternion = _numbers(lie.quaternion_xyzw(R))
    turned = math.isfinite(place.rotation_95)
    return {
        "parent": place.parent,
        "child": place.frame,
        "xyz": xyz,
        "quaternion_xyzw": quaternion,
        "rpy": _numbers(lie.rpy_from_rotation(R)),
        "std": [rounded(float(value)) for value in place.sd],
        "not_determined": place.untold or None,
        # A point is seen without its orientation, which then stays as it was given.
        "rotation_estimated": turned,
        "command": publisher_command(place.parent, place.frame, xyz, quaternion),
    }


def place_entries(calibration: Calibration) -> list[dict[str, Any]]:
    """The frames that were asked for, in the units that people read and in lines to copy.

    Empty where nothing may be put on a robot.
    """
    return [] if calibration.withheld else [_entry(place) for place in places(calibration)]


def _entry(place: FramePlace) -> dict[str, Any]:
    R, xyz = place.T[:3, :3], [_short(v) for v in place.T[:3, 3]]
    rpy, quaternion = lie.rpy_from_rotation(R), [_short(v) for v in lie.quaternion_xyzw(R)]
    entry = {
        "name": f"T_{place.parent}_{place.frame}",
        "parent": place.parent,
        "frame": place.frame,
        "xyz_mm": [rounded(1e3 * float(v)) for v in place.T[:3, 3]],
        "rpy_deg": [rounded(math.degrees(v)) for v in rpy],
        "quaternion_xyzw": quaternion,
        "std_mm": [rounded(1e3 * float(v)) for v in place.sd[:3]],
        "std_deg": [rounded(math.degrees(v)) for v in place.sd[3:]],
        "within_mm_95": rounded(1e3 * place.position_95),
        "within_deg_95": rounded(math.degrees(place.rotation_95)),
        "not_determined": place.untold or None,
        "joints_at": {joint: rounded(value) for joint, value in place.at.items()},
        "determined_in": None if place.told is None else _entry(place.told),
    }
    if not place.at:
        entry["origin"] = origin_line(xyz, [_short(v) for v in rpy])
        entry["command"] = publisher_command(place.parent, place.frame, xyz, quaternion)
    return entry


def origin_line(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    """The element of a URDF's fixed joint, m and rad."""
    texts = (" ".join(repr(v) for v in values) for values in (xyz, rpy))
    return '<origin xyz="{}" rpy="{}"/>'.format(*texts)


def publisher_command(
    parent: str, child: str, xyz: list[float], quaternion_xyzw: list[float]
) -> str:
    """The shell command that publishes T_parent_child (m, unit quaternion) in ROS 2."""
    names = ("x", "y", "z", "qx", "qy", "qz", "qw")
    numbers = zip(names, [*xyz, *quaternion_xyzw], strict=True)
    words = " ".join(f"--{name} {value!r}" for name, value in numbers)
    frames = f"--frame-id {shlex.quote(parent)} --child-frame-id {shlex.quote(child)}"
    return f"ros2 run tf2_ros static_transform_publisher {words} {frames}"


def _short(value: float) -> float:
    return round(float(value), DECIMALS) + 0.0


def _numbers(values: Array) -> list[float]:
    return [clean(float(value)) for value in values]
