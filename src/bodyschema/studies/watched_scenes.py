"""Detectors of the own body on films of a simulated robot, scored cell by cell against the truth.

A cell is of the body when at least half of it, on average over the film, shows links that the
joints move; it never is when no labelled frame shows a pixel of the body in it. Between the two lie
the cells that the outline sweeps; they count neither way. What is carried is scored by itself.

A film of k motions is judged in the rest after the k-th motion, before the next one begins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.frames import Frame
from bodyschema.simulation.film import Film
from bodyschema.simulation.random_motions import LEAST_REST

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

CELL = 16
"""pixels"""
BODY_SHARE = 0.5
"""Of a cell that is of the body."""
THING_SHARE = 0.4
"""Of a cell that shows what is carried."""
NOTED = 0.02
"""s before the next motion may begin, when the answer after a motion is read."""


class Detector(Protocol):
    """Finds the body frame by frame; see `attention.finder.BodyFinder`."""

    def start(self, size: tuple[int, int]) -> Any:
        """Before the first frame."""
        ...

    def step(self, state: Any, moment: tuple[Frame, ...]) -> tuple[Any, Any]:
        """One frame."""
        ...

    def found(self, state: Any) -> BodyInView:
        """What is known by now."""
        ...


@dataclass(frozen=True)
class Truth:
    """What the cells of a film truly show."""

    body: Flags
    """(rows, cols)."""
    never: Flags
    """(rows, cols) neither body nor carried thing in any labelled frame."""
    thing: Array
    """(m, rows, cols) share of the carried thing in each labelled frame."""
    links: Array
    """(m, rows, cols) share of the body's links."""
    joint: Ints
    """(rows, cols) joint that moves the body's part there furthest, of those that move the body."""


def truth_of(film: Film) -> Truth:
    """The truth about a film's cells."""
    links, thing = cell_shares(film.body), cell_shares(film.thing)
    own = len(film.joints) - len(film.head)
    return Truth(
        body=links.mean(axis=0) >= BODY_SHARE, never=(links + thing).max(axis=0) == 0, thing=thing,
        links=links, joint=cell_shares(film.speed[:own]).argmax(axis=0),
    )  # fmt: skip


def cell_shares(pixels: NDArray[Any]) -> Array:
    """Means over cells: (n, height, width) -> (n, rows, cols)."""
    n, height, width = pixels.shape
    rows, cols = height // CELL, width // CELL
    whole = pixels[:, : rows * CELL, : cols * CELL].reshape(n, rows, CELL, cols, CELL)
    return np.asarray(whole.mean(axis=(2, 4), dtype=np.float64))


def used_joints(film: Film, head_moves: bool) -> tuple[str, ...]:
    """Joints whose encoders a detector reads: all, or those of the arm alone."""
    return film.joints if head_moves else film.joints[: len(film.joints) - len(film.head)]


def watch(
    detector: Detector, film: Film, joints: int,
    note: Callable[[int, BodyInView], None] | None = None, frames: Flags | None = None,
) -> BodyInView:  # fmt: skip
    """Show a film to a detector.

    Args:
        detector: of the first `joints` joints of the film.
        film: what is shown.
        joints: how many of the film's joints are read.
        note: told the number of motions so far and what is found, in the rest after each.
        frames: (n,) those that are shown; all when absent. After a gap `note` is told late, of as
            many motions as were missed.

    Returns:
        what is found at the end.
    """
    height, width = film.pictures.shape[1:]
    state, done = detector.start((width, height)), 0
    shown = np.arange(len(film.time)) if frames is None else np.flatnonzero(frames)
    for i in shown:
        time = float(film.time[i])
        state, _ = detector.step(state, (Frame(time, film.pictures[i], film.q[i, :joints]),))
        while done < len(film.motion_end) and time >= film.motion_end[done] + LEAST_REST - NOTED:
            done += 1
            if note is not None:
                note(done, detector.found(state))
    return detector.found(state)


def counts(found: BodyInView, truth: Truth) -> dict[str, int]:
    """Cells of the body and others that are called me, and those whose joint is named rightly."""
    hit = found.mask & truth.body
    return {
        "hit": int(hit.sum()),
        "false": int((found.mask & truth.never).sum()),
        "body": int(truth.body.sum()),
        "right": int((found.joint == truth.joint)[hit].sum()),
    }


def shares(scores: Sequence[Mapping[str, int]]) -> dict[str, float | None]:
    """Precision, recall and share of cells with the right joint, over all cells of all films."""
    total = {key: sum(score[key] for score in scores) for key in ("hit", "false", "body", "right")}
    called = total["hit"] + total["false"]
    return {
        "precision": total["hit"] / called if called else None,
        "recall": total["hit"] / total["body"] if total["body"] else None,
        "joint_right_share": total["right"] / total["hit"] if total["hit"] else None,
    }
