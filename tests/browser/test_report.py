"""What a browser makes of the report: it is opened in headless Chromium and asked."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import Body, calibrate, lie
from bodyschema.report.report import report_html
from simulated import points, postures

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
ASK = """<script>
const shown = document.querySelector("main").innerText;
const page = document.documentElement;
const answer = {
  number: document.querySelector("#number .big").innerText,
  explanation: document.querySelector("#explanation").innerText,
  headings: [...document.querySelectorAll("h2")].map(e => e.innerText),
  variables: document.querySelectorAll("#parameter-table tr.parameter").length,
  pictures: [...document.querySelectorAll("svg")].map(e => e.getBoundingClientRect().width),
  texts: [...document.querySelectorAll("svg text")].map(e => e.textContent),
  fetched: performance.getEntriesByType("resource").map(e => e.name),
  width: page.clientWidth, content: page.scrollWidth,
};
document.title = JSON.stringify(answer);
</script></body>"""


@pytest.fixture(scope="module")
def chromium() -> str:
    for name in NAMES:
        found = shutil.which(name)
        if found:
            return found
    pytest.skip("no Chromium on this machine (looked for " + ", ".join(NAMES) + ")")


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


def asked(chromium: str, folder: Path, text: str, width: int) -> dict[str, Any]:
    """What the page says of itself in a window of this width."""
    page = folder / "report.html"
    page.write_text(text.replace("</body>", ASK), encoding="utf-8")
    command = [
        chromium, *FLAGS, f"--user-data-dir={folder / 'profile'}", f"--window-size={width},900",
        "--dump-dom", page.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    title = re.search(r"<title>(\{.*?\})</title>", done.stdout, re.S)
    assert title, f"the page did not answer: {done.stderr[-500:]}"
    answer: dict[str, Any] = json.loads(html.unescape(title.group(1)))
    return answer


@pytest.mark.parametrize("width", [1200, 600])
def test_what_it_shows(chromium: str, case: Any, tmp_path: Path, width: int) -> None:
    calibration, text = case
    answer = asked(chromium, tmp_path, text, width)
    assert answer["number"] == f"{1e3 * calibration.held_out.position.rms:.2f} mm"
    assert answer["explanation"] == calibration.explanation
    assert answer["headings"][0] == "Verdict"
    assert len(answer["headings"]) == 11
    assert answer["variables"] == len(calibration.estimate.variables)
    assert len(answer["pictures"]) == text.count("<svg ") >= 6
    assert min(answer["pictures"]) > 150
    assert "joint_1.offset" in answer["texts"]
    assert answer["fetched"] == []
    assert answer["content"] <= answer["width"], "the page is wider than the window"
