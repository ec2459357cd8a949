"""Evidence: what all sections are drawn from, with the numbers that several of them need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.agreement import within_prediction
from bodyschema.estimation.held_out import sizes
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.problem import moved_joints
from bodyschema.judging.calibration import Calibration
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

AGREES = 0.9
"""Share of held-out errors within their 95 % bounds from which the prediction is believed."""


@dataclass(frozen=True)
class Evidence:
    """A calibration with what it was made from."""

    calibration: Calibration
    nominal: Body
    """As described, without the frames that were attached."""
    senses: tuple[Sense, ...]
    run: Mapping[str, Any]
    """What was asked: run.json, and the "command" if there was one."""

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joints between the frames of the senses."""
        return moved_joints(self.calibration.body, self.senses)

    @cached_property
    def good(self) -> tuple[Bools, ...]:
        """(n,) a sense: the samples whose rows are no outliers; all where there are no others."""
        bad = [np.isin(sense.rows, self.calibration.outliers) for sense in self.senses]
        return tuple(~mask | mask.all() for mask in bad)

    def errors(self, component: str) -> list[tuple[Array, Array]]:
        """Lengths of one component before and after, (n,) each, sense by sense; empty without."""
        before, after = self.calibration.nominal_residuals, self.calibration.residuals
        return [
            (sizes(sense, old, component), sizes(sense, new, component))
            for sense, old, new in zip(self.senses, before, after, strict=True)
        ]

    @cached_property
    def within(self) -> tuple[dict[str, float], ...]:
        """Share of each sense's held-out errors within their 95 % bounds, noise included.

        By component; the rows that are no outliers.
        """
        fit = self.calibration.fit
        freedom = fit.freedom or (Loss().freedom,) * len(self.senses)
        found = []
        for i, sense in enumerate(self.senses):
            residual, good = self.calibration.residuals[i], self.good[i]
            inside = within_prediction(fit, sense, fit.levels[i], residual, freedom[i])
            found.append({k: float(v[good].mean()) for k, v in inside.items() if len(good)})
        return tuple(found)

    def label(self, sense: Sense, component: str) -> str:
        """What was seen, with the component where the sense has several."""
        return f"{sense.label}: {component}" if len(sense.components) > 1 else sense.label

    @property
    def agrees(self) -> bool:
        """Whether the held-out errors are about as small as predicted."""
        return float(np.mean(self.shares or [1.0])) >= AGREES

    @property
    def shares(self) -> list[float]:
        """Shares within their bounds, one for each component of each sense."""
        return [share for shares in self.within for share in shares.values()]


def spread(values: Array, most: int) -> Array:
    """Evenly spaced rows of an array, so many at most."""
    rows = np.linspace(0, len(values) - 1, min(len(values), most)).astype(int)
    return np.asarray(values[rows])
