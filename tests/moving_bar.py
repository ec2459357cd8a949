"""A textured bar that turns before a textured wall, with stops: a robot of one joint, on video."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema.sources.tables import write_table
from bodyschema.sources.video_writer import video_writer

cv2 = pytest.importorskip("cv2")

WIDTH, HEIGHT, FPS = 192, 144, 30
PIVOT, LENGTH, BREADTH = (40, 72), 120, 28  # px


def angles(motions: int) -> np.ndarray:
    """(n,) rad: rests of half a second, then quick turns to and fro."""
    turn = 0.25 * (1 - np.cos(np.pi * np.linspace(0, 1, 12))) / 2
    rest = np.zeros(16)
    way = [rest]
    for k in range(motions):
        base = 0.25 * (k % 2)
        way += [base + (1 - 2 * (k % 2)) * turn, 0.25 * ((k + 1) % 2) + rest]
    return np.concatenate(way)


def pictures(q: np.ndarray, seed: int = 0) -> list[np.ndarray]:
    """(HEIGHT, WIDTH, 3) for each angle."""
    rng = np.random.default_rng(seed)
    wall, skin = (_blots(rng, (HEIGHT, WIDTH)), _blots(rng, (BREADTH, LENGTH)))
    shown = []
    for angle in q:
        c, s = np.cos(angle), np.sin(angle)
        A = np.array([[c, -s, PIVOT[0] + s * BREADTH / 2], [s, c, PIVOT[1] - c * BREADTH / 2]])
        bar = cv2.warpAffine(skin, A, (WIDTH, HEIGHT))
        mask = cv2.warpAffine(np.full_like(skin, 255), A, (WIDTH, HEIGHT)) > 127
        image = np.where(mask, bar, wall) + rng.normal(0, 2, wall.shape)
        shown.append(np.repeat(np.clip(image, 0, 255).astype(np.uint8)[..., None], 3, axis=2))
    return shown


def record(folder: Path, motions: int = 6) -> tuple[Path, Path]:
    """Write arm.mp4 and joints.csv; one more joint, `idle`, never moves."""
    q = angles(motions)
    with video_writer(folder / "arm.mp4", (WIDTH, HEIGHT), FPS) as write:
        for picture in pictures(q):
            write(picture)
    columns = {"time": np.arange(len(q)) / FPS, "turn": np.rad2deg(q), "idle": np.zeros(len(q))}
    write_table(folder / "joints.csv", columns)
    return folder / "arm.mp4", folder / "joints.csv"


def _blots(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    raw = rng.integers(0, 256, shape).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), 1.5), None, 20, 235, cv2.NORM_MINMAX)
