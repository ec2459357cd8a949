"""The whole page: its skeleton, safety, and sameness."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from html.parser import HTMLParser
from typing import Any

import pytest

from bodyschema.errors import MissingExtraError
from bodyschema.report import page
from bodyschema.report.report import report_html
from bodyschema.senses.points import Points

TITLES = (
    "Verdict",
    "Accuracy before and after",
    "The robot before and after",
    "Residuals",
    "Error over joint space",
    "Rows to look at",
    "Corrections",
    "What cannot be told apart",
    "Coverage of joint space",
    "How to apply it",
    "How to reproduce it",
)
VOID = {"meta", "br", "path", "use", "rect", "image", "circle", "line"}


class Reader(HTMLParser):
    """Checks that tags close in order; collects identifiers, links, headings and texts."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.tags: list[str] = []
        self.texts: dict[str, list[str]] = {}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name in ("href", "src"):
                self.links.append(value or "")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open, f"</{tag}> closes nothing"
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and data.strip():
            self.texts.setdefault(self.open[-1], []).append(data.strip())


@pytest.fixture(scope="module")
def text(case: Any) -> str:
    return report_html(case.calibration, case.nominal, case.senses, case.run)


@pytest.fixture(scope="module")
def reader(text: str) -> Reader:
    read = Reader()
    read.feed(text)
    read.close()
    assert not read.open
    return read


def test_sections(reader: Reader) -> None:
    assert tuple(reader.texts["h2"]) == TITLES
    assert reader.texts["h1"] == ["Calibration of random_4"]


def test_identifiers_are_unique_and_links_lead_somewhere(reader: Reader) -> None:
    assert len(reader.ids) == len(set(reader.ids))
    inner = [link[1:] for link in reader.links if link.startswith("#")]
    assert set(inner) <= set(reader.ids)
    files = {link for link in reader.links if not link.startswith(("#", "data:"))}
    assert files == {
        "robot.urdf", "kinematics.yaml", "transforms.yaml", "calibration.yaml",
        "answer.json", "run.json",
    }  # fmt: skip


def test_clip_paths_and_markers_are_there(text: str, reader: Reader) -> None:
    assert set(re.findall(r"url\(#(\w+)\)", text)) <= set(reader.ids)


def test_nothing_is_fetched(text: str, reader: Reader) -> None:
    assert "http" not in text
    assert not {"script", "link", "iframe", "object", "embed"} & set(reader.tags)
    assert "@import" not in text
    assert not re.search(r"url\((?!#)", text)


def test_names_are_escaped(text: str) -> None:
    assert "<b>eye" not in text
    assert "<i>arm" not in text
    assert "<u>run" not in text
    assert "&lt;b&gt;eye&lt;/b&gt; &amp; $x$" in text


def test_the_same_bytes_again(case: Any, text: str) -> None:
    assert report_html(case.calibration, case.nominal, case.senses, case.run) == text


def test_size(text: str) -> None:
    assert len(text) < 800_000


@pytest.mark.parametrize("kind", ["only frames", "exact", "refused", "only outliers"])
def test_every_kind_of_answer(cases: dict[str, Any], kind: str) -> None:
    case = cases[kind]
    page_text = report_html(case.calibration, case.nominal, case.senses, case.run)
    read = Reader()
    read.feed(page_text)
    assert tuple(read.texts["h2"]) == TITLES
    assert "nan" not in page_text.lower().split()


def test_a_further_section(case: Any) -> None:
    class Colours:
        title = "Colours of the sense"

        def render(self) -> str:
            return "<p>all grey</p>"

    text = report_html(case.calibration, case.nominal, case.senses, case.run, [Colours()])
    assert text.index("all grey") < text.index('<h2 id="how-to-apply-it-title">')
    assert '<a href="#colours-of-the-sense">' in text


@pytest.mark.parametrize("package", ["jinja2", "matplotlib"])
def test_missing_extra(case: Any, monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    page._environment.cache_clear()
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=r"bodyschema\[report\]"):
        report_html(case.calibration, case.nominal, case.senses, case.run)


@dataclass(frozen=True)
class Weather:
    """A section of a sense."""

    rows: int
    title: str = "Weather"

    def render(self) -> str:
        """Its HTML."""
        return f"<p>{self.rows} days of sun.</p>"


class SunnyPoints(Points):
    """Points with something to add."""

    def sections(self, evidence: Any) -> list[Weather]:
        """See `Sense.sections`."""
        return [Weather(evidence.calibration.n_rows)]


def test_a_sense_adds_a_section(case: Any) -> None:
    first = case.senses[0]
    sunny = SunnyPoints(**vars(first))
    html = report_html(case.calibration, case.nominal, (sunny, *case.senses[1:]), case.run)
    assert '<section id="weather"' in html
    assert f"<p>{case.calibration.n_rows} days of sun.</p>" in html
    assert html.index('id="weather"') < html.index('id="corrections"')
