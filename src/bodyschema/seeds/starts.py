"""First values for unknown frames, from the samples alone, so that nobody has to guess one.

A sample says  T = X^-1 K(q) Y  where X places `seen_from` on its parent, Y places `seen` on its
parent and K is the robot's kinematics between those parents. Either or both of X, Y may be unknown:

    poses   both: K Y = X T, A X = X B on relative motions, or the best of many random fours of
            samples (`pair_starts`), whichever fits the better 40 % of the samples best; one: a mean
    points  both: alternate point-set alignment (X) and mean (y) from several y; one: closed form

Each closed form is repeated with Cauchy weights on its own residuals, which holds off outliers; the
fours hold where more than half of the samples are good.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds import closed_forms as hand_eye
from bodyschema.seeds.pair_starts import QUANTILE, pair_starts
from bodyschema.seeds.pixel_poses import seen_poses
from bodyschema.seeds.pixel_rays import place_by_rays
from bodyschema.seeds.point_sums import PointSums
from bodyschema.seeds.spread import spread
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Frames = tuple[Array, Array]
"""X and Y."""

ROUNDS = 12
SAME = 1e-6
"""m (and rad / m for poses): what moves less has arrived, far below what any sensor tells."""

DRAWS = 80
"""Fours of samples: when half of the samples are bad, five of 80 are good."""

ENOUGH = 4
"""Samples: three points in one plane leave a frame's mirror image, and noise none to spare."""

PICTURES = 300
"""Of a target; each costs a small fit of its own."""

POSITION = "link_x"
"""Component that is shown of a frame whose place is."""

GUESSES = 0.15 * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
"""m; places of an unknown point on its link from which the alternation begins."""


def start_frames(body: Body, unknown: Collection[str], senses: Sequence[Sense]) -> Body:
    """Place the unknown frames, and begin the unknown parts, where the samples say, roughly.

    Senses with fewer unknown ends come first, of those the ones that show more of them: what they
    settle is known to the others. A handful of samples settles what no other sense does. A sense
    that can say where its ends are (`Sense.start`, or the closed forms here) settles them.

    Args:
        body: nominal body with all frames attached.
        unknown: fixed frames to be placed, each an end of some sense; parts to begin.
        senses: what was seen.

    Raises:
        InputError: an unknown frame is at no end of any sense, or only at ends of senses that
            cannot start it.
    """
    frames = {name for name in unknown if name in body.frames}
    parts = set(unknown) - frames
    waiting = [sense for sense in senses if len(sense)]
    while waiting:
        waiting.sort(key=lambda sense: _order(sense, frames))
        settled = ((sense, _started(body, sense, frames | parts)) for sense in waiting)
        sense, found = next(((s, b) for s, b in settled if b is not None), (None, None))
        if sense is None or found is None:
            break
        body, waiting = found, [other for other in waiting if other is not sense]
        frames -= _placed(sense, waiting)
    if frames:
        name = min(frames)
        near = [sense.label for sense in senses if len(sense) and name in _ends(sense)]
        raise InputError(
            f"frame {name} is unknown, and nothing in what was seen ({', '.join(near)}) can place "
            'it from nothing; state roughly where it is, known = "roughly".'
            if near
            else f"frame {name} is unknown, but no sense begins or ends in it."
        )
    return body


def _ends(sense: Sense) -> tuple[str, ...]:
    return tuple(frame for pair in sense.pairs for frame in pair)


def _shown(sense: Sense) -> list[tuple[str, tuple[str, ...]]]:
    """Each end of a sense, and the components of its placement that the sense shows."""
    return list(zip(_ends(sense), sense.shows * len(sense.pairs), strict=True))


def _placed(sense: Sense, waiting: Sequence[Sense]) -> set[str]:
    """Ends that a sense settles: not the turn alone of one whose position another sense shows."""
    elsewhere = {end for other in waiting for end, shown in _shown(other) if POSITION in shown}
    return {end for end, shown in _shown(sense) if POSITION in shown or end not in elsewhere}


def _order(sense: Sense, unknown: Collection[str]) -> tuple[bool, int, int]:
    """Whether samples are too few for a frame, those last; number of unknown ends, fewer first;
    components that are shown of them, more first."""
    shown = [len(components) for frame, components in _shown(sense) if frame in unknown]
    return len(sense) < ENOUGH, len(shown), -sum(shown)


def _started(body: Body, sense: Sense, unknown: Collection[str]) -> Body | None:
    """The body with a sense's unknown ends and parts begun; None if it has or can say none."""
    found = sense.start(body, unknown)
    if found is not None:
        return found
    ends = (sense.seen_from in unknown, sense.seen in unknown)
    sense = spread(sense, PICTURES) if isinstance(sense, Pixels) else spread(sense)
    poses = seen_poses(body, sense) if isinstance(sense, Pixels) and any(ends) else sense
    if isinstance(sense, Pixels) and poses is None:
        return place_by_rays(body, sense, unknown)
    if any(ends) and isinstance(poses, Points | Poses):
        return _place(body, poses, *ends)
    return None


def _place(body: Body, sense: Points | Poses, find_x: bool, find_y: bool) -> Body:
    a, b = body.frame_index(sense.seen_from), body.frame_index(sense.seen)
    # An end whose placement is known stays inside K; identity then stands for it.
    left = body.frames[body.parent[a]] if find_x else sense.seen_from
    right = body.frames[body.parent[b]] if find_y else sense.seen
    K = relative_pose(body, sense.q, left, right)
    if isinstance(sense, Poses):
        X, Y = _from_poses(K, sense.pose, find_x, find_y)
    else:
        X, Y = _from_points(K, sense.position, find_x, find_y)
    if find_x:
        body = body.with_placement(sense.seen_from, X)
    if find_y:
        body = body.with_placement(sense.seen, Y)
    return body


def _robustly(
    solve: Callable[[Array], Frames],
    error: Callable[[Frames], Array],
    n: int,
    first: Frames | None = None,
) -> Frames:
    """Repeat a weighted closed form; weights 1 / (1 + (e / s)^2), s the median error.

    The first weights are equal, or those of the frames `first`; ends when no error moves.
    """
    weights = np.ones(n)
    if first is not None:
        errors = error(first)
        weights = 1 / (1 + (errors / max(float(np.quantile(errors, QUANTILE)), 1e-12)) ** 2)
    best, lowest, before = solve(weights), np.inf, np.full(n, np.inf)
    for _ in range(ROUNDS):
        found = solve(weights)
        errors = error(found)
        middle = float(np.median(errors))
        if middle < lowest:
            best, lowest = found, middle
        if np.abs(errors - before).max() < SAME:
            break
        before = errors
        weights = 1 / (1 + (errors / max(middle, 1e-12)) ** 2)
    return best


def _from_poses(K: Array, T: Array, find_x: bool, find_y: bool) -> Frames:
    identity = np.eye(4)

    def error(frames: Frames) -> Array:
        X, Y = frames
        return np.asarray(np.linalg.norm((K @ Y - X @ T)[:, :3], axis=(1, 2)))

    def only_x(w: Array) -> Frames:
        return hand_eye.mean_transform(K @ lie.inverse(T), w), identity

    def only_y(w: Array) -> Frames:
        return identity, hand_eye.mean_transform(lie.inverse(K) @ T, w)

    def both(w: Array) -> Frames:
        return hand_eye.solve_ky_xt(K, T, w)

    if not find_y:
        return _robustly(only_x, error, len(K))
    if not find_x:
        return _robustly(only_y, error, len(K))
    found = [_robustly(both, error, len(K)), _from_motions(K, T)]
    for Y, X in pair_starts(K, T, draws=DRAWS)[:1]:
        found += [(X, Y), _robustly(both, error, len(K), (X, Y))]
    return min(found, key=lambda frames: float(np.quantile(error(frames), QUANTILE)))


def _from_motions(K: Array, T: Array) -> Frames:
    """A Y = Y B with the motions between each sample and the one half a recording later."""
    partner = np.roll(np.arange(len(K)), len(K) // 2)
    A, B = lie.inverse(K) @ K[partner], lie.inverse(T) @ T[partner]

    def solve(w: Array) -> Frames:
        return np.eye(4), hand_eye.solve_ax_xb(A, B, w)

    def error(frames: Frames) -> Array:
        Y = frames[1]
        return np.asarray(np.linalg.norm((A @ Y - Y @ B)[:, :3], axis=(1, 2)))

    _, Y = _robustly(solve, error, len(A))
    X = hand_eye.mean_transform(K @ Y @ lie.inverse(T), np.ones(len(K)))
    return X, Y


def _from_points(K: Array, p: Array, find_x: bool, find_y: bool) -> Frames:
    identity = np.eye(4)

    def error(frames: Frames) -> Array:
        X, Y = frames
        gap = K[:, :3, :3] @ Y[:3, 3] + K[:, :3, 3] - p @ X[:3, :3].T - X[:3, 3]
        return np.asarray(np.linalg.norm(gap, axis=1))

    def only_x(w: Array) -> Frames:
        return lie.transform(*PointSums.of(K, p, w).frame(np.zeros(3))), identity

    def only_y(w: Array) -> Frames:
        return identity, lie.transform(
            np.eye(3), PointSums.of(K, p, w).point(np.eye(3), np.zeros(3))
        )

    if not find_y:
        return _robustly(only_x, error, len(K))
    if not find_x:
        return _robustly(only_y, error, len(K))

    def alternate(y: Array) -> Frames:
        def solve(w: Array) -> Frames:
            nonlocal y
            X, y = _settled(PointSums.of(K, p, w), y)
            return X, lie.transform(np.eye(3), y)

        return _robustly(solve, error, len(K))

    even = PointSums.of(K, p, np.ones(len(K)))
    places: list[Array] = []
    for guess in GUESSES:
        _, y = _settled(even, guess)
        if all(np.linalg.norm(y - other) > SAME for other in places):
            places.append(y)
    found = [alternate(y) for y in places]
    return min(found, key=lambda frames: float(np.median(error(frames))))


def _settled(sums: PointSums, y: Array) -> tuple[Array, Array]:
    """X and y by turns, from a guess of y."""
    for _ in range(ROUNDS):
        before, X = y, sums.frame(y)
        y = sums.point(*X)
        if np.linalg.norm(y - before) < SAME:
            break
    return lie.transform(*X), y
