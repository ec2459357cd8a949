"""Joint readings from the columns of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.joint_columns import PERCENT
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.sources.motors import GRIPPER, TICKS, motor_name, motor_of
from bodyschema.sources.motors import UNITS as MOTOR_UNITS
from bodyschema.sources.recording import UNITS, Recording

if TYPE_CHECKING:
    from bodyschema.cli.reading.joint_columns import JointColumns

Array = NDArray[np.float64]

ANGLES, LENGTHS = ("rad", "mrad", "deg"), ("m", "cm", "mm", "um", "in")


def column_of(joint: str, joints: JointColumns) -> str:
    """The column that a joint is read from."""
    return joints.of(joint).column


def read_joints(
    body: Body, recording: Recording, joints: JointColumns, pattern: str = "{joint}"
) -> Array:
    """(n_rows, n_joints) in rad and m; zero for joints that were not recorded.

    Args:
        body: whose joints.
        recording: the table.
        joints: names, units, signs and zeros of the columns.
        pattern: of the names, such as "speed_{joint}"; then the unit is per second, and zeros and
            limits count for nothing.

    Raises:
        InputError: a joint is named that the body does not have, or a cell is empty.
    """
    for joint in joints.named:
        body.joint_index(joint)
    q = np.zeros((len(recording), len(body.joints)))
    for j, joint in enumerate(body.joints):
        column = pattern.replace("{joint}", column_of(joint, joints))
        if column in recording.columns or joint in joints.named:
            values, present = recording.matrix([column], "1")
            if not present.all():
                row = int(np.flatnonzero(~present)[0])
                raise InputError(f"column '{column}' of {recording.source} is empty in row {row}.")
            one = conversion(body, j, joints)
            q[:, j] = one.rate(values[:, 0]) if pattern != "{joint}" else one.reading(values[:, 0])
    return q


@dataclass(frozen=True)
class Conversion:
    """From the numbers of a column to readings of a joint, and back."""

    size: float
    """What one in the column is, rad or m, with its sign."""
    zero: float
    """The number at which the joint is at `middle`."""
    middle: float = 0.0
    """rad or m"""
    ends: tuple[float, float] = (-np.inf, np.inf)
    """At these numbers and beyond the column is cut off."""

    def reading(self, values: Array) -> Array:
        """Readings, (n,) rad or m."""
        return np.asarray(self.middle + self.size * (values - self.zero))

    def rate(self, values: Array) -> Array:
        """Readings of speeds, (n,) rad/s or m/s; zeros and limits count for nothing."""
        return np.asarray(self.size * values)

    def column(self, readings: Array) -> Array:
        """The numbers that are read so, (n,)."""
        return np.asarray(self.zero + (readings - self.middle) / self.size)

    def cut_off(self, values: Array) -> NDArray[np.bool_]:
        """(n,) where the joint may have been beyond what was recorded."""
        return np.asarray((values <= self.ends[0]) | (values >= self.ends[1]))


def conversion(body: Body, joint: int, joints: JointColumns) -> Conversion:
    """How a joint is read from its column.

    Raises:
        InputError: a unit that is none, percent of no limits, or no motor of that name.
    """
    name = body.joints[joint]
    entry = joints.of(name)
    if joints.motors and not entry.unit:
        return _of_motor(body, joint, joints)
    middle, size = _unit(body, joint, entry.unit or joints.unit, bool(entry.unit))
    return Conversion(entry.sign * entry.scale * size, entry.zero, middle)


def _of_motor(body: Body, joint: int, joints: JointColumns) -> Conversion:
    """A joint whose motor stands in LeRobot's calibration."""
    name, unit = body.joints[joint], PERCENT[0] if joints.unit in PERCENT else joints.unit
    entry = joints.of(name)
    if unit not in MOTOR_UNITS:
        raise InputError(
            f"unit = '{joints.unit}' under [joints] beside a LeRobot calibration; its columns are "
            f"in {', '.join(MOTOR_UNITS)}."
        )
    if not _turns(body, joint):
        raise InputError(
            f"joint '{name}' slides, and a motor turns; give the joint a unit and a scale of its "
            f"own under [joints.{name}]."
        )
    motor, gripper = motor_of(entry.column, joints.motors), motor_name(entry.column) == GRIPPER
    degrees, zero = motor.degrees(unit, gripper)
    size = entry.sign * entry.scale * degrees * UNITS["deg"]
    return Conversion(size, zero + entry.zero, 0.0, motor.ends(unit, gripper))


def cut_off(body: Body, recording: Recording, joints: JointColumns) -> NDArray[np.bool_]:
    """(n_rows, n_joints) where a joint's column is at an end at which it is cut off."""
    found = np.zeros((len(recording), len(body.joints)), dtype=bool)
    for j, joint in enumerate(body.joints):
        column = column_of(joint, joints)
        if joints.motors and column in recording.columns:
            found[:, j] = conversion(body, j, joints).cut_off(recording.columns[column])
    return found


def _turns(body: Body, joint: int) -> bool:
    return bool(np.any(body.kind[body.driver == joint] == REVOLUTE))


def _unit(body: Body, joint: int, unit: str, own: bool) -> tuple[float, float]:
    """Where 0 of a unit lies and what one of it is, rad or m.

    The unit of a whole section is that of angles: sliding joints are in m, unless they say
    otherwise themselves or all are in percent.
    """
    name = body.joints[joint]
    if unit in PERCENT:
        low, high = body.lower[joint], body.upper[joint]
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise InputError(
                f"joint '{name}' is recorded in percent of its limits, and {body.name} has none "
                f"for it; write them there, or a scale and a zero under [joints.{name}]."
            )
        return float(low + high) / 2, float(high - low) / 200
    revolute = _turns(body, joint)
    if not revolute and not own:
        return 0.0, 1.0
    if unit == TICKS:
        raise InputError(
            f"joint '{name}' is in ticks, and nothing says how many are a turn; name LeRobot's "
            'file, [joints] calibration = "arm.json", or give a scale and a zero under '
            f"[joints.{name}]."
        )
    allowed = (ANGLES if revolute else LENGTHS) if own else tuple(UNITS)
    if unit not in allowed:
        whose = f" of joint '{name}'" if own else ""
        raise InputError(f"unknown unit '{unit}'{whose}{did_you_mean(unit, (*allowed, *PERCENT))}")
    return 0.0, UNITS[unit]


def refuse_missing(
    body: Body, recording: Recording, joints: JointColumns, needed: Sequence[str]
) -> None:
    """Joints between the frames must have been recorded.

    Raises:
        InputError: one was not.
    """
    missing = [j for j in needed if column_of(j, joints) not in recording.columns]
    if missing:
        unused = [c for c in recording.columns if c not in body.joints]
        raise InputError(
            f"no column for joint {', '.join(missing[:6])} in {recording.source}"
            f"{did_you_mean(missing[0], unused)} Name it under [joints] columns = "
            f'{{ {missing[0]} = "..." }}, or where the joints have a file of their own rate name '
            'that in recording and set join = "time".'
        )
