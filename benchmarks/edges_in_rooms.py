"""Where the edge likelihood of Vicente et al. 2016 works: walls, rooms, heads that move, lambdas.

    python benchmarks/edges_in_rooms.py [--json] [--movements N] [--frames N] [--rooms NAME...]
                                        [--heads NAME...] [--edges NAME...] [--rates R...]

The simulated iCub of Table 1 moves its hand (first N movements of the study, the open loop) and the
published filter, 200 particles, compares edges (section 3.4.2). Model and robot differ in the
joint offsets alone. What is behind the hand, and what else is varied:

room    the cluttered one of the studies: textures, boxes, shadows
wall    the same hand, shaded as there, cut out before a wall of one grey
still   the head at rest, as in the studies
moving  the neck turns by 5 degrees to either side, twice in the movement; its encoders are right
hand    all edges of the CAD hand are imagined, as published; "outline": the outline alone

Told is the mean over the movements of the estimation error (mm, degrees) in the last frame, of its
median over the last twenty, and of the effective sample size over the particles in the first and in
the last ten frames. Times are of the processor.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.learners.published.image_likelihood import EdgeLikelihood, Edges
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.images import Images, Picture
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import SeeingIcub
from bodyschema.studies.hand_movements import movement, true_offsets
from bodyschema.studies.watched_hand import adapt, believed, distance

Array = NDArray[np.float64]

ROOMS, HEADS, EDGES = ("room", "wall"), ("still", "moving"), ("hand", "outline")
SWAY = float(np.deg2rad(5))
"""rad of the neck, to either side."""
TURNS = 2
"""Times that it goes there and back."""
WALL = 230
"""Grey level."""
LAST = 20
"""Frames at the end whose median is told."""


@cache
def looks(number: int, frames: int, room: str, head: str) -> tuple[tuple[Images, Array], ...]:
    """What the eyes saw, and the true pose of the hand in the left eye, frame by frame."""
    way, robot = movement(number), SeeingIcub(true_offsets(), "cluttered")
    cut = SeeingIcub(true_offsets(), "plain") if room == "wall" else None
    neck = robot.joints.index("neck_yaw")
    found = []
    for k, q in enumerate(joint_trajectory(way.q_i, way.q_d, frames)):
        q = q.copy()
        if head == "moving":
            q[neck] += SWAY * np.sin(2 * np.pi * TURNS * k / frames)
        robot.command(q)
        seen = robot.look()
        if cut is not None:
            cut.command(q)
            pictures = zip(seen.pictures, cut.look().pictures, strict=True)
            seen = replace(seen, pictures=tuple(before_wall(*pair) for pair in pictures))
        found.append((seen, robot.true_pose(icub.LEFT_EYE, icub.HAND)))
    return tuple(found)


def before_wall(picture: Picture, mask: Picture) -> Picture:
    """The masked part of a picture before a wall."""
    return np.where(mask[..., None], picture, np.uint8(WALL)).astype(np.uint8)


def run(
    number: int, frames: int, room: str, head: str, edges: Edges, rate: float
) -> tuple[Array, Array]:
    """Errors (frames, 3: without, mm and deg apart) and sizes (frames,) of one movement."""
    mine = believed("identical")
    learner = bs.ParticleFilter(mine.surface, likelihood=EdgeLikelihood(rate, edges), seed=number)
    state, errors, sizes = learner.start(mine.body, icub.RIGHT_ARM), [], []
    for seen, T in looks(number, frames, room, head):
        state, (info,) = learner.step(state, (replace(seen, cameras=mine.cameras),))
        poses = [
            relative_pose(body, seen.q, icub.LEFT_EYE, icub.HAND)
            for body in (mine.body, adapt(mine.body, info.offsets))
        ]
        errors.append([distance(T, pose) for pose in poses])
        sizes.append(info.effective_size / learner.particles)
    return np.array(errors), np.array(sizes)


def measure(
    movements: int,
    frames: int,
    rooms: Sequence[str],
    heads: Sequence[str],
    edges: Sequence[Edges],
    rates: Sequence[float],
) -> dict[str, Any]:
    """All figures, by "room head edges rate"."""
    found: dict[str, Any] = {"movements": movements, "frames": frames}
    for room, head, what, rate in product(rooms, heads, edges, rates):
        begin = time.process_time()
        runs = [run(n, frames, room, head, what, rate) for n in range(movements)]
        errors, sizes = np.array([r[0] for r in runs]), np.array([r[1] for r in runs])
        name = f"{room} {head} {what} {rate:g}"
        found[name] = {
            "without": errors[:, -1, 0].mean(axis=0).round(1).tolist(),
            "end": errors[:, -1, 1].mean(axis=0).round(1).tolist(),
            "last_median": np.median(errors[:, -LAST:, 1], axis=1).mean(axis=0).round(1).tolist(),
            "size_first": round(float(sizes[:, :10].mean()), 4),
            "size_last": round(float(sizes[:, -10:].mean()), 4),
            "seconds": round(time.process_time() - begin, 1),
        }
        print(f"{name}: {found[name]}", file=sys.stderr, flush=True)
    return found


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Where the published edges teach, and where not.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--movements", type=int, default=2, help="of the study's 40")
    parser.add_argument("--frames", type=int, default=60, help="of the open loop")
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=ROOMS)
    parser.add_argument("--heads", nargs="+", choices=HEADS, default=HEADS)
    parser.add_argument("--edges", nargs="+", choices=EDGES, default=EDGES)
    parser.add_argument("--rates", nargs="+", type=float, default=(0.01, 0.1, 1.0))
    options = parser.parse_args()
    figures = measure(
        options.movements, options.frames, options.rooms, options.heads, options.edges,
        options.rates,
    )  # fmt: skip
    print(json.dumps(figures, indent=None if options.json else 1))


if __name__ == "__main__":
    main()
