"""Pictured: a small arm of boxes in a room, photographed by MuJoCo.

Four joints, each with a box on it that no symmetry hides. What is drawn is the robot as built; what
the user gets is the description, the readings and the pictures, in a folder.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from honest.effects import direction

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

JOINTS = ("pan", "lift", "bend", "turn")
LINKS = ("column", "upper", "fore", "hand")
AXES = np.array([[0.0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0]])
PLACES = np.array([[0.0, 0, 0], [0.02, 0, 0.16], [0.01, 0.0, 0.26], [0.14, 0.0, 0.06]])
"""(4, 3) m, of the joints in the link before."""
SIZES = np.array([[0.09, 0.12, 0.14], [0.05, 0.08, 0.24], [0.2, 0.05, 0.07], [0.14, 0.09, 0.03]])
CENTRES = np.array([[0.01, 0.0, 0.07], [0.0, 0.02, 0.13], [0.06, 0.0, 0.04], [0.07, 0.02, 0.0]])
"""(4, 3) m, of the boxes, in their links."""

SPREAD = np.array([0.9, 0.7, 0.9, 1.0])
"""rad, either way of home."""
HOME = np.array([0.0, -0.2, 0.5, 0.0])

WRONG_DEG = 4.0
"""Standard deviation of a joint's zero, drawn and stated."""

ROUGH_M, ROUGH_DEG = 0.03, 2.0
"""The same of each coordinate and each turn of a camera that is known roughly: measured by hand."""

WIDTH, HEIGHT, FOCAL = 320, 240, 300.0
"""px."""


@dataclass(frozen=True)
class Pictured:
    """An arm as it is built, a camera, and what was photographed."""

    q: Array
    """(n, 4) rad, as read."""
    offsets: Array
    """(4,) rad, true minus read."""
    T_base_eye: Array
    """(4, 4), optical."""
    said_eye: Array
    """The same as the user has it."""
    known: str = "exactly"
    places: Array = field(default_factory=PLACES.copy)
    sizes: Array = field(default_factory=SIZES.copy)
    """Of the robot as built."""
    turns: Array | None = None
    """(n, 4) rad, true joint angles; q and offsets when None."""
    focal: float = FOCAL
    """Of the lens as it is."""
    bent: float = 0.0
    """k1 of the lens, that nobody knows of."""
    bumped: Array | None = None
    """(4, 4) of the eye in itself, in the second half of the pictures."""
    shown: Ints | None = None
    """(n,) the moment that every picture really shows."""
    masked: bool = True
    spoilt: tuple[Callable[[Array, int], Array], ...] = ()
    """What becomes of picture or mask i."""

    @property
    def angles(self) -> Array:
        """(n, 4) rad, true joint angles at the moments."""
        return self.q + self.offsets if self.turns is None else self.turns

    def hand(self, q: Array) -> Array:
        """(n, 3) m: where the hand's frame is in the base, at readings q, by the true offsets."""
        T = np.tile(np.eye(4), (len(q), 1, 1))
        for k, axis in enumerate(AXES):
            turn = lie.exp_so3((q[:, k] + self.offsets[k])[:, None] * axis)
            T = T @ lie.transform(turn, np.tile(self.places[k], (len(q), 1)))
        return np.asarray(T[:, :3, 3])

    def write(self, folder: Path) -> Path:
        """The user's folder; returns the run file."""
        import cv2

        (folder / "arm.urdf").write_text(description(), "utf-8")
        header = ",".join(JOINTS)
        np.savetxt(folder / "joints.csv", self.q, delimiter=",", header=header, comments="")
        for i, (image, mask) in enumerate(self.photographs()):
            cv2.imwrite(str(folder / f"image_{i:03}.png"), image[..., ::-1])
            cv2.imwrite(str(folder / f"mask_{i:03}.png"), mask.astype(np.uint8) * 255)
        path = folder / "run.toml"
        path.write_text(self._run_file(), "utf-8")
        return path

    def photographs(self) -> list[tuple[Array, Array]]:
        """Image (height, width, 3) and mask of every moment."""
        os.environ.setdefault("MUJOCO_GL", "egl")
        import mujoco

        model = mujoco.MjModel.from_xml_string(self._scene())
        data, taken = mujoco.MjData(model), []
        arm = np.flatnonzero(model.geom_bodyid > 0)
        with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
            moments = np.arange(len(self.q)) if self.shown is None else self.shown
            for i, moment in enumerate(moments):
                data.qpos[:] = self.angles[moment]
                mujoco.mj_forward(model, data)
                late = self.bumped is not None and i >= len(moments) / 2
                pair = []
                for drawn in (renderer.disable_segmentation_rendering,
                              renderer.enable_segmentation_rendering):  # fmt: skip
                    drawn()
                    renderer.update_scene(data, "bumped" if late else "eye")
                    pair.append(self._seen(renderer.render(), i))
                taken.append((pair[0], np.isin(pair[1][..., 0], arm)))
        return [self._spoilt(pair, i) for i, pair in enumerate(taken)]

    def _seen(self, image: Array, i: int) -> Array:
        """Through a bent lens."""
        if not self.bent:
            return image
        import cv2

        y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
        a, b = (x - (WIDTH - 1) / 2) / FOCAL, (y - (HEIGHT - 1) / 2) / FOCAL
        straight = 1 - self.bent * (a**2 + b**2)
        maps = (straight * a * FOCAL + (WIDTH - 1) / 2, straight * b * FOCAL + (HEIGHT - 1) / 2)
        return np.asarray(cv2.remap(
            image.astype(np.float32), *(m.astype(np.float32) for m in maps),
            cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE,
        ).astype(image.dtype))  # fmt: skip

    def _spoilt(self, pair: tuple[Array, Array], i: int) -> tuple[Array, Array]:
        image, mask = pair
        for change in self.spoilt:
            image, mask = change(image, i), change(mask, i)
        return image, mask

    def _scene(self) -> str:
        boxes, closing = "", ""
        shades = ("0.8 0.3 0.2", "0.3 0.7 0.3", "0.2 0.4 0.8", "0.8 0.7 0.2")
        for k, name in enumerate(LINKS):
            place, axis, centre, size = (
                " ".join(map(str, v))
                for v in (self.places[k], AXES[k], CENTRES[k], self.sizes[k] / 2)
            )
            boxes += (
                f'<body name="{name}" pos="{place}"><joint name="{JOINTS[k]}" axis="{axis}"/>'
                f'<geom type="box" size="{size}" pos="{centre}" rgba="{shades[k]} 1"/>'
            )
            closing += "</body>"
        after = self.T_base_eye if self.bumped is None else self.T_base_eye @ self.bumped
        eyes = _eye("eye", self.T_base_eye, self.focal) + _eye("bumped", after, self.focal)
        return (
            f'<mujoco><visual><global offwidth="{WIDTH}" offheight="{HEIGHT}"/>'
            '<map znear="0.01"/></visual><worldbody>'
            f'<light pos="1 1 3" dir="-.3 -.3 -1"/>{boxes}{closing}{eyes}'
            '<geom type="plane" size="4 4 .1" pos="0 0 -.3" rgba=".45 .45 .4 1"/>'
            '<geom type="box" size=".1 .6 .3" pos="-1 -1.2 0" rgba=".4 .25 .5 1"/>'
            "</worldbody></mujoco>"
        )

    def _run_file(self) -> str:
        rpy = lie.rpy_from_rotation(self.said_eye[:3, :3]).tolist()
        masks = 'masks = "mask_{row:03}.png"\n' if self.masked else ""
        return (
            'robot = "arm.urdf"\nrecording = "joints.csv"\nhand = "hand"\n'
            f"[free]\njoints = {list(JOINTS)}\noffset_deg = {WRONG_DEG}\n"
            f'[cameras.eye]\nparent = "base"\nxyz = {self.said_eye[:3, 3].tolist()}\nrpy = {rpy}\n'
            f'known = "{self.known}"\nposition_m = {ROUGH_M}\nturn_deg = {ROUGH_DEG}\n'
            f"size = [{WIDTH}, {HEIGHT}]\n"
            f"lens = [{FOCAL}, {FOCAL}, {(WIDTH - 1) / 2}, {(HEIGHT - 1) / 2}]\n"
            'images = "image_{row:03}.png"\n' + masks
        )


def _eye(name: str, T: Array, focal: float) -> str:
    """A camera of MuJoCo, which looks along -z with y up."""
    fovy = 2 * np.degrees(np.arctan(HEIGHT / 2 / focal))
    x, y = T[:3, 0], -T[:3, 1]
    axes = " ".join(map(str, [*x, *y]))
    place = " ".join(map(str, T[:3, 3]))
    return f'<camera name="{name}" pos="{place}" xyaxes="{axes}" fovy="{fovy}"/>'


def description() -> str:
    """The robot as its maker describes it, URDF."""
    parts = ['<robot name="boxes"><link name="base"/>']
    for k, (joint, link) in enumerate(zip(JOINTS, LINKS, strict=True)):
        up = LINKS[k - 1] if k else "base"
        place, axis, centre, size = (
            " ".join(map(str, v)) for v in (PLACES[k], AXES[k], CENTRES[k], SIZES[k])
        )
        parts.append(
            f'<link name="{link}"><visual><origin xyz="{centre}"/><geometry><box size="{size}"/>'
            f'</geometry></visual></link><joint name="{joint}" type="revolute">'
            f'<parent link="{up}"/><child link="{link}"/><origin xyz="{place}"/>'
            f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
    return "\n".join([*parts, "</robot>"])


def draw_pictured(rng: np.random.Generator, n: int = 10, smooth: bool = False) -> Pictured:
    """An arm whose zeros are off by some degrees, seen from a metre and a bit."""
    q = HOME + SPREAD * rng.uniform(-1, 1, (n, 4))
    if smooth:
        t = np.linspace(0, 1, n)[:, None]
        wave = np.sin(2 * np.pi * rng.uniform(0.5, 1.2, 4) * t + rng.uniform(-3, 3, 4))
        q = HOME + SPREAD * wave
    around = rng.uniform(-2.6, -0.6) if rng.random() < 0.5 else rng.uniform(0.6, 2.6)
    looks_at = np.array([0.1, 0.0, 0.3])
    away = np.array([np.cos(around), np.sin(around), rng.uniform(0.1, 0.6)])
    z = -away / np.linalg.norm(away)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z], axis=1)
    T = lie.transform(R, looks_at - 1.25 * z)
    # As wrong as `track` takes cameras and meshes to be.
    said = T @ lie.transform(lie.exp_so3(np.radians(0.1) * rng.normal(size=3)), np.zeros(3))
    sizes = SIZES + 6e-4 * rng.normal(size=SIZES.shape)
    focal = FOCAL * (1 + 0.005 * rng.normal())
    return Pictured(
        q, np.radians(WRONG_DEG) * rng.normal(size=4), T, said, sizes=sizes, focal=focal
    )


def nudged(T: Array, size: float, rng: np.random.Generator) -> Array:
    """A frame that is `size` m and as many radians off, in itself."""
    turn = lie.exp_so3(size * direction(rng))
    return T @ lie.transform(turn, size * direction(rng))


def measured_by_hand(T: Array, rng: np.random.Generator) -> Array:
    """A frame that is as far off as one is said to be that is known roughly."""
    turn = lie.exp_so3(np.radians(ROUGH_DEG) * rng.normal(size=3))
    return T @ lie.transform(turn, ROUGH_M * rng.normal(size=3))


def longer(one: Pictured, factor: float) -> Pictured:
    """The robot as built is so many times larger than described, boxes and links."""
    return replace(one, places=factor * one.places, sizes=factor * one.sizes)
