"""Motion coincidence as published: what begins to move just after a joint did is moved by it.

Nabeshima and Kuniyoshi, section 3.3.2, Eq. 27. For joint i and cell j the evidence grows by

    Delta eps_ij = rho^a(da_i) AND rho^s(ds_j)

where rho^a is 1 for tau_a after joint i rises from rest, rho^s is 1 for tau_s after the flow in
cell j rises from zero, and AND asks that less of tau_a remains than of tau_s: the joint began
first. Here that reads: a cell that begins to move within tau of the onset of a joint gains one,
once for each onset of the joint. ds_j comes from pyramidal Lucas-Kanade flow, as in the paper.

What the paper leaves open: a joint rises when it turns faster than STILL after QUIET frames of
less; a point moves by more than POINT_MOVES and is found again when tracked backward; a cell moves
when two of its points do, and rises when it has done so for two frames after QUIET without.
Found is, as published, every cell with any evidence; a vote of several motions is stricter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView, NextMotion
from bodyschema.attention.frames import Frame, check_frame, check_settings, grid
from bodyschema.vision.flow import opencv

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]
Ints = NDArray[np.int64]

STILL = 0.01
"""rad/s; slower joints rest."""
TRACKING = {"winSize": (15, 15), "maxLevel": 2, "criteria": (3, 10, 0.03)}
"""Of OpenCV's tracker: window, levels, and at most 10 steps or down to 0.03 pixels."""
QUIET = 4
"""Frames of rest before something can rise."""
POINT_MOVES = 0.35
"""pixels/frame"""
POINTS = 2
"""Points of a cell that move when the cell does."""
BACK = 0.5
"""pixels by which a point may miss itself when it is tracked forward and backward."""
APART = 0.3
"""s; joints that rise nearer to each other than this make one motion."""
SPACING = 8
"""pixels between two points."""


@dataclass(frozen=True)
class OnsetState:
    """What the next frame needs."""

    size: tuple[int, int]
    """Width and height of the frames, pixels."""
    evidence: Array
    """(J, N) eps, onsets that coincided."""
    joint_onset: Array
    """(J,) s, when each joint rose last; -inf before it did."""
    counted: Flags
    """(J, N) cells that have coincided with the latest onset of a joint."""
    joint_quiet: Ints
    """(J,) frames for which each joint has rested."""
    cell_quiet: Ints
    """(N,) frames for which each cell has rested before it began to move."""
    cell_moving: Ints
    """(N,) frames for which each cell has moved."""
    time: float = -np.inf
    """s, of the last frame."""
    image: Grey | None = None
    """The last frame, blurred."""
    q: Array | None = None
    """(J,) positions at the last frame."""
    onsets: int = 0
    """Motions: frames in which a joint rose while none had for tau."""
    grown: bool = False
    """Whether the last motion has brought evidence: the paper repeats such a motion."""
    last_joint: int = -1
    """The joint that rose last."""


@dataclass(frozen=True)
class OnsetCoincidence:
    """The published detector."""

    joints: tuple[str, ...]
    """Names of the joints whose positions come with each frame."""
    cell_px: int = 16
    """Side of a cell, pixels."""
    tau_s: float = 0.3
    """s from the onset of a joint within which a cell must begin to move."""
    votes: int = 1
    """Onsets of a joint with which a cell must have coincided to be called me."""

    def __post_init__(self) -> None:
        check_settings(self.joints, self.cell_px, ())

    def start(self, size: tuple[int, int]) -> OnsetState:
        """Before the first frame; size is (width, height) in pixels.

        Raises:
            InputError: an image smaller than three cells either way.
        """
        rows, cols = grid(size, self.cell_px)
        J, N = len(self.joints), rows * cols
        none = np.zeros(N, dtype=np.int64)
        return OnsetState(
            size, np.zeros((J, N)), np.full(J, -np.inf), np.zeros((J, N), dtype=bool),
            np.full(J, QUIET), none + QUIET, none,
        )  # fmt: skip

    def step(
        self, state: OnsetState, moment: tuple[Frame, ...]
    ) -> tuple[OnsetState, tuple[bool, ...]]:
        """The state after one frame, and whether a motion has brought evidence."""
        grown = []
        for frame in moment:
            state = self._looked(state, frame)
            grown.append(state.grown)
        return state, tuple(grown)

    def _looked(self, state: OnsetState, frame: Frame) -> OnsetState:
        here, time_s = check_frame(state.size, self.joints, state.time, frame), frame.time
        blurred = opencv().GaussianBlur(frame.image, (5, 5), 0)
        if state.image is None or state.q is None:
            return replace(state, time=time_s, image=blurred, q=here)
        moves = self._cells_moving(state.image, blurred)
        fast = np.abs(here - state.q) > STILL * (time_s - state.time)
        seen = replace(state, time=time_s, image=blurred, q=here)
        return _coincided(_risen(seen, fast), moves, self.tau_s)

    def found(self, state: OnsetState) -> BodyInView:
        """What is known by now; `probability` is the share of motions that coincided."""
        shape = grid(state.size, self.cell_px)
        best = state.evidence.max(axis=0)
        mask = best >= self.votes
        moving = mask & (state.cell_moving > 0) & (state.joint_quiet < QUIET).any()
        again = None
        if state.grown:
            why = "cells began to move with it; moved again they show whether it was chance."
            again = NextMotion("repeat", self.joints[state.last_joint], why)
        return BodyInView(
            time=state.time, joints=self.joints, size=state.size, cell_px=self.cell_px,
            probability=np.minimum(best / max(state.onsets, 1), 1.0).reshape(shape),
            mask=mask.reshape(shape), now=moving.reshape(shape),
            joint=np.where(mask, state.evidence.argmax(axis=0), -1).reshape(shape),
            evidence=state.evidence.reshape(len(self.joints), *shape), lag_s=np.nan,
            lag_sd_s=np.nan, motions=state.onsets, enough=False,
            reason="the published detector does not say when it has seen enough.",
            next_motion=again,
        )  # fmt: skip

    def _cells_moving(self, before: Grey, after: Grey) -> Flags:
        """(N,) cells in which enough points move."""
        rows, cols = grid((before.shape[1], before.shape[0]), self.cell_px)
        moves = moving_points(before, after, points := _points(rows, cols, self.cell_px))
        cell = (points // self.cell_px).astype(np.int64) @ np.array([1, cols])
        return np.asarray(np.bincount(cell[moves], minlength=rows * cols) >= POINTS)


def moving_points(before: Grey, after: Grey, points: Array) -> Flags:
    """Which of the points (n, 2) move by pyramidal Lucas-Kanade flow that also leads back."""
    cv2 = opencv()
    start = points.astype(np.float32).reshape(-1, 1, 2)
    there, found, _ = cv2.calcOpticalFlowPyrLK(before, after, start, None, **TRACKING)
    flow = (there - start).reshape(-1, 2)
    moves = (found.ravel() > 0) & (np.hypot(flow[:, 0], flow[:, 1]) > POINT_MOVES)
    if moves.any():
        back, again, _ = cv2.calcOpticalFlowPyrLK(after, before, there[moves], None, **TRACKING)
        miss = (back - start[moves]).reshape(-1, 2)
        moves[moves] = (again.ravel() > 0) & (np.hypot(miss[:, 0], miss[:, 1]) < BACK)
    return np.asarray(moves)


def _points(rows: int, cols: int, cell_px: int) -> Array:
    """(n, 2) a lattice of points over all cells."""
    x = np.arange(SPACING / 2, cols * cell_px, SPACING)
    y = np.arange(SPACING / 2, rows * cell_px, SPACING)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _risen(state: OnsetState, fast: Flags) -> OnsetState:
    """rho^a: joints that are fast now after a rest have their onset now."""
    rises = fast & (state.joint_quiet >= QUIET)
    onset = np.where(rises, state.time, state.joint_onset)
    quiet = np.where(fast, 0, state.joint_quiet + 1)
    counted = state.counted & ~rises[:, None]
    if not rises.any():
        return replace(state, joint_onset=onset, joint_quiet=quiet, counted=counted)
    return replace(
        state, joint_onset=onset, joint_quiet=quiet, counted=counted, grown=False,
        onsets=state.onsets + bool(state.time - state.joint_onset.max() > APART),
        last_joint=int(np.argmax(rises)),
    )  # fmt: skip


def _coincided(state: OnsetState, moves: Flags, tau: float) -> OnsetState:
    """rho^s and Eq. 27: cells that have moved for two frames after a rest rise."""
    moving = np.where(moves, state.cell_moving + 1, 0)
    rises = (moving == 2) & (state.cell_quiet >= QUIET)
    # A rest is forgotten only once the motion after it has been seen for two frames.
    quiet = np.where(moves, np.where(moving >= 2, 0, state.cell_quiet), state.cell_quiet + 1)
    within = state.time - state.joint_onset <= tau
    new = within[:, None] & rises & ~state.counted
    return replace(
        state, cell_moving=moving, cell_quiet=quiet, counted=state.counted | new,
        evidence=state.evidence + new, grown=state.grown or bool(new.any()),
    )  # fmt: skip
