"""A run without a robot description: an arrangement, and the columns of its markers."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bodyschema.cli.reading.joint_columns import JointColumns
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.run_file import RunFile
from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.model.arrangement import Arrangement


def skeleton_run(skeleton: Path, recording: Sequence[Path], joint_unit: str) -> RunFile:
    """The run of an arrangement and a recording; the senses are still to be named.

    Raises:
        InputError: no recording.
    """
    if not recording:
        raise InputError("give also --recording: the table of joints and markers.")
    return RunFile(
        robot="",
        skeleton=os.path.abspath(skeleton),
        recording=tuple(map(os.path.abspath, recording)),
        joints=JointColumns(unit=joint_unit),
        frames={},
        senses=(),
    )


def marker_senses(
    arrangement: Arrangement, columns: Sequence[str] = (), unit: str = "m"
) -> tuple[SenseEntry, ...]:
    """The senses of an arrangement's markers, each seen as a point.

    Args:
        arrangement: names the markers and the frame that looks.
        columns: three for each marker, in the order of the file; NAME_x, NAME_y, NAME_z when
            empty.
        unit: of the columns.

    Raises:
        InputError: no markers, or another number of columns.
    """
    markers = tuple(arrangement.markers)
    if not markers:
        raise InputError(
            f"{arrangement.name} has no markers, so nothing can be seen of it; "
            'add [markers] with lines like: hand = "wrist".'
        )
    named = tuple(columns) or tuple(f"{marker}_{axis}" for marker in markers for axis in "xyz")
    if len(named) != 3 * len(markers):
        raise InputError(
            f"{arrangement.name} has the markers {', '.join(markers)}, three columns each; "
            f"{len(named)} columns were named."
        )
    return tuple(
        SenseEntry("points", arrangement.looks, marker, named[3 * i : 3 * i + 3], unit)
        for i, marker in enumerate(markers)
    )
