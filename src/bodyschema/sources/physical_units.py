"""Units of wrenches and motions as recordings have them, and what one of each is in SI."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bodyschema.errors import InputError, did_you_mean

POUND, INCH, G = 4.4482216152605, 0.0254, 9.80665

FORCES = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "kgf": G, "gf": 1e-3 * G, "lbf": POUND}
TORQUES = {
    "Nm": 1.0, "mNm": 1e-3, "Ncm": 1e-2, "Nmm": 1e-3, "kgfm": G, "kgfcm": 1e-2 * G,
    "lbfin": POUND * INCH, "lbfft": POUND * 12 * INCH,
}  # fmt: skip
ACCELERATIONS = {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": G, "mg": 1e-3 * G}
SPEEDS = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
TURNS = {"rad/s": 1.0, "deg/s": np.pi / 180, "rpm": np.pi / 30}
TURNINGS = {"rad/s^2": 1.0, "deg/s^2": np.pi / 180}


def factor(unit: str, units: Mapping[str, float]) -> float:
    """What one of the unit is in SI.

    Raises:
        InputError: the unit is none of these.
    """
    if unit not in units:
        raise InputError(f"unknown unit '{unit}'{did_you_mean(unit, units)}")
    return units[unit]
