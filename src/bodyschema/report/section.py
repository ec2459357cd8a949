"""Section: one part of the report. A later sense adds its own by having these two."""

from __future__ import annotations

import re
from typing import Protocol


class Section(Protocol):
    """One titled part of the page."""

    @property
    def title(self) -> str:
        """Its heading, a few words."""

    def render(self) -> str:
        """Its HTML below the heading; everything that was given by users escaped."""


def anchor(title: str) -> str:
    """The name by which a link finds a section."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
