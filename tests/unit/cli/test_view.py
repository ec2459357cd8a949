"""`bodyschema view`: a file, or a page on this machine alone; never over what is there."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema import lie
from bodyschema.cli import recall, run
from recorded_arm import recorded_arm
from simulated import random_pose


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run_file = recorded_arm(tmp_path_factory.mktemp("run"))
    out = run_file.parent / "result"
    assert run(["calibrate", str(run_file), "--out", str(out), "--json"]) == 0
    return out


def scene_of(page: Path) -> dict[str, Any]:
    (text,) = re.findall(r'id="scene">(.*?)</script>', page.read_text(encoding="utf-8"))
    return json.loads(text)


def test_a_file(result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "view.html"
    assert run(["view", str(result), "--html", str(page), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"html": str(page)}
    scene = scene_of(page)
    assert scene["verdict"] == "calibrated"
    assert len(scene["rows"]) == 25
    assert len(scene["marks"]) == 1
    assert scene["before"]


def test_what_is_there_stays(
    result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "mine.html"
    page.write_text("mine")
    assert run(["view", str(result), "--html", str(page)]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert page.read_text() == "mine"
    assert run(["view", str(result), "--html", str(result / "robot.urdf"), "--overwrite"]) == 2
    assert run(["view", str(result), "--html", str(page), "--overwrite"]) == 0
    assert scene_of(page)["title"].startswith("Calibration of")


def test_it_needs_no_extra(result: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("jinja2", "matplotlib", "trimesh", "viser", "cv2", "pyarrow"):
        monkeypatch.setitem(sys.modules, package, None)
    assert run(["view", str(result), "--html", str(tmp_path / "view.html")]) == 0


def test_a_result_whose_recording_is_gone(result: Path, tmp_path: Path) -> None:
    table = result.parent / "data.csv"
    away = table.rename(tmp_path / "data.csv")
    try:
        assert run(["view", str(result), "--html", str(tmp_path / "view.html")]) == 0
    finally:
        away.rename(table)
    scene = scene_of(tmp_path / "view.html")
    assert scene["marks"] == []
    assert any("not at hand" in note for note in scene["notes"])


def test_packages_that_are_none_are_a_note(result: Path, tmp_path: Path) -> None:
    """Found by the fuzz bench: a TypeError."""
    copy = tmp_path / "copy"
    shutil.copytree(result, copy)
    record = json.loads((copy / "run.json").read_text())
    (copy / "run.json").write_text(json.dumps(record | {"packages": [[[]]]}))
    assert run(["view", str(copy), "--html", str(tmp_path / "view.html")]) in (0, 2)


def test_postures_of_a_run_without_senses(
    result: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pictures and forces are no senses that are read again; the joints are."""
    monkeypatch.setattr(recall, "recall", lambda *_: recall.Recalled((), (), ()))
    assert run(["view", str(result), "--html", str(tmp_path / "view.html")]) == 0
    scene = scene_of(tmp_path / "view.html")
    assert scene["rows"] == list(range(25))
    assert not any("not at hand" in note for note in scene["notes"])


def test_hand_and_eye_without_a_robot(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    A = np.array([random_pose(rng, 0.4) for _ in range(20)])
    X, Y = random_pose(rng, 0.1), random_pose(rng, 1.0)
    noise = lie.transform(
        lie.exp_so3(1e-3 * rng.normal(size=(20, 3))), 5e-4 * rng.normal(size=(20, 3))
    )
    answer = bs.learn_hand_eye(A, lie.inverse(Y) @ A @ X @ noise, eye_on="base")
    answer.save(tmp_path / "found")
    assert run(["view", str(tmp_path / "found"), "--html", str(tmp_path / "view.html")]) == 0
    scene = scene_of(tmp_path / "view.html")
    assert scene["title"] == "Hand and eye"
    assert {one["name"] for one in scene["placed"]} == {"eye", "target"}
    assert scene["before"] is None


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--package", "arm"], "NAME=FOLDER"),
        (["--package", "arm=/nowhere"], "NAME=FOLDER"),
        (["--robot", "/nowhere.urdf"], "no robot description"),
    ],
)
def test_bad_flags(
    result: Path, capsys: pytest.CaptureFixture[str], flags: list[str], words: str
) -> None:
    assert run(["view", str(result), *flags]) == 2
    assert words in capsys.readouterr().err


def test_it_is_served_until_ctrl_c(result: Path) -> None:
    command = [sys.executable, "-c", "from bodyschema.cli import main; main()"]
    done = subprocess.Popen(
        [*command, "view", str(result), "--json"], stdout=subprocess.PIPE, text=True,
        env={**os.environ, "BROWSER": "false"},
    )  # fmt: skip
    try:
        assert done.stdout is not None
        url = json.loads(done.stdout.readline())["url"]
        assert url.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(url, timeout=10) as answer:
            assert b"Calibration of" in answer.read()
        done.send_signal(signal.SIGINT)
        assert done.wait(10) == 0
    finally:
        done.kill()
        done.communicate()
