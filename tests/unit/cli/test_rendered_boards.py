"""Boards that MuJoCo draws: a camera on the arm, one beside it, and both with two boards."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cv2")
pytest.importorskip("mujoco")

import bodyschema as bs
from board_truth import corner_noise, figures, true_body
from bodyschema.cli import run
from bodyschema.cli.loading import load
from bodyschema.cli.run_file import read_run_file
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.pixels import Pixels
from rendered_board import BOTH, OPTICAL, Stage, Truth, write_rendered_folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    """Two boards and two cameras, one of them a head that sees both boards."""
    made = tmp_path_factory.mktemp("both")
    try:
        return made, write_rendered_folder(made, "both", 8, 1)
    except RuntimeError as error:  # no renderer here
        pytest.skip(str(error))


def test_the_scene_is_where_our_kinematics_have_it(folder: tuple[Path, Truth]) -> None:
    truth, q = folder[1], np.array([0.3, -0.4, 0.5, 0.2, -0.6, 0.9])
    stage, body = Stage(BOTH), folder[1].body
    stage.pose(q)
    for name, one in truth.fixed.items():
        T = relative_pose(body, q[None], "base", name)[0]
        if one.target is None:
            place = stage.data.cam_xpos[stage.model.camera(name).id]
            turn = stage.data.cam_xmat[stage.model.camera(name).id].reshape(3, 3) @ OPTICAL
        else:
            place, turn = stage.data.body(name).xpos, stage.data.body(name).xmat.reshape(3, 3)
        assert place == pytest.approx(T[:3, 3], abs=1e-9)
        assert turn == pytest.approx(T[:3, :3], abs=1e-9)
    stage.close()


def test_corners_are_found_where_they_are_drawn(folder: tuple[Path, Truth]) -> None:
    place, truth = folder
    senses = [s for s in load(read_run_file(place / "run.toml")).senses if isinstance(s, Pixels)]
    assert len(senses) == 3
    assert corner_noise(true_body(truth), senses) < 0.08


def test_two_cameras_and_two_boards_in_one_run(
    folder: tuple[Path, Truth], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place, truth = folder
    (place / "short.toml").write_text("folds = 2\n" + (place / "run.toml").read_text())
    asked = ["calibrate", str(place / "short.toml"), "--out", str(tmp_path / "out")]
    assert run([*asked, "--free", "offsets"]) == 0
    said = capsys.readouterr().out
    for name in ("T_flange_camera", "T_base_board", "T_base_head", "T_flange_plate"):
        assert name in said
    names = {path.name[:9] for path in (tmp_path / "out").glob("overlay_*.jpg")}
    assert names == {"overlay_1", "overlay_2", "overlay_3"}
    found = bs.load(tmp_path / "out").body
    q = np.zeros((1, 6))
    for a, b in (("board", "head"), ("link_5", "plate")):
        true = relative_pose(true_body(truth), q, a, b)[0, :3, 3]
        assert relative_pose(found, q, a, b)[0, :3, 3] == pytest.approx(true, abs=2e-3)


def test_a_calibration_is_near_the_cramer_rao_bound() -> None:
    try:
        row = figures("hand", 10, 2)
    except RuntimeError as error:  # no renderer here
        pytest.skip(str(error))
    assert row["camera_mm"] < 2 * row["bound_mm"] < 0.4
    assert row["coverage"] > 0.8
    assert row["zero_deg"] < 0.02
