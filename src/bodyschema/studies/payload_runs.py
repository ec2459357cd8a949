"""One motion of a held object through both methods: when it is known, and how well at the end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.published.paper_payload import (
    READINGS,
    paper_courses,
    paper_rows,
    standing,
)
from bodyschema.model.inertia import Inertia, is_physical
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.studies.study import Result

Array = NDArray[np.float64]

COVERED = 1.96
"""Standard deviations that hold the truth in 95 of 100 cases."""

CURVE = 60
"""Points of a curve that are kept for the picture."""


def paper_run(samples: WristSamples, box: Inertia, noise: Array) -> Result:
    """The published relation after each fifth sample; its other readings beside the printed one.

    Args:
        samples: of the motion.
        box: the truth.
        noise: (6,) N and Nm of the sensor, for the reading that weighs rows by it.
    """
    if samples.rotation is None:
        raise ValueError("the paper's form needs the sensor's orientation.")
    wrench, down = samples.wrench, np.asarray(samples.down)
    A = paper_rows(samples.rotation, wrench[:, :3], wrench[:, 3:], down)
    still = standing(samples.rotation, samples.time)
    found: Result = {}
    for reading in READINGS:
        x = paper_courses(A, noise, still, reading)[5::5]
        mass = 1 / np.where(np.abs(x[:, 0]) > 1e-9, x[:, 0], 1e-9)
        told = _errors(samples.time[5::5], mass, x[:, 1:4], box)
        found[reading] = told | {"physical": bool(mass[-1] > 0)}
    others = {
        reading: {key: found[reading][key] for key in ("seconds", "mass_pct", "com_mm")}
        for reading in READINGS
    }
    printed: Result = found["printed"]
    return printed | {"inertia_pct": None, "inside": None, "readings": others}


def learner_run(samples: WristSamples, box: Inertia) -> Result:
    """The learner after each mean, told at the end of the mean's window."""
    averaging, learner = Averaging(), LoadLearner()
    means, belief = averaging.means(samples), learner.start()
    mass, com, certified, physical = [], [], None, True
    time = means.time + averaging.window / 2
    for k in range(len(means)):
        belief, _ = learner.step(belief, (means.take(slice(k, k + 1)),))
        load = belief.load
        if load is None or belief.solution is None:
            continue
        mass.append(load.mass)
        com.append(load.com)
        physical &= is_physical(belief.solution.guess.phi[0])
        if certified is None and learner.certificate(belief).holds:
            certified = float(time[k])
    if belief.solution is None or belief.load is None:
        raise ValueError("a motion without a single mean; make it longer.")
    error = belief.load.phi - box.phi
    std = np.sqrt(np.diag(belief.solution.phi_covariance(0)))
    off = np.linalg.norm(belief.load.moments - box.moments) / np.linalg.norm(box.moments)
    return _errors(time, np.array(mass), np.array(com), box) | {
        "inertia_pct": float(100 * off),
        "inside": [bool(hit) for hit in np.abs(error) < COVERED * std],
        "physical": bool(physical),
        "certified": certified,
    }


def _errors(time: Array, mass: Array, com: Array, box: Inertia) -> Result:
    """Time of the last miss, errors at the end, and their curves."""
    mass_pct = 100 * np.abs(mass / box.mass - 1)
    com_mm = 1e3 * np.linalg.norm(com - box.com, axis=1)
    missed = np.flatnonzero((mass_pct > 1) | (com_mm > 1))
    first = 0 if len(missed) == 0 else int(missed[-1]) + 1
    kept = np.unique(np.geomspace(1, len(time), CURVE).astype(int)) - 1
    return {
        "seconds": float(time[first]) if first < len(time) else None,
        "mass_pct": float(mass_pct[-1]),
        "com_mm": float(com_mm[-1]),
        "certified": None,
        "time": time[kept].tolist(),
        "curve": {
            "mass_pct": np.maximum(mass_pct, 1e-4)[kept].tolist(),
            "com_mm": np.maximum(com_mm, 1e-4)[kept].tolist(),
        },
    }
