"""A five-joint arm that holds a rod before a stereo camera: streams with changes in them.

The arm has the measures of a Katana 6M180 (an arm of the kind used in the paper). Random way points
are joined by minimum-jerk moves at half of the joints' speed limits; 30 samples a second. A rod
sits in the gripper, its tip about 0.29 m from the hand frame; the camera stands about 1 m away.
Noise may be correlated in time, some samples may be wild, and the camera's clock may be late.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.stereo_points import Stereo, StereoPoints
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

RATE = 30.0
"""samples a second"""

IMAGE = (640, 480)
"""pixels"""

SPEED = np.array([2.209, 1.190, 1.190, 2.209, 2.209])
"""rad/s limits of the joints"""

CENTRE = np.array([0.0, 0.9, -0.6, 0.2, 0.0])
REACH = np.array([0.6, 0.5, 0.7, 0.9, 2.2])
"""rad: way points are drawn from CENTRE +- REACH."""

WATCHED = np.array([0.38, 0.0, 0.24])
"""m: what the camera looks at."""

_JOINTS = ("pan", "lift", "elbow", "wrist", "roll")
_AXES = ((0, 0, 1), (0, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 0, 0))
_LINKS = ((0, 0, 0.2015), (0, 0, 0), (0.19, 0, 0), (0.139, 0, 0), (0.1523, 0, 0), (0.1505, 0, 0))
_LIMITS = (
    (-3.0255, 2.8911),
    (-0.1352, 2.1686),
    (-2.2218, 2.0542),
    (-2.0333, 1.8761),
    (-2.9932, 2.8710),
)


def katana() -> Body:
    """The arm: frames "base", one link a joint, and the gripper point "hand"."""
    return Body.build(
        name="katana",
        frames=["base", *_JOINTS, "hand"],
        carriers=["", *(f"{joint}_joint" for joint in _JOINTS), "hand_joint"],
        parent=range(-1, 6),
        kind=[FIXED, *[REVOLUTE] * 5, FIXED],
        axis=[(0, 0, 1), *_AXES, (0, 0, 1)],
        placement=lie.transform(np.tile(np.eye(3), (7, 1, 1)), [(0, 0, 0), *_LINKS]),
        limits={f"{j}_joint": span for j, span in zip(_JOINTS, _LIMITS, strict=True)},
    )


@dataclass(frozen=True)
class Scene:
    """Where the camera stands and where the tracked points sit in the hand."""

    T_world_cam: Array
    """(4, 4)."""
    points: Array
    """(K, 3) m."""

    def rod_moved(self, by: Array) -> Scene:
        """With all points shifted in the hand, (3,) m."""
        return replace(self, points=self.points + by)

    def head_moved(self, turn: Array, shift: Array) -> Scene:
        """With the camera turned about itself, (3,) rad, and shifted, (3,) m, in the world."""
        R, r_o = self.T_world_cam[:3, :3], self.T_world_cam[:3, 3]
        return replace(self, T_world_cam=lie.transform(lie.exp_so3(turn) @ R, r_o + shift))


@dataclass(frozen=True)
class Stream:
    """What the arm's encoders and its camera deliver."""

    time: Array
    """(n,) s."""
    q: Array
    """(n, 5) rad, at those times."""
    T_world_hand: Array
    """(n, 4, 4)."""
    pixels: Array
    """(n, K, 3) u_left, v, u_right."""

    def __len__(self) -> int:
        return len(self.time)

    def sample(self, i: int) -> StereoPoints:
        """One moment."""
        return StereoPoints(float(self.time[i]), self.T_world_hand[i], self.pixels[i])


@dataclass(frozen=True)
class Noise:
    """What is wrong with the pixels."""

    correlation: float = 0.0
    """From one sample to the next; the standard deviation is the camera's, whatever it is."""
    wild: float = 0.0
    """Share of samples that are anywhere in the images."""


def stereo(noise: float = 0.5) -> Stereo:
    """The pair of cameras; noise in pixels."""
    return Stereo(600.0, ((IMAGE[0] - 1) / 2, (IMAGE[1] - 1) / 2), 0.10, noise)


def draw_scene(rng: np.random.Generator, points: int = 1) -> Scene:
    """A camera about 1 m from the arm that looks at its work space, and points on the rod.

    The first point is the rod's tip, the others lie within 4 cm of the rod.

    Raises:
        InputError: there is no point.
    """
    if points < 1:
        raise InputError(f"the camera tracks at least one point of the rod; got {points}.")
    away = np.array([0.75, 0.55, 0.45]) + rng.uniform(-0.15, 0.15, 3)
    away /= np.linalg.norm(away)
    side = np.cross([0.0, 0.0, 1.0], away)
    side /= np.linalg.norm(side)
    # Optical frame: z towards the scene, x to the right, y down.
    R = np.column_stack([side, np.cross(-away, side), -away])
    R = R @ lie.exp_so3([0.0, 0.0, rng.uniform(-0.1, 0.1)])
    tip = np.array([0.12, 0.02, 0.26]) + rng.uniform(-0.02, 0.02, 3)
    along = np.concatenate([[1.0], rng.uniform(0.3, 0.95, points - 1)])
    beside = np.vstack([np.zeros((1, 3)), rng.uniform(-0.04, 0.04, (points - 1, 3))])
    return Scene(lie.transform(R, WATCHED + away), along[:, None] * tip + beside)


def draw_motion(
    seconds: float, rng: np.random.Generator, T_world_cam: Array, speed: float = 0.5
) -> tuple[Array, Array]:
    """Times (n,) and joint angles (n, 5) of random moves that keep the hand in view.

    Args:
        seconds: length.
        rng: of way points and pauses.
        T_world_cam: (4, 4), where the camera stands.
        speed: peak joint speed as a share of the limits.

    Raises:
        InputError: the speed is not above zero.
    """
    if speed <= 0:
        raise InputError(f"an arm that moves has a speed above zero; got {speed:g}.")
    time = np.arange(round(seconds * RATE)) / RATE
    ways = _way_points(rng, T_world_cam)
    here, start, pieces = next(ways), 0.0, []
    while start < seconds:
        there = next(ways)
        # A minimum-jerk move peaks at 15/8 of its mean speed.
        length = max(0.4, float(np.max(np.abs(there - here) * 1.875 / (speed * SPEED))))
        inside = time[(time >= start) & (time < start + length)]
        s = ((inside - start) / length)[:, None]
        pieces.append(here + (there - here) * s**3 * (10 - 15 * s + 6 * s * s))
        start += length
        pause = rng.uniform(0.0, 0.3)
        waiting = int(np.sum((time >= start) & (time < start + pause)))
        pieces.append(np.tile(there, (waiting, 1)))
        start, here = start + pause, there
    return time, np.concatenate(pieces)


def _way_points(rng: np.random.Generator, T_world_cam: Array) -> Iterator[Array]:
    """Postures with the hand in both images and 0.55 to 1.5 m away, one after the other."""
    body, eyes, T_cam_world = katana(), stereo(), lie.inverse(T_world_cam)
    while True:
        q = CENTRE + rng.uniform(-1, 1, (64, 5)) * REACH
        q = np.clip(q, body.lower, body.upper)
        c = (T_cam_world @ relative_pose(body, q, "base", "hand"))[:, :3, 3]
        pixels = eyes.project(c)
        inside = (pixels[:, ::2] > 0) & (pixels[:, ::2] < IMAGE[0])
        level = (pixels[:, 1] > 0) & (pixels[:, 1] < IMAGE[1])
        yield from q[(c[:, 2] > 0.55) & (c[:, 2] < 1.5) & inside.all(axis=1) & level]


def perceive(
    scene: Scene,
    T_world_hand: Array,
    eyes: Stereo,
    rng: np.random.Generator,
    noise: Noise | None = None,
) -> Array:
    """Noisy pixels (n, K, 3) of the scene's points while the hand is at (n, 4, 4)."""
    noise = noise or Noise()
    clean = project_points(scene, T_world_hand, eyes)
    n, K, _ = clean.shape
    white = rng.normal(size=clean.shape)
    pixels = clean + eyes.noise * correlate(white, noise.correlation)
    wild = rng.uniform(size=(n, K)) < noise.wild
    size = np.array([IMAGE[0], IMAGE[1], IMAGE[0]])
    return np.where(wild[..., None], rng.uniform(size=clean.shape) * size, pixels)


def project_points(scene: Scene, T_world_hand: Array, eyes: Stereo) -> Array:
    """Pixels (n, K, 3) without noise."""
    homogeneous = np.hstack([scene.points, np.ones((len(scene.points), 1))])
    world = np.einsum("nij,kj->nki", T_world_hand, homogeneous)
    c = world @ lie.inverse(scene.T_world_cam).T
    return eyes.project(c[..., :3])


def correlate(white: Array, rho: float) -> Array:
    """First-order autoregressive noise of the same variance along the first axis."""
    if rho == 0:
        return white
    from scipy.signal import lfilter

    kept = np.sqrt(1 - rho * rho) * white
    kept[0] = white[0]
    return np.asarray(lfilter([1.0], [1.0, -rho], kept, axis=0))


def stream(
    scene: Scene,
    seconds: float,
    eyes: Stereo,
    rng: np.random.Generator,
    speed: float = 0.5,
    noise: Noise | None = None,
    lag: float = 0.0,
) -> Stream:
    """A stream of an unchanging body.

    Args:
        scene: where camera and points are.
        seconds: length.
        eyes: the pair of cameras, with its noise.
        rng: of motion and noise.
        speed: peak joint speed as a share of the limits.
        noise: what else is wrong with the pixels.
        lag: s by which the images are older than the encoder readings of the same time stamp.
    """
    time, q = draw_motion(seconds, rng, scene.T_world_cam, speed)
    T = relative_pose(katana(), q, "base", "hand")
    seen_at = T if lag == 0 else relative_pose(katana(), delayed(time, q, lag), "base", "hand")
    return Stream(time, q, T, perceive(scene, seen_at, eyes, rng, noise))


def delayed(time: Array, q: Array, lag: float) -> Array:
    """Joint angles (n, 5) at `time - lag`, between samples by a straight line."""
    return np.column_stack([np.interp(time - lag, time, joint) for joint in q.T])
