"""Families of rivals: the ways in which real robots and real eyes are not what the model says.

    frame moved      a mounting shifts from a row on: a bumped camera, a marker that slips
    joint slipped    an encoder's zero shifts from a row on
    lag              joints and eye are not read at one moment, in either order: q - tau dq/dt
    gear             a joint turns by more or less than it says: E_j q_j
    wave             an eccentric gear: E_j sin k q_j and cos k q_j, k = 1 to 3
    sag              a joint gives way under a weight that pulls somewhere: E_j (J_j^T g)
    hysteresis       a joint lags by its play: E_j sign dq_j/dt
    warming          a joint's zero drifts with time: E_j t
    drift            a mounting drifts with time
    frame misplaced  a mounting that was believed is not where it was said to be
    scale            lengths that were seen are all too long by one share
    field            an eye's error grows with the square of where it looks

E_j and E_f are the effects of a joint and of a frame, see `effects`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bodyschema.trust.effects import Effects
from bodyschema.trust.rival import Rival

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

CUTS = 17
"""Moments at which something may have happened, evenly spaced: a change in between is seen by its
neighbours, less sharply."""

WAVES = (1, 2, 3)
"""Periods in a turn of the joint, or metre of a slide."""


def families(effects: Effects) -> Iterator[list[Rival]]:
    """All candidates, a list each family."""
    joints = [
        j for j in range(effects.by_joint.shape[1]) if np.any(np.abs(effects.by_joint[:, j]) > 0)
    ]
    yield _moved(effects)
    yield _slipped(effects, joints)
    yield _lag(effects)
    yield _gears(effects, joints)
    yield _waves(effects, joints)
    yield _sags(effects, joints)
    yield _hysteresis(effects, joints)
    yield _warming(effects, joints)
    yield _drifts(effects)
    yield _misplaced(effects)
    yield from _seen(effects)


def cuts(n_moments: int) -> Ints:
    """Moments from which something may be different."""
    inner = np.linspace(0, n_moments, CUTS + 2)[1:-1]
    return np.unique(np.clip(np.round(inner), 1, max(n_moments - 1, 1)).astype(np.int64))


def _moved(e: Effects) -> list[Rival]:
    found = []
    for frame in e.frames:
        own = _of_frame(e, frame)
        for row, after in _steps(e):
            Z = e.by_frame[:, e.columns(frame)] * after[:, None]
            says = f"'{frame}' moved at about row {row}"
            found.append(Rival("frame moved", says, "", Z, own, passes=True))
    return found


def _slipped(e: Effects, joints: list[int]) -> list[Rival]:
    found = []
    for j in joints:
        own = tuple(by_joint[:, :, [j]] for by_joint, _ in e.at_targets)
        for row, after in _steps(e):
            Z = e.by_joint[:, [j]] * after[:, None]
            says = f"the zero of '{_name(e, j)}' slipped by {{}} at about row {row}"
            found.append(Rival("joint slipped", says, "rad", Z, own, passes=True))
    return found


def _lag(e: Effects) -> list[Rival]:
    Z = -np.sum(e.by_joint * e.rate[e.scores.sample], axis=1, keepdims=True)
    says = "the joints were read {} after they were seen (before, if negative)"
    return [Rival("lag", says, "s", Z)]


def _gears(e: Effects, joints: list[int]) -> list[Rival]:
    return [
        _follows(e, j, "gear", f"'{_name(e, j)}' turns {{}} more than it says", "1", lambda q: q)
        for j in joints
    ]


def _waves(e: Effects, joints: list[int]) -> list[Rival]:
    found = []
    for j in joints:
        for k in WAVES:
            says = f"'{_name(e, j)}' errs by {{}} in a wave of {k} a turn"

            def wave(q: Array, k: int = k) -> Array:
                return np.stack([np.sin(k * q), np.cos(k * q)], axis=-1)

            found.append(_follows(e, j, "wave", says, "rad", wave))
    return found


def _sags(e: Effects, joints: list[int]) -> list[Rival]:
    if not e.targets:
        return []
    seen = e.burden(e.scores.q)
    there = [e.burden(target.q) for target in e.targets]
    found = []
    for j in joints:
        Z = e.by_joint[:, [j]] * seen[e.scores.sample, j]
        own = tuple(
            by_joint[:, :, [j]] * burden[:, None, j]
            for (by_joint, _), burden in zip(e.at_targets, there, strict=True)
        )
        says = f"'{_name(e, j)}' gives way under its load"
        found.append(Rival("sag", says, "", Z, own))
    return found


def _hysteresis(e: Effects, joints: list[int]) -> list[Rival]:
    way = np.sign(e.rate)[e.scores.sample]
    return [
        Rival(
            "hysteresis",
            f"'{_name(e, j)}' stays {{}} behind whichever way it turns",
            "rad",
            e.by_joint[:, [j]] * way[:, [j]],
        )
        for j in joints
    ]


def _warming(e: Effects, joints: list[int]) -> list[Rival]:
    clock = _progress(e)
    return [
        Rival(
            "warming",
            f"the zero of '{_name(e, j)}' drifts by {{}} through the recording",
            "rad",
            e.by_joint[:, [j]] * clock[:, None],
            tuple(by_joint[:, :, [j]] for by_joint, _ in e.at_targets),
            passes=True,
        )
        for j in joints
    ]


def _drifts(e: Effects) -> list[Rival]:
    clock = _progress(e)
    return [
        Rival(
            "drift",
            f"'{frame}' drifts through the recording",
            "",
            e.by_frame[:, e.columns(frame)] * clock[:, None],
            _of_frame(e, frame),
            passes=True,
        )
        for frame in e.frames
    ]


def _misplaced(e: Effects) -> list[Rival]:
    """Frames that the fit has taken at their word."""
    freed = set(e.scores.estimate.variables.groups)
    return [
        Rival(
            "frame misplaced",
            f"'{frame}' is not where it was said to be",
            "",
            e.by_frame[:, e.columns(frame)],
            _of_frame(e, frame),
        )
        for frame in e.frames
        if f"frame:{frame}" not in freed
    ]


def _seen(e: Effects) -> Iterator[list[Rival]]:
    """Scale and field of what positions were seen."""
    body = e.scores.estimate.body
    for i, sense in enumerate(e.scores.senses):
        part = next((p for n, u, p in sense.components if u == "m" and p.stop - p.start == 3), None)
        if part is None:
            continue
        # Not what was observed: its noise would agree with itself.
        place = sense.predict(body)
        p = place[:, :3, 3] if place.ndim == 3 else place[:, :3]
        size = max(float(np.ptp(p, axis=0).max(initial=0.0)), 1e-12)
        u = (p - p.mean(axis=0)) / size
        ones = np.eye(3)
        squares = np.stack([u[:, a] * u[:, b] for a in range(3) for b in range(a, 3)], axis=1)
        scale = [Rival("scale", f"lengths of {sense.label} are {{}} too long", "1",
                       e.of_sense(i, part, p[:, :, None]))]  # fmt: skip
        curved = np.einsum("nm,dk->ndmk", squares, ones).reshape(len(sense), 3, -1)
        says = f"{sense.label} errs with where it is seen, as a lens or a tracker does"
        yield scale
        yield [Rival("field", says, "", e.of_sense(i, part, curved))]


def _follows(e: Effects, j: int, family: str, says: str, unit: str, law: object) -> Rival:
    """A joint's effect times a law of its reading, (n,) -> (n,) or (n, k)."""
    assert callable(law)

    def columns(q: Array) -> Array:
        return np.asarray(law(q)).reshape(len(q), -1)

    Z = e.by_joint[:, [j]] * columns(e.scores.q[:, j])[e.scores.sample]
    own = tuple(
        by_joint[:, :, [j]] * columns(target.q[:, j])[:, None]
        for (by_joint, _), target in zip(e.at_targets, e.targets, strict=True)
    )
    return Rival(family, says, unit, Z, own)


def _of_frame(e: Effects, frame: str) -> tuple[Array, ...]:
    return tuple(by_frame[:, :, e.columns(frame)] for _, by_frame in e.at_targets)


def _steps(e: Effects) -> Iterator[tuple[int, Array]]:
    """Row of each cut, and which rows of the fit lie behind it, (N,)."""
    rows = np.concatenate([sense.rows for sense in e.scores.senses])
    for cut in cuts(e.scores.n_moments):
        behind = e.scores.moment >= cut
        yield int(rows[behind].min(initial=np.iinfo(np.int64).max)), behind[e.scores.sample] * 1.0


def _progress(e: Effects) -> Array:
    """(N,) -0.5 at the first moment to 0.5 at the last."""
    return np.asarray(e.scores.moment[e.scores.sample] / max(e.scores.n_moments - 1, 1) - 0.5)


def _name(e: Effects, j: int) -> str:
    return e.scores.estimate.reference.joints[j]
