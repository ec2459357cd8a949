"""A textured plate in a hand before two rectified cameras, drawn by its homographies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.learners.hand_eye.stereo_points import Stereo

cv2 = pytest.importorskip("cv2")

WIDTH, HEIGHT = 320, 240
STEREO = Stereo(focal=300.0, centre=(159.5, 119.5), baseline=0.06, noise=0.1)
PLATE = np.array([0.01, -0.02, 0.03])  # m, its middle in the hand; it lies in the plane z = 0.03
SIDE, TEXELS = 0.12, 160


@dataclass(frozen=True)
class Sight:
    """What both cameras saw."""

    time: float
    T_world_hand: np.ndarray
    left: np.ndarray
    right: np.ndarray
    mask: np.ndarray


def world_camera(seed: int) -> np.ndarray:
    """(4, 4) T_world_cam of the left camera."""
    rng = np.random.default_rng(seed)
    return lie.transform(lie.exp_so3(rng.normal(size=3)), 0.3 * rng.normal(size=3))


def sights(seed: int, count: int, noise: float = 2.0) -> Iterator[Sight]:
    """Frames, 30 a second, of a hand that turns by 22 degrees either way about each axis."""
    rng = np.random.default_rng(seed + 1000)
    texture, background = _blots(rng, (TEXELS, TEXELS), 2), _blots(rng, (HEIGHT, WIDTH), 3)
    frequency, phase = rng.uniform(0.15, 0.4, 6), rng.uniform(0, 2 * np.pi, 6)
    T_world_cam = world_camera(seed)
    for k in range(count):
        s = np.sin(2 * np.pi * frequency * k / 30 + phase)
        R = lie.exp_so3(np.deg2rad(22) * s[:3]) @ lie.exp_so3([0.2, -0.1, 0.3])
        T_cam_hand = lie.transform(R, np.array([0.05, 0.035, 0.06]) * s[3:] + [0.01, 0, 0.42])
        left, mask = _drawn(T_cam_hand, 0.0, texture, background)
        right, _ = _drawn(T_cam_hand, STEREO.baseline, texture, background)
        left, right = (_noisy(image, noise, rng) for image in (left, right))
        yield Sight(k / 30, T_world_cam @ T_cam_hand, left, right, mask)


def on_plate(place: np.ndarray, T_cam_hand: np.ndarray) -> np.ndarray:
    """(K, 3) points of the hand that are seen at pixels (K, 2) of the left camera."""
    T_hand_cam = lie.inverse(T_cam_hand)
    ray = np.column_stack([(place - STEREO.centre) / STEREO.focal, np.ones(len(place))])
    direction, origin = ray @ T_hand_cam[:3, :3].T, T_hand_cam[:3, 3]
    return origin + ((PLATE[2] - origin[2]) / direction[:, 2])[:, None] * direction


def _blots(rng: np.random.Generator, shape: tuple[int, int], size: float) -> np.ndarray:
    raw = rng.integers(0, 256, shape).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), size), None, 20, 235, cv2.NORM_MINMAX)


def _drawn(T_cam_hand, shift, texture, background):
    c_x, c_y = STEREO.centre
    K = np.array([[STEREO.focal, 0, c_x], [0, STEREO.focal, c_y], [0, 0, 1]])
    middle = T_cam_hand[:3, 3] + T_cam_hand[:3, :3] @ PLATE - [shift, 0, 0]
    m, o = SIDE / TEXELS, -(TEXELS - 1) / 2 * SIDE / TEXELS
    H = K @ np.column_stack([T_cam_hand[:3, :2], middle]) @ [[m, 0, o], [0, m, o], [0, 0, 1]]
    size = (WIDTH, HEIGHT)
    mask = cv2.warpPerspective(np.full_like(texture, 255), H, size) > 127
    return np.where(mask, cv2.warpPerspective(texture, H, size), background), mask


def _noisy(image, noise, rng):
    return np.clip(image + rng.normal(0, noise, image.shape), 0, 255).astype(np.uint8)
