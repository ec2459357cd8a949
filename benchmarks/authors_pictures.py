"""The published filter of Vicente et al. 2016 on the pictures that its authors published.

    python benchmarks/authors_pictures.py [--json] [--data FOLDER] [--runs N] [--frames N]
                                          [--only NAME...] [--rates R...]

The recording (`vislab`) shows a simulated iCub before a hall full of things, its head at rest; only
the right arm moves. The joint offsets are published, up to 20 degrees. The filter starts at zero
and sees the frames in their order, with the paper's settings, and these likelihoods:

silhouettes   masks that the recording's background yields (section 3.4.1)
hand          edges of the images, all edges of the CAD hand imagined, Canny (3.4.2)
outline       the same, the outline alone imagined
wall          edges of the masks, as of a hand before a plain wall; the outline imagined

Edges are told for each lambda in `--rates`: 0.01 is the paper's, 0.1 (nearly) that of the released
code. "mm" and "deg" are means over the runs (other random numbers) of the mean distance of the
hand, in three postures, to that by the published offsets; 4.5 mm of it are a difference between the
model and the recording simulator. "size" is the effective sample size over the particles in the
last ten frames: at 1 the pictures prefer no particle. Times are of the processor.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.published.image_likelihood import (
    EdgeLikelihood,
    Edges,
    Likelihood,
    SilhouetteLikelihood,
)
from markerless import DATA, apart, hands
from watched_arms import PUBLISHED, Watched, vislab

Array = NDArray[np.float64]

FACES = 500
"""Of each link."""

NAMES = ("silhouettes", "hand", "outline", "wall")
RATES = (0.01,)
"""lambda, 1/pixel."""


def likelihoods(names: Sequence[str], rates: Sequence[float]) -> dict[str, Likelihood]:
    """Those that are asked for, "outline 0.01" and so on."""
    found: dict[str, Likelihood] = {}
    for name in names:
        if name == "silhouettes":
            found[name] = SilhouetteLikelihood()
            continue
        edges: Edges = "hand" if name == "hand" else "outline"
        found |= {f"{name} {rate:g}": EdgeLikelihood(rate, edges) for rate in rates}
    return found


def run(w: Watched, likelihood: Likelihood, frames: int, seed: int) -> tuple[Array, list[float]]:
    """Mean distance of the hand at the end, mm and degrees, and sizes of the last frames."""
    learner = bs.ParticleFilter(w.surface, likelihood=likelihood, seed=seed)
    state, sizes = learner.start(w.body, w.joints), []
    for i in np.linspace(0, len(w.frames) - 1, frames).round().astype(int):
        state, (info,) = learner.step(state, (w.frames[i],))
        sizes.append(info.effective_size / learner.particles)
    return apart(hands(w, info.offsets), hands(w, PUBLISHED)), sizes[-10:]


def measure(
    data: Path, frames: int, runs: int, names: Sequence[str], rates: Sequence[float]
) -> dict[str, Any]:
    """All figures."""
    folder = data / "vislab_icub_sim"
    masks, images = (vislab(folder, masked, FACES) for masked in (True, False))
    before = apart(hands(masks, np.zeros(7)), hands(masks, PUBLISHED))
    found: dict[str, Any] = {"frames": frames, "runs": runs}
    found["without_adaptation"] = dict(zip(("mm", "deg"), before.round(2).tolist(), strict=True))
    for name, likelihood in likelihoods(names, rates).items():
        watched = masks if name.split()[0] in ("silhouettes", "wall") else images
        begin = time.process_time()
        ends = [run(watched, likelihood, frames, seed) for seed in range(runs)]
        error = np.array([end[0] for end in ends])
        found[name] = {
            "mm": round(float(error[:, 0].mean()), 2),
            "deg": round(float(error[:, 1].mean()), 2),
            "each_mm": error[:, 0].round(1).tolist(),
            "each_deg": error[:, 1].round(1).tolist(),
            "size": round(float(np.mean([end[1] for end in ends])), 3),
            "seconds": round((time.process_time() - begin) / runs, 1),
        }
        print(f"{name}: {found[name]}", file=sys.stderr, flush=True)
    return found


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="The published filter on its authors' pictures.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    parser.add_argument("--runs", type=int, default=4, help="of each likelihood")
    parser.add_argument("--frames", type=int, default=120, help="of the recording's 132")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, help="likelihoods")
    parser.add_argument("--rates", nargs="+", type=float, default=RATES, help="lambda of edges")
    options = parser.parse_args()
    figures = measure(options.data, options.frames, options.runs, options.only, options.rates)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
