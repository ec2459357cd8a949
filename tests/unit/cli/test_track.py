"""`bodyschema track` on pictures of a small arm of boxes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.imagination.contours import silhouette
from bodyschema.imagination.poses import piece_poses

cv2 = pytest.importorskip("cv2")
pytest.importorskip("trimesh")

LINK = """<link name="{name}"><visual><origin xyz="0 0 {z}"/>
<geometry><box size="{size}"/></geometry></visual></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{up}"/><child link="{down}"/>
<origin xyz="0 0 {z}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/>
</joint>"""
ROBOT = "\n".join(
    [
        '<robot name="boxes"><link name="base"/>',
        LINK.format(name="upper", z=0.15, size="0.06 0.09 0.3"),
        LINK.format(name="fore", z=0.1, size="0.05 0.03 0.2"),
        JOINT.format(name="lift", up="base", down="upper", z=0, axis="0 1 0"),
        JOINT.format(name="bend", up="upper", down="fore", z=0.3, axis="0 1 0"),
        "</robot>",
    ]
)
TRACK = """
robot = "arm.urdf"
recording = "joints.csv"
hand = "fore"
[free]
joints = ["lift", "bend"]
[cameras.eye]
parent = "base"
xyz = [0.0, 1.2, 0.2]
rpy = [1.5707963267948966, 0.0, 0.0]
size = [320, 240]
lens = [300.0, 300.0, 159.5, 119.5]
images = "image_{row:03}.png"
masks = "mask_{row:03}.png"
"""
WRONG = np.deg2rad([4, -6])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A robot, its encoders, which are wrong, and what a camera saw."""
    (tmp_path / "arm.urdf").write_text(ROBOT)
    (tmp_path / "track.toml").write_text(TRACK)
    q = np.array([[-0.5, 0.9], [0.1, 0.5], [0.6, -1.0], [0.3, 1.2]])
    rows = "\n".join(f"{a},{b}" for a, b in q)
    (tmp_path / "joints.csv").write_text(f"lift,bend\n{rows}\n")
    body = bs.Body.from_urdf(tmp_path / "arm.urdf")
    T = np.array([[1, 0, 0, 0], [0, 0, -1, 1.2], [0, 1, 0, 0.2], [0, 0, 0, 1.0]])
    body = body.attach("eye", "base", T)
    K = np.array([[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1.0]])
    camera, surface = bs.Camera("eye", "eye", 320, 240, K), bs.Surface.of(body)
    for i, pose in enumerate(piece_poses(body, q + WRONG, [camera], surface.frames)[:, 0]):
        mask = silhouette(surface, pose, camera).astype(np.uint8) * 255
        cv2.imwrite(str(tmp_path / f"mask_{i:03}.png"), mask)
        cv2.imwrite(str(tmp_path / f"image_{i:03}.png"), np.repeat(mask[..., None], 3, 2))
    return tmp_path


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
    assert answer == json.loads((out / "track.json").read_text())
    found = [answer["parameters"][f"{name}.offset"] for name in ("lift", "bend")]
    np.testing.assert_allclose([f["value"] for f in found], WRONG, atol=np.deg2rad(0.3))
    assert all(f["std"] < np.deg2rad(0.3) for f in found)
    assert len(answer["frames"]) == 4
    assert not any(frame["lost"] for frame in answer["frames"])
    assert np.shape(answer["frames"][0]["covariance"]) == (6, 6)
    assert answer["not_identifiable"] == []
    assert len(list(out.glob("overlay_*.png"))) == 1


def test_an_arm_that_is_not_there_is_a_no(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in folder.glob("mask_*.png"):
        cv2.imwrite(str(path), np.zeros((240, 320), np.uint8))
    command = ["track", str(folder / "track.toml"), "--out", str(folder / "out")]
    assert run([*command, "--seeds", "0", "--overlays", "0"]) == 1
    said = capsys.readouterr().out
    assert "not found in the pictures" in said
    assert "lost in 4 of 4 rows" in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("lens =", "lense ="), "unknown key 'lense'"),
        (("[320, 240]", "[320]"), "needs size"),
        (("image_{row:03}", "image_{number}"), "write {row}"),
        (("mask_{row:03}", "nothing_{row}"), "no picture at"),
        (("cameras.eye", "eyes.eye"), "names no camera"),
        (('hand = "fore"', 'hand = "for"'), "fore"),
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
