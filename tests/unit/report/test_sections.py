"""What single sections say, in words and numbers that can be checked."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape
from typing import Any

import numpy as np
import pytest

from bodyschema.export.static_transforms import place_entries
from bodyschema.judging.settled import settled
from bodyschema.report.accuracy import AccuracySection
from bodyschema.report.ambiguity import Ambiguity, _clusters
from bodyschema.report.application import Application
from bodyschema.report.bad_rows import BadRows
from bodyschema.report.coverage import Coverage
from bodyschema.report.drawing import VISIBLE, Drawing
from bodyschema.report.joint_space import JointSpace
from bodyschema.report.parameters import ParameterTable
from bodyschema.report.reproduction import Reproduction
from bodyschema.report.residuals import Residuals
from bodyschema.report.section import anchor
from bodyschema.report.verdict import Verdict
from bodyschema.units import shown

SECTIONS = (
    Verdict, AccuracySection, Drawing, Residuals, JointSpace, BadRows, ParameterTable, Ambiguity,
    Coverage, Application, Reproduction,
)  # fmt: skip


def words(html: str) -> str:
    """The text of some HTML, without tags and line breaks."""
    return " ".join(unescape(re.sub(r"<[^>]*>", " ", html)).split())


@pytest.mark.parametrize("section", SECTIONS)
def test_it_renders(case: Any, section: Any) -> None:
    made = section(case.evidence)
    assert len(words(made.render())) > 20
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", anchor(made.title))


def test_the_verdict_is_a_sentence_and_a_number(case: Any) -> None:
    said = words(Verdict(case.evidence).render())
    c = case.calibration
    assert c.explanation in said
    assert f"{1e3 * c.held_out.position.rms:.2f} mm" in said
    assert f"{1e3 * c.nominal.position.rms:.2f} mm as modelled" in said
    assert "1 of 30 rows are outliers and do not count in the errors: 7" in said
    assert "The held-out errors agree with that" in said


def test_the_frames_asked_for_come_first_and_the_stated_error_before_the_held_out(
    case: Any,
) -> None:
    said = Verdict(case.evidence).render()
    (tracker, *_) = place_entries(case.calibration)
    hero, text = said.index('class="hero"'), unescape(said)
    assert said.index('class="place"') < hero
    assert tracker["name"] in text
    assert tracker["origin"] in text
    big = re.search(r'<span class="big">([^<]*)', said)
    assert big is not None
    assert big[1] == shown(case.calibration.stated_95, "m", 2)
    assert said.index("big") < said.index("Held-out error")
    refused = Verdict(
        replace(case, calibration=replace(case.calibration, verdict="refused")).evidence
    )
    assert "<origin" not in refused.render()
    assert "big" not in refused.render()


def test_what_is_not_written_is_folded(case: Any) -> None:
    said = ParameterTable(case.evidence).render()
    kept = settled(case.calibration)
    top, _, folded = said.partition("<details")
    assert top.count('class="parameter') == int(kept.changed.sum())
    assert folded.count('class="parameter') == int((~kept.changed).sum()) > 0


def test_the_verdict_tells_when_the_prediction_fails(case: Any) -> None:
    """Held-out errors ten times as large as predicted are called so."""
    worse = tuple(10 * r for r in case.calibration.residuals)
    doubtful = replace(case, calibration=replace(case.calibration, residuals=worse))
    assert "Do not rely on that prediction" in words(Verdict(doubtful.evidence).render())


def test_the_verdict_warns(cases: dict[str, Any]) -> None:
    refused = words(Verdict(cases["refused"].evidence).render())
    assert "do not put these files on a robot" in refused
    assert "Clock fault (p = 0.0001)" in refused
    assert "rows 3, 4." in refused
    assert "had not settled" in words(Verdict(cases["not settled"].evidence).render())


def test_accuracy_marks_the_chosen_model(case: Any) -> None:
    said = AccuracySection(case.evidence).render()
    chosen = re.findall(r'<tr class="chosen"><th scope="row">([^<]*)', said)
    assert chosen == ["joint offsets, axes"]


def test_outliers_are_listed_once_with_their_row(case: Any) -> None:
    said = BadRows(case.evidence).render()
    body = said[said.index("<tbody>") : said.index("</tbody>")]
    assert body.count("<tr>") == 1
    assert '<td class="n">7</td>' in body


def test_every_parameter_has_a_row_and_open_ones_no_error(case: Any) -> None:
    said = ParameterTable(case.evidence).render()
    rows = re.findall(r'<tr class="parameter (\w+)[^"]*">(.*?)</tr>', said, re.S)
    known = case.calibration.identifiability
    assert len(rows) == len(known.open_share)
    assert [state == "open" for state, _ in rows].count(True) == int(np.sum(known.open_share > 0.5))
    for state, cells in rows:
        assert (state == "open") == ('<td class="n"></td>' in cells)
        assert (state == "open") == ("not determined" in cells)


def test_open_directions_are_all_in_words(case: Any) -> None:
    said = words(Ambiguity(case.evidence).render())
    for sentence in case.calibration.identifiability.sentences:
        for name in re.findall(r"joint_\d\.\w+", sentence):
            assert name in said


def test_clusters_join_what_is_correlated() -> None:
    C = np.eye(4)
    C[0, 2] = C[2, 0] = -0.99
    C[2, 3] = C[3, 2] = 0.97
    assert _clusters(["a", "b", "c", "d"], C) == ["a, c, d"]


def test_coverage_gives_the_share_of_the_range(case: Any) -> None:
    spans = [Coverage(case.evidence)._span(joint) for joint in case.evidence.joints]
    readings = np.degrees(case.senses[0].q)
    for span, column in zip(spans, readings.T, strict=True):
        assert span.unit == "deg"
        np.testing.assert_allclose(span.quantiles[[0, 4]], [column.min(), column.max()])
        assert span.share == pytest.approx(np.ptp(column) / (span.high - span.low))


def test_a_small_correction_is_exaggerated(case: Any) -> None:
    """The drawn shift stays below its share of the robot; the true one is stated."""
    drawing = Drawing(case.evidence)
    row, q = drawing._posture()
    assert row != 7, "an outlier is not representative"
    pose = drawing._pose(q)
    size = np.ptp(pose.before, axis=0).max()
    assert pose.factor == 1 or pose.factor * pose.largest <= VISIBLE * size
    nearer = replace(case.calibration.estimate, x=case.calibration.estimate.x / 100)
    small = replace(case, calibration=replace(case.calibration, fit=nearer))
    assert Drawing(small.evidence)._pose(q).factor > 1
    assert "times as large" in words(Drawing(small.evidence).render())


def test_how_to_apply_it(cases: dict[str, Any]) -> None:
    said = words(Application(cases["calibrated"].evidence).render())
    assert "the numbers of" in said
    assert "ros2 run tf2_ros static_transform_publisher" in said
    assert "stays as it was" in words(Application(cases["only frames"].evidence).render())
    assert "do not apply it" in words(Application(cases["refused"].evidence).render())


def test_how_to_reproduce_it(cases: dict[str, Any]) -> None:
    said = words(Reproduction(cases["calibrated"].evidence).render())
    assert "bodyschema calibrate" in said
    assert "0" * 64 in said
    assert "python 3.11" in said
    bare = words(Reproduction(cases["bare run"].evidence).render())
    assert "numpy" in bare
    assert "the robot's description was used" in words(
        Application(cases["bare run"].evidence).render()
    )
