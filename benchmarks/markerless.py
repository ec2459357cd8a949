"""Joint offsets from pictures alone, on recordings of arms that cameras watched.

    python benchmarks/markerless.py [--json] [--data FOLDER] [--starts N] [--hands]

vislab  N random starts: five stereo pairs, and encoders wrong by up to 15 degrees a joint more or
        less than the recording's truth. "converged" counts runs whose hand is within 2 mm and
        2 degrees of the median run's; "repeatability" is the mean over all pairs of runs,
        "to_published" the mean distance to the hand by the published offsets, of which 4.5 mm are a
        difference between the model and the recording simulator. Poses of the hand at frames 0, 60
        and 120. "twenty_frames" is the same from 20 pairs each.
med7    camera pose (start: the coarse one of the source) and offsets together from five pairs of
        a real arm, by its moving links; INJECTED is added to the joints and looked for again.
        "injected_error_deg" is accuracy: what is found for the arm with INJECTED, against it; the
        arm's own zeros count as right. "injected_repeat_deg" is repeatability: the same less what
        is found without INJECTED, so an error that both answers share is not in it.
        "iou" is of the whole arm with the supplied masks. "without_masks" uses the images only.
hands   with --hands, in place of the recordings: a simulated hand, see `hand_trials`.

Times are of the processor.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
import hand_trials
from bodyschema import lie
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit, overlap
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.images import Images
from watched_arms import PUBLISHED, Watched, med7, vislab

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

INJECTED = np.array([0, 4, -3, 5, -4, 5, 0.0])
"""deg, added to the joints of the KUKA arm."""

WRONG = np.deg2rad(15)
"""rad, largest error of a joint at a start of vislab."""

JUDGED = (0, 60, 120)
"""Frames of vislab whose hand is looked at."""

SIMULATED = Doubts(focal=0, centre=0, turn=0, shape=0)
"""The cameras and the meshes of vislab are those of the simulator that drew its pictures."""

SEEDS = 512

FACES = 6000
"""Of each link of the KUKA arm; coarser links are too narrow."""


def shifted(frames: tuple[Images, ...], w: Watched, offsets: Array) -> list[Images]:
    """The same pictures with other encoder readings, (7,) rad more."""
    column = [w.body.joint_index(name) for name in w.joints]
    out = []
    for seen in frames:
        q = seen.q.copy()
        q[column] += offsets
        out.append(replace(seen, q=q))
    return out


def hands(w: Watched, offsets: Array) -> Array:
    """(3, 4, 4) poses of the hand by offsets (7,) rad."""
    seen = shifted(tuple(w.frames[i] for i in JUDGED), w, offsets)
    return np.array([relative_pose(w.body, f.q, w.eye, w.hand) for f in seen])


def apart(A: Array, B: Array) -> Array:
    """Mean distance of poses (n, 4, 4): mm and degrees."""
    place = np.linalg.norm(A[:, :3, 3] - B[:, :3, 3], axis=1)
    turn = np.linalg.norm(lie.log_so3(A[:, :3, :3] @ np.swapaxes(B[:, :3, :3], 1, 2)), axis=1)
    return np.array([1e3 * place.mean(), np.rad2deg(turn).mean()])


def vislab_run(w: Watched, number: int, pairs: int, wrong: float) -> tuple[Array, MarkerlessFit]:
    """Offsets found (7,) rad from one random start, and what was said."""
    rng = np.random.default_rng([number, pairs])
    start = PUBLISHED + rng.uniform(-wrong, wrong, 7)
    chosen = np.sort(rng.choice(len(w.frames), pairs, replace=False))
    free = bs.free_joints(w.body, ["offsets"], w.joints).with_prior(np.full(7, np.deg2rad(8)))
    frames = shifted(tuple(w.frames[i] for i in chosen), w, start)
    fit = Markerless(w.surface, seeds=SEEDS, doubts=SIMULATED, seed=number).fit(
        w.body, free, frames
    )
    return start + fit.estimate.x, fit


def vislab_figures(w: Watched, starts: int, pairs: int) -> dict[str, Any]:
    """Convergence, scatter and distance to the published offsets."""
    begin = time.process_time()
    runs = [vislab_run(w, i, pairs, WRONG) for i in range(starts)]
    seconds = (time.process_time() - begin) / starts
    x = np.array([offsets for offsets, _ in runs])
    poses, middle = [hands(w, offsets) for offsets in x], hands(w, np.median(x, axis=0))
    good = [(apart(pose, middle) < 2).all() for pose in poses]
    kept = np.flatnonzero(good)
    scatter = np.array([apart(poses[a], poses[b]) for a, b in combinations(kept, 2)])
    published = np.array([apart(poses[i], hands(w, PUBLISHED)) for i in kept])
    std = np.array([runs[i][1].estimate.std for i in kept])
    return {
        "converged": int(np.sum(good)),
        "starts": starts,
        "repeatability_mm": float(scatter[:, 0].mean()),
        "repeatability_deg": float(scatter[:, 1].mean()),
        "worst_mm": float(scatter[:, 0].max()),
        "worst_deg": float(scatter[:, 1].max()),
        "to_published_mm": float(published[:, 0].mean()),
        "to_published_deg": float(published[:, 1].mean()),
        "scatter_deg": np.rad2deg(x[good].std(axis=0)).round(3).tolist(),
        "stated_deg": np.rad2deg(std.mean(axis=0)).round(3).tolist(),
        "iou": float(np.mean([runs[i][1].iou for i in kept])),
        "lost_flag_right": int(sum(fit.lost != g for (_, fit), g in zip(runs, good, strict=True))),
        "seconds": seconds,
    }


def med7_fit(w: Watched, frames: list[Images]) -> MarkerlessFit:
    """Camera pose and offsets by the moving links."""
    moving = bs.Surface.of(w.body, list(w.surface.frames[1:]), FACES)
    offsets = bs.free_joints(w.body, ["offsets"], w.joints).with_prior(np.full(7, np.deg2rad(5)))
    free = bs.join(offsets, bs.free_frame(w.body, w.eye, 0.1, 0.1))
    return Markerless(moving, seeds=SEEDS).fit(w.body, free, frames)


def med7_figures(data: Path, masked: bool) -> dict[str, Any]:
    """Recovery of injected offsets, and overlap."""
    w, masks = med7(data, masked, faces=FACES), med7(data, faces=FACES)
    begin = time.process_time()
    plain = med7_fit(w, list(w.frames))
    seconds = time.process_time() - begin
    injected = med7_fit(w, shifted(w.frames, w, np.deg2rad(INJECTED)))
    found, without = (np.rad2deg(fit.estimate.x[:7]) for fit in (injected, plain))
    error, repeat = found + INJECTED, found - without + INJECTED
    whole_arm = replace(plain.model, surface=w.surface)
    return {
        "injected_error_deg": dict(zip(w.joints, error.round(3).tolist(), strict=True)),
        "injected_repeat_deg": dict(zip(w.joints, repeat.round(3).tolist(), strict=True)),
        "stated_deg": np.rad2deg(plain.estimate.std[:7]).round(3).tolist(),
        "not_identifiable": list(plain.identifiability.sentences),
        "iou": overlap(whole_arm, plain.z, masks.frames),
        "residual_px": plain.residual,
        "bias_px": plain.bias.round(2).tolist(),
        "seconds": seconds,
    }


def vislab_all(data: Path, starts: int) -> dict[str, Any]:
    """Five pairs, and twenty for fewer starts."""
    w = vislab(data, faces=500)
    figures = vislab_figures(w, starts, 5)
    return figures | {"twenty_frames": vislab_figures(w, max(starts // 5, 3), 20)}


def measure(data: Path, starts: int) -> dict[str, Any]:
    """All figures."""
    arm = data / "roboreg_med7_zed2i"
    with_masks = med7_figures(arm, True)
    return {
        "vislab": vislab_all(data / "vislab_icub_sim", starts),
        "med7": with_masks | {"without_masks": med7_figures(arm, False)},
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Joint offsets from pictures alone.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    parser.add_argument("--starts", type=int, default=50, help="random starts of vislab")
    parser.add_argument("--hands", action="store_true", help="the simulated hands")
    options = parser.parse_args()
    figures = hand_trials.measure() if options.hands else measure(options.data, options.starts)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
