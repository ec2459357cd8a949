"""Have two independent beliefs of the same numbers a common truth? A test part by part.

With d the difference and C the sum of their covariances, for the numbers B of one part

    T_B = d_B^T C_BB^-1 d_B

is chi-square of as many degrees of freedom if nothing has changed. The smallest p-value times the
number of parts is compared with the allowed rate of false alarms (Bonferroni). Errors that both
beliefs share (a lens, a sensor's scale) are counted twice in C, so alarms are rarer than allowed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from bodyschema.monitoring.change import ChangeTest
from bodyschema.monitoring.moved_part import Suspect

Array = NDArray[np.float64]


def two_beliefs(
    change: Array,
    covariance: Array,
    parts: Mapping[str, Sequence[int]],
    names: Sequence[str],
    false_alarm: float,
) -> ChangeTest:
    """Test a difference.

    Args:
        change: (n,) new less old.
        covariance: (n, n) of it, both beliefs' together.
        parts: rows of each part that may have changed on its own.
        names: (n,) of the numbers.
        false_alarm: chance of calling what is unchanged changed.

    Returns:
        The test; every part beyond the rate is a suspect, the clearest first. Nothing is a
        position, so `position_rms` is not a number.
    """
    suspects = []
    for part, rows in parts.items():
        d, C = change[list(rows)], covariance[np.ix_(rows, rows)]
        T = float(d @ np.linalg.solve(C, d))
        suspects.append(
            Suspect(part, float(chdtrc(len(d), T)), T - len(d), d, tuple(names[i] for i in rows))
        )
    p_value = min(1.0, len(suspects) * min(suspect.p_value for suspect in suspects))
    guilty = [s for s in suspects if s.p_value * len(suspects) < false_alarm]
    ranked = tuple(sorted(guilty, key=lambda suspect: suspect.p_value))
    return ChangeTest(bool(ranked), p_value, ranked, float("nan"))
