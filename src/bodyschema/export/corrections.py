"""Reading the joint corrections of a result back from its calibration.yaml."""

from __future__ import annotations

from pathlib import Path

import yaml

from bodyschema.errors import InputError


def read_corrections(result: Path) -> dict[str, float]:
    """Deviations of the joints' parameters by name, rad or m; frames are left out.

    Args:
        result: the folder that `calibrate` wrote, or its calibration.yaml.

    Raises:
        InputError: there is no calibration, it is something else, or it was refused.
    """
    path = result / "calibration.yaml" if result.is_dir() else result
    if not path.is_file():
        raise InputError(
            f"no calibration.yaml in '{result}'; name the folder that calibrate wrote."
        )
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
        verdict, parameters = document["verdict"], document["parameters"]
        corrections = {
            str(entry["name"]): float(entry["value"])
            for entry in parameters
            if not str(entry["group"]).startswith("frame:")
        }
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"'{path}' is no calibration ({type(error).__name__}); calibrate again."
        ) from None
    if verdict == "refused":
        raise InputError(f"the calibration in '{path}' was refused; there is nothing to export.")
    return corrections
