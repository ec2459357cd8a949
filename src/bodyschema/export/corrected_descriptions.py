"""The corrections of an answer in a robot description of any form, as one of any form.

from \\ to       .urdf                                   .xml (MJCF)
URDF, xacro     the file with the changed numbers       written anew, with its inertias
MJCF            written anew                            the file with the changed numbers
table           written anew                            written anew
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bodyschema.errors import InputError
from bodyschema.export.corrections import corrected_body, corrected_urdf, refuse_nothing
from bodyschema.export.double_zeros import double_zeros
from bodyschema.export.mjcf_edits import edited_mjcf
from bodyschema.export.mjcf_writer import write_mjcf
from bodyschema.export.payload import carried_loads, urdf_with_load
from bodyschema.export.static_transforms import added_frames
from bodyschema.export.urdf_edits import unwritable, urdf_edits
from bodyschema.export.urdf_frames import with_frames
from bodyschema.export.urdf_inertials import urdf_inertials
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.calibration import Calibration
from bodyschema.model.description import is_mjcf, is_urdf, read_description
from bodyschema.model.meshes import Packages
from bodyschema.model.urdf import parse_urdf, urdf_text

URDF, MJCF = ".urdf", ".xml"
"""Endings of what is written."""


@dataclass(frozen=True)
class Corrected:
    """A corrected description."""

    text: bytes
    kind: str
    """"urdf" or "mjcf"."""
    changed: list[str]
    """Joints, and links that are new."""
    notes: list[str]
    patched: bool
    """Whether it is the file that was given, but for numbers."""


def corrected_description(
    calibration: Calibration,
    robot: Path,
    out: Path,
    packages: Packages,
    arguments: Mapping[str, str],
    add_frames: bool = False,
    stops: bool = False,
) -> Corrected:
    """Put the corrections of an answer into a description.

    Args:
        calibration: the answer of any verb.
        robot: the description.
        out: where it goes; its ending says the form, and none leaves it as it is.
        packages: folder of each ROS package that it names.
        arguments: of a xacro file, by name.
        add_frames: also add the frames that were estimated.
        stops: limits of a URDF are mechanical stops, see `urdf_edits`.

    Raises:
        InputError: nothing may be put on a robot, this one lacks a joint, or another ending.
    """
    ending = out.suffix or (MJCF if is_mjcf(robot) else URDF)
    if ending not in (URDF, MJCF):
        raise InputError(
            f"a robot goes into a .urdf or, as MJCF, an .xml, not into '{out.name}'; name "
            "another --out."
        )
    if is_mjcf(robot) and ending == MJCF:
        return _mjcf_of_mjcf(calibration, robot, out, add_frames)
    if not is_urdf(robot):
        text, nominal = None, read_description(robot, packages, arguments)
        corrected = corrected_body(calibration, nominal)
        refuse_nothing(calibration, nominal)
        changed, loads = sorted(urdf_edits(nominal, corrected)), carried_loads(calibration)
        patched = write_urdf(corrected)
        for link, carried in loads.items():
            nominal.frame_index(link)
            patched = urdf_with_load(patched, link, carried)
    else:
        text = urdf_text(robot, packages, arguments)
        nominal = parse_urdf(text, robot, packages)
        patched, changed = corrected_urdf(calibration, text, nominal, stops)
    if add_frames:
        patched = with_frames(patched, added_frames(calibration, nominal))
    corrected = corrected_body(calibration, nominal)
    notes = double_zeros(nominal, corrected) + unwritable(nominal, corrected)
    if ending == MJCF:
        written = parse_urdf(patched, robot, packages)
        return Corrected(
            write_mjcf(written, urdf_inertials(patched)), "mjcf", changed, notes, False
        )
    return Corrected(patched, "urdf", changed, notes, robot.suffix == URDF and text is not None)


def _mjcf_of_mjcf(calibration: Calibration, robot: Path, out: Path, add_frames: bool) -> Corrected:
    nominal = read_description(robot)
    corrected = corrected_body(calibration, nominal)
    refuse_nothing(calibration, nominal)
    added = added_frames(calibration, nominal) if add_frames else []
    elsewhere = out.resolve().parent != robot.resolve().parent
    text, changed = edited_mjcf(robot, nominal, corrected, added, elsewhere)
    notes = unwritable(nominal, corrected)
    if carried_loads(calibration):
        notes.append("The load is not in the MJCF; export a URDF for it, --out corrected.urdf.")
    return Corrected(text, "mjcf", changed, notes, True)
