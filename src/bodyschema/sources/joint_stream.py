"""Joint stream: readings at a rate of their own, asked for at the times of another stream.

Between readings a joint runs along the quintic spline through them, whose error falls with the
sixth power of their spacing: a joint that swings once in 8 s, read every 0.8 s, is 0.1 mrad off
where straight lines are 80 and cubics 2 mrad off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

DEGREE = 5

GAPS = 4.0
"""Of the usual spacing: over a longer pause nobody knows what the joints did."""


@dataclass(frozen=True)
class JointStream:
    """Readings of all joints on one clock."""

    source: str
    """Where they came from, for messages."""
    time: Array
    """(n,) s, increasing."""
    q: Array
    """(n, n_joints) rad and m."""
    cut: Flags | None = None
    """(n, n_joints) where a reading was cut off at an end; nowhere when None."""

    def __post_init__(self) -> None:
        if len(self.time) <= DEGREE:
            raise InputError(
                f"{self.source} has {len(self.time)} readings of the joints; to be joined by time "
                f"they must be more than {DEGREE}."
            )

    def at(self, time: Array) -> tuple[Array, Array, Flags]:
        """Readings and their rates at other times.

        Args:
            time: (m,) s on the clock of the joints.

        Returns:
            q (m, n_joints), dq/dt (m, n_joints) per s, and (m,) where both are known: within the
            readings and not in a pause.
        """
        inside = np.clip(time, self.time[0], self.time[-1])
        after = self._after(inside)
        gap = self.time[after] - self.time[after - 1]
        known = (inside == time) & (gap <= GAPS * float(np.median(np.diff(self.time))))
        value, slope = self._spline
        return np.asarray(value(inside)), np.asarray(slope(inside)), np.asarray(known)

    def near_a_cut(self, time: Array) -> Flags:
        """(m, n_joints) where one of the readings next to these times (m,) was cut off."""
        if self.cut is None:
            return np.zeros((len(time), self.q.shape[1]), dtype=bool)
        after = self._after(time)
        return np.asarray(self.cut[after - 1] | self.cut[after])

    def _after(self, time: Array) -> NDArray[np.int64]:
        return np.asarray(np.clip(np.searchsorted(self.time, time), 1, len(self.time) - 1))

    @property
    def speed(self) -> float:
        """How fast the fastest joint usually is, rad/s or m/s."""
        rates = np.diff(self.q, axis=0) / np.diff(self.time)[:, None]
        return float(np.sqrt(np.mean(rates**2, axis=0)).max(initial=0.0))

    @cached_property
    def _spline(self) -> tuple[Any, Any]:
        # The module costs a tenth of a second, which only this way of joining has to pay.
        from scipy.interpolate import make_interp_spline

        value = make_interp_spline(self.time, self.q, k=DEGREE)
        return value, value.derivative()
