"""Joint readings from the columns of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.sources.recording import Recording

if TYPE_CHECKING:
    from bodyschema.cli.reading.run_entries import JointColumns

Array = NDArray[np.float64]


def column_of(joint: str, joints: JointColumns) -> str:
    """The column that a joint is read from."""
    return joints.columns.get(joint, joint)


def read_joints(
    body: Body, recording: Recording, joints: JointColumns, pattern: str = "{joint}"
) -> Array:
    """(n_rows, n_joints) in rad and m; zero for joints that were not recorded.

    Args:
        body: whose joints.
        recording: the table.
        joints: names and unit of the columns.
        pattern: of the names, such as "speed_{joint}"; then the unit is per second.

    Raises:
        InputError: a joint is named that the body does not have, or a cell is empty.
    """
    for joint in joints.columns:
        body.joint_index(joint)
    q = np.zeros((len(recording), len(body.joints)))
    for j, joint in enumerate(body.joints):
        column = pattern.replace("{joint}", column_of(joint, joints))
        if column in recording.columns or joint in joints.columns:
            revolute = np.any(body.kind[body.driver == j] == REVOLUTE)
            values, present = recording.matrix([column], joints.unit if revolute else "m")
            if not present.all():
                row = int(np.flatnonzero(~present)[0])
                raise InputError(f"column '{column}' of {recording.source} is empty in row {row}.")
            q[:, j] = values[:, 0]
    return q


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
            f'{{ {missing[0]} = "..." }}.'
        )
