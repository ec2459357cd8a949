"""How the page looks: contrast in light and dark, findings as texts of pictures, tables, order."""

from __future__ import annotations

import re
from html import unescape
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import bodyschema.report.page
from bodyschema.report import figure
from bodyschema.report.figure import IN_THE_PAGE, svg
from bodyschema.report.report import report_html
from bodyschema.view import page as view_page

ENOUGH = 4.5
"""Contrast of text against its ground that WCAG 2.2 AA asks for."""
TEMPLATES = Path(bodyschema.report.page.__file__).parent / "templates"
STYLES = {
    "report": (TEMPLATES / "style.css").read_text(encoding="utf-8"),
    "view": view_page._asset("view.css"),
}
TEXTS = {
    "report": [
        (text, ground)
        for ground in ("paper", "soft", "warning")
        for text in ("ink", "grey", "before", "after")
    ]
    + [("paper", "after"), ("paper", "doubtful"), ("paper", "bad")],
    "view": [
        (text, ground)
        for ground in ("paper", "space")
        for text in ("ink", "grey", "before", "after", "bad", "doubtful", "mark")
    ],
}
"""Colours that texts have, and what they stand on."""


def variables(style: str, dark: bool) -> dict[str, str]:
    """Colours of a style by name."""
    light, _, night = style.partition("(prefers-color-scheme: dark)")
    found = dict(re.findall(r"--(\w+): (#[0-9a-f]{6})", light[: light.index("@media")]))
    other = dict(re.findall(r"--(\w+): (#[0-9a-f]{6})", night[: night.index("\n}")]))
    assert other.keys() == found.keys(), "each colour has one of the night"
    return other if dark else found


def contrast(one: str, other: str) -> float:
    """WCAG's ratio of two colours."""

    def light(colour: str) -> float:
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        r, g, b = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


def test_contrast_is_what_it_is_called() -> None:
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
    assert contrast("#ffffff", "#767676") == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("page", STYLES)
def test_texts_can_be_read(page: str, dark: bool) -> None:
    colours = variables(STYLES[page], dark)
    weak = {
        pair: round(contrast(*(colours[name] for name in pair)), 2)
        for pair in TEXTS[page]
        if contrast(*(colours[name] for name in pair)) < ENOUGH
    }
    assert not weak


def test_charts_are_drawn_in_the_colours_of_the_page() -> None:
    """In daylight the same as by themselves; no letter in a colour that the night does not know."""
    light = variables(STYLES["report"], dark=False)
    assert {name: light[name] for name in IN_THE_PAGE.values()} == {
        name: colour for colour, name in IN_THE_PAGE.items()
    }
    assert set(figure.STYLE.values()) & set(IN_THE_PAGE)


@pytest.fixture(scope="module")
def pages(cases: dict[str, Any]) -> dict[str, str]:
    return {
        kind: report_html(case.calibration, case.nominal, case.senses, case.run)
        for kind, case in cases.items()
        if kind in ("calibrated", "only frames", "exact", "only outliers")
    }


KINDS = ("calibrated", "only frames", "exact", "only outliers")


@pytest.mark.parametrize("kind", KINDS)
def test_no_colour_is_left_to_daylight(pages: dict[str, str], kind: str) -> None:
    """Fills and strokes of charts are variables; only pictures of many colours keep their own."""
    for drawn in re.findall(r"<svg.*?</svg>", pages[kind], re.S):
        assert not re.findall(r"(?:fill|stroke): #[0-9a-f]{6}", drawn)


@pytest.mark.parametrize("kind", KINDS)
def test_texts_of_charts_are_findings(pages: dict[str, str], kind: str) -> None:
    said = [unescape(text) for text in re.findall(r'<svg[^>]* aria-label="([^"]*)"', pages[kind])]
    assert len(said) == pages[kind].count("<svg ") >= 5
    assert len(set(said)) == len(said)
    for sentence in said:
        assert re.search(r"\d", sentence), sentence
        assert sentence.endswith("."), sentence
        assert "nan" not in sentence.split()


def test_the_numbers_of_a_finding_are_those_of_the_answer(cases: dict[str, Any]) -> None:
    from bodyschema.report.residuals import Residuals

    case = cases["calibrated"]
    panel = Residuals(case.evidence).panels()[0]
    after = panel.after[~panel.bad]
    assert f"is {sorted(after)[len(after) // 2]:.2f}"[:6] in panel.words
    assert "1 outlier row besides" in panel.words
    assert f"in row {panel.rows[~panel.bad][after.argmax()]}" in panel.words


@pytest.mark.parametrize("kind", KINDS)
def test_tables_say_what_their_heads_head(pages: dict[str, str], kind: str) -> None:
    heads = re.findall(r"<th\b[^>]*>", pages[kind])
    assert heads
    assert [head for head in heads if "scope=" not in head] == []
    assert pages[kind].count("<table") == pages[kind].count(
        '<div class="scroll" tabindex="0"><table'
    )


@pytest.mark.parametrize("kind", KINDS)
def test_headings_go_down_one_at_a_time(pages: dict[str, str], kind: str) -> None:
    levels = [int(level) for level in re.findall(r"<h([1-6])\b", pages[kind])]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_landmarks_and_a_way_past_the_contents(pages: dict[str, str]) -> None:
    page = pages["calibrated"]
    for landmark in ("<header>", "<nav aria-label=", '<main id="content">', "<footer>"):
        assert page.count(landmark) == 1
    first = re.search(r"<body>\s*(<[^>]*>)", page)
    assert first
    assert first.group(1) == '<a class="skip" href="#content">'
    assert ":focus-visible { outline:" in STYLES["report"]
    assert ":focus-visible { outline:" in STYLES["view"]


def test_a_chart_scrolls_in_its_own_box() -> None:
    drawn = svg("one", "Three is 3.", (300, 200), lambda figure: figure.subplots())
    assert drawn.startswith('<div class="chart" tabindex="0"><svg ')
    assert drawn.endswith("</svg></div>")
