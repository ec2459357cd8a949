"""`bodyschema board`: the PDF is as large as it says, and is found again where it says."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from bodyschema.cli import run
from bodyschema.cli.entry_types import entry_of
from bodyschema.vision.targets.target import Target

pytest.importorskip("cv2")

from bodyschema.vision.targets.detection import find_target

PX = 5.0
"""px a mm"""


def rasterised(pdf: bytes) -> tuple[np.ndarray, np.ndarray]:
    """The page at PX, and its rectangles in mm from the top left: x, y, width, height."""
    numbers = r"(-?[\d.]+) (-?[\d.]+) (-?[\d.]+) (-?[\d.]+)"
    text = pdf.decode("latin-1")
    page = re.findall(rf"MediaBox \[{numbers}\]", text)[0]
    width, height = (25.4 / 72 * float(one) for one in page[2:])
    boxes = 25.4 / 72 * np.array(re.findall(rf"{numbers} re", text), dtype=float)
    boxes[:, 1] = height - boxes[:, 1] - boxes[:, 3]
    grey = np.full((round(PX * height), round(PX * width)), 255, np.uint8)
    for x, y, w, h in boxes:
        grey[round(PX * y) : round(PX * (y + h)), round(PX * x) : round(PX * (x + w))] = 0
    return grey, boxes


@pytest.mark.parametrize(
    "flags",
    [
        [],
        ["--kind", "chessboard", "--columns", "8", "--rows", "5", "--square-mm", "20"],
        ["--kind", "tags", "--columns", "3", "--rows", "2", "--dictionary", "APRILTAG_36h11"],
        ["--kind", "tags", "--columns", "1", "--rows", "1", "--marker-mm", "120"],
        ["--rows", "4", "--square-mm", "30", "--dictionary", "4X4_50"],
    ],
)
def test_what_is_printed_is_found(
    flags: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "board.pdf"
    assert run(["board", "--out", str(out), "--json", *flags]) == 0
    told = json.loads(capsys.readouterr().out)
    target = entry_of(Target, tomllib.loads(f"t = {told['target']}")["t"], "the text")
    pdf = out.read_bytes()
    assert b"/PrintScaling /None" in pdf
    grey, boxes = rasterised(pdf)
    assert np.ptp([boxes[:, 0], boxes[:, 0] + boxes[:, 2]]) == pytest.approx(
        told["width_mm"], abs=0.01
    )
    found = find_target(target, grey)
    assert found is not None
    assert len(found) == len(target.corners)
    mm = (found.image + 0.5) / PX
    at = 1e3 * target.corners[found.ids, :2]
    assert np.abs((mm - mm.mean(axis=0)) - (at - at.mean(axis=0))).max() < 0.15


def test_rectangles_are_true_to_a_hundredth_of_a_mm(tmp_path: Path) -> None:
    out = tmp_path / "board.pdf"
    flags = ["--kind", "chessboard", "--columns", "8", "--rows", "5", "--square-mm", "25.4"]
    assert run(["board", "--out", str(out), *flags]) == 0
    _, boxes = rasterised(out.read_bytes())
    assert np.abs(boxes[:, 2:] - 25.4).max() < 0.01
    apart = (boxes[:, :2] - boxes[:, :2].min(axis=0)) / 25.4
    assert np.abs(apart - np.rint(apart)).max() < 0.01 / 25.4
    begin = re.search(rb"startxref\n(\d+)", out.read_bytes())
    assert begin is not None
    assert out.read_bytes()[int(begin[1]) :].startswith(b"xref")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--square-mm", "60"], "does not fit a4; print it on a2"),
        (["--marker-mm", "40"], "less than square_m"),
        (["--dictionary", "4X4_5"], "4X4_50"),
        (["--dictionary", "4X4_50", "--columns", "20", "--rows", "12"], "does not fit a4"),
    ],
)  # fmt: skip
def test_what_cannot_be_printed(
    flags: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["board", "--out", str(tmp_path / "board.pdf"), *flags]) == 2
    assert words in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "board.pdf").exists()


def test_a_dictionary_that_is_too_small(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--dictionary", "4X4_50", "--columns", "16", "--rows", "11", "--square-mm", "10"]
    assert run(["board", "--out", str(tmp_path / "board.pdf"), *flags]) == 2
    assert "take a larger one" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("kind", ["charuco", "tags"])
def test_tags_need_the_extra(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    assert run(["board", "--kind", kind, "--out", str(tmp_path / "b.pdf")]) == 2
    assert "pip install 'bodyschema[vision]'" in capsys.readouterr().err
