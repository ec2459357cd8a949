"""Section of the report: every photograph of a board, before and after."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

from bodyschema.report.page import render


@dataclass(frozen=True)
class BoardPicture:
    """A photograph with its corners before and after."""

    says: str
    """What it is and what was found, for the caption."""
    jpeg: bytes


@dataclass(frozen=True)
class BoardPictures:
    """Photographs inside the page."""

    pictures: Sequence[BoardPicture]
    more: int = 0
    """Of which only a file is there."""
    title: str = "The board, in every picture"

    def render(self) -> str:
        """See `Section`."""
        shown = [(one.says, base64.b64encode(one.jpeg).decode()) for one in self.pictures]
        return render("boards.html", pictures=shown, more=self.more)
