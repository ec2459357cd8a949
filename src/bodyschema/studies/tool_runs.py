"""One run with a held tool: what a learner or the monitor made of it, in numbers that JSON takes.

An error is the root mean square over fresh postures against the true body, in m. "Steps to stay
below" counts the samples after which the error never again reaches a limit; None if it never stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.learner import BodyLearner, run
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.smoother import Smoother
from bodyschema.learners.watched_smoother import WatchedSmoother
from bodyschema.monitoring.monitor import Monitor
from bodyschema.studies.held_tool import BLOCKS, ELBOW, TIP, Change, Scene, arm, freed
from bodyschema.studies.study import Result

Array = NDArray[np.float64]

LEARNERS: dict[str, tuple[BodyLearner[Any, Any], bool]] = {
    "online_gradient_last_limb": (OnlineGradient(0.001, length=1.0), False),
    "online_gradient_whole_arm": (OnlineGradient(0.005, length=1.0), True),
    "smoother_last_limb": (Smoother(), False),
    "smoother_whole_arm": (Smoother(), True),
}
"""Name -> learner, and whether the whole arm adapts. The paper does not give its step sizes; these
are chosen so that the gradient takes about as many steps as in the paper, lengths in metres."""

LIMITS = {"5cm": 0.05, "2cm": 0.02, "1cm": 0.01}
"""m"""

LOOKS = (10, 100, 1000)
"""Samples after which the error of the tip is kept, beside the last one."""

AFTER = (10, 30, 100)
"""Samples after a change at which the error of the tip is kept."""

OFTEN = 1e5
"""Mean number of samples between false alarms, at least: three hours."""

DRAWN = 400
"""Points of a curve."""


def learning(name: str, scene: Scene, curve: bool) -> Result:
    """A learner meets the tool.

    Args:
        name: in LEARNERS.
        scene: without a change.
        curve: keep the distances between the seen and the predicted tip, for the picture.
    """
    learner, whole = LEARNERS[name]
    tip, elbow = scene.places(0, TIP), scene.places(0, ELBOW)
    state = learner.start(arm(), freed(whole))
    errors, distances = [], []
    for after, (info,) in run(learner, state, [scene.seen]):
        state = after
        errors.append(scene.miss(state.body, tip, TIP))
        distances.append(float(np.linalg.norm(info.residual)))
    n = len(errors)
    looks = sorted({k for k in LOOKS if k < n} | {n})
    found: Result = {
        "steps": {limit: steps_below(errors, value) for limit, value in LIMITS.items()},
        "tip": {str(k): errors[k - 1] for k in looks},
        "bound": {str(k): scene.bound(whole, k) for k in looks},
        "elbow": scene.miss(state.body, elbow, ELBOW),
        "elbow_before": scene.miss(arm(), elbow, ELBOW),
    }
    if curve:
        rows = range(0, n, max(1, n // DRAWN))
        found["curve"] = [[k + 1, round(distances[k], 4), round(errors[k], 4)] for k in rows]
    return found


def changing(change: Change, scene: Scene) -> Result:
    """The monitor meets a change in mid-run; samples count from the change, the first being 1."""
    monitor = Monitor(WatchedSmoother(arm(), freed(True), BLOCKS), OFTEN)
    state, at = monitor.start(), change.at
    tip, elbow = scene.places(at, TIP), [scene.places(t, ELBOW) for t in (at - 1, at)]
    found: Result = {"noticed": None, "blamed": None, "decided": None, "false_alarms": 0}
    errors = []
    for k, (after, info) in enumerate(run(monitor, state, [scene.seen]), 1 - at):
        state, body = after, after.belief.body
        if k == 0:
            found["tip_before"] = scene.miss(body, scene.places(at - 1, TIP), TIP)
            found["elbow_before"] = scene.miss(body, elbow[0], ELBOW)
        if k < 1:
            found["false_alarms"] += info.event == "alarm"
            continue
        errors.append(scene.miss(body, tip, TIP))
        if info.event == "alarm" and found["noticed"] is None:
            found["noticed"] = k
        if info.event == "changed" and found["blamed"] is None:
            found["blamed"], found["decided"] = info.block, k
    found["steps"] = {limit: steps_below(errors, value) for limit, value in LIMITS.items()}
    found["tip"] = {str(k): errors[k - 1] for k in AFTER}
    found["elbow_after"] = scene.miss(body, elbow[1], ELBOW)
    return found


def steps_below(errors: Sequence[float], limit: float) -> int | None:
    """Samples after which the error stays below a limit to the end."""
    above = np.flatnonzero(np.asarray(errors) >= limit)
    steps = int(above[-1]) + 2 if len(above) else 1
    return steps if steps <= len(errors) else None
