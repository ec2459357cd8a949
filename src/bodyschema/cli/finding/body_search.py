"""Look for the body in every frame of a clip, and draw what is known by then."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.frames import Frame
from bodyschema.attention.overlay import draw_found
from bodyschema.sources.clip import Clip, Moment
from bodyschema.sources.video_writer import video_writer
from bodyschema.vision.overlay import save_png

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Search:
    """What came out."""

    found: BodyInView
    """After the last frame."""
    moving: Flags
    """(n_frames, rows, cols) cells that moved with the joints in each frame."""
    seconds: float
    """s for all: reading, looking, drawing, writing."""
    looking: float
    """s of them for the search itself."""


def search(finder: BodyFinder, clip: Clip, folder: Path, pictures: int) -> Search:
    """Step through the clip.

    Args:
        finder: the detector.
        clip: frames with joint positions.
        folder: for overlay.mp4 and overlay_NNNN.png.
        pictures: how many of the latter.
    """
    chosen = set(np.linspace(0, len(clip) - 1, pictures + 1).astype(int)[1:])
    begin, looking, moving = time.perf_counter(), 0.0, []
    state = finder.start((clip.video.width, clip.video.height))
    found = finder.found(state)
    blank = np.zeros((clip.video.height, clip.video.width, 3), dtype=np.uint8)
    high, wide = draw_found(blank, found).shape[:2]
    rate = (len(clip) - 1) / (clip.time[-1] - clip.time[0])
    with video_writer(folder / "overlay.mp4", (wide, high), rate) as write:
        for k, moment in enumerate(_with_progress(clip)):
            before = time.perf_counter()
            state, _ = finder.step(state, (Frame(moment.time, moment.grey, moment.positions),))
            found = finder.found(state)
            looking += time.perf_counter() - before
            moving.append(found.now)
            picture = draw_found(moment.image, found, f"frame {moment.index}, {moment.time:.2f} s")
            write(picture)
            if k in chosen:
                save_png(picture, folder / f"overlay_{moment.index:04}.png")
    return Search(found, np.array(moving), time.perf_counter() - begin, looking)


def _with_progress(clip: Clip) -> Iterator[Moment]:
    """The moments, with a bar that says how many come a second."""
    columns = (
        TextColumn("looking for the body"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]:.1f} frames a second"),
    )
    begin = time.perf_counter()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task("", total=len(clip), rate=0.0)
        for done, moment in enumerate(clip.moments(), start=1):
            yield moment
            progress.update(task, completed=done, rate=done / (time.perf_counter() - begin))
