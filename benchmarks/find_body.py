"""How long a frame takes to find the body in: 640 x 480, one core, ours and the published detector.

    python benchmarks/find_body.py [--frames 300] [--json]

A bar of 200 x 60 pixels turns and rests before a textured wall. Milliseconds of this process's time
for one `step`, for one `found`, and the slowest step (a motion is weighed at its end).
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any

import cv2
import numpy as np

import bodyschema as bs

WIDTH, HEIGHT, JOINTS = 640, 480, 7


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    names = tuple(f"joint_{i}" for i in range(JOINTS))
    detectors = {"better": bs.BodyFinder(names), "faithful": bs.OnsetCoincidence(names)}
    answer = {name: measure(detector, asked.frames) for name, detector in detectors.items()}
    if asked.json:
        print(json.dumps(answer))
        return
    for name, found in answer.items():
        print(f"{name}: " + ", ".join(f"{key} {value:.2f}" for key, value in found.items()))


def measure(detector: Any, frames: int) -> dict[str, float]:
    """ms: median step, mean step, slowest step, one look at the answer."""
    state, took = detector.start((WIDTH, HEIGHT)), []
    for i, (picture, q) in enumerate(film(frames)):
        begin = time.process_time()
        state, _ = detector.step(state, (bs.Frame(i / 30, picture, q),))
        took.append(1e3 * (time.process_time() - begin))
    begin = time.process_time()
    for _ in range(20):
        detector.found(state)
    look = 1e3 * (time.process_time() - begin) / 20
    steps = np.array(took[5:])
    return {
        "step_ms_median": float(np.median(steps)),
        "step_ms_mean": float(steps.mean()),
        "step_ms_slowest": float(steps.max()),
        "found_ms": look,
    }


def film(frames: int) -> Any:
    """Pictures (HEIGHT, WIDTH) and joint angles (JOINTS,)."""
    rng = np.random.default_rng(0)
    wall, skin = blots(rng, (HEIGHT, WIDTH)), blots(rng, (60, 300))
    for i in range(frames):
        phase = i % 40 / 20
        angle = 0.15 * (1 - np.cos(np.pi * min(phase, 1.0))) * (1 if i // 40 % 2 else -1)
        c, s = np.cos(angle), np.sin(angle)
        A = np.array([[c, -s, 200.0], [s, c, 200.0]])
        mask = cv2.warpAffine(np.full_like(skin, 255), A, (WIDTH, HEIGHT)) > 127
        image = np.where(mask, cv2.warpAffine(skin, A, (WIDTH, HEIGHT)), wall)
        noisy = image + 3 * rng.standard_normal(image.shape, dtype=np.float32)
        q = angle * np.linspace(1.0, 0.2, JOINTS)
        yield np.clip(noisy, 0, 255).astype(np.uint8), q


def blots(rng: np.random.Generator, shape: tuple[int, int]) -> Any:
    """A random texture."""
    raw = rng.integers(0, 256, shape).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), 2.5), None, 20, 235, cv2.NORM_MINMAX)


if __name__ == "__main__":
    main()
