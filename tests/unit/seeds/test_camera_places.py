"""A camera that nobody has placed is placed by masks of a real arm."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema import lie
from bodyschema.seeds.camera_places import camera_places
from bodyschema.senses.images import Images

cv2 = pytest.importorskip("cv2")
pytest.importorskip("collada")

OPTICAL = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
LENS = np.array([[534.6265, 0, 478.0846], [0, 534.6265, 260.9944], [0, 0, 1]])


def test_five_masks_place_a_camera_near_enough_to_be_refined(
    shared_data: Callable[[str], Path],
) -> None:
    data = shared_data("roboreg_med7_zed2i")
    body = bs.Body.from_urdf(data / "lbr_med7_r800.urdf").attach("eye", "lbr_link_0")
    eye = bs.Camera("eye", "eye", 960, 540, LENS)
    frames = [
        Images(
            float(i),
            np.load(data / f"stereo/joint_states_{i}.npy").astype(float),
            (eye,),
            (cv2.imread(str(data / f"stereo/mask_sam2_left_image_{i}.png"), 0) > 0,),
        )
        for i in range(5)
    ]
    true = np.load(data / "stereo/HT_cam_swarm.npy").reshape(4, 4) @ OPTICAL
    off = []
    for T in camera_places(bs.Surface.of(body, faces=600), body, "eye", frames):
        apart = lie.inverse(true) @ T
        turn = np.linalg.norm(lie.log_so3(apart[:3, :3]))
        off.append((float(turn), float(np.linalg.norm(apart[:3, 3]))))
    assert 1 < len(off) <= 4
    assert min(turn for turn, _ in off) < 0.4
    assert min(metres for _, metres in off) < 0.5
    blank = [Images(f.time, f.q, f.cameras, (np.zeros((540, 960), np.uint8),)) for f in frames]
    with pytest.raises(bs.InputError, match="say roughly where it is"):
        camera_places(bs.Surface.of(body, faces=600), body, "eye", blank)
