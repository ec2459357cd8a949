"""The report: one HTML file that shows what a calibration found, how sure it is, and what to do.

It needs no network and no other file; the same calibration gives the same bytes.
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


def report_html(
    calibration: Calibration,
    nominal: Body,
    senses: Sequence[Sense],
    run: Mapping[str, Any],
    more: Sequence[Section] = (),
) -> str:
    """The whole page.

    Args:
        calibration: the answer.
        nominal: the robot as described, without the frames that were attached.
        senses: what was seen, as it was given to `calibrate`.
        run: what was asked, with versions and hashes; see `export.result_folder.run_record`.
        more: further sections, such as those of a sense; they come before how to apply the result.

    Raises:
        MissingExtraError: jinja2 or matplotlib is not installed.
    """
    evidence = Evidence(calibration, nominal, tuple(senses), run)
    findings: list[Section] = [
        Verdict(evidence),
        AccuracySection(evidence),
        Drawing(evidence),
        Residuals(evidence),
        JointSpace(evidence),
        BadRows(evidence),
        ParameterTable(evidence),
        Ambiguity(evidence),
        Coverage(evidence),
    ]
    sections = [*findings, *more, Application(evidence), Reproduction(evidence)]
    return page_html(f"Calibration of {calibration.body.name}", sections)


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


def page_html(heading: str, sections: Sequence[Section]) -> str:
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
