"""Coverage: how much of each joint's range the recording has seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.report.evidence import Evidence
from bodyschema.report.figure import AFTER, GREY, INK, RANGE, SPAN, svg
from bodyschema.report.joint_space import joint_unit
from bodyschema.report.page import render
from bodyschema.report.residuals import WIDTH
from bodyschema.units import listed

Array = NDArray[np.float64]

MOST_A_CHART = 12
"""Joints of one chart; a taller one would leave half a printed page empty."""
NARROW = 0.3
"""Share of its range below which a joint is called little moved."""


@dataclass(frozen=True)
class Span:
    """One joint: limits and readings in the unit that is shown."""

    joint: str
    unit: str
    low: float
    high: float
    limited: bool
    quantiles: Array
    """Least, first quartile, median, third quartile, largest."""

    @property
    def share(self) -> float:
        """Of the range between the limits that was seen."""
        return float((self.quantiles[4] - self.quantiles[0]) / max(self.high - self.low, 1e-12))

    @property
    def words(self) -> str:
        """What was seen, with its figures."""
        least, most = self.quantiles[[0, 4]]
        of = f", {100 * self.share:.0f} % of its range" if self.limited else ""
        return f"{self.joint} from {least:.0f} to {most:.0f} {self.unit}{of}"


@dataclass(frozen=True)
class Coverage:
    """Range bars of all joints between the frames."""

    evidence: Evidence
    title: str = "Coverage of joint space"

    def render(self) -> str:
        """See `Section`."""
        spans = [self._span(joint) for joint in self.evidence.joints]
        units = list(dict.fromkeys(span.unit for span in spans))
        parts = [
            [span for span in spans if span.unit == unit][first : first + MOST_A_CHART]
            for unit in units
            for first in range(0, sum(span.unit == unit for span in spans), MOST_A_CHART)
        ]
        charts = [self._chart(f"coverage-{k}", part) for k, part in enumerate(parts)]
        narrow = [span.joint for span in spans if span.share < NARROW]
        return render("coverage.html", charts=charts, narrow=listed(narrow, 12), limit=100 * NARROW)

    def _span(self, joint: str) -> Span:
        body = self.evidence.calibration.body
        j = body.joint_index(joint)
        scale, unit = joint_unit(self.evidence, joint)
        readings = np.concatenate([sense.q[:, j] for sense in self.evidence.senses])
        quantiles = scale * np.quantile(readings, [0, 0.25, 0.5, 0.75, 1])
        limited = bool(np.isfinite(body.lower[j]) and np.isfinite(body.upper[j]))
        reach = 180.0 if unit == "deg" else 500.0
        low, high = (scale * body.lower[j], scale * body.upper[j]) if limited else (-reach, reach)
        return Span(joint, unit, float(low), float(high), limited, quantiles)

    def _chart(self, name: str, spans: list[Span]) -> str:
        def paint(figure: Any) -> None:
            axes = figure.subplots()
            for k, span in enumerate(spans):
                _draw_span(axes, k, span)
            axes.set(ylim=(len(spans) - 0.5, -0.6), xlabel=spans[0].unit)
            axes.set_yticks(range(len(spans)), [span.joint for span in spans])
            axes.grid(axis="y", visible=False)

        size = (WIDTH, 70 + 30 * len(spans))
        return svg(name, f"Seen: {'; '.join(span.words for span in spans)}.", size, paint)


def _draw_span(axes: Any, k: int, span: Span) -> None:
    least, q1, middle, q3, most = span.quantiles
    style = "-" if span.limited else (0, (2, 2))
    axes.plot([span.low, span.high], [k, k], color=RANGE, lw=1.5, ls=style)
    if span.limited:
        axes.plot([span.low, span.high], [k, k], "|", color=GREY, ms=14)
    axes.plot([least, most], [k, k], color=SPAN, lw=6, solid_capstyle="butt")
    axes.plot([q1, q3], [k, k], color=AFTER, lw=11, solid_capstyle="butt")
    axes.plot([middle], [k], "|", color=INK, ms=13, mew=2)
    text = f"{100 * span.share:.0f} %" if span.limited else f"{most - least:.0f} {span.unit}"
    axes.annotate(text, (1.01, k), xycoords=("axes fraction", "data"), va="center", fontsize=11,
                  annotation_clip=False)  # fmt: skip
