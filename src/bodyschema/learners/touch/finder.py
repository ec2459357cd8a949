"""Touches as they happen: when something touches the object in the hand, and where.

    unexplained wrench ──► onset: touched or not ──► evidence: mean and scatter ──► place
                              (chi-square)              (fixed size)               (line, surface)

The wrench is that of anything but the sensor on the object (`unexplained`). Before a touch the
evidence remembers the last moments; a touch adds to them, so what the onset changed counts
for more than what the sensor's offset may be. No sample is kept, and the cost of a sample does not
grow with time.

A touch is a point when its wrenches agree with one place on the surface (see `place`). Otherwise it
is said why not: a couple along the force (`twist`), a line that misses the object (`beside`), or
wrenches of different moments that do not agree (`moving`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtrc, chdtri

from bodyschema.errors import InputError
from bodyschema.learners.learner import in_turn
from bodyschema.learners.touch.evidence import Evidence, principal
from bodyschema.learners.touch.onset import Smoothed, limits
from bodyschema.learners.touch.place import Located, Place, locate
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.model.solid import Solid

Array = NDArray[np.float64]

Verdict = Literal["point", "twist", "beside", "moving"]

UNLIKELY = 1e-3
"""Chance that a point contact is refused."""

FEWEST = 4.0
"""Samples before a touch that are remembered at least."""

CLEAR = 3.3
"""Standard deviations that a couple along the force, or a miss, must have to be blamed."""


@dataclass(frozen=True)
class Touch:
    """A contact, over or not."""

    begins: float
    """s, when it was noticed."""
    ends: float | None
    """s, when it was over; None while it lasts."""
    force: Array
    """(3,) N on the object when it was pushed hardest, a little smoothed; mount's axes."""
    verdict: Verdict
    """"point", or why it is not one."""
    places: tuple[Place, ...]
    """Where it may be, the likeliest first."""
    inside: bool
    """False when the line of force misses the surface and the place is the nearest on it."""
    p_value: float
    """Chance that a point contact fits as badly."""
    couple: float
    """Nm along the force."""
    couple_std: float
    """Nm."""
    beside: float = 0.0
    """Chi-square of one degree of freedom: how much worse a point on the surface explains the
    wrenches than one anywhere."""

    @property
    def point(self) -> Array:
        """(3,) m, the likeliest place in the mount's frame."""
        return self.places[0].point

    @property
    def covariance(self) -> Array:
        """(3, 3) m^2 of the point."""
        return self.places[0].covariance


@dataclass(frozen=True)
class Feeling:
    """State: what is felt now, and the evidence of the touch, if there is one."""

    smoothed: Smoothed
    evidence: Evidence
    begins: float | None = None
    """s; None while nothing touches."""
    samples: int = 0
    """Since the touch was noticed."""
    force: Array | None = None
    """(3,) N, the largest smoothed one since the touch was noticed."""
    calm: int = 0
    """Samples in a row below the lower limit."""
    above: float | None = None
    """s, of the latest sample, if it was the first above the upper limit."""


@dataclass(frozen=True)
class Felt:
    """What one sample was worth."""

    surprise: float
    """Squared size of the smoothed wrench in its standard deviations, over the limit."""
    event: Literal["", "begins", "ends"] = ""
    touch: Touch | None = None
    """At the beginning, at the end, and every so many samples between."""


@dataclass(frozen=True)
class TouchFinder:
    """Settings of the learner."""

    noise: Array
    """(6, 6) covariance of a sample, as it counts in a mean of several: N^2, N Nm, Nm^2."""
    solid: Solid | None = None
    """The object in the mount's frame; without it only touches from several sides are placed."""
    rate: float = 100.0
    """Samples a second."""
    false_per_hour: float = 0.1
    """Touches an hour that may be felt where there are none."""
    samples: float = np.inf
    """From which the noise was measured."""
    before: float = 0.2
    """s before a touch that it is compared with."""
    longest: float = 2.0
    """s of a touch that are remembered."""
    patience: float = 0.1
    """s without any wrench that end a touch."""
    every: float = 0.1
    """s between two looks at the place while a touch lasts."""
    surface: float = 0.0
    """m, one standard deviation that the object's surface may be off."""

    def __post_init__(self) -> None:
        N = self.noise
        if N.shape != (6, 6) or not np.isfinite(N).all() or np.linalg.eigvalsh(N)[0] <= 0:
            raise InputError(
                f"the noise of a wrench is a positive definite 6x6 covariance; got {N.tolist()}."
            )
        times = (self.before, self.longest, self.patience, self.every)
        above = min(self.rate, self.false_per_hour, *times) > 0 and self.surface >= 0
        if not above or not self.samples > 12:
            raise InputError(
                "settings of a touch finder are above zero, and its noise is measured on more than "
                "12 samples."
            )

    def start(self, lasting: int = 0) -> Feeling:
        """Before the first sample; `lasting` is the number k of errors that stay the same."""
        return Feeling(Smoothed(np.zeros(6), np.zeros((6, lasting))), Evidence.none(lasting))

    def step(
        self, state: Feeling, moment: tuple[Unexplained, ...]
    ) -> tuple[Feeling, tuple[Felt, ...]]:
        """The state after one sample, in a batch of one."""
        return in_turn(self._feel, state, moment)

    def _feel(self, state: Feeling, sample: Unexplained) -> tuple[Feeling, Felt]:
        time, wrench, factor = float(sample.time[0]), sample.wrench[0], sample.factor[0]
        if not (np.isfinite(wrench).all() and np.isfinite(factor).all()):
            raise InputError(f"the wrench at {time:g} s is no finite number: {wrench}.")
        upper, lower = limits(self.false_per_hour, self.rate, self.samples)
        smoothed = state.smoothed.follow(wrench, factor, self.noise)
        touched = state.begins is not None
        longest = max((self.longest if touched else self.before) * self.rate, FEWEST)
        evidence = state.evidence.add(wrench, factor, longest)
        calm = state.calm + 1 if smoothed.surprise < lower else 0
        size = smoothed.surprise / upper
        if not touched:
            if size < 1 or state.above is None:
                # One sample alone may be a spike: noise has longer tails than it is believed to.
                above = time if size >= 1 else None
                return Feeling(smoothed, evidence, above=above), Felt(size)
            state = Feeling(smoothed, evidence, state.above, 1, smoothed.wrench[:3])
            return state, Felt(size, "begins", self.touch(state))
        if calm >= max(self.patience * self.rate, 2):
            felt = Felt(size, "ends", self.touch(state, time))
            return Feeling(smoothed, self.start(factor.shape[1]).evidence), felt
        force = _larger(smoothed.wrench[:3], state.force)
        state = Feeling(smoothed, evidence, state.begins, state.samples + 1, force, calm)
        due = state.samples % max(round(self.every * self.rate), 1) == 0
        return state, Felt(size, touch=self.touch(state) if due else None)

    def touch(self, state: Feeling, ends: float | None = None) -> Touch | None:
        """What is known of the touch that the state is in; None if it is in none."""
        if state.begins is None or state.force is None:
            return None
        felt = principal(state.evidence, self.noise)
        found = locate(felt, state.force, self.solid, self.surface)
        q, size = found.places[0].misfit, float(np.linalg.norm(state.force))
        return Touch(
            begins=state.begins,
            ends=ends,
            force=state.force,
            verdict=_verdict(found),
            places=found.places,
            inside=found.inside,
            p_value=float(chdtrc(found.freedom, q)),
            couple=found.pitch * size,
            couple_std=found.pitch_std * size,
            beside=max(q - found.misfit, 0.0),
        )

    def touches(self, unexplained: Unexplained) -> list[Touch]:
        """All touches of a recording; the last one may last beyond its end."""
        found = []
        state = self.start(unexplained.factor.shape[2])
        for moment in unexplained.moments():
            state, (felt,) = self.step(state, moment)
            if felt.event == "ends" and felt.touch is not None:
                found.append(felt.touch)
        last = self.touch(state)
        return found if last is None else [*found, last]


def _larger(force: Array, before: Array | None) -> Array:
    return force if before is None or force @ force > before @ before else before


def _verdict(found: Located) -> Verdict:
    q = found.places[0].misfit
    if q <= chdtri(found.freedom, UNLIKELY):
        return "point"
    meets = found.misfit <= chdtri(found.freedom, UNLIKELY)
    if (meets or not found.inside) and q > found.misfit + CLEAR**2:
        return "beside"
    return "twist" if abs(found.pitch) > CLEAR * found.pitch_std else "moving"


def covariance_of(std: ArrayLike) -> Array:
    """(6, 6) noise of a sample from the standard deviations (6,) of force, N, and torque, Nm."""
    return np.diag(np.asarray(std, dtype=np.float64) ** 2)
