"""Likelihood maps of Nabeshima and Kuniyoshi (Eq. 27), with or without the confirming motion.

In the paper a motion that brings evidence is interrupted; the arm goes back to the posture at which
the evidence grew and moves again, perturbed. With eps_m (J, rows, cols) what began to move just
after a joint did in motion m, and eps'_m the same of the confirming motion, the map of m is

    L_m = eps_m AND eps'_m     with the confirming motion (the way back counts neither way)
    L_m = eps_m                without

and the body is, by two readings, the cells of any map so far (red in Fig. 3), or those that the
maps find again and again: the redder cells of the blend in Fig. 5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.frames import Frame
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.simulation.film import Film
from bodyschema.simulation.random_motions import CONFIRMED, LEAST_REST
from bodyschema.studies.watched_scenes import NOTED

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]


class Maps:
    """Maps of the motions so far, from the evidence in the rest after each."""

    def __init__(self, confirm: bool) -> None:
        """Of a film with or without confirming motions."""
        self.confirm = confirm
        self.count = 0
        """Maps so far."""
        self._motions = 0
        self._before: Array | float = 0.0
        self._first: Flags = np.zeros(0, dtype=bool)
        self._total: Array = np.zeros(())
        self._blend: Array = np.zeros(())

    def add(self, evidence: Array) -> bool:
        """Whether a map was finished by one more motion, with its evidence (J, rows, cols)."""
        new = self.grown(evidence)
        part = self._motions % CONFIRMED if self.confirm else CONFIRMED - 1
        self._motions, self._before = self._motions + 1, evidence
        if part == 0:
            self._first = new
        if part < CONFIRMED - 1:
            return False
        found = new & self._first if self.confirm else new
        self.count += 1
        self._total = np.asarray(self._total + found)
        self._blend = np.asarray(self._blend + found.any(axis=0))
        return True

    def grown(self, evidence: Array) -> Flags:
        """(J, rows, cols) cells whose evidence has grown since the last motion."""
        return np.asarray(evidence - self._before > 0)

    def now(self, evidence: Array) -> Flags:
        """(J, rows, cols) the map of the motion under way."""
        if not self.confirm:
            return self.grown(evidence)
        last = self._motions % CONFIRMED == CONFIRMED - 1
        return self.grown(evidence) & self._first & last

    def body(self, found: BodyInView, share: float) -> BodyInView:
        """Cells that at least this share of the maps has, and one of them at least."""
        blend = self._blend
        mask = blend >= max(share * self.count - 1e-9, 1.0)
        joint = np.where(mask, self._total.argmax(axis=0), -1)
        return replace(found, mask=mask, joint=joint, probability=blend / self.count)


@dataclass(frozen=True)
class Moment:
    """What the published detector knows at a frame of the motion that is judged."""

    since_onset: float | None
    """s since the first joint rose in this motion; None before."""
    moving: Flags
    """(rows, cols) cells in which there is flow."""
    likelihood: Flags
    """(J, rows, cols) the map so far."""
    found: BodyInView
    """With the cells of the map as mask."""
    picture: Grey


def moments(film: Film, joints: tuple[str, ...], confirm: bool) -> Iterator[Moment]:
    """Frame by frame through the last motion of a film: the confirming one, if there is one.

    Args:
        film: of one motion, or of one with its confirmation.
        joints: whose positions are read, the film's first ones.
        confirm: whether the film has confirming motions.
    """
    ends, maps = film.motion_end + LEAST_REST - NOTED, Maps(confirm)
    detector, done, begun = OnsetCoincidence(joints), 0, -np.inf
    height, width = film.pictures.shape[1:]
    state = detector.start((width, height))
    for time, picture, q in zip(film.time, film.pictures, film.q[:, : len(joints)], strict=True):
        state, _ = detector.step(state, (Frame(float(time), picture, q),))
        found = detector.found(state)
        if done < len(ends) - 1 and time >= ends[done]:
            maps.add(found.evidence)
            done, begun = done + 1, float(time)
        if done == len(ends) - 1:
            risen = state.joint_onset[state.joint_onset > begun]
            likelihood = maps.now(found.evidence)
            yield Moment(
                float(time - risen.min()) if len(risen) else None,
                (state.cell_moving > 0).reshape(found.mask.shape),
                likelihood,
                replace(
                    found, mask=np.asarray(likelihood.any(axis=0)), joint=likelihood.argmax(axis=0)
                ),
                picture,
            )
