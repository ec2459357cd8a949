"""Motions of a body's inner geometry that nothing seen can show, for naming what stays open.

Move the origin of frame k by u e and put back everything that hangs on it:

    d l_k = u R_k e,      d l_c = -u e   for every frame c on k        (R_k of the placement of k)

Frame k then lies elsewhere, and all others where they were. If k turns about the axis a_k this
is so for e = a_k alone, since R(theta) a = a: the joint's centre *slides* along its axis. If k does
not turn, e may be any direction: its *origin* moves. The motion is exact for every u, and is open
when nothing is seen of frame k or from it and all those links are free (Hersch et al. 2008, 4.5.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import LINK, REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

WITHIN = 0.99
"""Cosine of the angle between a motion and a space above which it lies in the space."""


@dataclass(frozen=True)
class Motion:
    """One way to move a frame without moving the others."""

    frame: str
    """The frame that moves."""
    row: Array
    """(n_parameters,) m, for u = 1."""
    sentence: str


def invisible_motions(body: Body, variables: Variables) -> list[Motion]:
    """Slides of all joints and moves of all origins for which every link is free."""
    column = {
        (int(variables.index[i]), int(variables.component[i])): i
        for i in range(len(variables))
        if variables.code[i] == LINK
    }
    found = []
    for k, frame in enumerate(body.frames):
        if body.kind[k] == REVOLUTE:
            name = body.carriers[k]
            says = f"{name} slides along its axis: no motion shows where on it the centre lies"
            moves = [(body.axis[k], f"{says}; fix its link as modelled.")]
        else:
            says = f"the origin of {frame} moves along its"
            ends = "axis: no motion shows where it lies; fix it as modelled."
            moves = [(e, f"{says} {c} {ends}") for e, c in zip(np.eye(3), "xyz", strict=True)]
        rows = [(_row(body, column, k, e, len(variables)), sentence) for e, sentence in moves]
        found += [Motion(frame, row, sentence) for row, sentence in rows if row is not None]
    return found


def _row(body: Body, column: dict[tuple[int, int], int], k: int, e: Array, n: int) -> Array | None:
    """The motion of frame k along e; None when a link that it needs is not free."""
    moves = {int(c): -e for c in np.flatnonzero(body.parent == k)}
    if k > 0:
        moves[k] = body.placement[k, :3, :3] @ e
    row = np.zeros(n)
    for node, by in moves.items():
        for i in np.flatnonzero(np.abs(by) > 1e-12):
            if (node, int(i)) not in column:
                return None
            row[column[node, int(i)]] = by[i]
    return row if row.any() else None


def take_out(space: Array, motions: Sequence[Motion], scale: Array) -> tuple[list[Motion], Array]:
    """The motions that lie in a space, and what is left of the space.

    Args:
        space: (k, n_parameters) orthonormal rows, in units of `scale`.
        motions: candidates.
        scale: (n_parameters,) of the parameters.

    Returns:
        Independent motions within the space, and (k - their number, n_parameters) orthonormal rows.
    """
    inside: list[Motion] = []
    taken = np.zeros((0, len(space)))
    for motion in motions:
        u = motion.row / scale
        c = space @ (u / np.linalg.norm(u))
        new = c - taken.T @ (taken @ c)
        if np.linalg.norm(c) > WITHIN and np.linalg.norm(new) > np.sqrt(1 - WITHIN**2):
            inside.append(motion)
            taken = np.vstack([taken, new / np.linalg.norm(new)])
    _, _, Vt = np.linalg.svd(taken, full_matrices=True)
    return inside, np.asarray(Vt[len(taken) :] @ space)
