"""The picture of the touch study: error of the place against force, in both cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bodyschema.errors import MissingExtraError
from bodyschema.report.figure import AFTER, BEFORE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

METHODS = {"faithful": ("theirs", BEFORE), "better": ("ours", AFTER)}
MARKS = ("o", "s", "^")
"""Of the speeds, slow to fast."""


def draw_touch(
    summary: Mapping[str, Any], surfaces: Sequence[str], forces: Sequence[float]
) -> Figure:
    """Medians at each speed; at the speed of the case, filled and with the 95 % dashed.

    Args:
        summary: of the study.
        surfaces: names of the things, a column each.
        forces: N.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
    figure = Figure(figsize=(11, 7), layout="constrained")
    panels = figure.subplots(2, len(surfaces), sharex=True, sharey=True)
    for row, ending in enumerate(("", "_outside")):
        case = summary[f"premises{ending}"]
        where = "outside" if ending else "within"
        for axes, surface in zip(panels[row], surfaces, strict=True):
            for name, (label, colour) in METHODS.items():
                cells = [summary[f"{name}{ending}"][surface][f"{force:g}"] for force in forces]
                _draw_method(axes, cells, forces, f"{case['speed']:g}", label, colour)
            name = "cup" if surface == "mesh" else surface
            axes.set_title(
                f"{name}, {where}: {case['force_offset_n']:g} N, {case['turn_deg']:g} deg, "
                f"x{case['speed']:g} (filled)",
                fontsize=10,
            )
            axes.set_xticks(forces, [f"{force:g}" for force in forces])
            axes.minorticks_off()
            axes.grid(alpha=0.3)
        panels[row, 0].set_ylabel("error of the place, mm")
    for axes in panels[-1]:
        axes.set_xlabel("force, N")
    handles, labels = panels[-1, -1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _draw_method(
    axes: Axes,
    cells: Sequence[Mapping[str, Any]],
    forces: Sequence[float],
    own: str,
    label: str,
    colour: str,
) -> None:
    for mark, speed in zip(MARKS, cells[0]["speeds"], strict=False):
        medians = [cell["speeds"][speed]["median_mm"] for cell in cells]
        face = colour if speed == own else "none"
        axes.loglog(forces, medians, f"{mark}-", ms=5, lw=1, color=colour, mfc=face,
                    label=f"{label} x{speed}")  # fmt: skip
    tails = [cell["p95_mm"] for cell in cells]
    axes.loglog(forces, tails, "--", lw=1, color=colour, label=f"{label}, 95 %")
