"""Rows to look at: outliers with their errors, and the test of the clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bodyschema.learning.clock import FALSE_ALARM
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.report.units import listed, shown

MOST_ROWS = 40


class Row(NamedTuple):
    """One sample of an outlier row as it is shown."""

    row: str
    time: str
    what: str
    errors: tuple[str, ...]
    """Before, after, and after in units of the noise."""


@dataclass(frozen=True)
class BadRows:
    """A table of the outliers, the worst first, and the verdict on the clocks."""

    evidence: Evidence
    title: str = "Rows to look at"

    def render(self) -> str:
        """See `Section`."""
        c = self.evidence.calibration
        rows = self._rows()
        return render(
            "bad_rows.html",
            rows=rows[:MOST_ROWS],
            left_out=max(len(rows) - MOST_ROWS, 0),
            count=len(c.outliers),
            total=c.n_rows,
            faulty=c.clock.faulty,
            p_value=f"{c.clock.p_value:.2g}",
            limit=FALSE_ALARM,
            late=listed(c.clock.late_rows, 60),
        )

    def _rows(self) -> list[Row]:
        """Samples of outlier rows: row, time, what was seen, errors, times the noise."""
        evidence, found = self.evidence, []
        for i, sense in enumerate(evidence.senses):
            levels = evidence.calibration.fit.levels[i]
            for (name, unit, part), level in zip(sense.components, levels, strict=True):
                noise = level * np.sqrt(np.sum(np.diag(sense.covariance)[part]))
                before, after = evidence.errors(name)[i]
                for k in np.flatnonzero(~evidence.good[i]):
                    times = float(after[k] / noise)
                    errors = (shown(before[k], unit), shown(after[k], unit), f"{times:.0f}")
                    row, time = f"{sense.rows[k]}", f"{sense.time[k]:g}"
                    found.append((times, Row(row, time, f"{sense.label}: {name}", errors)))
        return [row for _, row in sorted(found, key=lambda pair: -pair[0])]
