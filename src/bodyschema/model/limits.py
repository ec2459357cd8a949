"""Limits of joints that a recording contradicts.

Exporters that do not know a joint's range write lower = upper = 0, and a <limit> without lower and
upper means the same. A joint that was recorded elsewhere is not locked there: its limits are
unknown, and the range that was recorded is all that is known to be in reach.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.tree import Body

NO_RANGE = 1e-3
"""rad or m: a joint that may move by no more is locked by its limits; encoders resolve less."""


def contradicted_limits(body: Body, recorded: ArrayLike) -> NDArray[np.bool_]:
    """Joints that were recorded beyond limits which leave them no range, (n_joints,).

    Args:
        body: with limits.
        recorded: (n, n_joints) readings, rad and m.
    """
    q = np.asarray(recorded, dtype=np.float64).reshape(-1, len(body.joints))
    if not len(q):
        return np.zeros(len(body.joints), dtype=bool)
    locked = body.upper - body.lower <= NO_RANGE
    beyond = np.maximum(body.lower - q.min(axis=0), q.max(axis=0) - body.upper)
    return np.asarray(locked & (beyond > NO_RANGE))


def with_recorded_limits(body: Body, recorded: ArrayLike) -> Body:
    """The body with the recorded ranges in place of limits that they contradict, and a remark.

    Args:
        body: with limits.
        recorded: (n, n_joints) readings, rad and m.
    """
    wrong = contradicted_limits(body, recorded)
    if not wrong.any():
        return body
    q = np.asarray(recorded, dtype=np.float64)
    names = ", ".join(np.array(body.joints)[wrong])
    remark = (
        f"The limits of {names} leave no range, yet these joints were recorded elsewhere: they "
        "count as unknown, and nothing is asked for beyond what was recorded. Write the real "
        "limits into the robot description."
    )
    return replace(
        body,
        lower=np.where(wrong, q.min(axis=0), body.lower),
        upper=np.where(wrong, q.max(axis=0), body.upper),
        remarks=(*body.remarks, remark),
    )
