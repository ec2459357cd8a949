"""Residuals: the error of every sample, and its spread along every axis, before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.report.evidence import Evidence, spread
from bodyschema.report.figure import AFTER, BEFORE, INK, MOST_DOTS, log_scale, new_figure, svg
from bodyschema.report.page import render
from bodyschema.units import read_as, significant, with_error

Array = NDArray[np.float64]

SMALLEST = {"m": 1e-7, "rad": 1e-8, "1": 1e-9}
SMALLEST_OTHER = 1e-6
"""Smaller errors are drawn as this: a logarithmic axis has no zero."""
MOST_PANELS = 6
MOST_NAMED = 8
"""Outliers whose row numbers are written beside them."""
WIDTH = 840


@dataclass(frozen=True)
class Panel:
    """One component of one sense."""

    title: str
    unit: str
    rows: NDArray[np.int64]
    before: Array
    after: Array
    bad: NDArray[np.bool_]

    @property
    def words(self) -> str:
        """What it tells, with its figures."""
        good = ~self.bad | self.bad.all()
        worst = np.argmax(np.where(good, self.after, -np.inf))
        old, new = (significant(float(np.median(e[good]))) for e in (self.before, self.after))
        count = int(self.bad.sum())
        left_out = f"; {count} outlier row{'s' * (count > 1)} besides" if count > 0 else ""
        return (
            f"{self.title}: the median error was {old} {self.unit} before and is {new} "
            f"{self.unit} after; the largest after is {significant(float(self.after[worst]))} "
            f"{self.unit}, in row {self.rows[worst]}{left_out}."
        )


@dataclass(frozen=True)
class Residuals:
    """Charts of every sample and every axis."""

    evidence: Evidence
    title: str = "Residuals"

    def render(self) -> str:
        """See `Section`."""
        panels = self.panels()
        drawn = sorted(panels, key=lambda p: -float(p.after.max(initial=0)))[:MOST_PANELS]
        kept = [panel for panel in panels if any(panel is other for other in drawn)]
        return render(
            "residuals.html",
            samples=[_samples(k, panel) for k, panel in enumerate(kept)],
            left_out=len(panels) - len(kept),
            thinned=max(len(panel.rows) for panel in kept) > MOST_DOTS,
            axes=[self._axes(*key) for key in self._frames()],
            outliers=bool(self.evidence.calibration.outliers),
        )

    def panels(self) -> list[Panel]:
        """One for each component of each sense."""
        evidence, panels = self.evidence, []
        for i, sense in enumerate(evidence.senses):
            for name, unit, _ in sense.components:
                before, after = (
                    np.maximum(e, SMALLEST.get(unit, SMALLEST_OTHER)) * read_as(unit)[0]
                    for e in evidence.errors(name)[i]
                )
                panels.append(
                    Panel(evidence.label(sense, name), read_as(unit)[1], sense.rows, before, after,
                          ~evidence.good[i])
                )  # fmt: skip
        return [panel for panel in panels if len(panel.rows)]

    def _frames(self) -> list[tuple[str, str, str]]:
        """(frame, component, unit) that residuals are given in, each once."""
        found = {
            (sense.seen_from, name, unit): None
            for sense in self.evidence.senses
            for name, unit, part in sense.components
            if part.stop - part.start == 3
        }
        return list(found)

    def _axes(self, frame: str, component: str, unit: str) -> str:
        before, after = self._along(frame, component)
        scale, word = read_as(unit)
        left = [" ± ".join(pair) for pair in zip(*_told(scale * after), strict=True)]
        were = [" ± ".join(pair) for pair in zip(*_told(scale * before), strict=True)]
        says = (
            f"Residuals of the {component} along x, y and z of {frame}, mean and standard "
            f"deviation: {'; '.join(left)} {word}; before {'; '.join(were)} {word}."
        )
        return svg(
            f"axes-{frame}-{component}", says, (WIDTH, 215),
            lambda figure: _draw_axes(
                figure, f"{component}, in {frame}", word, scale * before, scale * after
            ),
        )  # fmt: skip

    def _along(self, frame: str, component: str) -> tuple[Array, Array]:
        """Residuals of all senses from one frame, without the outliers, (n, 3) each."""
        c, parts = self.evidence.calibration, []
        for i, sense in enumerate(self.evidence.senses):
            for name, _, part in sense.components:
                if (sense.seen_from, name) == (frame, component):
                    good = self.evidence.good[i]
                    before, after = c.nominal_residuals[i], c.residuals[i]
                    parts.append((before[good][:, part], after[good][:, part]))
        before, after = (np.concatenate(side) for side in zip(*parts, strict=True))
        return before, after


def residual_figure(evidence: Evidence) -> Any:
    """The errors of every sample before and after as a matplotlib Figure.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    panels = Residuals(evidence).panels()
    return new_figure((WIDTH, 40 + 175 * len(panels)), lambda figure: _draw_samples(figure, panels))


def _samples(k: int, panel: Panel) -> str:
    """The chart of one panel; the first has the legend."""

    def paint(figure: Any) -> None:
        _draw_samples(figure, [panel], legend=k == 0)

    return svg(f"samples-{k}", panel.words, (WIDTH, 215 if k == 0 else 190), paint)


def _told(values: Array) -> tuple[list[str], list[str]]:
    """Means and standard deviations of the columns, as text."""
    pairs = [with_error(float(np.mean(v)), float(np.std(v))) for v in values.T]
    return [mean for mean, _ in pairs], [std for _, std in pairs]


def _draw_samples(figure: Any, panels: list[Panel], legend: bool = True) -> None:
    panes = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
    for axes, panel in zip(panes, panels, strict=True):
        shown = spread(np.arange(len(panel.rows), dtype=np.float64), MOST_DOTS).astype(int)
        shown = np.union1d(shown, np.flatnonzero(panel.bad)[:MOST_DOTS])
        rows = panel.rows[shown]
        axes.plot(rows, panel.before[shown], "o", ms=4.5, mfc="none", mec=BEFORE, label="before")
        axes.plot(rows, panel.after[shown], "o", ms=4.5, mfc=AFTER, mec="none", label="after")
        _ring_outliers(axes, panel)
        axes.margins(y=0.12)
        log_scale(axes, panel.unit)
        axes.set_title(panel.title)
    panes[-1].set_xlabel("row of the recording")
    if legend:
        figure.legend(*panes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3,
                      frameon=False)  # fmt: skip


def _ring_outliers(axes: Any, panel: Panel) -> None:
    bad = np.flatnonzero(panel.bad)
    if not len(bad):
        return
    axes.plot(
        panel.rows[bad], panel.after[bad], "o", ms=10, mfc="none", mec=INK, label="outlier row"
    )
    # The row may be one for what another sense saw.
    gross = bad[panel.after[bad] > panel.after[~panel.bad].max(initial=0.0)]
    for k, i in enumerate(np.sort(gross[np.argsort(-panel.after[gross])][:MOST_NAMED])):
        axes.annotate(
            f"{panel.rows[i]}", (panel.rows[i], panel.after[i]), xytext=(7, 4 if k % 2 else -12),
            textcoords="offset points", fontsize=11,
        )  # fmt: skip


def _draw_axes(figure: Any, title: str, unit: str, before: Array, after: Array) -> None:
    """Quantiles of each axis as bars: 90 % thin, half of the samples thick, the median a dot."""
    axes = figure.subplots()
    axes.axvline(0, color=INK, lw=0.8)
    places = []
    for k in range(3):
        for shift, values, colour in ((-0.17, before, BEFORE), (0.17, after, AFTER)):
            low, q1, middle, q3, high = np.quantile(values[:, k], [0.05, 0.25, 0.5, 0.75, 0.95])
            axes.plot([low, high], [k + shift] * 2, color=colour, lw=2)
            axes.plot([q1, q3], [k + shift] * 2, color=colour, lw=8, solid_capstyle="butt")
            axes.plot(middle, k + shift, "o", ms=5, mfc="white", mec=INK, mew=1)
            texts = with_error(float(np.mean(values[:, k])), float(np.std(values[:, k])))
            places.append((k + shift, " ± ".join(texts), colour))
    for height, text, colour in places:
        axes.annotate(text, (1.01, height), xycoords=("axes fraction", "data"), va="center",
                      fontsize=11, color=colour, annotation_clip=False)  # fmt: skip
    axes.annotate(f"mean ± std, {unit}", (1.01, -0.62), xycoords=("axes fraction", "data"),
                  va="center", fontsize=11, annotation_clip=False)  # fmt: skip
    axes.set(yticks=range(3), yticklabels=list("xyz"), ylim=(2.45, -0.75), title=title)
    axes.set_xlabel(f"seen minus predicted, {unit}")
    axes.grid(axis="y", visible=False)
