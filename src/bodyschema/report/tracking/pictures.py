"""What the first camera saw, with the outline of the body before and after."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

from bodyschema.report.page import render
from bodyschema.report.tracking.evidence import OverlayPicture


@dataclass(frozen=True)
class Pictures:
    """Overlays inside the page."""

    overlays: Sequence[OverlayPicture]
    title: str = "Before and after, in the pictures"

    def render(self) -> str:
        """See `Section`."""
        pictures = [
            (picture.says, base64.b64encode(picture.jpeg).decode()) for picture in self.overlays
        ]
        return render("tracking/pictures.html", pictures=pictures)
