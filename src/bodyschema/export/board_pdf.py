"""A target as a PDF page: rectangles in mm, so that it is as large on paper as it says.

1 m = 72 / 0.0254 points; /PrintScaling /None asks the viewer not to fit the page.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]

POINTS = 72 / 0.0254
"""Of PDF, in one metre."""

PAPERS = {"a4": (0.21, 0.297), "a3": (0.297, 0.42), "a2": (0.42, 0.594), "a1": (0.594, 0.841),
          "a0": (0.841, 1.189), "letter": (0.2159, 0.2794)}  # fmt: skip
"""m, upright."""

MARGIN = 0.008
"""m that a printer leaves blank at the edge, and that a detector wants white round a pattern."""


def page_for(width: float, height: float, paper: str) -> tuple[float, float]:
    """Width and height of the page, turned so that a pattern of this size fits, m.

    Raises:
        InputError: it does not fit the paper.
    """
    upright = PAPERS[paper]
    for page in (upright, upright[::-1]):
        if width + 2 * MARGIN <= page[0] and height + 2 * MARGIN <= page[1]:
            return page
    larger = [
        name
        for name, size in PAPERS.items()
        if min(width, height) + 2 * MARGIN <= size[0] and max(width, height) + 2 * MARGIN <= size[1]
    ]
    raise InputError(
        f"the board is {1e3 * width:.0f} x {1e3 * height:.0f} mm and does not fit {paper}; "
        + (f"print it on {larger[0]}" if larger else "no paper that is known here is so large")
        + ", or make the squares smaller."
    )


def board_pdf(
    rectangles: ArrayLike, size: tuple[float, float], page: tuple[float, float], caption: str
) -> bytes:
    """A page with a pattern in the middle.

    Args:
        rectangles: (n, 4) x, y, width, height, m; y down from the pattern's top.
        size: width and height of the pattern, m.
        page: width and height of the paper, m.
        caption: a line below the pattern.
    """
    left, top = (page[0] - size[0]) / 2, (page[1] + size[1]) / 2
    x, y, w, h = np.asarray(rectangles, dtype=np.float64).T
    boxes = POINTS * np.stack([left + x, top - y - h, w, h], axis=1)
    drawn = [f"{a:.5f} {b:.5f} {c:.5f} {d:.5f} re" for a, b, c, d in boxes]
    words = caption.encode("latin-1", "replace").decode("latin-1")
    for mark in "\\()":
        words = words.replace(mark, "\\" + mark)
    foot = POINTS * (top - size[1]) - 14
    text = f"BT /F 7 Tf {POINTS * left:.3f} {foot:.3f} Td ({words}) Tj ET"
    content = "\n".join(["0 g", *drawn, "f", text]).encode("latin-1")
    box = f"[0 0 {POINTS * page[0]:.5f} {POINTS * page[1]:.5f}]".encode()
    return _document(
        [
            b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
            b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
            b"<< /Type /Page /Parent 2 0 R /MediaBox " + box + b" /Contents 4 0 R "
            b"/Resources << /Font << /F 5 0 R >> >> >>",
            b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
            b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
        ]
    )


def _document(objects: list[bytes]) -> bytes:
    """A PDF of numbered objects, the first its catalogue."""
    out, begins = b"%PDF-1.4\n", []
    for number, body in enumerate(objects, start=1):
        begins.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % at for at in begins)
    count = len(objects) + 1
    return out + (
        b"xref\n0 %d\n0000000000 65535 f \n%strailer\n<< /Size %d /Root 1 0 R >>\n"
        b"startxref\n%d\n%%%%EOF\n" % (count, table, count, len(out))
    )
