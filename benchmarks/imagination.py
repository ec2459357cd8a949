"""How fast bodies are imagined and compared with what both eyes see, and how exactly.

    python benchmarks/imagination.py [--json]

The iCub's right hand, wrist and forearm (1182 faces) at 320x240, hypotheses of one posture with
joint offsets of 3 deg; ms for all hypotheses in both views, mean over five postures of the best of
several runs, one thread (keys ending in _2: two threads). CPU time is that of all threads.

jaccard, jaccard_chamfer, directional, region   the scores; what is observed is the native mesh
times_faster_than_depth_buffer   one view with Jaccard and chamfer against a compiled depth buffer
times_faster_than_mujoco         the same against MuJoCo's segmentation (OpenGL); CPU times
iou_to_mujoco_min                silhouette against MuJoCo's, the worst of 12 views
iou_decimated_min, _mean         1182 faces against the native 2014, 200 views
iou_near_min                     forearm beside the camera, against ray casting, views with a cut
pixels_wrong, pixels_checked     native mesh against ray casting, 100 views at each of three sizes;
                                 checked are the pixels that rays call covered
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable

os.environ.setdefault("MUJOCO_GL", "egl")  # read when mujoco is first imported

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.colours import ColourModel, ObservedColours
from bodyschema.vision.contours import fit_contours, silhouette
from bodyschema.vision.depth_buffer import depth_image
from bodyschema.vision.edge_image import ObservedEdges
from bodyschema.vision.observed import ObservedMask
from bodyschema.vision.scores import OrientedChamfer, Region
from icub_arm import arm, beside_the_eye, eyes, hypotheses, views
from referees import iou, mujoco_silhouettes, ray_silhouette

POSTURES = (0, 4, 8, 12, 16)
SIZES = ((160, 120), (320, 240), (640, 480))

Times = dict[str, float]
Work = Callable[[int], object]
"""What is timed, given the number of threads."""


def best(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Least CPU and wall time in ms; on a busy machine the least disturbed run is the truth."""
    times = []
    for _ in range(repeats):
        cpu, wall = time.process_time(), time.perf_counter()
        work()
        times.append((time.process_time() - cpu, time.perf_counter() - wall))
    least = 1e3 * np.min(times, axis=0)
    return float(least[0]), float(least[1])


def scores(posture: int, n: int) -> dict[str, Work]:
    """Every score of n hypotheses in both views."""
    T, surface, cameras = hypotheses(n, posture=posture), arm(), eyes()
    rng = np.random.default_rng(posture)
    truth = [silhouette(arm(False), T[0, c], camera) for c, camera in enumerate(cameras)]
    masks = [ObservedMask.of(mask) for mask in truth]
    images = [_image(mask, rng) for mask in truth]
    edges = [ObservedEdges.of(image) for image in images]
    colours = [
        ObservedColours.of(image, ColourModel.learn(image, mask))
        for image, mask in zip(images, truth, strict=True)
    ]
    directional, region = (
        OrientedChamfer(surface, cameras, edges),
        Region(surface, cameras, colours),
    )
    return {
        "jaccard": lambda threads: fit_contours(surface, T, cameras, masks, False, threads),
        "jaccard_chamfer": lambda threads: fit_contours(surface, T, cameras, masks, True, threads),
        "directional": lambda threads: directional.score(T, threads),
        "region": lambda threads: region.score(T, threads),
    }


def _image(mask: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A grey picture: a bright arm before blocks of random grey."""
    blocks = np.kron(rng.integers(0, 180, (15, 20)), np.ones((16, 16)))
    grey = np.where(mask, 200, blocks) + rng.normal(0, 8, mask.shape)
    return np.clip(grey, 0, 255).astype(np.uint8)


def speed() -> dict[str, dict[str, Times]]:
    """Times of every score, by number of hypotheses."""
    found: dict[str, dict[str, list[Times]]] = {}
    for n, repeats in ((200, 15), (2000, 3)):
        for posture in POSTURES:
            for name, work in scores(posture, n).items():
                work(1)
                cpu, wall = best(lambda work=work: work(1), repeats)
                cpu_2, wall_2 = best(lambda work=work: work(2), repeats)
                times = {"cpu_ms": cpu, "wall_ms": wall, "cpu_ms_2": cpu_2, "wall_ms_2": wall_2}
                found.setdefault(name, {}).setdefault(str(n), []).append(times)
    return {
        name: {
            n: {key: float(np.mean([t[key] for t in runs])) for key in runs[0]}
            for n, runs in by_n.items()
        }
        for name, by_n in found.items()
    }


def times_faster(view_ms: float) -> dict[str, float]:
    """How much longer a depth buffer and MuJoCo take than `view_ms` for one view."""
    T, camera = hypotheses(20)[:, 0], eyes()[0]
    depth_image(arm(), T[0], camera)
    depth, _ = best(lambda: [depth_image(arm(), t, camera) for t in T], 3)
    many = [
        best(lambda k=k: mujoco_silhouettes(arm(), np.tile(T, (k, 1, 1, 1)), camera), 2)[0]
        for k in (1, 6)
    ]
    mujoco = (many[1] - many[0]) / (5 * len(T))  # without the start of the renderer
    return {
        "times_faster_than_depth_buffer": depth / len(T) / view_ms,
        "times_faster_than_mujoco": mujoco / view_ms,
    }


def exactness() -> dict[str, float]:
    """Silhouettes against those of others."""
    native, wrong, checked = arm(False), 0, 0
    for width, height in SIZES:
        for T in views(50, seed=width):
            for c, camera in enumerate(eyes(width, height)):
                rays = ray_silhouette(native, T[c], camera)
                wrong += int(np.count_nonzero(silhouette(native, T[c], camera) != rays))
                checked += int(np.count_nonzero(rays))
    eye = eyes()[0]
    near = [
        iou(silhouette(native, T, eye), ray_silhouette(native, T, eye)) for T in beside_the_eye(200)
    ]
    decimated = [
        iou(silhouette(arm(), T[c], camera), silhouette(native, T[c], camera))
        for T in views(100, seed=5)
        for c, camera in enumerate(eyes())
    ]
    T = views(12, seed=3)[:, 0]
    others = mujoco_silhouettes(native, T, eye)
    mujoco = [iou(silhouette(native, t, eye), mask) for t, mask in zip(T, others, strict=True)]
    return {
        "iou_to_mujoco_min": min(mujoco),
        "iou_decimated_min": min(decimated),
        "iou_decimated_mean": float(np.mean(decimated)),
        "iou_near_min": min(near),
        "near_views": len(near),
        "pixels_wrong": wrong,
        "pixels_checked": checked,
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Speed and exactness of imagined silhouettes.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    times = speed()
    view_ms = times["jaccard_chamfer"]["200"]["cpu_ms"] / 400
    figures = {**times, "faces": len(arm().faces), **times_faster(view_ms), **exactness()}
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
