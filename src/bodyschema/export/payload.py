"""An identified load for others: payload.yaml, robot controllers, the URDF, calibration.yaml.

Every controller wants mass and centre of mass in its flange frame, and moments about the centre of
mass, but not in one form:

    UR       set_target_payload(m, [cx, cy, cz], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz])
             kg, m and kg m^2, about the centre of mass, along the flange's axes
    KUKA     {M m, CM {X, Y, Z, A, B, C}, J {X, Y, Z}}
             kg, mm, degrees (A about z, then B about y', then C about x''), principal moments
             in kg m^2
    Franka   setLoad(mass, F_x_Cload, load_inertia)
             kg, m and kg m^2, about the centre of mass, flange's axes, column after column
    ABB      loaddata [mass, [cog], [aom], ix, iy, iz]
             kg, mm, the quaternion (scalar first) of the axes of moment, principal moments in
             kg m^2 about the centre of mass
    xArm     set_tcp_load(mass, [cx, cy, cz])
             kg and mm

What is not told is in no form: without mass and centre of mass there is none, without moments the
forms that can do without leave them out.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.calibration_yaml import calibration_document
from bodyschema.export.documents import rounded, versions, yaml_text
from bodyschema.export.joint_edit import clean
from bodyschema.judging.calibration import Calibration
from bodyschema.model.inertia import Inertia

Array = NDArray[np.float64]

HEADING = """\
What hangs on a wrist, found by bodyschema. SI: kg, m, kg m^2.
com and inertia: along the sensor's axes as declared, inertia about the centre of mass; std are one
standard deviation. flange: the same along the flange's axes from its origin.
sensor: bias is what it adds to its reading, along its own axes, with the sign of the recording.
not_told: what the motion did not show; do not use these numbers.
com_95: m, the error of com stays below it with 95 %.
controllers: calls and data for robot controllers, in the flange frame, of what is told alone."""

CLOSING = re.compile(rb"</\s*robot\s*>\s*$")


def payload_text(answer: Mapping[str, Any]) -> str:
    """payload.yaml of the answer of `bodyschema payload`."""
    return yaml_text(payload_entry(answer) | {"versions": versions()}, HEADING)


def payload_entry(answer: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a document that tells of loads and sensor, numbers rounded."""
    kept = ("loads", "sensor", "unexplained", "samples", "left_out", "events", "notes")
    return {key: _short(answer[key]) for key in kept if key in answer}


def entered(calibration: Calibration, details: Mapping[str, Any]) -> str:
    """A calibration's document with the payload as one more entry.

    Args:
        calibration: of a robot.
        details: of the answer of `learn_payload`.
    """
    document = calibration_document(calibration) | {"payload": payload_entry(details)}
    return yaml_text(document, "A calibration, and what hangs on the wrist (entry payload).")


def carried_loads(calibration: Calibration) -> dict[str, dict[str, Mapping[str, Any]]]:
    """Loads by the link that carries them, in that link's frame; none if they are not known."""
    link = calibration.details.get("sensor", {}).get("link", "")
    if not link or calibration.withheld:
        return {}
    return {link: {load["name"]: load["flange"] for load in calibration.details["loads"]}}


def controller_forms(load: Inertia, not_told: Collection[str] = ()) -> dict[str, str]:
    """What controllers take, by maker, of what is told; the load is in the flange frame.

    Nothing where mass or centre of mass are not told; without moments where one of them is not,
    and nothing for a controller that cannot do without.

    Args:
        load: in the flange frame.
        not_told: "mass", "com", "I_xx" ..., see `learners.payload.untold`.
    """
    if {"mass", "com"} & {*not_told}:
        return {}
    I, c = load.moments, load.com  # noqa: E741
    mass, place = _number(load.mass), _list(c)
    if not_told:
        at = ", ".join(f"{n} {_number(1e3 * v)}" for n, v in zip("XYZ", c, strict=True))
        return {
            "ur": f"set_target_payload({mass}, {place})",
            "kuka": f"{{M {mass}, CM {{{at}, A 0.0, B 0.0, C 0.0}}}}",
            "xarm": f"set_tcp_load({mass}, {_list(1e3 * c)})",
        }
    six = (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    ur = f"set_target_payload({mass}, {place}, {_list(six)})"
    moments, axes = load.principal()
    roll, pitch, yaw = np.degrees(lie.rpy_from_rotation(axes))
    frame = (*(1e3 * c), yaw, pitch, roll)
    named = ", ".join(f"{n} {_number(v)}" for n, v in zip("XYZABC", frame, strict=True))
    main = ", ".join(f"{n} {_number(v)}" for n, v in zip("XYZ", moments, strict=True))
    kuka = f"{{M {mass}, CM {{{named}}}, J {{{main}}}}}"
    franka = f"setLoad({mass}, {_braces(c)}, {_braces(I.T.ravel())})"
    x, y, z, w = lie.quaternion_xyzw(axes)
    ends = ", ".join(_number(v) for v in moments)
    abb = f"[{mass}, {_list(1e3 * c)}, {_list((w, x, y, z))}, {ends}]"
    xarm = f"set_tcp_load({mass}, {_list(1e3 * c)})"
    return {"ur": ur, "kuka": kuka, "franka": franka, "abb": abb, "xarm": xarm}


def urdf_with_load(source: bytes, link: str, loads: Mapping[str, Mapping[str, Any]]) -> bytes:
    """The URDF with a link for each load, fixed to the link that carries the sensor.

    Every byte of the file stays; the new elements come before `</robot>`.

    Args:
        source: the URDF.
        link: its link whose frame is the loads' flange frame.
        loads: name -> mass, com and inertia in that frame.

    Raises:
        InputError: the file does not end in `</robot>`, or has such a link already.
    """
    closing = CLOSING.search(source)
    if closing is None:
        raise InputError("the URDF does not end in </robot>; the load cannot be written into it.")
    added = []
    for name, load in loads.items():
        own = f"payload_{re.sub(r'[^a-zA-Z0-9_]+', '_', name)}"
        if f'name="{own}"'.encode() in source:
            raise InputError(f"the URDF has a link '{own}' already; give the URDF without it.")
        added.append(_link(own, link, load))
    text = "".join(added).encode("utf-8")
    return source[: closing.start()] + text + source[closing.start() :]


def _link(name: str, parent: str, load: Mapping[str, Any]) -> str:
    I = load["inertia"]  # noqa: E741
    six = {"ixx": I[0][0], "ixy": I[0][1], "ixz": I[0][2], "iyy": I[1][1], "iyz": I[1][2]}
    six["izz"] = I[2][2]
    moments = " ".join(f'{key}="{_number(value)}"' for key, value in six.items())
    xyz = " ".join(_number(value) for value in load["com"])
    return (
        f'  <link name="{name}">\n'
        f"    <inertial>\n"
        f'      <origin xyz="{xyz}" rpy="0 0 0"/>\n'
        f'      <mass value="{_number(load["mass"])}"/>\n'
        f"      <inertia {moments}/>\n"
        f"    </inertial>\n"
        f"  </link>\n"
        f'  <joint name="{name}_joint" type="fixed">\n'
        f'    <parent link="{parent}"/>\n'
        f'    <child link="{name}"/>\n'
        f"  </joint>\n"
    )


def _number(value: float) -> str:
    return repr(clean(rounded(float(value), 7) or 0.0))


def _list(values: Any) -> str:
    return "[" + ", ".join(_number(value) for value in values) + "]"


def _braces(values: Any) -> str:
    return "{" + ", ".join(_number(value) for value in values) + "}"


def _short(value: Any) -> Any:
    """Numbers to nine digits, lists and mappings as they are."""
    if isinstance(value, Mapping):
        return {key: _short(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_short(inner) for inner in value]
    return rounded(value) if isinstance(value, float) else value
