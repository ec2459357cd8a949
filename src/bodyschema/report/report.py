"""The report: one HTML file that shows what was found, how sure it is, and what to do.

Every answer has a verdict and how to reproduce it; what was seen, what was corrected and how to
apply it follow where there is such a thing, and the sections that a verb or a sense brings. The
page needs no network and no other file; the same answer gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from bodyschema.export.calibration_yaml import calibration_document
from bodyschema.export.documents import versions
from bodyschema.judging.calibration import Calibration
from bodyschema.model.tree import Body
from bodyschema.report.accuracy import AccuracySection
from bodyschema.report.ambiguity import Ambiguity
from bodyschema.report.application import Application
from bodyschema.report.bad_rows import BadRows
from bodyschema.report.coverage import Coverage
from bodyschema.report.drawing import Drawing
from bodyschema.report.evidence import Evidence
from bodyschema.report.joint_space import JointSpace
from bodyschema.report.page import render
from bodyschema.report.parameters import ParameterTable
from bodyschema.report.reproduction import Reproduction
from bodyschema.report.residuals import Residuals
from bodyschema.report.section import Section, anchor
from bodyschema.report.summary import summary_text
from bodyschema.report.verdict import Verdict
from bodyschema.senses.sense import Sense

HEADINGS = {
    "payload": "What the wrist carries",
    "touch": "What touches the wrist's load",
    "track": "{} tracked without markers",
    "find-body": "What of the picture is me",
    "hand-eye": "Hand and eye",
}
"""Of answers that are no calibration, by verb; with the robot's name."""


def report_html(
    calibration: Calibration,
    nominal: Body,
    senses: Sequence[Sense],
    run: Mapping[str, Any],
    more: Sequence[Section] = (),
    heading: str = "",
) -> str:
    """The whole page.

    Args:
        calibration: the answer.
        nominal: the robot as described, without the frames that were attached.
        senses: what was seen, as it was given to `calibrate`.
        run: what was asked, with versions and hashes; see `export.result_folder.run_record`.
        more: further sections, of a verb; those of the senses come before them.
        heading: of the page, of an answer that is no calibration.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    evidence = Evidence(calibration, nominal, tuple(senses), run)
    seen: list[Section] = [
        AccuracySection(evidence),
        Drawing(evidence),
        Residuals(evidence),
        JointSpace(evidence),
        BadRows(evidence),
    ]
    known: list[Section] = [ParameterTable(evidence), Ambiguity(evidence)]
    sections = [
        Verdict(evidence),
        *(seen if senses else []),
        *(section for sense in senses for section in sense.sections(evidence)),
        *more,
        *(known if len(calibration.estimate.variables) else []),
        *([Coverage(evidence)] if senses else []),
        *([Application(evidence)] if calibration.corrects else []),
        Reproduction(evidence),
    ]
    title = heading or f"Calibration of {calibration.body.name}"
    return _page(title, sections)


def short_html(
    calibration: Calibration, nominal: Body, senses: Sequence[Sense], run: Mapping[str, Any]
) -> str:
    """Verdict and accuracy alone, for a notebook's cell; the words without what was seen.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    if not senses:
        return f"<pre>{escape(summary_text(calibration_document(calibration)))}</pre>"
    evidence = Evidence(calibration, nominal, tuple(senses), run)
    return Verdict(evidence).render() + AccuracySection(evidence).render()


def _page(heading: str, sections: Sequence[Section]) -> str:
    """A whole page of sections, in their order.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    return render(
        "page.html",
        heading=heading,
        version=versions()["bodyschema"],
        sections=[(anchor(s.title), s.title, s.render()) for s in sections],
    )
