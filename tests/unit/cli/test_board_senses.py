"""Photographs of a board through `calibrate`: drawn pictures, known truth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from board_folder import CHARUCO, Truth, write_board_folder
from bodyschema.cli import run
from bodyschema.model.camera import Camera
from bodyschema.vision.targets.target import Target

cv2 = pytest.importorskip("cv2")


def calibrated(
    folder: Path, capsys: pytest.CaptureFixture[str], *flags: str
) -> tuple[int, dict[str, Any], str]:
    asked = ["calibrate", str(folder / "run.toml"), "--out", str(folder / "out"), "--json"]
    code = run([*asked, "--free", "offsets", *flags])
    said = capsys.readouterr()
    return code, json.loads(said.out) if said.out else {}, said.out + said.err


def assert_right(answer: dict[str, Any], truth: Truth) -> None:
    """Zeros within their error bars; a drawn pixel is off by some hundredths itself."""
    found = {p["name"]: p for p in answer["parameters"]}
    names = ("shoulder_lift", "elbow", "wrist_1", "wrist_2")
    for name, true in zip(names, truth.offsets[1:5], strict=True):
        one = found[f"{name}.offset"]
        assert abs(one["value"] - true) < 4 * one["std"] + 1e-4, name


def test_lens_camera_board_and_zeros_in_one_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nobody knows anything but the board; and a lens of which no word is said is 600 px long."""
    truth = write_board_folder(tmp_path)
    code, answer, _ = calibrated(tmp_path, capsys)
    assert code == 0
    assert answer["trust"]["level"] == "good"
    assert answer["held_out"]["image_px"]["rms"] < 0.1
    assert_right(answer, truth)
    assert any("in 15 of 15 pictures" in note for note in answer["notes"])


def test_the_camera_is_answered_though_the_end_joints_are_open(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is said of joints: the verdict speaks of the camera, and of what stays open."""
    write_board_folder(tmp_path, 20, 1)
    asked = ["calibrate", str(tmp_path / "run.toml"), "--out", str(tmp_path / "out"), "--json"]
    assert run(asked) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["verdict"], answer["trust"]["level"]) == ("calibrated", "good")
    assert answer["predicted_95_mm"] < 1
    places = {place["name"]: place for place in answer["transforms"]}
    assert {"T_flange_camera", "T_base_board", "T_board_camera"} <= set(places)
    assert "wrist_3" in str(places["T_flange_camera"])
    # Who asks for the arm itself is told that pictures do not tell it.
    text = (tmp_path / "run.toml").read_text()
    (tmp_path / "run.toml").write_text(text + '[[wanted]]\nseen = "flange"\n')
    run([*asked, "--overwrite"])
    arm = json.loads(capsys.readouterr().out)
    assert arm["predicted_95_mm"] > 10 * answer["predicted_95_mm"]


def test_pictures_of_another_board_are_held_off(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = write_board_folder(tmp_path, others=(2, 7, 11))
    _, answer, _ = calibrated(tmp_path, capsys)
    assert_right(answer, truth)
    assert set(answer["outliers"]) == {2, 7, 11}


def test_blurred_pictures_are_left_out_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A fifth of all is smeared or shows another board: the rest is as right as ever."""
    truth = write_board_folder(tmp_path, 20, blurred=(3, 13), others=(7, 17))
    _, answer, _ = calibrated(tmp_path, capsys)
    assert_right(answer, truth)
    assert answer["held_out"]["image_px"]["rms"] < 0.1
    assert set(answer["outliers"]) == {7, 17}
    assert any("3.png, 13.png" in note for note in answer["notes"])
    assert any("in 18 of 20 pictures" in note for note in answer["notes"])
    assert any("Held off by the fit: 7.png, 17.png." in note for note in answer["notes"])
    drawn = {path.name for path in (tmp_path / "out").glob("overlay_*.jpg")}
    assert drawn == {f"overlay_{row:04}.jpg" for row in range(20)}
    page = (tmp_path / "out" / "report.html").read_text()
    assert "3.png: is blurred; left out." in page
    assert page.count("held off by the fit.") == 2 * 2


@pytest.mark.parametrize(("model", "stated"), [("fisheye", False), ("rational", True)])
def test_lenses_of_other_models(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], model: str, stated: bool
) -> None:
    """One of which no word is said, and one whose focal length is 1 % off."""
    k = {"fisheye": [0.05, -0.02, 0.006, -0.001], "rational": [0.3, 0.05, 0, 0, 0, 0.4, 0.1, 5e-3]}
    K = np.array([[280.0, 0, 320], [0, 280, 240], [0, 0, 1]])
    camera = Camera("lens", "lens", 640, 480, K, np.array(k[model]), fisheye=model == "fisheye")
    said = f"fx = 283.0\nfy = 283.0\ndistortion = {k[model]}" if stated else 'known = "no"'
    lens = f'{said}\nmodel = "{model}"'
    truth = write_board_folder(tmp_path, 10, 1, lens=lens, camera=camera)
    code, answer, _ = calibrated(tmp_path, capsys)
    assert code == 0
    assert answer["held_out"]["image_px"]["rms"] < 0.15
    assert_right(answer, truth)


def test_squares_of_another_size_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = replace(CHARUCO, square_m=1.05 * CHARUCO.square_m, marker_m=1.05 * CHARUCO.marker_m)
    truth = write_board_folder(tmp_path, declared=wrong, lens="fx = 600.0")
    code, answer, said = calibrated(tmp_path, capsys, "--force")
    assert_right(answer, truth)
    assert code == 1 or answer["trust"]["level"] == "contradicted"
    assert "0.952" in said
    assert any("declared lengths" in str(one) for one in answer["findings"])
    scale = next(p for p in answer["parameters"] if p["name"] == "size_of_board.scale")
    assert 1 + scale["value"] == pytest.approx(1 / 1.05, abs=2e-3)


def test_a_board_that_looks_the_same_turned_round(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """9 x 7 corners come out either way round; the postures tell which."""
    truth = write_board_folder(tmp_path, target=Target("chessboard", 9, 7, 0.013))
    code, answer, _ = calibrated(tmp_path, capsys)
    assert code == 0
    assert answer["held_out"]["image_px"]["rms"] < 0.2
    assert_right(answer, truth)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("size = [640, 480]", "size = [1280, 720]", "have 640 x 480 pixels"),
        ("size = [640", 'model = "fishy"\nsize = [640', "model = 'fishy' in [parts.lens]"),
        (
            "size = [640",
            'fx = 600.0\nmodel = "fisheye"\ndistortion = [0, 0, 0, 0, 0]\nsize = [640',
            "has 5 numbers, and a lens of model 'fisheye' has 4",
        ),
        ("columns = 7", "columns = 9", "check columns, rows, dictionary"),
        ('kind = "charuco"', 'kind = "charucco"', "did you mean 'charuco'"),
        ("target = {", "target = [] # {", "is a table, such as"),
        ("{row}.png", "{row}.jpg", "0.jpg"),
        ('known = "no"\nsize', "size", 'known = "no"'),
    ],
)
def test_what_cannot_be_used_ends_in_a_sentence(
    pictures: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    old: str,
    new: str,
    words: str,
) -> None:
    text = (pictures / "run.toml").read_text()
    assert old in text
    for name in ("arm.urdf", "joints.csv", "shots"):
        text = text.replace(f'"{name}', f'"{pictures}/{name}')
    (tmp_path / "run.toml").write_text(text.replace(old, new))
    code, _, said = calibrated(tmp_path, capsys)
    assert code == 2
    assert words in said.replace("\n", " ")


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    write_board_folder(folder, n=3)
    return folder
