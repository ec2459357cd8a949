"""The picture of a study as PNG and SVG: the same bytes each time, whatever the user's style is."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any

from bodyschema.errors import MissingExtraError
from bodyschema.report.figure import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 150


def picture_files(name: str, draw: Callable[[], Figure]) -> dict[str, bytes]:
    """figure.png and figure.svg.

    Args:
        name: of the study; the SVG's identifiers come from it.
        draw: makes the figure.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context, rcdefaults, rcParams
    except ImportError:
        raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
    with rc_context():
        rcdefaults()
        rcParams.update(STYLE)
        # Powers of ten on logarithmic axes, and Greek letters, are written as mathematics.
        rcParams.update(
            {"figure.facecolor": "white", "svg.hashsalt": name, "text.parse_math": True}
        )
        figure = draw()
        unsigned: dict[str, Any] = {
            "png": {"metadata": {"Software": None}, "dpi": DOTS_PER_INCH},
            "svg": {"metadata": {"Date": None, "Creator": None}},
        }
        files = {}
        for form, options in unsigned.items():
            content = BytesIO()
            figure.savefig(content, format=form, **options)
            files[f"figure.{form}"] = content.getvalue()
    return files
