"""Section of the report on a search for the body: the cells of the picture that are me."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.report.page import render
from bodyschema.vision.overlay import png_bytes


@dataclass(frozen=True)
class Cells:
    """The mask as a picture, and who moves how much of it."""

    found: BodyInView
    title: str = "The cells that are me"

    def render(self) -> str:
        """See `Section`."""
        found = self.found
        white = np.where(found.pixels(), np.uint8(255), np.uint8(0))
        picture = png_bytes(np.repeat(white[..., None], 3, axis=2))
        counts = [int(np.sum(found.mask & (found.joint == j))) for j in range(len(found.joints))]
        return render(
            "cells.html",
            picture=base64.b64encode(picture).decode(),
            joints=[(name, n) for name, n in zip(found.joints, counts, strict=True) if n],
            cell=found.cell_px,
            share=f"{100 * float(np.mean(white > 0)):.1f}",
        )
