"""Likelihood maps of Nabeshima and Kuniyoshi (Eq. 27), with or without the confirming motion.

In the paper a motion that brings evidence is interrupted; the arm goes back to the posture at which
the evidence grew and moves again, perturbed. With eps_m (J, rows, cols) what began to move just
after a joint did in motion m, and eps'_m the same of the confirming motion, the map of m is

    L_m = eps_m AND eps'_m     with the confirming motion (the way back counts neither way)
    L_m = eps_m                without: the same motion, before it is confirmed

and the body is, by two readings, the cells of any map so far (red in Fig. 3), or those that the
maps find again and again: the redder cells of the blend in Fig. 5.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.attention.frames import Frame
from bodyschema.attention.onsets import STILL, OnsetCoincidence
from bodyschema.simulation.film import Film
from bodyschema.simulation.random_motions import CONFIRMED, LEAST_REST, RATE
from bodyschema.studies.study import Result
from bodyschema.studies.watched_scenes import NOTED, counts, truth_of, watch

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]


class Maps:
    """Maps of the motions so far, from the evidence in the rest after each."""

    def __init__(self, confirm: bool, made: int | None = None) -> None:
        """Of a film in which each motion is `made` so many times; by default as `confirm` needs."""
        self.confirm = confirm
        self.made = made or (CONFIRMED if confirm else 1)
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
        part = self._motions % self.made
        self._motions, self._before = self._motions + 1, evidence
        if part == 0:
            self._first = new
        if part != (self.made - 1 if self.confirm else 0):
            return False
        found = new & self._first
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
    for t, picture, q in zip(film.time, film.pictures, film.q[:, : len(joints)], strict=True):
        state, _ = detector.step(state, (Frame(float(t), picture, q),))
        found = detector.found(state)
        if done < len(ends) - 1 and t >= ends[done]:
            maps.add(found.evidence)
            done, begun = done + 1, float(t)
        if done == len(ends) - 1:
            risen = state.joint_onset[state.joint_onset > begun]
            likelihood = maps.now(found.evidence)
            yield Moment(
                float(t - risen.min()) if len(risen) else None,
                (state.cell_moving > 0).reshape(found.mask.shape),
                likelihood,
                replace(
                    found, mask=np.asarray(likelihood.any(axis=0)), joint=likelihood.argmax(axis=0)
                ),
                picture,
            )


LEAD_FRAMES, TRAIL_S = 8, 0.4
"""Frames before an onset, and s after it, that the published detector must see of a film."""


def published(film: Film, joints: tuple[str, ...], share: float, noted: Sequence[int]) -> Result:
    """Eq. 27 in a film of motions that are confirmed: four readings from one pass.

    Args:
        film: each motion back and once more.
        joints: whose positions are read, the film's first ones.
        share: of the motions that must find a cell, beside any of them.
        noted: numbers of motions after which the cells are counted.

    Returns:
        "faithful" with the confirming motion, "faithful_outside" without, the same with "_share":
        cells right and wrong by number of motions, and seconds a frame that was looked at.
    """
    truth, frames = truth_of(film), near_onsets(film, len(joints))
    maps = {"faithful": Maps(True), "faithful_outside": Maps(False, CONFIRMED)}
    after: dict[str, dict[str, Any]] = {
        name + ending: {} for name in maps for ending in ("", "_share")
    }

    def note(_: int, found: BodyInView) -> None:
        for name, one in maps.items():
            if one.add(found.evidence) and one.count in noted:
                for ending, least in (("", 0.0), ("_share", share)):
                    after[name + ending][str(one.count)] = counts(one.body(found, least), truth)

    begin = time.process_time()
    watch(OnsetCoincidence(joints), film, len(joints), note, frames)
    seconds = (time.process_time() - begin) / int(frames.sum())
    return {name: {"after": found, "seconds_a_frame": seconds} for name, found in after.items()}


def near_onsets(film: Film, joints: int) -> Flags:
    """(n,) frames that Eq. 27 depends on: a rest before each onset that counts, and tau after it.

    A cell counts when it rises within tau of an onset, after a rest of some frames. What happens
    in between, and on the way back, changes nothing; the first frame after a gap is compared with
    the last before it, and what that says is over before the onset.
    """
    fast = np.abs(np.diff(film.q[:, :joints], axis=0)) > STILL / RATE
    begins = (fast[1:] & ~fast[:-1]).any(axis=1)
    seen = np.zeros(len(film.time), dtype=bool)
    seen[0] = seen[-1] = True
    for i in np.flatnonzero(begins) + 2:
        if np.searchsorted(film.motion_end, film.time[i]) % CONFIRMED != 1:
            seen[max(i - LEAD_FRAMES, 0) : i + round(TRAIL_S * RATE)] = True
    return seen
