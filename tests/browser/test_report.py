"""What a browser makes of the report: it is opened in headless Chromium and asked."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import Body, calibrate, lie
from bodyschema.report.report import report_html
from bodyschema.units import shown
from browser.chromium import opened, title_of
from simulated import points, postures

ASK = """<script>
const shown = document.querySelector("main").innerText;
const page = document.documentElement;
const boxed = e => e.closest(".scroll, .chart");
const scale = e => {
  const svg = e.closest("svg");
  return svg ? svg.getBoundingClientRect().width / svg.viewBox.baseVal.width : 1;
};
const written = [...document.querySelectorAll("main *")].filter(e =>
  [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()) && !e.closest("defs"));
const answer = {
  number: document.querySelector("#number .big").innerText,
  explanation: document.querySelector("#explanation").innerText,
  headings: [...document.querySelectorAll("h2")].map(e => e.innerText),
  variables: document.querySelectorAll("tr.parameter").length,
  pictures: [...document.querySelectorAll("svg")].map(e => e.getBoundingClientRect().width),
  texts: [...document.querySelectorAll("svg text")].map(e => e.textContent),
  fetched: performance.getEntriesByType("resource").map(e => e.name),
  width: page.clientWidth, content: page.scrollWidth,
  wide: [...document.querySelectorAll("body *")].filter(e => !boxed(e.parentElement) &&
    e.getBoundingClientRect().right > page.clientWidth + 1).map(e => e.outerHTML.slice(0, 80)),
  letters: Math.min(...written.map(e => parseFloat(getComputedStyle(e).fontSize) * scale(e))),
  ground: getComputedStyle(document.body).backgroundColor,
  inks: [...new Set([...document.querySelectorAll("svg text")].map(e => getComputedStyle(e).fill))],
};
document.title = JSON.stringify(answer);
</script></body>"""
NIGHT = "--blink-settings=preferredColorScheme=0"
MOST_PAGES = 9
"""Of paper, that the report of an arm of four joints takes."""


@pytest.fixture(scope="module")
def case() -> Any:
    """An arm of four joints with wrong offsets, and its report."""
    rng = np.random.default_rng(3)
    nominal = Body.random_chain(4, rng)
    body = nominal.attach("camera", "base").attach("tool", "tip")
    truth = replace(body, offset=rng.uniform(-0.08, 0.08, 4)).with_placement(
        "camera", lie.transform(lie.exp_so3([0.3, -2.0, 0.5]), [0.2, 1.0, 0.7])
    )
    seen = points(truth, postures(30, body, rng), rng, 1e-3, "camera", "tool")
    found = calibrate(body, [seen], {"camera": "no"}, ["offsets"], folds=3)
    run = {"robot": "/home/somebody/" + "long/" * 30 + "arm.urdf", "sha256": {"a.csv": "0" * 64}}
    return found, report_html(found, nominal, [seen], run)


def asked(chromium: str, folder: Path, text: str, width: int, *flags: str) -> dict[str, Any]:
    """What the page says of itself in a window of this width."""
    page = folder / "report.html"
    page.write_text(text.replace("</body>", ASK), encoding="utf-8")
    return title_of(chromium, folder, page, width, *flags)


@pytest.mark.parametrize("width", [1200, 600, 500])
def test_what_it_shows(chromium: str, case: Any, tmp_path: Path, width: int) -> None:
    calibration, text = case
    answer = asked(chromium, tmp_path, text, width)
    assert answer["number"] == shown(calibration.stated_95, "m", 2)
    assert answer["explanation"] == calibration.explanation
    assert answer["headings"][0] == "Verdict"
    assert len(answer["headings"]) == 11
    assert answer["variables"] == len(calibration.estimate.variables)
    assert len(answer["pictures"]) == text.count("<svg ") >= 6
    assert min(answer["pictures"]) > 150
    assert "joint_1.offset" in answer["texts"]
    assert answer["fetched"] == []
    assert answer["content"] <= answer["width"], "the page is wider than the window"
    assert answer["wide"] == []
    assert answer["letters"] >= 11


def test_at_night(chromium: str, case: Any, tmp_path: Path) -> None:
    """Page and charts turn dark together."""
    day = asked(chromium, tmp_path, case[1], 1200)
    night = asked(chromium, tmp_path, case[1], 1200, NIGHT)
    assert (day["ground"], night["ground"]) == ("rgb(255, 255, 255)", "rgb(27, 31, 36)")
    assert "rgb(230, 227, 220)" in night["inks"]
    assert not set(day["inks"]) & set(night["inks"])


def test_on_paper(chromium: str, case: Any, tmp_path: Path) -> None:
    page, paper = tmp_path / "report.html", tmp_path / "report.pdf"
    page.write_text(case[1], encoding="utf-8")
    opened(chromium, tmp_path, page, f"--print-to-pdf={paper}")
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", paper.read_bytes())) <= MOST_PAGES
