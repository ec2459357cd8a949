"""A load that is learned until it is certified, and not longer: then touching begins by itself.

The paper's robot "automatically determined that the identification finished" and "just after
determination, it performed touching motion". Each method decides by its own rule from one motion:
the published one by its eigenvalues, ours by its certificate, and by having seen enough samples to
know the noise in which a touch has to be noticed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.published.linear_relation import Moments
from bodyschema.learners.published.paper_payload import (
    UNKNOWNS,
    PaperPayload,
    load_of,
    paper_rows,
)
from bodyschema.learners.touch.known_load import KnownLoad
from bodyschema.learners.touch.search import TouchSearch
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.loads import RATE
from bodyschema.studies.touch_runs import Wrist

Array = NDArray[np.float64]

MEASURED = 4.0
"""s of free motion that tell the noise of a wrench: 30 means of a quarter of a second, and some."""

EVERY = 20
"""Samples between two looks at the eigenvalues."""


@dataclass(frozen=True)
class PublishedLoad:
    """By Eq. 37, as long as lambda_5 and lambda_4 asked for."""

    mass: float
    """kg."""
    com: Array
    """(3,) m."""
    satisfied: float | None
    """s; None if the motion ended before."""
    course: list[list[float]]
    """s and lambda_2 .. lambda_5 at each look, to the end of the motion."""


@dataclass(frozen=True)
class SureLoad:
    """By ours, until its certificate."""

    search: TouchSearch
    """Taught by the motion until then."""
    certified: float | None
    """s; None if the motion ended before."""


def published_load(samples: WristSamples) -> PublishedLoad:
    """The load when the published rule is met; that of the whole motion when it is not."""
    if samples.rotation is None:
        raise ValueError("the paper's form needs the sensor's orientation.")
    learner, moments, y = PaperPayload(), Moments.empty(UNKNOWNS), samples.wrench
    rows = paper_rows(samples.rotation, y[:, :3], y[:, 3:], np.asarray(samples.down))
    course, x, satisfied = [], None, None
    for t, A in zip(samples.time, rows, strict=True):
        moments = moments.add(A)
        if moments.count % EVERY:
            continue
        found = learner.solve(moments)
        course.append([float(t), *(float(value) for value in found.squares[3::-1])])
        if satisfied is None and learner.satisfied(found):
            x, satisfied = found.x, float(t)
    mass, com = load_of(learner.solve(moments).x if x is None else x)
    return PublishedLoad(mass, com, satisfied, course)


def sure_load(samples: WristSamples, wrist: Wrist) -> SureLoad:
    """The load when its certificate holds, and what is not explained then; else at the end.

    Args:
        samples: free motion.
        wrist: whose; its thing is the surface that may be touched.
    """
    means, learner = Averaging().means(samples), LoadLearner()
    belief, certified = learner.start(), None
    for k in range(len(means)):
        belief, _ = learner.step(belief, (means.take([k]),))
        told = float(means.time[k]) + Averaging().window / 2
        if told >= MEASURED and learner.certificate(belief).holds:
            certified = told
            break
    if belief.solution is None:
        raise ValueError("a motion without a single mean; make it longer.")
    seen = samples if certified is None else samples.take(slice(0, round(certified * RATE)))
    load = KnownLoad.of(belief.solution)
    return SureLoad(TouchSearch.taught(seen, load, wrist.held.solid, 0.0), certified)
