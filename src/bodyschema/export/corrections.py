"""Corrections of an answer, ready to be put into another description of the robot."""

from __future__ import annotations

from bodyschema.errors import InputError, did_you_mean
from bodyschema.export.payload import carried_loads, urdf_with_load
from bodyschema.export.static_transforms import estimated_frames
from bodyschema.export.urdf_edits import urdf_edits
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.settled import settled
from bodyschema.model.tree import Body
from bodyschema.model.variables import GROUPS, free_joints


def joint_corrections(calibration: Calibration) -> dict[str, float]:
    """Deviations of the joints' parameters by name, rad or m; frames and parts are left out.

    What is not determined, or unchanged within its error, is left out; see `judging.settled`.

    Raises:
        InputError: nothing may be put on a robot.
    """
    if calibration.withheld:
        raise InputError(
            f"the verdict was '{calibration.verdict}'; there is nothing to export. "
            f"{calibration.explanation}"
        )
    variables, kept = calibration.estimate.variables, settled(calibration)
    rows = zip(variables.names, variables.groups, kept.x, kept.changed, strict=True)
    return {n: float(x) for n, group, x, changed in rows if group in GROUPS and changed}


def corrected_body(calibration: Calibration, nominal: Body) -> Body:
    """A robot with the corrections of an answer.

    Raises:
        InputError: nothing may be put on a robot, or this one lacks a joint.
    """
    wanted, free = joint_corrections(calibration), free_joints(nominal)
    unknown = [name for name in wanted if name not in free.names]
    if unknown:
        hint = did_you_mean(unknown[0], free.names)
        raise InputError(f"'{nominal.name}' has no {unknown[0]}{hint}")
    body = nominal.with_variables(free, [wanted.get(n, 0.0) for n in free.names])
    found = settled(calibration).body
    for frame in described_frames(calibration, nominal):
        body = body.with_placement(frame, found.placement[found.frame_index(frame)])
    return body


def described_frames(calibration: Calibration, nominal: Body) -> tuple[str, ...]:
    """The estimated frames that a robot has itself, on the same parent."""
    ours = calibration.estimate.reference

    def parent(body: Body, frame: str) -> str:
        return body.frames[int(body.parent[body.frame_index(frame)])]

    return tuple(
        frame
        for frame in estimated_frames(calibration.estimate.variables)
        if frame in nominal.frames and parent(ours, frame) == parent(nominal, frame)
    )


def refuse_nothing(calibration: Calibration, nominal: Body) -> None:
    """Refuse an answer that changes nothing on a robot. Raises InputError."""
    placed = described_frames(calibration, nominal)
    if not (placed or joint_corrections(calibration) or carried_loads(calibration)):
        raise InputError(
            "the result corrects no joint and knows no load on a link of a robot; "
            "there is nothing to export."
        )


def corrected_urdf(
    calibration: Calibration, text: bytes, nominal: Body, stops: bool = False
) -> tuple[bytes, list[str]]:
    """A description with the corrections and the loads, byte by byte the same otherwise.

    Args:
        calibration: the answer of any verb.
        text: the URDF.
        nominal: the same as a body.
        stops: the limits are mechanical stops, see `urdf_edits`.

    Returns:
        The URDF, and the names of the joints and links that are new or changed.

    Raises:
        InputError: nothing may be put on a robot, or this one lacks a joint or the sensor's link.
    """
    body, loads = corrected_body(calibration, nominal), carried_loads(calibration)
    refuse_nothing(calibration, nominal)
    edits, changed = urdf_edits(nominal, body, stops), []
    patched = patch_urdf(text, edits)
    for link, carried in loads.items():
        nominal.frame_index(link)
        patched = urdf_with_load(patched, link, carried)
        changed += [f"{link}: {name}" for name in carried]
    return patched, sorted(edits) + changed
