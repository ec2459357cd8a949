"""The script of docs/board_photographs.md on pictures of a board that were drawn here."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.cli.run_file import run_from_table
from bodyschema.senses.layouts import poses_from_columns
from bodyschema.sources.tables import open_recording

cv2 = pytest.importorskip("cv2")

PAGE = (Path(__file__).parents[2] / "docs" / "board_photographs.md").read_text(encoding="utf-8")
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])
SQUARE = 0.025


def drawn(T_camera_board: np.ndarray) -> np.ndarray:
    """A picture (480, 640) of a chessboard of 9 by 6 squares, its first inner corner the origin."""
    px = 40
    squares = np.add.outer(np.arange(6), np.arange(9)) % 2
    sheet = np.full((8 * px, 11 * px), 255, np.uint8)
    sheet[px:-px, px:-px] = np.kron(255 * squares, np.ones((px, px))).astype(np.uint8)
    # Pixel centres lie half a pixel off the edges of the squares.
    to_board = np.array([[1.0, 0, -2 * px + 0.5], [0, 1.0, -2 * px + 0.5], [0, 0, px / SQUARE]])
    homography = K @ T_camera_board[:3, [0, 1, 3]] @ (to_board * (SQUARE / px))
    large = cv2.warpPerspective(
        sheet, np.diag([4, 4, 1]) @ homography, (2560, 1920), borderValue=128, flags=cv2.INTER_AREA
    )
    return np.asarray(cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA))


def test_the_script_finds_the_poses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(4)
    (tmp_path / "shots").mkdir()
    truth = []
    for i in range(12):
        turn = lie.exp_so3(rng.uniform(-0.6, 0.6, 3) * [1, 1, 0.4])
        centre = np.array([3.5, 2.0, 0.0]) * SQUARE
        place = np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(0.35, 0.5)]) - turn @ centre
        truth.append(lie.transform(turn, place))
        picture = np.full((480, 640), 90, np.uint8) if i == 5 else drawn(truth[-1])
        cv2.imwrite(str(tmp_path / "shots" / f"{i:02}.png"), picture)
    monkeypatch.chdir(tmp_path)
    (script,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(script, "board_photographs.md", "exec"), {})
    table = open_recording(tmp_path / "board.csv")
    values, present = table.matrix(["x", "y", "z", "rx", "ry", "rz"], "1")
    assert np.flatnonzero(~present).tolist() == [5], "a picture without a board has empty cells"
    found = poses_from_columns(values[present], "xyz_rotvec", 1.0)
    # The detector counts from the other end of the board, always the same one.
    end = lie.transform(lie.exp_so3([0, 0, np.pi]), np.array([7.0, 4.0, 0.0]) * SQUARE)
    apart = lie.inverse(np.array(truth)[present] @ end) @ found
    assert np.linalg.norm(apart[:, :3, 3], axis=1).max() < 0.004
    assert np.linalg.norm(lie.log_so3(apart[:, :3, :3]), axis=1).max() < 0.01


def test_the_run_file_is_read(tmp_path: Path) -> None:
    import tomllib

    whole, _ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    run = run_from_table(tomllib.loads(whole), tmp_path, "the page")
    assert run.senses[0].kind == "pixels"
