"""Watches the load on a wrist: identified by itself, and a grasp, a release or a swap noticed.

    identify --certificate--> hold --alarm--> settle --a few samples--> identify, sensor known
                                ^                                          |
                                +----------- named when told --------------+

Each sample is first tested against the belief, then waits for `WAIT` samples before it is learned,
so that a change is not learned as if it were the load. With e the innovation, S its covariance
(noise that remembers counted at its long-run size), the squared innovations e^T S^-1 e of force and
torque go into the sums of `cusum`, whose mean time to a false alarm is set. After an alarm the load
alone is forgotten; rotation and bias of the sensor stay, with their doubt, so the next load is
known soon. The change is named when the new mass is clearly known:

    grasp     heavier than before, which was the lightest load known, or the tool alone
    release   lighter, back to that
    swap      another object: both are heavier than the tool alone
    shift     the same mass elsewhere
    same      the same load: something touched it
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.loads import com_covariance
from bodyschema.learners.payload.learner import LoadBelief, LoadLearner
from bodyschema.model.inertia import Inertia
from bodyschema.monitoring.cusum import Cusum, Sums
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]

Mode = Literal["identify", "hold", "settle"]
Event = Literal["", "identified", "alarm", "grasp", "release", "swap", "shift", "same"]

WAIT, SETTLE = 8, 4
"""Samples that wait before they are learned, and that are left out after an alarm."""

ARMED, WILD_SHARE = 0.25, 1e-3
"""See `machine` and `cusum`."""

CLEAR = 4.0
"""Standard deviations that make a difference."""

SLIGHT = 0.02
"""Share of the mass that is no difference: what grasping itself does to a sensor's scale."""


@dataclass(frozen=True)
class LoadState:
    """State of the watch."""

    belief: LoadBelief
    mode: Mode = "identify"
    waiting: tuple[WrenchMeans, ...] = ()
    sums: Sums = field(default_factory=Sums)
    left: int = 0
    """Samples still to be left out."""
    before: LoadBelief | None = None
    """The belief before the last alarm, until the change is named."""
    tool: Inertia | None = None
    """The lightest load so far, or the one that was declared."""


@dataclass(frozen=True)
class LoadReport:
    """What one sample led to."""

    mode: Mode
    event: Event = ""
    load: Inertia | None = None
    """At an event, the load that is known now."""


@dataclass(frozen=True)
class LoadWatch:
    """Settings."""

    learner: LoadLearner = field(default_factory=LoadLearner)
    samples: float = 24 * 3600 * 7.5
    """Mean number of samples between false alarms, at least: a day of means."""
    tool: Inertia | None = None
    """What hangs on the sensor when nothing is held, if it is known."""

    def start(self) -> LoadState:
        """Nothing known."""
        return LoadState(self.learner.start(), tool=self.tool)

    def step(self, state: LoadState, mean: WrenchMeans) -> tuple[LoadState, LoadReport]:
        """The state after one sample, and what happened."""
        if state.left:
            state = replace(state, left=state.left - 1)
            return replace(state, mode="settle" if state.left else "identify"), LoadReport("settle")
        if state.belief.solution is None:
            belief = self.learner.step(state.belief, mean)
            return replace(state, belief=belief), LoadReport("identify")
        sums, alarm = self._test(state, mean)
        if alarm:
            return self._alarm(state), LoadReport("settle", "alarm")
        waiting, belief = (*state.waiting, mean), state.belief
        if len(waiting) > (WAIT if state.mode == "hold" else 1):
            belief, waiting = self.learner.step(belief, waiting[0]), waiting[1:]
        return self._look(replace(state, sums=sums, waiting=waiting, belief=belief))

    @cached_property
    def _cusum(self) -> Cusum:
        return Cusum(self.samples)

    def _test(self, state: LoadState, mean: WrenchMeans) -> tuple[Sums, bool]:
        e, S = self.learner.innovation(state.belief, mean)
        if state.belief.solution is None:
            raise ValueError("a belief without a sample cannot be tested.")
        levels = state.belief.solution.levels
        S = S + np.diag(levels.variance * (levels.tau - 1))
        own = S - np.diag(levels.v)
        squared = [
            (float(e[part] @ np.linalg.solve(S[part, part], e[part])), 3)
            for part in (slice(0, 3), slice(3, 6))
        ]
        unit = 1 / np.sqrt(np.diag(S))
        armed = float(np.sum(np.diag(own) * unit**2)) < ARMED * 6
        return self._cusum.step(state.sums, squared, WILD_SHARE, armed)

    def _alarm(self, state: LoadState) -> LoadState:
        """Forget the load; keep the sensor if it was known."""
        known = state.mode == "hold" or state.before is not None
        before = state.before or (state.belief if known else None)
        belief = self.learner.start() if before is None else self.learner.forget_load(before)
        return LoadState(belief, "settle", left=SETTLE, before=before, tool=state.tool)

    def _look(self, state: LoadState) -> tuple[LoadState, LoadReport]:
        """Certified or told apart by now?"""
        load = state.belief.load
        if state.mode == "hold" or load is None or state.belief.solution is None:
            return state, LoadReport(state.mode)
        certified = self.learner.certificate(state.belief).holds
        if not certified:
            return state, LoadReport(state.mode)
        event: Event = "identified"
        if state.before is not None:
            event = change_between(state.before, state.belief, state.tool)
        tool = state.tool
        if self.tool is None and (tool is None or load.mass < tool.mass):
            tool = load
        held = replace(state, mode="hold", before=None, tool=tool, sums=Sums())
        return held, LoadReport("hold", event, load)


def change_between(before: LoadBelief, after: LoadBelief, tool: Inertia | None) -> Event:
    """Name the difference of two loads; see the module's text.

    Args:
        before: the belief before the change.
        after: the belief now.
        tool: what hangs on the sensor when nothing is held; None if nobody knows.
    """
    if before.solution is None or after.solution is None:
        return "identified"
    old, new = before.solution.guess.load(0), after.solution.guess.load(0)
    P_old, P_new = before.solution.phi_covariance(0), after.solution.phi_covariance(0)
    if not _differs(new.mass, old.mass, P_new[0, 0] + P_old[0, 0], 0.1 * SLIGHT):
        C = com_covariance(old, P_old) + com_covariance(new, P_new)
        step = new.com - old.com
        moved = float(step @ np.linalg.solve(C, step)) > CLEAR**2 + 3
        return "shift" if moved and float(np.linalg.norm(step)) > 1e-3 else "same"
    bare = None if tool is None else tool.mass
    if bare is None or not _differs(old.mass, bare, P_old[0, 0], SLIGHT):
        return "grasp" if new.mass > old.mass else "release"
    if not _differs(new.mass, bare, P_new[0, 0], SLIGHT) or new.mass < bare:
        return "release"
    return "swap"


def _differs(mass: float, other: float, variance: float, slight: float) -> bool:
    """Whether two masses differ by more than doubt and scale explain."""
    margin = CLEAR * float(np.sqrt(variance)) + slight * max(mass, other)
    return abs(mass - other) > margin
