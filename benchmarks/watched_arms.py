"""Recordings of arms that cameras watched, as bodies, surfaces and pictures."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import fast_simplification
import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.images import Images
from bodyschema.vision.decimation import welded

Array = NDArray[np.float64]

OPTICAL = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""Optical axes in axes of ROS cameras (x forward, y left, z up)."""

PUBLISHED = np.deg2rad([10, 10, -6, 7, 1, 20, -7])
"""Offsets of vislab's seven arm joints, added to the encoders."""

HEAD = [-10.0, 0, 0, -10, 0, 0]
"""Angles of vislab's head, deg."""


@dataclass(frozen=True)
class Watched:
    """A robot and what its cameras saw."""

    body: bs.Body
    """As modelled, with the cameras' frames."""
    surface: bs.Surface
    joints: tuple[str, ...]
    """Of the arm, from its base."""
    eye: str
    """Frame of the first camera."""
    hand: str
    """Frame whose pose is judged."""
    frames: tuple[Images, ...]


def vislab(data: Path, masked: bool = True, faces: int = 0) -> Watched:
    """132 stereo pairs of the iCub simulator, q as the encoders say (no offset added)."""
    nodes = json.loads((data / "model/model.json").read_text())["nodes"]
    name, turns = [str(n["id"]) for n in nodes], [n["rotation"] for n in nodes]
    parent, local = [n["parent"] for n in nodes], np.array([n["local"] for n in nodes])
    size = {-1: 1.0}  # the nodes change the scale; a body does not, so the meshes take it
    for i, (k, T) in enumerate(zip(parent, local, strict=True)):
        size[i] = size[k] * np.cbrt(np.linalg.det(T[:3, :3]))
        T[:3, :3], T[:3, 3] = T[:3, :3] * size[k] / size[i], T[:3, 3] * size[k]
    axes = [r["sign"] * np.eye(3)["xyz".index(r["axis"])] if r else (0, 0, 1) for r in turns]
    kinds = [REVOLUTE if r else FIXED for r in turns]
    body = bs.Body.build("icub_sim", name, name, parent, kinds, axes, local)
    eyes = {n["name"]: str(n["id"]) for n in nodes}
    outward = np.diag([-1.0, -1.0, 1.0, 1.0])
    for side in ("left", "right"):
        body = body.attach(side, eyes[f"{side.title()}EyeCam"], outward)
    K = np.array([[257.34, 0, 159.5], [0, 257.34, 119.5], [0, 0, 1.0]])
    cameras = tuple(bs.Camera(side, side, 320, 240, K) for side in ("left", "right"))
    table = np.genfromtxt(data / "frames.csv", delimiter=",", skip_header=1)[:, 4:]
    column = [r["index"] + 16 * (r["source"] == "head") for r in turns if r]
    gain, zero = np.array([(r["gain"], r["zero_deg"]) for r in turns if r]).T
    arm = [str(n["id"]) for n in sorted(
        (n for n in nodes if n["rotation"] and n["rotation"]["source"] == "arm"),
        key=lambda n: n["rotation"]["index"],
    ) if n["rotation"]["index"] < 7]  # fmt: skip
    frames = []
    for i, row in enumerate(table):
        q = np.deg2rad(gain * (np.append(row, HEAD)[column] - zero))
        views = tuple(_read(data, side, i, masked) for side in ("left", "right"))
        frames.append(Images(float(i), q, cameras, views))
    shape = np.load(data / "model/meshes.npz")
    skin = {
        k: (str(n), size[n] * shape[f"V{k}"], shape[f"F{k}"])
        for k, n in enumerate(shape["node"])
        if nodes[n]["in_right_arm"]
    }
    surface = _welded(body, arm, frames[0].q, list(skin.values()), faces)
    return Watched(body, surface, tuple(arm), "left", arm[-1], tuple(frames))


def _welded(
    body: bs.Body, arm: list[str], q: Array, skin: list[tuple[str, Array, Array]], faces: int
) -> bs.Surface:
    """Pieces that move together in this recording (its fingers do not move) as one, thinned out."""
    pieces: dict[str, tuple[list[Array], list[Array]]] = {}
    for frame, V, F in skin:
        k = body.frame_index(frame)
        while body.frames[k] not in arm and body.parent[k] >= 0:
            k = int(body.parent[k])
        T = relative_pose(body, q, body.frames[k], frame)
        vertices, triangles = pieces.setdefault(body.frames[k], ([], []))
        triangles.append(F + sum(map(len, vertices)))
        vertices.append(V @ T[:3, :3].T + T[:3, 3])
    joined = {name: (np.concatenate(V), np.concatenate(F)) for name, (V, F) in pieces.items()}
    return bs.Surface.build(
        {name: _thin(V, F, faces) for name, (V, F) in joined.items()} if faces else joined
    )


def _thin(V: Array, F: Array, faces: int) -> tuple[Array, Array]:
    """At most so many faces."""
    V, F = welded(V, F.astype(np.int64))
    if len(F) <= faces:
        return V, F
    return fast_simplification.simplify(V, F, target_count=faces, agg=1.0)


def _read(data: Path, side: str, i: int, masked: bool) -> NDArray[np.generic]:
    if masked:
        return np.asarray(cv2.imread(str(data / f"mask/{side}_{i:03}.png"), 0) > 0)
    return np.ascontiguousarray(cv2.imread(str(data / f"img/{side}_{i:03}.png"))[..., ::-1])


def med7(
    data: Path, masked: bool = True, start: str = "HT_cam_swarm", faces: int = 1500
) -> Watched:
    """Five stereo pairs of a real KUKA arm; the camera where `start` says."""
    folder = data / "stereo"
    body = bs.Body.from_urdf(data / "lbr_med7_r800.urdf")
    surface = bs.Surface.of(body, faces=faces)
    body = body.attach(
        "left", "lbr_link_0", np.load(folder / f"{start}.npy").reshape(4, 4) @ OPTICAL
    )
    # Rectified, the right camera stands 0.12 m to the right of the left one.
    body = body.attach("right", "left", lie.transform(np.eye(3), [0.12, 0, 0]))
    K = np.array([[534.6265, 0, 478.0846], [0, 534.6265, 260.9944], [0, 0, 1]])
    cameras = tuple(bs.Camera(side, side, 960, 540, K) for side in ("left", "right"))
    frames = []
    for i in range(5):
        views = []
        for side in ("left", "right"):
            name = f"{'mask_sam2_' if masked else ''}{side}_image_{i}.png"
            seen = cv2.imread(str(folder / name), 0 if masked else 1)
            views.append(seen > 0 if masked else np.ascontiguousarray(seen[..., ::-1]))
        q = np.load(folder / f"joint_states_{i}.npy").astype(float)
        frames.append(Images(float(i), q, cameras, tuple(views)))
    joints = tuple(body.joints)
    return Watched(body, surface, joints, "left", "lbr_link_7", tuple(frames))
