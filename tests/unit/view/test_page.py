"""The page: whole, the same each time, and no name in it is markup."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from bodyschema.view.page import page_html, scene_json

pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def page(seen: Any) -> str:
    return page_html(seen.scene())


class Tags(HTMLParser):
    """Names of all tags, addresses in them, and the text of the first script."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.scene = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1] == "script" and self.tags.count("script") == 1:
            self.scene += data


def scene_in(page: str) -> dict[str, Any]:
    return json.loads(Tags(page).scene.split("\n")[0])


def test_no_character_of_the_scene_is_markup(seen: Any) -> None:
    assert not set("<>&") & set(scene_json(seen.scene()))


def test_names_are_text(page: str) -> None:
    """One that closes the script and opens an image does neither."""
    tags = Tags(page).tags
    assert "img" not in tags
    assert tags.count("script") == 2
    assert "</script ><img onerror=alert(1)>" in scene_in(page)["frames"]


def test_a_title_is_text(seen: Any) -> None:
    page = page_html(replace(seen.scene(), title="<b>@scene@</b>", explanation="@script@ & <i>"))
    assert "<b>" not in page
    assert "<i>" not in page
    assert page.count("&lt;b&gt;@scene@&lt;/b&gt;") == 2
    assert "@script@ &amp; &lt;i&gt;" in page


def test_nothing_is_fetched(page: str) -> None:
    assert Tags(page).addresses == ["#panel"]
    assert "http:" not in page
    assert "https:" not in page
    assert "import(" not in page
    assert "fetch(" not in page


def test_only_its_own_script_and_style_may_run(page: str) -> None:
    """The policy holds the hashes of what is there, and allows nothing else."""
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy
    for text in re.findall(r"<(?:style|script)>(.*?)</(?:style|script)>", page, re.S):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy


def test_numbers_survive(page: str, seen: Any) -> None:
    scene, there = seen.scene(), scene_in(page)
    poses = np.frombuffer(base64.b64decode(there["after"]), "<f4")
    shape = (len(there["rows"]), len(there["frames"]), 7)
    np.testing.assert_array_equal(poses.reshape(shape), scene.moving.packed(scene.moving.after))
    faces = np.frombuffer(base64.b64decode(there["shapes"][0]["faces"]), "<u4")
    np.testing.assert_array_equal(faces.reshape(-1, 3), scene.shapes[0].faces)
    assert there["shift"]["mm"] == pytest.approx(1e3 * scene.moving.shift[0], abs=1e-3)


def test_what_is_wider_than_the_robot_is_said_and_not_drawn(seen: Any) -> None:
    scene = seen.scene()
    first = scene.ellipsoids[0]
    huge = replace(first, axes=first.axes * 100 * scene.size / first.widest)
    page = page_html(replace(scene, ellipsoids=(huge, *scene.ellipsoids[1:])))
    there = scene_in(page)
    assert len(there["ellipsoids"]) == len(scene.ellipsoids) - 1
    assert "too much to draw" in there["notes"][0]


def test_the_same_bytes_again(page: str, seen: Any) -> None:
    assert page_html(seen.scene()) == page


def test_size(page: str) -> None:
    assert len(page) < 150_000
