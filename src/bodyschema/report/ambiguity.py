"""What cannot be told apart: correlations of what is determined, and the directions left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.judging.places import OPEN, PREFIX
from bodyschema.report.evidence import Evidence
from bodyschema.report.figure import AFTER, BEFORE, INK, PAPER, svg
from bodyschema.report.page import render
from bodyschema.report.residuals import WIDTH
from bodyschema.units import listed

Array = NDArray[np.float64]

MOST_SHOWN = 60
"""Variables of a heat map; more could not be read."""
STRONG = 0.95
MOST_NAMED = 12
LETTER = 7.0
"""CSS pixels that a letter of a name is wide, at most."""


@dataclass(frozen=True)
class Ambiguity:
    """Correlation matrix, picture of the open directions, and their sentences."""

    evidence: Evidence
    title: str = "What cannot be told apart"

    def render(self) -> str:
        """See `Section`."""
        known = self.evidence.calibration.identifiability
        names, matrix = self._correlations()
        return render(
            "ambiguity.html",
            correlations=_heat_map(names, matrix) if len(names) > 1 else "",
            clusters=_clusters(names, matrix),
            strong=STRONG,
            directions=known.directions,
            picture=self._null_space(),
        )

    def _correlations(self) -> tuple[list[str], Array]:
        """Names and correlation matrix of the joint parameters that are determined."""
        calibration = self.evidence.calibration
        variables, known = calibration.estimate.variables, calibration.identifiability
        kept = [
            i
            for i, group in enumerate(variables.groups)
            if known.open_share[i] <= OPEN and not group.startswith((PREFIX, "load:"))
        ][:MOST_SHOWN]
        C = calibration.estimate.covariance[np.ix_(kept, kept)]
        std = np.sqrt(np.diag(C))
        return [variables.names[i] for i in kept], np.asarray(C / np.outer(std, std))

    def _null_space(self) -> str:
        directions = self.evidence.calibration.identifiability.directions
        involved = {name for direction in directions for name in direction.members}
        order = self.evidence.calibration.estimate.variables.names
        names = [name for name in order if name in involved][:MOST_SHOWN]
        if not names:
            return ""

        def paint(figure: Any) -> None:
            axes = figure.subplots()
            for k, direction in enumerate(directions):
                places = [names.index(name) for name in direction.members if name in names]
                colour = INK if direction.inherent else BEFORE
                axes.plot(
                    [min(places, default=0), max(places, default=0)], [k, k], color=colour, lw=1.2
                )
                axes.plot(places, [k] * len(places), "s", ms=9, mfc=colour, mec=PAPER)
            axes.set(xlim=(-0.7, len(names) - 0.3), ylim=(len(directions) - 0.4, -0.6))
            axes.set_yticks(range(len(directions)), range(1, len(directions) + 1))
            _name_axis(axes.xaxis, names)

        width = min(WIDTH, 190 + 26 * len(names))
        height = _room(names) + 50 + 18 * len(directions)
        inherent = sum(direction.inherent for direction in directions)
        says = (
            f"{len(directions)} combinations of {len(names)} parameters are open; no motion closes "
            f"{inherent} of them."
        )
        return svg("null-space", says, (width, height), paint)


def _room(names: list[str]) -> float:
    """CSS pixels that the longest name takes."""
    return LETTER * max(len(name) for name in names)


def _name_axis(axis: Any, names: list[str]) -> None:
    rotation = 90 if axis.axis_name == "x" else 0
    axis.set_ticks(range(len(names)), names, rotation=rotation, fontsize=11)


def _heat_map(names: list[str], matrix: Array) -> str:
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("sign", [BEFORE, PAPER, AFTER])

    def paint(figure: Any) -> None:
        axes = figure.subplots()
        image = axes.imshow(matrix, cmap=colours, vmin=-1, vmax=1, interpolation="none")
        axes.grid(False)
        _name_axis(axes.xaxis, names)
        _name_axis(axes.yaxis, names)
        bar = figure.colorbar(image, ax=axes, shrink=0.6, ticks=[-1, 0, 1])
        bar.outline.set_visible(False)

    side = min(WIDTH - 70, _room(names) + 50 + 28 * len(names))
    return svg("correlations", _strongest(names, matrix), (side + 70, side), paint)


def _strongest(names: list[str], matrix: Array) -> str:
    """What the map tells, with its figures."""
    apart = np.abs(matrix - np.diag(np.diag(matrix)))
    i, k = np.unravel_index(int(np.argmax(apart)), apart.shape)
    strong = int((apart > STRONG).sum()) // 2
    return (
        f"Of {len(names)} joint parameters, {names[i]} and {names[k]} are the most alike, with a "
        f"correlation of {matrix[i, k]:.2f}; {strong} pairs are beyond {STRONG:g}."
    )


def _clusters(names: list[str], matrix: Array) -> list[str]:
    """Variables that are nearly one, together."""
    found: list[list[int]] = []
    for k in range(len(names)):
        joined = [c for c in found if any(abs(matrix[k, other]) > STRONG for other in c)]
        together = sorted([k, *(other for c in joined for other in c)])
        found = [c for c in found if c not in joined] + [together]
    return [listed([names[k] for k in c], MOST_NAMED) for c in sorted(found) if len(c) > 1]
