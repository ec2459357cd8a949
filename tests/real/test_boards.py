"""Real photographs of boards: found, numbered, and better explained than by OpenCV's own chain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("cv2")

from board_sets import ur3e_sets
from boards import real_set
from bodyschema.cli.reading.board_pictures import grey_picture
from bodyschema.vision.targets.detection import find_target
from bodyschema.vision.targets.target import Target

Folder = Callable[[str], Path]


def test_a_chessboard_that_came_out_either_way_round(shared_data: Folder) -> None:
    """Half of the boards are numbered from the other end; the lens is not told."""
    folder = shared_data("ur3e_fixed_cameras")
    _, table, here, joints = next(ur3e_sets(folder))
    figures = real_set(table, here, joints)
    assert figures["pictures"] == 40
    assert figures["held_out_px"] < 0.5
    assert figures["held_out_px"] < 0.5 * figures["opencv_held_out_px"]


def test_what_was_drawn_over_a_board_is_no_corner(shared_data: Folder) -> None:
    """Marks beside the corners of 6 boards: a detector finds 8 corners in one of the pictures."""
    folder = shared_data("doosan_a0509_wrist")
    target = Target("charuco", 7, 5, 0.03, 0.022, "4X4_50")
    found = [find_target(target, grey_picture(path)) for path in folder.glob("images/*.jpg")]
    assert len(found) == 6
    seen = [one for one in found if one is not None]
    assert [(len(one), len(one.rejected)) for one in seen] == [(0, 8)]
