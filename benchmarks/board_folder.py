"""A folder of board pictures with known truth: an arm with wrong zeros and a camera on its wrist.

Pictures are drawn by OpenCV (`drawn_board`), the arm is that of `simulation.wrist_camera`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.camera import Camera
from bodyschema.simulation.wrist_camera import (
    T_BASE_BOARD,
    T_FLANGE_CAMERA,
    WristCamera,
    simulate_wrist_camera,
)
from bodyschema.sources.tables import write_table
from bodyschema.vision.targets.target import Target
from drawn_board import drawn, drawn_through

Array = NDArray[np.float64]

SMEAR = 9
"""px, of a picture that was taken in motion."""

CHARUCO = Target("charuco", 7, 5, 0.03, 0.022, "4X4_50")

RUN = """robot = "arm.urdf"
recording = "joints.csv"
[frames.camera]
parent = "flange"
known = "no"
[frames.board]
parent = "base"
known = "no"
[parts.lens]
kind = "lens"
{lens}
size = [640, 480]
[[senses]]
kind = "board"
seen_from = "camera"
seen = "board"
images = "shots/{{row}}.png"
lens = "lens"
target = {target}
"""


@dataclass(frozen=True)
class Truth:
    """What is to be found."""

    T_link_camera: Array
    T_link_board: Array
    offsets: Array
    """(6,) rad"""


def write_board_folder(
    folder: Path,
    n: int = 15,
    seed: int = 0,
    target: Target = CHARUCO,
    declared: Target | None = None,
    lens: str = 'known = "no"',
    others: Collection[int] = (),
    noise: float = 2.0,
    blurred: Collection[int] = (),
    camera: Camera | None = None,
) -> Truth:
    """Write arm.urdf, joints.csv, shots and run.toml.

    Args:
        folder: is there.
        n: pictures.
        seed: of the postures and the noise.
        target: that is drawn.
        declared: in the run file; the same when None.
        lens: lines of its section.
        others: pictures in which the board lies elsewhere, as if it were another.
        noise: of the pictures, grey levels.
        blurred: pictures that are smeared, each in a direction of its own.
        camera: with another lens than that of `drawn_board`.
    """
    import cv2

    recorded = simulate_wrist_camera(WristCamera(n, seed, 2.0, noise_mm=0, noise_deg=0))
    middle = (target.corners.min(axis=0) + target.corners.max(axis=0)) / 2
    flip = lie.transform(np.diag([1.0, -1.0, -1.0]), -np.diag([1.0, -1.0, -1.0]) @ middle)
    rng = np.random.default_rng([seed, 5])
    (folder / "shots").mkdir()
    for row, T in enumerate(recorded.postures.T_board_camera):
        T_camera_target = lie.inverse(T) @ flip
        if row in others:
            T_camera_target = T_camera_target @ lie.transform(
                lie.exp_so3([0.1, -0.15, 1.0]), [0.06, -0.03, 0.01]
            )
        grey = (
            drawn(target, T_camera_target)
            if camera is None
            else drawn_through(target, T_camera_target, camera)
        )
        if row in blurred:
            grey = smeared(grey, rng.uniform(0, np.pi))
        grey = grey + rng.normal(0, noise, (480, 640))
        cv2.imwrite(str(folder / "shots" / f"{row}.png"), np.clip(grey, 0, 255).astype(np.uint8))
    arm = recorded.believed
    (folder / "arm.urdf").write_bytes(write_urdf(arm))
    readings = dict(zip(arm.joints, recorded.postures.q.T, strict=True))
    write_table(folder / "joints.csv", readings)
    (folder / "run.toml").write_text(RUN.format(lens=lens, target=(declared or target).toml))
    return Truth(T_FLANGE_CAMERA, T_BASE_BOARD @ flip, recorded.offsets)


def smeared(grey: NDArray[np.uint8], angle: float) -> NDArray[np.uint8]:
    """A picture moved by SMEAR pixels in a direction, rad, while it was taken."""
    import cv2

    half = (SMEAR - 1) / 2
    along = np.linspace(-half, half, 8 * SMEAR)
    kernel = np.zeros((SMEAR, SMEAR))
    rows, columns = (np.rint(half + along * f(angle)).astype(int) for f in (np.sin, np.cos))
    np.add.at(kernel, (rows, columns), 1 / len(along))
    return np.asarray(cv2.filter2D(grey, -1, kernel), dtype=np.uint8)
