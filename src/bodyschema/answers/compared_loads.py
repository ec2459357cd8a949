"""What two wrists carry, side by side: mass, centre of mass and moments of inertia.

Offsets and gains of the sensor are each recording's own and no difference of the load.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bodyschema.answers.compared_part import ComparedPart
from bodyschema.answers.recheck import LOAD_NAMES, LOAD_PARTS, load_numbers
from bodyschema.errors import InputError
from bodyschema.model.inertia import Inertia
from bodyschema.monitoring.two_beliefs import two_beliefs

UNITS = ("kg", *["m"] * 3, *["kg m^2"] * 6)


def loads_compared(
    first: Any, second: Any, false_alarm: float
) -> tuple[tuple[ComparedPart, ...], float]:
    """The loads at the end of two recordings, those that differ first, and the chance of it.

    Args:
        first: an answer of `payload` or `touch`.
        second: likewise.
        false_alarm: chance of calling one load two.

    Raises:
        InputError: one of them knows no load.
    """
    (a, A), (b, B) = (_carried(one) for one in (first, second))
    test = two_beliefs(b - a, A + B, LOAD_PARTS, LOAD_NAMES, false_alarm)
    guilty = {suspect.part for suspect in test.suspects}
    every = two_beliefs(b - a, A + B, LOAD_PARTS, LOAD_NAMES, 2.0 * len(LOAD_PARTS)).suspects
    parts = [
        ComparedPart(
            one.part, one.names, tuple(UNITS[i] for i in rows), one.change,
            np.sqrt(np.diag((A + B)[np.ix_(rows, rows)])), (A + B)[np.ix_(rows, rows)],
            float(np.sqrt(max(one.evidence + len(rows), 0.0))),
            min(1.0, one.p_value * len(LOAD_PARTS)), one.part in guilty,
        )
        for one in every for rows in [list(LOAD_PARTS[one.part])]
    ]  # fmt: skip
    return tuple(sorted(parts, key=lambda part: (not part.differs, part.p_value))), test.p_value


def _carried(one: Any) -> Any:
    """Numbers of all that a wrist carried at the end, and their covariance."""
    last = [load for load in one.details.get("loads", ()) if load["name"] in one.details["last"]]
    if not last:
        raise InputError("a result knows of no load, so there is nothing to compare.")
    phi = np.sum([list(load["phi"].values()) for load in last], axis=0)
    return load_numbers(
        Inertia.from_phi(phi), np.sum([load["phi_covariance"] for load in last], axis=0)
    )
