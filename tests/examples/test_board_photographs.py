"""docs/board_photographs.md, executed on pictures of a board that were drawn here."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from board_folder import write_board_folder
from bodyschema.cli import run

pytest.importorskip("cv2")

PAGE = (Path(__file__).parents[2] / "docs" / "board_photographs.md").read_text(encoding="utf-8")


def test_the_page_goes_from_photographs_to_the_camera(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = write_board_folder(tmp_path, n=15)
    whole, _ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "run.toml").write_text(whole)
    monkeypatch.chdir(tmp_path)
    for command in re.findall(r"```sh\n(.*?)\n```", PAGE, re.DOTALL):
        assert run([*shlex.split(command)[1:], "--json"]) == 0
    answer = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "camera" / "robot.urdf").is_file()
    found = {p["name"]: p for p in answer["parameters"]}
    elbow = found["elbow.offset"]
    assert abs(elbow["value"] - truth.offsets[2]) < 4 * elbow["std"] + 1e-4
