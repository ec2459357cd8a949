"""How fast pictures of the hand become offsets: frames a second, end to end.

    python benchmarks/tracking_speed.py [--frames 60] [--json]

Stereo pictures of 320x240, in colours, of the iCub's right arm on its way (a movement of
`bodyschema study vicente2016 table1`); MuJoCo draws them beforehand. A frame begins with these
pictures: the robot is told from a white background by its colour (plain), or edges are found
(cluttered). It ends with the estimate. Vicente et al. 2016 made 1.25 frames a second with 200
particles and 0.13 with 2000, on a GPU.

    particle-filter   the published filter with 200 and 2000 particles (_2: on two threads)
    track             outlines in information form with 200 and 2000 first guesses, on one thread

fps, ms           frames a second and ms a frame of wall time, from the median over frames
cpu_ms            the same of processor time, of all threads
all_fps           frames a second over the whole run, the search in its first frame included
first_s           wall time of the first frame, in which a tracker looks for the arm
load              what else the machine was doing: its load average before and after
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")  # read when mujoco is first imported

import bodyschema  # noqa: F401  (sets one BLAS thread a process, so it must come before numpy)

# isort: split
import numpy as np

from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.learners.images.contour_tracker import ContourTracker
from bodyschema.learners.published.image_likelihood import EdgeLikelihood, SilhouetteLikelihood
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.senses.images import Images, Picture
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import SEEN_LINKS, Scene, SeeingIcub
from bodyschema.studies.hand_movements import movement, true_offsets
from bodyschema.vision.surface import Surface

PARTICLES = (200, 2000)
SCENES: tuple[Scene, ...] = ("plain", "cluttered")
GREY, WHITE = 160, 255
"""Of the robot before a plain background."""
FRAMES_OF_AN_OPEN_LOOP = 120

Stepper = Callable[[Any, Images], tuple[Any, Any]]


def seen(scene: Scene, frames: int) -> list[Images]:
    """What the eyes see on a part of the way, in colours."""
    way, robot = movement(0), SeeingIcub(true_offsets(), scene)
    found = []
    for q in joint_trajectory(way.q_i, way.q_d, FRAMES_OF_AN_OPEN_LOOP)[:frames]:
        robot.command(q)
        images = robot.look()
        if scene == "plain":
            images = replace(images, pictures=tuple(map(painted, images.pictures)))
        found.append(images)
    return found


def painted(mask: Picture) -> Picture:
    """A grey robot before white, (height, width, 3)."""
    grey = np.where(mask, GREY, WHITE).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def prepared(images: Images, scene: Scene) -> Images:
    """What a learner is given: masks by colour before white, the pictures themselves elsewhere."""
    if scene == "cluttered":
        return images
    masks = tuple(picture[..., 1] < (GREY + WHITE) // 2 for picture in images.pictures)
    return replace(images, pictures=masks)


def learners(surface: Surface, scene: Scene) -> Iterator[tuple[str, str, Any]]:
    """(method, particles with _2 for two threads, learner)."""
    likelihood = SilhouetteLikelihood() if scene == "plain" else EdgeLikelihood()
    for m in PARTICLES:
        for threads, suffix in ((1, ""), (2, "_2")):
            kind = ParticleFilter(surface, particles=m, likelihood=likelihood, threads=threads)
            yield "particle-filter", f"{m}{suffix}", kind
        yield "track", str(m), ContourTracker(surface, seeds=m)


def timed(learner: Any, frames: list[Images], scene: Scene) -> dict[str, float]:
    """Times of a learner from the first picture to the last."""
    body, cpu, wall = icub.nominal_icub(), [], []
    state = learner.start(body, icub.RIGHT_ARM)
    for images in frames:
        c, w = time.process_time(), time.perf_counter()
        state, _ = learner.step(state, (prepared(images, scene),))
        cpu.append(time.process_time() - c)
        wall.append(time.perf_counter() - w)
    middle = float(np.median(wall[1:]))
    return {
        "fps": 1 / middle,
        "ms": 1e3 * middle,
        "cpu_ms": 1e3 * float(np.median(cpu[1:])),
        "all_fps": len(frames) / float(np.sum(wall)),
        "first_s": wall[0],
        "first_cpu_s": cpu[0],
    }


def measure(frames: int) -> dict[str, Any]:
    """All figures."""
    surface, before = Surface.of(icub.nominal_icub(), SEEN_LINKS, 0), os.getloadavg()[0]
    found: dict[str, Any] = {}
    for scene in SCENES:
        pictures = seen(scene, frames)
        for method, says, learner in learners(surface, scene):
            timed(learner, pictures[:2], scene)  # compiles
            found.setdefault(scene, {}).setdefault(method, {})[says] = timed(
                learner, pictures, scene
            )
    load = [before, os.getloadavg()[0]]
    return {**found, "frames": frames, "cores": os.cpu_count(), "load": load}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Frames a second from pictures to offsets.")
    parser.add_argument("--frames", type=int, default=60, help="of the movement, 2 to 120")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = measure(options.frames)
    print(json.dumps(figures, indent=None if options.json else 2))


if __name__ == "__main__":
    main()
