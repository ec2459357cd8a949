"""`bodyschema track` on pictures of a small arm of boxes."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.cli.run_file import read_run_file
from bodyschema.cli.tracking.album import Album
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration
from bodyschema.learners.images.picture_weights import PictureWeights
from bodyschema.report.application import Application
from bodyschema.report.evidence import Evidence
from bodyschema.report.tracking.words import warnings
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from small_arm import CAMERA, POSTURES, TRACK, WRONG, write_arm

cv2 = pytest.importorskip("cv2")
pytest.importorskip("trimesh")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A robot, its encoders, which are wrong, and what a camera saw."""
    body, camera, q = write_arm(tmp_path), CAMERA, POSTURES
    (tmp_path / "track.toml").write_text(TRACK)
    rows = "\n".join(f"{a},{b}" for a, b in q)
    (tmp_path / "joints.csv").write_text(f"lift,bend\n{rows}\n")
    surface = bs.Surface.of(body)
    for i, pose in enumerate(piece_poses(body, q + WRONG, [camera], surface.frames)[:, 0]):
        mask = silhouette(surface, pose, camera).astype(np.uint8) * 255
        cv2.imwrite(str(tmp_path / f"mask_{i:03}.png"), mask)
        cv2.imwrite(str(tmp_path / f"image_{i:03}.png"), np.repeat(mask[..., None], 3, 2))
    return tmp_path


def test_a_camera_that_stands_elsewhere_is_doubted(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = TRACK.replace("xyz = [0.0, 1.2, 0.2]", "xyz = [0.02, 1.2, 0.18]")
    (folder / "track.toml").write_text(text)
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out"), "--force"]
    run([*command, "--overlays", "0", "--seeds", "64", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert answer["cameras_elsewhere"]["p_value"] < 0.01
    assert answer["trust"]["level"] != "good"
    assert "The pictures move camera 'eye' by" in answer["trust"]["reasons"][0]


@pytest.mark.parametrize("masked", [True, False])
def test_offsets_and_poses_are_written(
    folder: Path, capsys: pytest.CaptureFixture[str], masked: bool
) -> None:
    if not masked:
        text = TRACK.replace('masks = "mask_{row:03}.png"\n', "")
        (folder / "track.toml").write_text(text)
    out = folder / "out"
    command = ["track", str(folder / "track.toml"), "--out", str(out), "--seeds", "64"]
    assert run([*command, "--overlays", "1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["frames_per_second"] > 0
    written = json.loads((out / "track.json").read_text())
    assert written == {key: answer[key] for key in written}
    assert answer["verdict"] == "found"
    assert answer["trust"] == {"level": "good", "reasons": []}
    assert 0 < answer["predicted_95_mm"] < 30
    assert answer["cameras_elsewhere"]["p_value"] > 0.01
    assert (answer["pictures"]["used"], answer["pictures"]["of"]) == (4, 4)
    assert "4 of 4 pictures used" in answer["explanation"]
    assert "pictures used" in (out / "report.html").read_text()
    assert answer["held_out"]["outline_px"]["rms"] < 0.5 < answer["nominal"]["outline_px"]["rms"]
    told = {entry["name"]: entry for entry in answer["parameters"]}
    found = [told[f"{name}.offset"] for name in ("lift", "bend")]
    np.testing.assert_allclose([f["value"] for f in found], WRONG, atol=np.deg2rad(0.3))
    assert all(f["std"] < np.deg2rad(0.3) for f in found)
    assert len(answer["frames"]) == 4
    assert not any(frame["lost"] for frame in answer["frames"])
    assert np.shape(answer["frames"][0]["covariance"]) == (6, 6)
    assert answer["unidentifiable"] == []
    assert len(list(out.glob("overlay_*.png"))) == 1
    stored = bs.load(out)
    np.testing.assert_allclose(stored.estimate.x, [f["value"] for f in found])
    assert stored.body.offset == pytest.approx(stored.estimate.x)


def test_a_tracked_robot_is_checked_in_new_pictures(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, path = str(folder / "out"), str(folder / "track.toml")
    assert run(["track", path, "--out", out, "--seeds", "64", "--overlays", "0"]) == 0
    assert run(["check", out, "--recording", str(folder / "joints.csv")]) == 2
    assert "give the run file" in capsys.readouterr().err
    assert run(["check", out, "--recording", path, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "still true"
    bent = "\n".join(f"{a},{b - np.deg2rad(1.0)}" for a, b in POSTURES)
    (folder / "joints.csv").write_text(f"lift,bend\n{bent}\n")
    assert run(["check", out, "--recording", path, "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert [suspect["part"] for suspect in answer["suspects"]] == ["bend"]
    assert answer["suspects"][0]["change"]["bend.offset"] == pytest.approx(np.deg2rad(1), rel=0.2)
    assert run(["plan", out]) == 0
    assert "One more moment with" in capsys.readouterr().out


def test_an_answer_that_most_pictures_speak_against_is_not_written(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for k in (0, 1):
        cv2.imwrite(str(folder / f"mask_{k:03}.png"), np.zeros((240, 320), np.uint8))
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out")]
    command += ["--seeds", "64", "--overlays", "0"]
    assert run([*command, "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["trust"]["level"] == answer["verdict"] == "contradicted"
    assert "Only 2 of 4 pictures show the body" in answer["trust"]["reasons"][0]
    assert not (folder / "out").exists()
    assert run([*command, "--force"]) == 1
    assert (folder / "out" / "report.html").is_file()


def test_a_camera_that_nobody_has_placed_asks_for_masks(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = TRACK.replace('masks = "mask_{row:03}.png"\n', "").replace(
        "[cameras.eye]", '[cameras.eye]\nknown = "no"'
    )
    (folder / "track.toml").write_text(text)
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out")]
    assert run([*command, "--seeds", "8", "--overlays", "0"]) == 2
    assert 'say roughly where it is (known = "roughly")' in capsys.readouterr().err


def test_an_arm_that_is_not_there_is_a_no(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in folder.glob("mask_*.png"):
        cv2.imwrite(str(path), np.zeros((240, 320), np.uint8))
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out")]
    assert run([*command, "--seeds", "0", "--overlays", "0"]) == 1
    said = capsys.readouterr().out
    assert said.split()[:2] == ["not", "found"]
    assert "lost in 4 of 4 rows" in said
    assert "Nothing was corrected" in said
    page = (folder / "out" / "report.html").read_text()
    assert "Not found" in page
    assert "Nothing was corrected" in page
    assert not list((folder / "out").glob("*.urdf"))
    assert run(["export", str(folder / "out"), "--robot", str(folder / "arm.urdf")]) == 2
    assert "there is nothing to export" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("lens =", "lense ="), "unknown key 'lense'"),
        (("[320, 240]", "[320]"), "needs size"),
        (("[320, 240]", "[640, 480]"), "'eye' has 640 x 480 pixels, and its picture 320 x 240"),
        (("image_{row:03}", "image_{number}"), "write {row}"),
        (("mask_{row:03}", "nothing_{row}"), "no picture at"),
        (("cameras.eye", "eyes.eye"), "names no camera"),
        (('hand = "fore"', 'hand = "for"'), "fore"),
        (('hand = "fore"', ""), "lacks the key 'hand'"),
        (
            (
                "[cameras.eye]",
                '[wrench]\ncolumns = []\nframe = "base"\nsign = "on_object"\n[cameras.eye]',
            ),
            "is read by 'bodyschema payload and touch'",
        ),
        (('robot = "arm.urdf"', "robot = 3"), "robot = 3 in 'track.toml'; expected text"),
        (("[cameras.eye]", "[cameras]\neye = 3\n[other]"), "must be a section with keys"),
        (("[0.0, 1.2, 0.2]", "[0.0, 1.2]"), "must be three numbers"),
        (("[0.0, 1.2, 0.2]", "[nan, 1.2, 0.2]"), "expected a list, each a finite number"),
        (('"bend"]', '"bend"]\noffset_deg = nan'), "expected a finite number"),
        (('"bend"]', '"bend"]\noffset_deg = -1'), "a standard deviation above zero"),
        (('["lift", "bend"]', '"lift"'), "expected a list, each text"),
        (('["lift", "bend"]', "[]"), "names no joints"),
    ],
)
def test_what_cannot_be_read_is_told(
    folder: Path, change: tuple[str, str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = TRACK.replace(*change)
    if "image" in change[0]:
        text = text.replace('masks = "mask_{row:03}.png"\n', "")
    (folder / "track.toml").write_text(text)
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out"), "--seeds", "0"]
    assert run(command) == 2
    assert message in capsys.readouterr().err


def test_a_joint_that_slides_is_doubted_and_told_in_mm(folder: Path) -> None:
    """Its offset is a length: neither 8 degrees nor any other angle."""
    urdf = (folder / "arm.urdf").read_text()
    head, bend = urdf.split('<joint name="bend"')
    slide = bend.replace("revolute", "prismatic")
    assert slide != bend
    (folder / "arm.urdf").write_text(f'{head}<joint name="bend"{slide}')
    album = Album.open(read_run_file(folder / "track.toml", "track"))
    variables = album.variables
    np.testing.assert_allclose(variables.prior_std, [np.deg2rad(8), 0.005])
    said = Identifiability(8, (), np.zeros(2))
    estimate = Estimate(album.body, variables, np.array([0.01, 0.01]), 1e6 * np.eye(2))
    none = Accuracy({}, {})
    found = Calibration("found", "", estimate, none, none, said, (), 1, groups=("offsets",))
    page = Application(Evidence(found, album.nominal, (), {"robot": "arm.urdf"})).render()
    assert "lift.offset  +0.573 deg" in page
    assert "bend.offset  +10.000 mm" in page


def test_a_hand_that_never_shows_is_told_apart_from_a_body_that_is_not_there() -> None:
    pose = SimpleNamespace(lost=True)
    weights = PictureWeights(np.ones((2, 1)), np.ones(1))
    fit = SimpleNamespace(lost=False, bias=np.zeros(1), weights=weights)
    evidence: Any = SimpleNamespace(
        fit=fit, lost=np.array([True, True]), poses=[pose, pose], hand="fore", kept=(),
        cameras=("eye",), numbers=[0, 1],
    )  # fmt: skip
    assert any("is something mounted on it?" in line for line in warnings(evidence))
    fit.lost = True
    assert not any("is something mounted on it?" in line for line in warnings(evidence))


def test_who_takes_lens_and_meshes_at_their_word_is_surer(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["track", str(folder / "track.toml"), "--seeds", "0", "--overlays", "0", "--json"]
    spread = []
    for section in ("", "[doubts]\nfocal_percent = 0\ncentre_px = 0\nturn_deg = 0\nshape_mm = 0\n"):
        (folder / "track.toml").write_text(TRACK + section)
        assert run([*command, "--out", str(folder / f"out_{len(spread)}")]) == 0
        answer = json.loads(capsys.readouterr().out)
        spread.append(np.trace(np.array(answer["frames"][0]["covariance"])[:3, :3]))
    assert spread[1] < spread[0] / 4
    (folder / "track.toml").write_text(TRACK + "[doubts]\nfocal_percent = -1\n")
    assert run([*command, "--out", str(folder / "out")]) == 2
    assert "standard deviation, 0 or more" in capsys.readouterr().err
