"""Real pictures of boards, as run files read them: `boards.py` calibrates each."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from board_folder import smeared
from bodyschema.cli.reading.board_pictures import grey_picture
from bodyschema.sources.tables import open_recording, write_table

RealSet = tuple[str, dict[str, Any], Path, tuple[str, ...]]
"""Name, run file as a table, the folder that it counts from, and joints that may be wrong."""

LARGER = 1.05
"""Of declared squares that are wrong."""

SPOILED = 4
"""Pictures of 40 that are smeared, and as many that are those of another camera."""


def entry(target: dict[str, Any], images: Path, **more: Any) -> dict[str, Any]:
    """A sense of a board."""
    ends = {"kind": "board", "seen_from": "camera", "seen": "board", "lens": "lens"}
    return {**ends, "images": str(images), "target": target, **more}


def unknown(camera: str, board: str, size: list[int]) -> dict[str, Any]:
    """Frames and lens of which nothing is known."""
    return {
        "frames": {
            "camera": {"parent": camera, "known": "no"},
            "board": {"parent": board, "known": "no"},
        },
        "parts": {"lens": {"kind": "lens", "known": "no", "size": size}},
    }


def real_sets(data: Path, panda: Path) -> Iterator[RealSet]:
    """The sets that are there."""
    if (data / "franka_handeye_charuco").is_dir() and panda.is_file():
        yield from franka_sets(data / "franka_handeye_charuco", panda)
    if (data / "ur3e_fixed_cameras").is_dir():
        yield from ur3e_sets(data / "ur3e_fixed_cameras")
        yield from spoiled_set(data / "ur3e_fixed_cameras")
    if (data / "rct_industrial").is_dir():
        yield from rct_sets(data / "rct_industrial")


def franka_sets(franka: Path, panda: Path) -> Iterator[RealSet]:
    """A wrist camera: lens not told, its maker's, and squares declared too large."""
    target = {"kind": "charuco", "columns": 5, "rows": 7, "square_m": 0.034,
              "marker_m": 0.028, "dictionary": "6X6_250"}  # fmt: skip
    table = unknown("panda_link8", "panda_link0", [1280, 720])
    table |= {"robot": str(panda), "recording": "recording.csv"}
    images = franka / "images/{row:03}.jpg"
    table["senses"] = [entry(target, images)]
    joints = tuple(f"panda_joint{k}" for k in range(2, 7))
    with (franka / "camera.json").open() as file:
        maker = json.load(file)
    K = maker["camera_matrix"]
    stated = {"fx": K[0][0], "fy": K[1][1], "cx": K[0][2], "cy": K[1][2], "known": "exactly",
              "distortion": maker["distortion_opencv"]}  # fmt: skip
    yield franka.name, table, franka, joints
    told = {**table, "parts": {"lens": {**table["parts"]["lens"], **stated}}}
    yield f"{franka.name}, lens stated", told, franka, joints
    large = {k: LARGER * target[k] for k in ("square_m", "marker_m")}  # type: ignore[operator]
    wrong = {**told, "senses": [entry({**target, **large}, images)]}
    yield f"{franka.name}, lens stated, squares 5 % too large", wrong, franka, joints


def ur3e_sets(ur: Path) -> Iterator[RealSet]:
    """A board in the hand before two cameras."""
    for camera in ("cam1", "cam2"):
        yield f"{ur.name} {camera}", *ur3e_set(ur, ur / f"images/{camera}_{{row:02}}.jpg")


def ur3e_set(ur: Path, images: Path) -> tuple[dict[str, Any], Path, tuple[str, ...]]:
    """The pictures of one of them."""
    names = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    joints = tuple(f"{name}_joint" for name in names)
    target = {"kind": "chessboard", "columns": 9, "rows": 7, "square_m": 0.02}
    table = unknown("base", "flange", [1280, 720])
    table |= {"robot": "ur3e_dh.toml", "recording": "recording.csv"}
    table["joints"] = {"unit": "deg", "columns": {j: f"{j}_deg" for j in joints}}
    table["senses"] = [entry(target, images, columns=["row"])]
    return table, ur, joints[1:-1]


def spoiled_set(ur: Path) -> Iterator[RealSet]:
    """A fifth of the pictures are of no use: a tenth each is smeared, or of the other camera."""
    import cv2

    rng = np.random.default_rng(0)
    # Rows count from 0 where pictures count from 1; every fourth of the former is held out.
    bad = [row + 1 for row in range(40) if row % 4 == 1]
    with tempfile.TemporaryDirectory() as name:
        for row in range(1, 41):
            camera = "cam2" if row in bad[1 : 2 * SPOILED : 2] else "cam1"
            grey = grey_picture(ur / f"images/{camera}_{row:02}.jpg")
            if row in bad[0 : 2 * SPOILED : 2]:
                grey = smeared(grey, rng.uniform(0, np.pi))
            cv2.imwrite(f"{name}/{row:02}.png", grey)
        yield f"{ur.name} cam1, spoiled", *ur3e_set(ur, Path(name) / "{row:02}.png")


def rct_sets(rct: Path) -> Iterator[RealSet]:
    """Flange poses without a robot: a hand that flies, none of whose joints may be wrong."""
    dots = {"kind": "circles", "columns": 10, "rows": 10, "square_m": 0.0254}
    charuco = {"kind": "charuco", "columns": 5, "rows": 7, "square_m": 0.036195,
               "marker_m": 0.018256, "dictionary": "6X6_250"}  # fmt: skip
    for name, target, carriers, size, ending in (
        ("test_set_10x10", dots, ("tool0", "base"), [640, 480], "png"),
        ("test_set_charuco", charuco, ("base", "tool0"), [1600, 1200], "jpg"),
    ):
        with flying_hand(rct / name / "poses.csv") as folder:
            table = unknown(*carriers, size)
            table |= {"robot": "hand.urdf", "recording": "joints.csv"}
            table["senses"] = [entry(target, rct / name / f"images/{{row:02}}.{ending}")]
            yield f"{rct.name} {name}", table, folder, ()


@contextmanager
def flying_hand(poses: Path) -> Iterator[Path]:
    """A folder with hand.urdf, three sliding and three turning joints, and their joints.csv."""
    from scipy.spatial.transform import Rotation

    columns = open_recording((str(poses),)).columns
    quaternions = np.stack([columns[k] for k in ("qx", "qy", "qz", "qw")], axis=1)
    angles = Rotation.from_quat(quaternions).as_euler("ZYX").T
    read = {k: columns[k] for k in "xyz"} | dict(zip(("yaw", "pitch", "roll"), angles, strict=True))
    axes = ("1 0 0", "0 1 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0")
    links = ("base", *[f"link_{name}" for name in [*read][:-1]], "tool0")
    text = "".join(f'<link name="{link}"/>' for link in links)
    for k, (joint, axis) in enumerate(zip(read, axes, strict=True)):
        kind = "prismatic" if k < 3 else "revolute"
        text += (
            f'<joint name="{joint}" type="{kind}"><parent link="{links[k]}"/>'
            f'<child link="{links[k + 1]}"/><axis xyz="{axis}"/>'
            '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "hand.urdf").write_text(f'<robot name="hand">{text}</robot>')
        write_table(Path(name) / "joints.csv", read)
        yield Path(name)
