"""Explanations: what else may have shaped what was seen, when the variables seem to explain it.

A model with many free numbers takes for its own what they can imitate: links bend to a lens that
nobody calibrated, joint zeros to a tracker that drifts. A rival (`rival`) then finds nothing left.
Here the same is told from the start, with as little of it as each row needs, and beside it the
numbers of the robot may be as small as they are in most robots (`hierarchy`):

    eye       errs with the products of where it looks
    lens      errs along the ray with the cube of its distance from the middle of the view
    drift     mountings wander: cosines of the recording, the k-th 1 / k as large
    warming   joint zeros wander likewise
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.trust.effects import Effects

Array = NDArray[np.float64]

WANDERING = 4
"""Cosines of a mounting's path, the last two turns long."""

CREEPING = 2
"""Of a joint zero, which follows the heat of its motor."""

MOST = 72
"""Columns of a wandering: more would take longer than the fit."""

WHEN = np.array([0.0, 0.5, 1.0])
"""Shares of the recording at which a robot that has changed counts: whichever suits it best."""


@dataclass(frozen=True)
class Explanation:
    """Something that is not in the model."""

    family: str
    says: str
    """In words, as they follow "that"."""
    Z: Array
    """(N, k) its effect on the whitened residuals, a row of Z gamma of about unit size."""
    ways: tuple[tuple[Array, ...], ...] = ()
    """(n, 3, k) its effect on each target, at each of WHEN; empty for what an eye does alone."""


def explanations(effects: Effects) -> Iterator[Explanation]:
    """All of them that show at all."""
    for one in (*_seen(effects), *_wandering(effects)):
        size = float(np.sqrt(np.mean(np.sum(one.Z**2, axis=1)))) if one.Z.size else 0.0
        if np.isfinite(size) and size > 0:
            ways = tuple(tuple(way / size for way in target) for target in one.ways)
            yield replace(one, Z=one.Z / size, ways=ways)


def _seen(e: Effects) -> Iterator[Explanation]:
    """What each eye may do, in metres or pixels."""
    body = e.scores.estimate.body
    for i, sense in enumerate(e.scores.senses):
        kinds = {"m": 3, "px": 2}
        part = next((p for _, u, p in sense.components if kinds.get(u) == p.stop - p.start), None)
        if part is None:
            continue
        # Not what was observed: its noise would agree with itself.
        place = sense.predict(body)
        d = part.stop - part.start
        p = place[:, :3, 3] if place.ndim == 3 else place[:, :d]
        u = p - p.mean(axis=0)
        u = u / max(float(np.ptp(u, axis=0).max(initial=0.0)), 1e-12)
        products = np.stack([u[:, a] * u[:, b] for a in range(d) for b in range(a, d)], axis=1)
        curved = np.einsum("nm,dk->ndmk", products, np.eye(d)).reshape(len(sense), d, -1)
        radial = (u * np.sum(u**2, axis=1, keepdims=True))[:, :, None]
        says = f"{sense.label} errs with where it is seen, as a lens or a tracker does"
        yield Explanation("eye", says, e.of_sense(i, part, curved))
        yield Explanation("lens", says, e.of_sense(i, part, radial))


def _wandering(e: Effects) -> Iterator[Explanation]:
    """What may have moved while it was looked at."""
    free = np.concatenate([e.columns(f) for f in e.frames]) if e.frames else np.zeros(0, np.int64)
    places = tuple(by_frame[:, :, free] for _, by_frame in e.at_targets)
    says = "what stands still or is held fast wanders through the recording"
    yield _wanders(e, "drift", says, e.by_frame[:, free], places, WANDERING)
    turns = tuple(by_joint for by_joint, _ in e.at_targets)
    says = "the zeros of the joints wander through the recording"
    yield _wanders(e, "warming", says, e.by_joint, turns, CREEPING)


def _wanders(
    e: Effects, family: str, says: str, rows: Array, there: tuple[Array, ...], most: int
) -> Explanation:
    k = np.arange(1, max(1, min(most, MOST // max(rows.shape[1], 1))) + 1)

    def grown(effect: Array, when: Array) -> Array:
        waves = np.cos(np.pi * k * when[..., None]) / k
        return (effect[..., None] * waves[..., None, :]).reshape(*effect.shape[:-1], -1)

    when = e.scores.moment[e.scores.sample] / max(e.scores.n_moments - 1, 1)
    ways = tuple(tuple(grown(effect, np.asarray(w)) for w in WHEN) for effect in there)
    return Explanation(family, says, grown(rows, when), ways)
