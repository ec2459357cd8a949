"""Rows to look at: outliers with their errors, and the test of the clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bodyschema.estimation.clock import FALSE_ALARM
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.units import listed, shown

MOST_ROWS = 40
MOST_GOOD = 5


class Row(NamedTuple):
    """One row of the recording as it is shown."""

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
        bad = [row for row in self._rows() if int(row.row) in c.outliers]
        good = [row for row in self._rows() if int(row.row) not in c.outliers]
        return render(
            "bad_rows.html",
            rows=bad[:MOST_ROWS],
            left_out=max(len(bad) - MOST_ROWS, 0),
            count=len(c.outliers),
            total=c.n_rows,
            clocked=any(np.any(sense.time != sense.rows) for sense in self.evidence.senses),
            largest=listed([f"{row.row} ({row.errors[1]})" for row in good[:MOST_GOOD]], MOST_GOOD),
            faulty=c.clock.faulty,
            p_value=f"{c.clock.p_value:.2g}",
            limit=FALSE_ALARM,
            late=listed(c.clock.late_rows, 60),
        )

    def _rows(self) -> list[Row]:
        """Every row by the sample that is furthest off in units of the noise, the worst first."""
        evidence, worst = self.evidence, dict[int, tuple[float, Row]]()
        for i, sense in enumerate(evidence.senses):
            levels = evidence.calibration.fit.levels[i]
            for (name, unit, part), level in zip(sense.components, levels, strict=True):
                noise = level * np.sqrt(np.sum(np.diag(sense.covariance)[part]))
                before, after = evidence.errors(name)[i]
                for k, row in enumerate(sense.rows.tolist()):
                    times = float(after[k] / noise)
                    if row in worst and times <= worst[row][0]:
                        continue
                    errors = (shown(before[k], unit), shown(after[k], unit), f"{times:.0f}")
                    time, label = f"{sense.time[k]:g}", evidence.label(sense, name)
                    worst[row] = times, Row(str(row), time, label, errors)
        return [row for _, row in sorted(worst.values(), key=lambda pair: -pair[0])]
