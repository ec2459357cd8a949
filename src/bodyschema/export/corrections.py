"""Reading the joint corrections of a result back: from calibration.yaml, or from track.json."""

from __future__ import annotations

import json
from pathlib import Path

from bodyschema.errors import InputError
from bodyschema.export.calibration_yaml import read_document
from bodyschema.export.static_transforms import PREFIX


def read_corrections(result: Path) -> dict[str, float]:
    """Deviations of the joints' parameters by name, rad or m; frames are left out.

    Args:
        result: the folder that `calibrate` or `track` wrote, or the calibration.yaml.

    Raises:
        InputError: there is no calibration, it is something else, or it was refused.
    """
    if (result / "track.json").is_file():
        return _tracked(result / "track.json")
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


def _tracked(path: Path) -> dict[str, float]:
    """The corrections that `track` decided on."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        lost = bool(document["lost"])
        corrections = {str(k): float(v) for k, v in document["corrections"].items()}
    except (OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"'{path}' is no answer of track ({type(error).__name__}); track again."
        ) from None
    if lost:
        raise InputError(f"the body was not found in '{path.parent}'; there is nothing to export.")
    return corrections
