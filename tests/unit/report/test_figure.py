"""Charts as inline SVG."""

from __future__ import annotations

from typing import Any

import matplotlib
import pytest

from bodyschema.report.figure import log_scale, svg


def paint(figure: Any) -> None:
    axes = figure.subplots()
    axes.plot([0, 1, 2], [1, 10, 1000], "o-")
    axes.set_title("a$b$ <c>")
    log_scale(axes, "mm")


def test_text_stays_text_and_is_escaped() -> None:
    drawn = svg("one", 'says "more" <than>', (300, 200), paint)
    assert "a$b$ &lt;c&gt;" in drawn
    assert 'aria-label="says &quot;more&quot; &lt;than&gt;"' in drawn
    assert "1000 mm" in drawn
    assert "font-family" not in drawn
    assert "DejaVu" not in drawn


def test_what_a_terminal_would_obey_is_written_out() -> None:
    drawn = svg(
        "one", "says \x1b[31m", (300, 200), lambda f: f.subplots().set_title("a\x1b[2J\x9b\u202e")
    )
    assert r"a\x1b[2J\x9b\u202e" in drawn
    assert r"says \x1b[31m" in drawn
    assert drawn.replace("\n", "").isprintable()


def test_letters_that_the_font_lacks_are_kept() -> None:
    assert "\u8155" in svg("one", "", (300, 200), lambda f: f.subplots().set_title("\u8155"))


def test_a_users_settings_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = svg("one", "says", (300, 200), paint)
    with matplotlib.rc_context({"lines.linewidth": 9, "axes.grid": False}):
        assert svg("one", "says", (300, 200), paint) == plain
        assert matplotlib.rcParams["lines.linewidth"] == 9, "they are put back"


def test_charts_of_one_page_share_no_identifiers() -> None:
    import re

    one, other = (set(re.findall(r'id="([^"]*)"', svg(n, "", (300, 200), paint))) for n in "ab")
    assert one
    assert not one & other
