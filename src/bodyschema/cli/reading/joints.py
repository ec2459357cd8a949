"""Joint readings from the columns of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.joint_columns import PERCENT
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.tree import Body
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
        entry = joints.of(joint)
        column = pattern.replace("{joint}", entry.column)
        if column in recording.columns or joint in joints.named:
            values, present = recording.matrix([column], "1")
            if not present.all():
                row = int(np.flatnonzero(~present)[0])
                raise InputError(f"column '{column}' of {recording.source} is empty in row {row}.")
            middle, size = _unit(body, j, entry.unit or joints.unit, bool(entry.unit))
            moved = pattern != "{joint}"
            zero, middle = (0.0, 0.0) if moved else (entry.zero, middle)
            q[:, j] = middle + entry.sign * entry.scale * size * (values[:, 0] - zero)
    return q


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
    revolute = bool(np.any(body.kind[body.driver == joint] == REVOLUTE))
    if not revolute and not own:
        return 0.0, 1.0
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
