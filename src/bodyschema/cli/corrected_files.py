"""A recording or a calibration file of LeRobot, written again with the corrections of a result."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.atomic import new_file
from bodyschema.cli.reading.corrected_joints import CorrectedJoints, with_motors
from bodyschema.cli.reading.joint_columns import JointColumns, joint_columns
from bodyschema.documents import json_file
from bodyschema.errors import InputError
from bodyschema.sources.motors import read_motors
from bodyschema.sources.parquet import parquet_table
from bodyschema.sources.tables import WRITERS, open_recording, write_table
from bodyschema.sources.text_table import ENDINGS, text_columns
from bodyschema.units import listed

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer

Array = NDArray[np.float64]

NAMED = 6
"""Columns that a sentence names."""


def write_recording(answer: Answer, recording: Path, out: Path, overwrite: bool) -> dict[str, Any]:
    """Write the same recording with corrected joints; returns what was done, in plain values.

    Cells of a text table that are not corrected stay as they are written.

    Args:
        answer: of calibrate or track.
        recording: as a run file may name it.
        out: .csv or .parquet.
        overwrite: replace a file that is there.

    Raises:
        InputError: nothing corrects it, or it cannot be read or written.
    """
    if out.suffix.lower() not in WRITERS:
        raise InputError(f"cannot write '{out}'; expected a name ending in .csv or .parquet.")
    corrected = CorrectedJoints.of(answer, _joints(answer))
    table = open_recording(recording)
    columns, notes = corrected.columns(table), list(corrected.notes)
    kind = recording.suffix.lower()
    if kind in ENDINGS and out.suffix.lower() == ".csv":
        _write_cells(text_columns(recording), {**table.columns}, columns, out, overwrite)
    elif kind == ".parquet" and out.suffix.lower() == ".parquet":
        _write_parquet(recording, columns, out, overwrite)
    else:
        write_table(out, {**table.columns, **columns}, overwrite)
        if table.texts:
            left = listed(sorted(table.texts), NAMED)
            notes.append(f"Columns without numbers are not in it: {left}.")
    return {"recording": str(out), "columns": list(columns), "notes": notes}


def write_motors(answer: Answer, calibration: Path, out: Path, overwrite: bool) -> dict[str, Any]:
    """Write LeRobot's calibration with the zeros put right; see `write_recording`."""
    corrected = CorrectedJoints.of(answer, _joints(answer))
    motors = read_motors(calibration)
    slid, notes = corrected.motors(motors)
    document = with_motors(json_file(calibration, "", "no JSON"), slid)
    with new_file(out, overwrite) as temporary:
        temporary.write_text(json.dumps(document, indent=4), encoding="utf-8")
    changed = [name for name in motors if motors[name] != slid[name]]
    notes.append(
        "The ends of these ranges slide with the zeros: let nothing drive a motor into a stop "
        "that now lies within its range."
    )
    return {"calibration": str(out), "motors": changed, "notes": [*corrected.notes, *notes]}


def _joints(answer: Answer) -> JointColumns:
    """How the joints were read in the run."""
    table = answer.run.get("joints")
    if not isinstance(table, Mapping):
        raise InputError(
            "the result does not say how joints were recorded; calibrate from a run file."
        )
    return joint_columns(table, "joints of run.json")


def _write_cells(
    cells: Mapping[str, Sequence[str]],
    numbers: Mapping[str, Array],
    corrected: Mapping[str, Array],
    out: Path,
    overwrite: bool,
) -> None:
    """Write a text table with other numbers in some columns."""
    with new_file(out, overwrite) as temporary, temporary.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(cells)
        texts = []
        for name, column in cells.items():
            if name in corrected:
                texts.append(["" if np.isnan(x) else repr(float(x)) for x in corrected[name]])
            elif name in numbers and any("," in cell for cell in column):  # decimals of commas
                texts.append(["" if np.isnan(x) else repr(float(x)) for x in numbers[name]])
            else:
                texts.append(list(column))
        writer.writerows(zip(*texts, strict=True))


def _write_parquet(
    recording: Path, corrected: Mapping[str, Array], out: Path, overwrite: bool
) -> None:
    """Write a Parquet file with other numbers in some columns."""
    table = parquet_table(recording)
    import pyarrow as pa
    import pyarrow.parquet as pq

    for name, values in corrected.items():
        at = table.column_names.index(name)
        table = table.set_column(at, name, pa.array(values, from_pandas=True))
    with new_file(out, overwrite) as temporary:
        pq.write_table(table, temporary)
