"""Boards before cameras on and beside an arm, as MuJoCo draws them: a renderer that is not ours.

The arm is that of `simulation.wrist_camera`, built as bodies of MuJoCo, whose kinematics place
cameras and boards; a board is a textured quad. Cameras see 640 x 480 pixels through a pinhole.

    hand    a camera on the flange, a board beside the base
    fixed   a board on the flange, a camera beside the base
    both    the first, a second board on the flange, and a head camera that sees both boards
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.camera import Camera
from bodyschema.model.tree import Body
from bodyschema.simulation.wrist_camera import (
    ROWS,
    T_BASE_BOARD,
    T_FLANGE_CAMERA,
    WristCamera,
    simulate_wrist_camera,
)
from bodyschema.sources.tables import write_table
from bodyschema.vision.targets.target import Target
from drawn_board import PX, sheet

os.environ.setdefault("MUJOCO_GL", "egl")

Array = NDArray[np.float64]

WIDTH, HEIGHT = 640, 480
FINE = 2
"""Times as fine, before pixels are averaged."""

SHARP = 4
"""Times finer than `drawn_board` the texture is: edges are those of the pixels, not its own."""

OPTICAL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up."""

A = Target("charuco", 7, 5, 0.03, 0.022, "4X4_50")
B = Target("charuco", 6, 5, 0.03, 0.022, "5X5_50")

SIDES = {"flange": "wrist_3", "base": "world"}
"""Bodies of MuJoCo that the frames of the arm are fixed to."""


@dataclass(frozen=True)
class Fixed:
    """A camera or a board, where it truly is."""

    parent: str
    """"flange" or "base"."""
    T: Array
    """(4, 4) T_parent_frame."""
    focal: float = 0.0
    """px; of a camera."""
    target: Target | None = None


def facing(target: Target) -> Array:
    """T that lays a target's middle at the origin, to be looked at from +z."""
    middle = (target.corners.min(axis=0) + target.corners.max(axis=0)) / 2
    flip = np.diag([1.0, -1.0, -1.0])
    return lie.transform(flip, -flip @ middle)


HAND: dict[str, Fixed] = {
    "camera": Fixed("flange", T_FLANGE_CAMERA, 600.0),
    "board": Fixed("base", T_BASE_BOARD @ facing(A), target=A),
}
# The same places with the roles exchanged: the board in the hand is seen from below.
FIXED: dict[str, Fixed] = {
    "camera": Fixed("base", T_BASE_BOARD, 600.0),
    "board": Fixed("flange", T_FLANGE_CAMERA @ facing(A), target=A),
}
_ABOVE = lie.transform(np.diag([1.0, -1.0, -1.0]), [-0.48, -0.14, 1.25])
_BACK = lie.transform(lie.exp_so3([np.pi, 0.0, 0.0]), [0.0, 0.2, -0.05])
BOTH: dict[str, Fixed] = {
    **HAND,
    "head": Fixed("base", _ABOVE, 900.0),
    "plate": Fixed("flange", _BACK @ facing(B), target=B),
}
SCENES = {
    "hand": (HAND, (("camera", "board"),)),
    "fixed": (FIXED, (("camera", "board"),)),
    "both": (BOTH, (("camera", "board"), ("head", "plate"), ("head", "board"))),
}
"""What is there, and which camera is said to see which board."""


@dataclass(frozen=True)
class Truth:
    """What is to be found."""

    fixed: Mapping[str, Fixed]
    believed: Body
    offsets: Array
    """(6,) rad"""

    @property
    def body(self) -> Body:
        """The arm with all frames where they are, at readings that are right."""
        body = self.believed
        for name, one in self.fixed.items():
            body = body.attach(name, one.parent, one.T)
        return body


class Stage:
    """A scene of MuJoCo that is drawn at any posture."""

    def __init__(self, fixed: Mapping[str, Fixed]) -> None:
        import mujoco

        self._mujoco = mujoco
        text, assets = scene(fixed)
        self.model = mujoco.MjModel.from_xml_string(text, assets)
        self.data = mujoco.MjData(self.model)
        self._renderer = mujoco.Renderer(self.model, FINE * HEIGHT, FINE * WIDTH)

    def pose(self, q: Array) -> None:
        """Move the arm to true joint angles (6,) rad."""
        self.data.qpos[:] = q
        self._mujoco.mj_forward(self.model, self.data)

    def picture(self, camera: str) -> NDArray[np.uint8]:
        """(HEIGHT, WIDTH) grey, as a camera sees it."""
        import cv2

        self._renderer.update_scene(self.data, camera)
        grey = self._renderer.render()[..., 1]
        size = (WIDTH, HEIGHT)
        return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.uint8)

    def close(self) -> None:
        """Give the renderer back."""
        self._renderer.close()


def scene(fixed: Mapping[str, Fixed]) -> tuple[str, dict[str, bytes]]:
    """MJCF text and its textures."""
    assets, made, hung = dict[str, bytes](), "", {"flange": "", "base": ""}
    for name, one in fixed.items():
        if one.target is None:
            T = one.T @ lie.transform(OPTICAL, [0, 0, 0])
            turn = " ".join(f"{v:.12g}" for v in [*T[:3, 0], *T[:3, 1]])
            fov = np.degrees(2 * np.arctan(HEIGHT / 2 / one.focal))
            place = f'name="{name}" pos="{_words(T[:3, 3])}"'
            hung[one.parent] += f'<camera {place} xyaxes="{turn}" fovy="{fov:.12g}"/>'
            continue
        assets[f"{name}.png"], corners = _texture(one.target)
        made += (
            f'<texture name="{name}" type="2d" file="{name}.png"/>'
            f'<material name="{name}" texture="{name}" specular="0" shininess="0"/>'
            f'<mesh name="{name}" inertia="shell" vertex="{corners}" '
            'texcoord="0 0 1 0 1 1 0 1" face="0 2 1 0 3 2"/>'
        )
        hung[one.parent] += (
            f'<body name="{name}" pos="{_words(one.T[:3, 3])}" quat="{_quaternion(one.T)}">'
            f'<geom type="mesh" mesh="{name}" material="{name}" contype="0" conaffinity="0"/>'
            "</body>"
        )
    return _TEXT.format(made=made, arm=_arm(hung["flange"]), base=hung["base"]), assets


_TEXT = """<mujoco><compiler balanceinertia="true" angle="radian"/><visual>
<global offwidth="1280" offheight="960"/><quality shadowsize="0" offsamples="0"/><map znear="0.02"/>
<headlight ambient="0.9 0.9 0.9" diffuse="0.1 0.1 0.1" specular="0 0 0"/></visual>
<asset>{made}</asset>
<worldbody><geom type="plane" size="3 3 0.1" pos="0 0 -0.05" rgba="0.45 0.4 0.35 1"/>
{base}{arm}</worldbody></mujoco>"""


def _arm(hand: str) -> str:
    """Nested bodies of the standard Denavit-Hartenberg table, the hand's things in the last."""
    text = hand
    for row, (joint, a, alpha, d) in reversed(list(enumerate(ROWS))):
        before = ROWS[row - 1] if row else ("", 0.0, 0.0, 0.0)
        turn = lie.transform(lie.exp_so3([before[2], 0.0, 0.0]), [before[1], 0.0, before[3]])
        link = f'fromto="0 0 0 {a} 0 {d}"' if row < len(ROWS) - 1 else 'fromto="0 0 0 0 0 0.05"'
        # The flange is the frame behind the last row: its fixed part stands in a body of its own.
        inner = (
            text
            if row < len(ROWS) - 1
            else f'<body pos="{a} 0 {d}" quat="{_quaternion(_turned(alpha))}">{text}</body>'
        )
        text = (
            f'<body name="{joint}" pos="{_words(turn[:3, 3])}" quat="{_quaternion(turn)}">'
            f'<joint name="{joint}" axis="0 0 1"/>'
            f'<geom type="capsule" size="0.03" {link} rgba="0.6 0.6 0.65 1" mass="1"/>'
            f"{inner}</body>"
        )
    return text


def _turned(alpha: float) -> Array:
    return lie.transform(lie.exp_so3([alpha, 0.0, 0.0]), [0.0, 0.0, 0.0])


def _texture(target: Target) -> tuple[bytes, str]:
    """The sheet as a PNG, and the corners of its quad in the target's frame, m."""
    import cv2

    flat, origin = sheet(target)
    scale = target.square_m / PX
    left, top = (np.array([-0.5, -0.5]) - origin) * scale
    right, bottom = (np.array(flat.shape[::-1]) - 0.5 - origin) * scale
    _, data = cv2.imencode(".png", np.kron(flat, np.ones((SHARP, SHARP), np.uint8)))
    places = [(left, top), (right, top), (right, bottom), (left, bottom)]
    return bytes(data), " ".join(f"{x:.12g} {y:.12g} 0" for x, y in places)


def _words(numbers: Array) -> str:
    return " ".join(f"{v:.12g}" for v in numbers)


def _quaternion(T: Array) -> str:
    """w x y z of a rotation."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat()
    return f"{w:.15g} {x:.15g} {y:.15g} {z:.15g}"


def write_rendered_folder(
    folder: Path, which: str, n: int, seed: int = 0, worst_deg: float = 2.0, noise: float = 2.0
) -> Truth:
    """Write arm.urdf, joints.csv, the pictures of every camera and run.toml.

    Args:
        folder: is there.
        which: a key of `SCENES`.
        n: pictures of each camera.
        seed: of postures and noise.
        worst_deg: the joint whose zero is most wrong.
        noise: of the pictures, grey levels.
    """
    import cv2

    fixed, seen = SCENES[which]
    settings = WristCamera(n, seed, worst_deg, noise_mm=0, noise_deg=0)
    recorded = simulate_wrist_camera(settings)
    rng, stage = np.random.default_rng([seed, 7]), Stage(fixed)
    cameras = [name for name, one in fixed.items() if one.target is None]
    for row, reading in enumerate(recorded.postures.q):
        stage.pose(reading + recorded.offsets)
        for camera in cameras:
            grey = stage.picture(camera) + rng.normal(0, noise, (HEIGHT, WIDTH))
            path = folder / f"{camera}_{row}.png"
            cv2.imwrite(str(path), np.clip(grey, 0, 255).astype(np.uint8))
    stage.close()
    arm = recorded.believed
    (folder / "arm.urdf").write_bytes(write_urdf(arm))
    readings = dict(zip(arm.joints, recorded.postures.q.T, strict=True))
    write_table(folder / "joints.csv", readings)
    (folder / "run.toml").write_text(run_text(fixed, seen))
    return Truth(fixed, arm, recorded.offsets)


def run_text(fixed: Mapping[str, Fixed], seen: tuple[tuple[str, str], ...]) -> str:
    """A run file in which neither frames nor lenses are known."""
    text = 'robot = "arm.urdf"\nrecording = "joints.csv"\n'
    for name, one in fixed.items():
        text += f'[frames.{name}]\nparent = "{one.parent}"\nknown = "no"\n'
        if one.target is None:
            size = f"[{WIDTH}, {HEIGHT}]"
            text += f'[parts.lens_of_{name}]\nkind = "lens"\nknown = "no"\nsize = {size}\n'
    for camera, board in seen:
        target = fixed[board].target
        assert target is not None
        text += (
            f'[[senses]]\nkind = "board"\nseen_from = "{camera}"\nseen = "{board}"\n'
            f'images = "{camera}_{{row}}.png"\nlens = "lens_of_{camera}"\ntarget = {target.toml}\n'
        )
    return text


def true_camera(name: str, one: Fixed) -> Camera:
    """A pinhole of its focal length."""
    K = np.array([[one.focal, 0, (WIDTH - 1) / 2], [0, one.focal, (HEIGHT - 1) / 2], [0, 0, 1]])
    return Camera(name, name, WIDTH, HEIGHT, K)
