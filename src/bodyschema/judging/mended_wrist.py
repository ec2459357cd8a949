"""A wrist's recording mended where a cause other than the load explains what the load leaves over.

    tilt, lag      of the whole recording: gravity and the clock of its samples are put right
    drift, jump    of the sensor's offset: taken off the means that a fit is made of

Each is believed if it explains most, is no chance, and foretells stretches of time that it was not
fitted to (`trust.wrench_doubt`). It stays as free beside the load as it was found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.clock_lag import shifted
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.senses.even_samples import evenly
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.trust.wrench_doubt import repair
from bodyschema.trust.wrench_gravity import lean
from bodyschema.trust.wrench_rivals import WeighedRival, upright

Array = NDArray[np.float64]
Mended = tuple[WristSamples, tuple[WeighedRival, ...]]

ROUNDS = 4
"""Repairs that are made at most: tilt and lag are found in steps, each linear."""

LONGEST = 0.25
"""s of lag that one step may say."""


def mended_samples(
    samples: WristSamples,
    cut: Callable[[WristSamples], Sequence[Part]],
    learner: LoadLearner,
    wanted: Sequence[str],
    empty: WristSamples | None = None,
) -> Mended:
    """The samples with gravity and clock as the wrench has them, and what was put right.

    Args:
        samples: of a recording.
        cut: the parts of samples, all with the loads that they are believed to carry.
        learner: with the priors of the sensor.
        wanted: "tilt", and "lag" where rows follow a motion.
        empty: another recording, which the first part is cut from.
    """
    found = list[WeighedRival]()
    for _ in range(ROUNDS):
        fit = fit_payload(cut(samples), learner)
        made = repair(fit, learner, world_rotation(samples, fit.parts, empty), wanted)
        if made is None:
            break
        one = made[0]
        found.append(one)
        if one.family == "tilt":
            samples = _plumb(_tilted(samples, one.gamma), cut, learner, empty)
        else:
            lag = float(np.clip(-one.gamma[0], -LONGEST, LONGEST))
            samples = shifted(evenly(samples), lag)
    return samples, tuple(found)


def mended_fit(
    fit: PayloadFit,
    samples: WristSamples,
    learner: LoadLearner,
    empty: WristSamples | None = None,
) -> tuple[PayloadFit, tuple[WeighedRival, ...]]:
    """The fit without what the sensor's offset did, and what that was."""
    found = list[WeighedRival]()
    for _ in range(ROUNDS):
        R_world = world_rotation(samples, fit.parts, empty)
        made = repair(fit, learner, R_world, ("drift", "jump"))
        if made is None:
            break
        found.append(made[0])
        parts, a = [], 0
        for part in fit.parts:
            off = made[1][a : a + len(part.means)]
            own = np.hstack([off[:, :3] @ fit.R, off[:, 3:] @ fit.R])
            parts.append(replace(part, means=replace(part.means, y=part.means.y - own)))
            a += len(part.means)
        fit = fit_payload(parts, learner)
    return fit, tuple(found)


def world_rotation(
    samples: WristSamples, parts: Sequence[Part], empty: WristSamples | None = None
) -> Array | None:
    """(n, 3, 3) of all means, to axes whose z points up; None where gravity was measured.

    Args:
        samples: of the recording.
        parts: of it.
        empty: another recording, which the first part is cut from.
    """
    found = []
    for k, part in enumerate(parts):
        own = empty if empty is not None and k == 0 else samples
        if own.rotation is None or own.gravity is not None:
            return None
        rows = np.clip(np.searchsorted(own.time, part.means.time), 0, len(own) - 1)
        found.append(upright(np.asarray(samples.down)) @ own.rotation[rows])
    return np.concatenate(found)


def _plumb(
    samples: WristSamples,
    cut: Callable[[WristSamples], Sequence[Part]],
    learner: LoadLearner,
    empty: WristSamples | None,
) -> WristSamples:
    """Gravity where the means under it have it: a large lean was found by turning means alone."""
    fit = fit_payload(cut(samples), learner)
    R_world = world_rotation(samples, fit.parts, empty)
    rest = None if R_world is None else lean(fit, learner, R_world)
    return samples if rest is None else _tilted(samples, rest.gamma)


def _tilted(samples: WristSamples, angles: Array) -> WristSamples:
    """Gravity turned towards x and y of the upright world, as strong as before."""
    down = np.asarray(samples.down)
    strength = float(np.linalg.norm(down))
    turned = down + 9.81 * angles @ upright(down)[:2]
    x, y, z = strength * turned / np.linalg.norm(turned)
    return replace(samples, down=(float(x), float(y), float(z)))
