"""The page on a tracked body; the same answer gives the same bytes."""

from __future__ import annotations

from dataclasses import dataclass

from bodyschema.report.report import page_html
from bodyschema.report.reproduction import reproduction_html
from bodyschema.report.section import Section
from bodyschema.report.tracking.application import TrackApplication
from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.report.tracking.moments import Moments
from bodyschema.report.tracking.offsets import NotTold, Offsets
from bodyschema.report.tracking.pictures import Pictures
from bodyschema.report.tracking.trust import Trust
from bodyschema.report.tracking.verdict import TrackVerdict


@dataclass(frozen=True)
class TrackReproduction:
    """Everything that the numbers depend on."""

    evidence: TrackEvidence
    title: str = "How to reproduce it"

    def render(self) -> str:
        """See `Section`."""
        return reproduction_html(self.evidence.run)


def tracking_html(evidence: TrackEvidence) -> str:
    """The whole page.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    sections: list[Section] = [
        TrackVerdict(evidence),
        Pictures(evidence),
        Offsets(evidence),
        NotTold(evidence),
        Moments(evidence),
        Trust(evidence),
        TrackApplication(evidence),
        TrackReproduction(evidence),
    ]
    return page_html(f"{evidence.nominal.name} tracked without markers", sections)
