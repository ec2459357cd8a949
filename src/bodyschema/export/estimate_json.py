"""estimate.json: the belief of a calibration, whole, so that a later run can go on from it.

It holds the reference body (frames of the run file included), the parameters with their chart, the
mean, the information of the data and the noise levels, all at full precision.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.calibration import Calibration
from bodyschema.errors import InputError
from bodyschema.estimation.discrepancy import Field
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

FORM = 1
"""Version of the file's form."""


@dataclass(frozen=True)
class StoredResult:
    """What a result folder says of the robot."""

    estimate: Estimate
    """Reference body, parameters, belief and noise levels."""
    run: dict[str, Any]
    """The run as it was asked, from run.json."""
    verdict: str
    fields: dict[str, Field]
    """Residual field of each sense by its label."""

    @property
    def body(self) -> Body:
        """The corrected body, frames of the run file included."""
        return self.estimate.body


def estimate_text(calibration: Calibration) -> str:
    """The file's text."""
    estimate = calibration.estimate
    document = {
        "form": FORM,
        "verdict": calibration.verdict,
        "reference": _arrays(estimate.reference, skip=("visuals",)),
        "parameters": _arrays(estimate.variables),
        "x": estimate.x.tolist(),
        "data_information": estimate.data_information.tolist(),
        "noise": dict(estimate.noise or {}),
        "fields": {
            sense: {name: getattr(field, name) for name in ("length", "amplitude", "noise")}
            for sense, field in calibration.fields.items()
        },
    }
    return json.dumps(document) + "\n"


def read_result(folder: Path) -> StoredResult:
    """Read a result folder back.

    Raises:
        InputError: it is no result folder, or not of this version.
    """
    path = folder / "estimate.json"
    if not path.is_file():
        raise InputError(f"no estimate.json in '{folder}'; name a folder that calibrate wrote.")
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        run = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        estimate = Estimate(
            reference=Body(**_values(Body, document["reference"])),
            variables=Variables(**_values(Variables, document["parameters"])),
            x=np.array(document["x"], dtype=np.float64),
            data_information=np.array(document["data_information"], dtype=np.float64),
            noise=document["noise"],
        )
        stored = {name: Field(**values) for name, values in document["fields"].items()}
        return StoredResult(estimate, run, document["verdict"], stored)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"'{path}' cannot be read ({type(error).__name__}: {error}); calibrate again."
        ) from None


def _arrays(record: Any, skip: tuple[str, ...] = ()) -> dict[str, Any]:
    """Fields of a frozen record in plain lists."""
    plain = {}
    for field in fields(record):
        if field.name not in skip:
            value = getattr(record, field.name)
            plain[field.name] = value.tolist() if isinstance(value, np.ndarray) else value
    return plain


def _values(kind: type, stored: dict[str, Any]) -> dict[str, Any]:
    """Fields as the record wants them: tuples of names, arrays of numbers."""
    values: dict[str, Any] = {}
    for field in fields(kind):
        if field.name not in stored:
            continue
        value = stored[field.name]
        if field.type == "tuple[str, ...]":
            values[field.name] = tuple(value)
        elif field.type == "Ints":
            values[field.name] = np.array(value, dtype=np.int64)
        elif field.type == "Array":
            values[field.name] = np.array(value, dtype=np.float64)
        else:
            values[field.name] = value
    return values
