"""What a browser makes of the page in space: it is drawn, turned, and told apart from markup."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import Body, calibrate, lie
from bodyschema.model.tree import Visual
from bodyschema.view.page import page_html
from bodyschema.view.scene import scene_of
from browser.chromium import opened, title_of
from simulated import points, postures

pytest.importorskip("trimesh")

NASTY = "</script><img src=x onerror=document.title=1>"
ASK = """<script>
{
const at = id => document.getElementById(id), page = document.documentElement;
// The page draws when the browser next shows it; a browser without a window may never do so.
const drawn = () => { render(); return pixels(); };
const pixels = () => {
  const copy = document.createElement("canvas"), from = at("space");
  [copy.width, copy.height] = [from.width, from.height];
  const brush = copy.getContext("2d");
  brush.drawImage(from, 0, 0);
  return brush.getImageData(0, 0, copy.width, copy.height).data;
};
const first = drawn(), ground = first.slice(0, 3).join(), count = {};
for (let i = 0; i < first.length; i += 4) {
  const colour = first.slice(i, i + 3).join();
  count[colour] = (count[colour] || 0) + 1;
}
const before = at("where").textContent;
at("slider").value = 5;
at("slider").dispatchEvent(new Event("input"));
at("space").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
const then = drawn(), written = [...document.querySelectorAll("#panel *, #labels span")];
document.title = JSON.stringify({
  ground, colours: Object.keys(count).length,
  drawn: 1 - 4 * (count[ground] || 0) / first.length,
  before, where: at("where").textContent,
  changed: then.reduce((sum, v, i) => sum + (i % 4 === 0 && v !== first[i]), 0),
  images: document.images.length,
  labels: [...document.querySelectorAll("#labels span")].map(e => e.textContent),
  failed: !at("failed").hidden,
  fetched: performance.getEntriesByType("resource").map(e => e.name),
  width: page.clientWidth, content: page.scrollWidth,
  letters: Math.min(...written.map(e => parseFloat(getComputedStyle(e).fontSize))),
});
}
</script></body>"""


@pytest.fixture(scope="module")
def page() -> str:
    """An arm of four joints with a box on each of two links, and a frame of a dangerous name."""
    rng = np.random.default_rng(3)
    nominal = Body.random_chain(4, rng)
    body = nominal.attach(NASTY, "base").attach("tool", "tip")
    truth = replace(body, offset=rng.uniform(-0.08, 0.08, 4)).with_placement(
        NASTY, lie.transform(lie.exp_so3([0.3, -2.0, 0.5]), [0.2, 1.0, 0.7])
    )
    seen = points(truth, postures(30, body, rng), rng, 1e-3, NASTY, "tool")
    found = calibrate(body, [seen], {NASTY: "no"}, ["offsets"], folds=3)
    boxes = [Visual(nominal.frames[k], np.eye(4), "box", (0.05, 0.05, 0.2)) for k in (1, 2)]
    return page_html(scene_of(found, "An arm", [seen], boxes))


def asked(chromium: str, folder: Path, text: str, width: int, *flags: str) -> dict[str, Any]:
    """What the page says of itself; its policy, which would forbid to ask, is taken out."""
    page = folder / "view.html"
    open_text = text.replace('http-equiv="Content-Security-Policy"', 'name="policy"')
    page.write_text(open_text.replace("</body>", ASK), encoding="utf-8")
    return title_of(chromium, folder, page, width, *flags)


@pytest.mark.parametrize("width", [1200, 500])
def test_it_is_drawn_and_turns(chromium: str, page: str, tmp_path: Path, width: int) -> None:
    answer = asked(chromium, tmp_path, page, width)
    assert not answer["failed"]
    assert answer["colours"] > 50
    assert answer["drawn"] > 0.02
    assert answer["changed"] > 1000
    assert answer["before"].startswith("Row 0, 1 of 30; error ")
    assert answer["where"].startswith("Row 5, 6 of 30; error ")
    assert answer["content"] <= answer["width"]
    assert answer["letters"] >= 11
    assert answer["fetched"] == []


def test_a_name_is_a_label_and_no_image(chromium: str, page: str, tmp_path: Path) -> None:
    answer = asked(chromium, tmp_path, page, 1200)
    assert answer["images"] == 0
    assert NASTY in answer["labels"]


def test_at_night(chromium: str, page: str, tmp_path: Path) -> None:
    night = asked(chromium, tmp_path, page, 1200, "--blink-settings=preferredColorScheme=0")
    assert night["ground"] == "20,23,27"


def test_its_policy_lets_it_run(chromium: str, page: str, tmp_path: Path) -> None:
    """As it is written, with its hashes."""
    path = tmp_path / "view.html"
    path.write_text(page, encoding="utf-8")
    shown = opened(chromium, tmp_path, path, "--window-size=1200,900", "--dump-dom")
    assert '<p id="verdict" class="good">calibrated</p>' in shown
    assert "Row 0, 1 of 30" in shown
