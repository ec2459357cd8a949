"""Reading the joint corrections of a result back from its calibration.yaml."""

from __future__ import annotations

from pathlib import Path

from bodyschema.errors import InputError
from bodyschema.export.calibration_yaml import read_document
from bodyschema.export.static_transforms import PREFIX


def read_corrections(result: Path) -> dict[str, float]:
    """Deviations of the joints' parameters by name, rad or m; frames are left out.

    Args:
        result: the folder that `calibrate` wrote, or its calibration.yaml.

    Raises:
        InputError: there is no calibration, it is something else, or it was refused.
    """
    document = read_document(result)
    try:
        corrections = {
            str(entry["name"]): float(entry["value"])
            for entry in document["parameters"]
            if not str(entry["group"]).startswith(PREFIX)
        }
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"'{result}' is no calibration ({type(error).__name__}); calibrate again."
        ) from None
    if document["verdict"] == "refused":
        raise InputError(f"the calibration in '{result}' was refused; there is nothing to export.")
    return corrections
