"""Charts as inline SVG: the same bytes each time, text as text, nothing fetched from anywhere."""

from __future__ import annotations

import html
import re
import warnings
from collections.abc import Callable
from io import StringIO
from typing import Any

from bodyschema.errors import MissingExtraError, shown

BEFORE, AFTER = "#b34d08", "#08756d"
INK, GREY, FAINT = "#22272e", "#5f6670", "#e4e1da"
PAPER, EDGE, RANGE, SPAN = "#ffffff", "#c9c5bc", "#b9b5ac", "#9ed2cd"
IN_THE_PAGE = {
    BEFORE: "before", AFTER: "after", INK: "ink", GREY: "grey", FAINT: "line", PAPER: "paper",
    EDGE: "edge", RANGE: "range", SPAN: "span",
}  # fmt: skip
"""Variables of the page's style, light or dark, that its charts are drawn in."""
MOST_DOTS = 400
"""Samples that one panel shows; more would make the page heavy and tell the eye no more."""

STYLE: Any = {
    "svg.fonttype": "none",
    "text.parse_math": False,
    "font.size": 12,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": EDGE,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "grid.color": FAINT,
    "grid.linewidth": 0.8,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
}


def svg(name: str, says: str, size: tuple[float, float], paint: Callable[[Any], None]) -> str:
    """Draw a chart.

    Args:
        name: unique on the page; keeps the identifiers of its parts apart from other charts'.
        says: what it tells, with its figures, for readers who cannot see it.
        size: width and height in CSS pixels.
        paint: draws into the matplotlib figure that it is given.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context, rcdefaults, rcParams
        from matplotlib.backends.backend_svg import FigureCanvasSVG
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "report", "report.html") from None
    with rc_context():
        # What a user's matplotlibrc says would change the bytes.
        rcdefaults()
        rcParams.update(STYLE)
        rcParams["svg.hashsalt"] = name
        # An SVG has 72 units an inch, and a unit is drawn as a pixel.
        figure = Figure(figsize=(size[0] / 72, size[1] / 72), layout="constrained")
        FigureCanvasSVG(figure)
        paint(figure)
        text = StringIO()
        with warnings.catch_warnings():
            # Texts stay texts, and readers' browsers have fonts of their own.
            warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
            figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return shown(_inline(text.getvalue(), says, size))


def new_figure(size: tuple[float, float], paint: Callable[[Any], None]) -> Any:
    """A matplotlib Figure in the same style, for notebooks and files.

    Args:
        size: width and height in CSS pixels.
        paint: draws into it.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "report", "plot") from None
    with rc_context({**STYLE, "figure.facecolor": "white"}):
        figure = Figure(figsize=(size[0] / 72, size[1] / 72), layout="constrained")
        paint(figure)
    return figure


def _inline(text: str, says: str, size: tuple[float, float]) -> str:
    """The drawing alone: no XML heading, no addresses of name spaces, no fonts of its own."""
    inner = text[text.index("<defs") : text.rindex("</svg>")]
    inner = re.sub(r"<g id=\"[^\"]*\"", "<g", inner)
    inner = re.sub(r"font-family: [^;\"]*; ?", "", inner)
    inner = inner.replace("xlink:href", "href")
    inner = re.sub(r"\n\s*", "\n", inner)
    # What matplotlib draws without a rim has a rim that is transparent.
    inner = inner.replace("stroke: #000000; stroke-opacity: 0", "stroke: none")
    for colour, name in IN_THE_PAGE.items():
        inner = inner.replace(f": {colour}", f": var(--{name}, {colour})")
    label = html.escape(says, quote=True)
    return (
        f'<div class="chart" tabindex="0"><svg viewBox="0 0 {size[0]:g} {size[1]:g}" '
        f'width="{size[0]:g}" role="img" aria-label="{label}">\n{inner}</svg></div>'
    )


def log_scale(axes: Any, unit: str) -> None:
    """A logarithmic y axis whose marks are numbers with a unit, not powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_yscale("log")
    low, high = axes.get_ylim()
    wide = high > 30 * low
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} {unit}"))
    # Minor marks have no numbers here and would take most of the drawing time.
    axes.yaxis.set_minor_locator(NullLocator())


def plain(axes: Any) -> None:
    """Remove the frame and the grid of an axes that carries a drawing."""
    axes.grid(False)
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
