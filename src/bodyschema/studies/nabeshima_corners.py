"""From pictures to hand and eye: motion finds the hand, its corners are followed, both are learned.

The paper marks nothing and knows no model of the hand: what moves with the joints is the hand, and
points on it are followed in both images (Nabeshima and Kuniyoshi, sections 3.3 and 4.2). Here the
same runs from pictures that MuJoCo draws, 640x480, of a five-joint arm before a rectified pair:

    3 s    the wrist waggles: cells that move now in a fifth of the frames are the hand
    then   the arm swings: corners in those cells, u_left, v, u_right, into `HandEyePoints`

Errors are those of the camera in the world against where MuJoCo has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.frames import Frame
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import StereoPoints
from bodyschema.simulation.stereo_film import StereoFilm
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.vision.corners import CornerTracker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OFTEN = 0.2
"""Share of the frames in which a cell of the hand moves."""
EVERY = 30
"""Frames between two figures of the course."""
TRACKER = CornerTracker(count=12, window=11, spacing=8.0)


@dataclass(frozen=True)
class Corners:
    """Hand and eye learned from pictures alone: hand found by motion, corners followed."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "corners"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 5
    """Arms, cameras and rooms."""
    seed: int = 0
    """The same seed gives the same answer."""
    waggle: float = 3.0
    """s in which the wrist moves alone and the hand is found."""
    seconds: float = 15.0
    """s of swings that hand and eye are learned from."""

    def __post_init__(self) -> None:
        if not (self.waggle >= 1 and self.seconds >= 1):
            raise InputError(
                f"give each part at least 1 s, not {self.waggle:g} and {self.seconds:g}."
            )

    def tasks(self) -> Sequence[Task]:
        """One film each."""
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """One film, from the first frame to the camera's place."""
        film = StereoFilm([self.seed, int(task.settings["run"])])
        hand, truly = _hand_found(film, self.waggle)
        cells = _cells_of(truly, BodyFinder.cell_px)
        found = {
            "cells": int(hand.sum()),
            "cells_right": float(np.mean(cells[hand] > 0.3)) if hand.any() else None,
        }
        return found | _learned(film, hand, self.seconds)

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians and worst of the runs, and in how many the truth lies within the bounds."""
        runs = [result for result in results.values() if result["course"]]
        last = np.array([result["course"][-1] for result in runs]).reshape(-1, 5)
        answer: Result = {"runs": len(results), "learned": len(runs)}
        for k, name in ((1, "rotation_deg"), (2, "camera_mm")):
            answer[name] = _spread(last[:, k])
        answer["within_bounds"] = int(np.sum((last[:, 1:3] < last[:, 3:]).all(axis=1)))
        for name in ("corners", "on_hand_share", "seen_share"):
            answer[name] = _spread(np.array([result[name] for result in runs]))
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Errors at the end."""
        names = {
            "rotation_deg": "camera turned wrong, deg",
            "camera_mm": "camera misplaced, mm",
            "corners": "corners",
            "on_hand_share": "share of them on the hand",
            "seen_share": "share seen in both images",
        }
        table = [
            [label, *(f"{summary[name][k]:.3g}" for k in ("median", "least", "most"))]
            for name, label in names.items()
            if summary[name]
        ]
        notes = [
            f"{summary['learned']} of {summary['runs']} films gave corners; in "
            f"{summary['within_bounds']} of them both errors lie within their stated bounds.",
            f"The wrist waggles {self.waggle:g} s, then the arm swings {self.seconds:g} s; "
            "640x480, 30 frames a second, grey values with noise of 2 of 255.",
        ]
        return Rows(("", "median", "least", "most"), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Errors over time, dotted the stated bounds."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(9, 3.6), layout="constrained")
        panels = figure.subplots(1, 2)
        for axes, k, label in zip(panels, (1, 2), ("rotation, deg", "place, mm"), strict=True):
            for run, result in enumerate(results.values()):
                if not result["course"]:
                    continue
                course = np.array(result["course"])
                axes.semilogy(course[:, 0], course[:, k], color=f"C{run}", lw=1.2)
                axes.semilogy(course[:, 0], course[:, k + 2], color=f"C{run}", lw=0.8, ls=":")
            axes.set_xlabel("time, s (dotted: stated bound)")
            axes.set_ylabel(f"error of the camera: {label}")
        return figure


def _hand_found(film: StereoFilm, seconds: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(rows, cols) cells that move with the wrist, and (height, width) where the hand truly is."""
    finder, state, moving = BodyFinder(film.joints), None, []
    for moment in film.waggle(seconds):
        height, width = moment.left.shape
        state = state or finder.start((width, height))
        state, _ = finder.step(state, (Frame(moment.time, moment.left, moment.q),))
        moving.append(finder.found(state).now)
    return np.mean(moving, axis=0) > OFTEN, film.hand()


def _cells_of(pixels: NDArray[np.bool_], side: int) -> NDArray[np.float64]:
    """(rows, cols) share of each cell."""
    height, width = pixels.shape
    return np.asarray(pixels.reshape(height // side, side, width // side, side).mean(axis=(1, 3)))


def _learned(film: StereoFilm, hand: NDArray[np.bool_], seconds: float) -> Result:
    """Follow corners of the hand and learn; course: time, two errors, two bounds (s, deg, mm)."""
    side, moments = BodyFinder.cell_px, film.swings(seconds)
    first = next(moments)
    try:
        mask = hand.repeat(side, axis=0).repeat(side, axis=1)
        state = TRACKER.start(first.left, mask, first.right)
    except InputError:
        return {"course": [], "corners": 0, "on_hand_share": None, "seen_share": None}
    u, v = np.rint(state.place).astype(int).T
    on_hand = float(film.hand()[v, u].mean())
    learner = HandEyePoints(film.stereo, points=len(state.place))
    belief, course, seen = learner.start(), [], []
    for frame, moment in enumerate(chain([first], moments), start=1):
        if frame > 1:
            state = TRACKER.step(state, moment.left, moment.right)
        seen.append(float(np.isfinite(state.pixels).all(axis=1).mean()))
        if seen[-1]:
            sample = StereoPoints(moment.time, moment.T_world_hand, state.pixels)
            belief, _ = learner.step(belief, (sample,))
        if frame % EVERY == 0 and belief.theta is not None:
            bounds = learner.certificate(belief).bounds
            stated = (float(np.rad2deg(bounds["rotation"])), 1e3 * float(bounds["camera"]))
            errors = _errors(belief.theta.T_world_cam, film.T_world_cam)
            course.append([moment.time, *errors, *stated])
    return {
        "course": course,
        "corners": len(state.place),
        "on_hand_share": on_hand,
        "seen_share": float(np.mean(seen)),
    }


def _errors(found: NDArray[np.float64], truth: NDArray[np.float64]) -> tuple[float, float]:
    """Degrees and mm between two poses."""
    turn = np.linalg.norm(lie.log_so3(found[:3, :3].T @ truth[:3, :3]))
    away = np.linalg.norm(found[:3, 3] - truth[:3, 3])
    return float(np.rad2deg(turn)), 1e3 * float(away)


def _spread(values: NDArray[np.float64]) -> dict[str, float]:
    """Median, least and most; nothing for nothing."""
    if not len(values):
        return {}
    median, least, most = np.median(values), values.min(), values.max()
    return {"median": float(median), "least": float(least), "most": float(most)}
