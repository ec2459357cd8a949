"""Which part of the picture is me? A robot moves a little and looks, one frame after the other.

The arm is filmed in MuJoCo while two pendulums and two boxes move beside it. The loop is what runs
on a real robot: take a picture, read the encoders, `step`; ask `found` whenever you like. With
--camera 0 it looks through a webcam and takes the joint positions from `read_encoders`, which is
yours to write.

python examples/09_find_the_body.py [--camera NUMBER]    needs the extras sim and vision
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator

import numpy as np

import bodyschema as bs
from bodyschema.simulation.moving_scene import Film, MovingScene, Studio

Moment = tuple[float, np.ndarray, np.ndarray]  # s; (height, width) grey; (n_joints,) rad


def read_encoders() -> np.ndarray:
    """Joint positions of your robot now, rad."""
    raise SystemExit("Write read_encoders() for your robot.")


def webcam(number: int) -> Iterator[Moment]:
    """Pictures as they come, with the clock of this computer."""
    import cv2

    camera = cv2.VideoCapture(number)
    while True:
        there, image = camera.read()
        if not there:
            return
        yield time.monotonic(), cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), read_encoders()


def filmed(film: Film) -> Iterator[Moment]:
    """The same from a film."""
    yield from zip(film.time, film.pictures, film.q, strict=True)


def truly_me(film: Film, cell: int) -> np.ndarray:
    """(rows, cols) cells of which half or more showed the arm in any labelled frame."""
    frames, height, width = film.body.shape
    cells = film.body.reshape(frames, height // cell, cell, width // cell, cell)
    return (cells.mean(axis=(2, 4)) >= 0.5).any(axis=0)


def look(finder: bs.BodyFinder, moments: Iterator[Moment]) -> bs.BodyInView:
    """Say what is known after every motion."""
    state, known = None, -1
    for t, image, q in moments:
        state = state or finder.start(image.shape[::-1])
        state, _ = finder.step(state, (bs.Frame(t, image, q),))
        found = finder.found(state)
        if found.motions != known:
            known = found.motions
            print(f"{t:6.1f} s  {known:2d} motions  {found.mask.sum():3d} cells are me")
        if found.enough:
            break
    return found


if "--camera" in sys.argv:
    number = int(sys.argv[sys.argv.index("--camera") + 1])
    look(bs.BodyFinder(("pan", "lift")), webcam(number))  # name your joints
    raise SystemExit

film = Studio(MovingScene(robot="arm", distractor="always", seed=3, motions=8)).film()
finder = bs.BodyFinder(film.joints, camera_joints=film.head)
found = look(finder, filmed(film))
print("Seen enough?", "Yes:" if found.enough else "No:", found.reason)
if found.next_motion is not None:
    print("What would help:", found.next_motion.why)
if np.isfinite(found.lag_s):
    delay = 1e3 * film.delay_s
    print(f"Pictures lag by {1e3 * found.lag_s:.0f} ms; in truth by {delay:.0f} ms")
right = found.mask & truly_me(film, finder.cell_px)
print(f"{right.sum()} of {found.mask.sum()} cells that are called me did show the arm")
counts = np.bincount(found.joint[found.mask], minlength=len(film.joints))
for name, count in zip(film.joints, counts, strict=True):
    print(f"  {name:>12} moves {count:3d} of them furthest")
