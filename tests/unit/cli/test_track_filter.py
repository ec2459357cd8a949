"""`bodyschema track --method particle-filter` on pictures of a small arm of boxes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.learners.images.recorded_filter import NARROW, filtered, held_out_moments
from bodyschema.model.variables import free_joints
from bodyschema.senses.images import Images
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from small_arm import CAMERA, TRACK, WRONG, write_arm

cv2 = pytest.importorskip("cv2")
pytest.importorskip("trimesh")

COUNT = 30
T = np.linspace(0, 1, COUNT)
READ = np.column_stack([-0.6 + 1.2 * T, 0.9 * np.sin(5 * T) + 0.2])
HELD = [2, 7, 12, 17, 22, 27]


def record(folder: Path, q_true: np.ndarray) -> bs.Body:
    """Write the robot, its readings and what its eye saw of the true joints (n, 2)."""
    body = write_arm(folder)
    (folder / "track.toml").write_text(TRACK)
    rows = "\n".join(f"{a},{b}" for a, b in READ)
    (folder / "joints.csv").write_text(f"lift,bend\n{rows}\n")
    surface = bs.Surface.of(body)
    for i, pose in enumerate(piece_poses(body, q_true, [CAMERA], surface.frames)[:, 0]):
        mask = silhouette(surface, pose, CAMERA).astype(np.uint8) * 255
        cv2.imwrite(str(folder / f"mask_{i:03}.png"), mask)
        cv2.imwrite(str(folder / f"image_{i:03}.png"), np.repeat(mask[..., None], 3, 2))
    return body


def asked(folder: Path, *more: str) -> list[str]:
    return [
        "track", str(folder / "track.toml"), "--method", "particle-filter",
        "--out", str(folder / "out"), *more,
    ]  # fmt: skip


def test_the_published_filter_on_a_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(tmp_path, READ + WRONG)
    assert run([*asked(tmp_path), "--overlays", "1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["verdict"], answer["learner"]) == ("found", "particle-filter")
    assert "cameras, lenses and meshes are known" in answer["premises"][0]
    assert "overlap (Eq. 20" in answer["premises"][1]
    assert answer["trust"]["level"] == "limited"
    assert "no error bar" in answer["trust"]["reasons"][0]
    assert "3.2 times as wide" in answer["trust"]["reasons"][0]
    assert answer["moments"] == {"learned": 24, "held_out": 6}
    assert answer["held_out_pictures"] == HELD
    assert [f["frame"] for f in answer["frames"] if f["held_out"]] == HELD
    assert (
        answer["held_out"]["outline_px"]["median"] < 1 < answer["nominal"]["outline_px"]["median"]
    )
    assert 0.8 < answer["effective_size"]["first"] < answer["effective_size"]["last"] <= 1
    found = [entry["value"] for entry in answer["parameters"]]
    np.testing.assert_allclose(found, WRONG, atol=np.deg2rad(2.5))
    assert found == pytest.approx(answer["frames"][-1]["offsets"])
    stored = bs.load(tmp_path / "out")
    np.testing.assert_allclose(stored.body.offset, found)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "The filter, picture by picture" in page
    assert len(list((tmp_path / "out").glob("overlay_*.png"))) == 1
    written = json.loads((tmp_path / "out" / "track.json").read_text())
    assert written["frames"] == answer["frames"]
    assert run(["plan", str(tmp_path / "out")]) == 0
    assert "does not say which posture" in capsys.readouterr().out
    check = ["check", str(tmp_path / "out"), "--recording", str(tmp_path / "track.toml")]
    assert run(check) == 2
    assert "has no error bar to check it against" in capsys.readouterr().err


def test_without_masks_edges_are_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(tmp_path, READ + WRONG)
    text = TRACK.replace('masks = "mask_{row:03}.png"\n', "")
    (tmp_path / "track.toml").write_text(text)
    more = ("--edges", "outline", "--overlays", "0", "--json", "--force")
    run([*asked(tmp_path), *more])
    answer = json.loads(capsys.readouterr().out)
    assert "edges of the outline alone, with lambda 0.01" in answer["premises"][1]
    assert answer["effective_size"]["last"] > 0.99
    assert "--edges outline" in json.loads((tmp_path / "out" / "run.json").read_text())["command"]


def test_what_does_not_hold_in_other_pictures_is_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    q = READ + WRONG
    q[HELD] = READ[HELD]
    record(tmp_path, q)
    assert run([*asked(tmp_path), "--overlays", "0", "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["trust"]["level"] == "contradicted"
    assert "held out" in answer["trust"]["reasons"][0]
    assert not (tmp_path / "out").exists()


def test_an_arm_that_is_not_there_is_a_no(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(tmp_path, READ + WRONG)
    for path in tmp_path.glob("mask_*.png"):
        cv2.imwrite(str(path), np.zeros((240, 320), np.uint8))
    assert run([*asked(tmp_path), "--overlays", "0"]) == 1
    said = capsys.readouterr().out
    assert said.split()[:2] == ["not", "found"]
    assert "Nothing was corrected" in said
    assert not list((tmp_path / "out").glob("*.urdf"))


def test_held_out_moments_are_not_learned_from(tmp_path: Path) -> None:
    body = record(tmp_path, READ + WRONG)
    surface = bs.Surface.of(body)
    learner, variables = bs.ParticleFilter(surface, particles=20), free_joints(body, ["offsets"])
    poses = piece_poses(body, READ + WRONG, [CAMERA], surface.frames)[:, 0]

    def moments(spoilt: bool) -> list[Images]:
        masks = [silhouette(surface, pose, CAMERA) for pose in poses]
        for k in HELD if spoilt else ():
            masks[k] = np.zeros_like(masks[k])
        return [Images(0.0, q, (CAMERA,), (m,)) for q, m in zip(READ, masks, strict=True)]

    good, bad = (filtered(learner, body, variables, moments(s), COUNT) for s in (False, True))
    assert good.held == tuple(HELD)
    np.testing.assert_array_equal(good.infos[-1].offsets, bad.infos[-1].offsets)
    assert bad.found is False
    x = good.infos[-1].offsets
    by_filter = learner.start(body, ["lift", "bend"]).error.hand_poses(
        body, READ[0], x[None], "eye", "fore"
    )[0]
    told = bs.relative_pose(good.estimate(-1).body, READ[0], "eye", "fore")
    np.testing.assert_allclose(by_filter, told, atol=1e-12)
    prior = np.eye(2) / learner.prior**2
    told = np.linalg.inv(good.infos[-1].covariance) - prior
    stated = np.linalg.inv(good.estimate(-1).covariance) - prior
    np.testing.assert_allclose(stated, told / NARROW**2, rtol=1e-6)


def test_few_moments_leave_one_to_test_in() -> None:
    assert held_out_moments(2) == (1,)
    assert held_out_moments(5) == (2,)
    with pytest.raises(bs.InputError, match="2 moments or more"):
        held_out_moments(1)


@pytest.mark.parametrize(
    ("change", "flags", "message"),
    [
        (("[cameras.eye]", '[cameras.eye]\nknown = "roughly"'), (), "takes cameras at their word"),
        (("", ""), ("--particles", "2"), "2 particles cannot show how 2 offsets go together"),
        (("", ""), ("--particles", "1"), "give 2 or more"),
        (("joints.csv", "one.csv"), (), "2 moments or more"),
        (("arm.urdf", "slide.urdf"), (), "bend.offset is a length"),
    ],
)
def test_what_the_filter_cannot_use_is_told(
    tmp_path: Path,
    change: tuple[str, str],
    flags: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    record(tmp_path, READ + WRONG)
    (tmp_path / "track.toml").write_text(TRACK.replace(*change))
    (tmp_path / "one.csv").write_text("lift,bend\n0.1,0.2\n")
    head, bend = (tmp_path / "arm.urdf").read_text().split('<joint name="bend"')
    slide = bend.replace("revolute", "prismatic")
    (tmp_path / "slide.urdf").write_text(f'{head}<joint name="bend"{slide}')
    assert run(asked(tmp_path, "--overlays", "0", *flags)) == 2
    assert message in capsys.readouterr().err
