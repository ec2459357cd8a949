"""Hand-eye: poses of a hand and of what an eye sees, through `bodyschema.learn_hand_eye`.

What counts is the place of the eye, in the hand or in the base. One recording gives one error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.prediction import length_quantile
from honest import sights
from honest.pose_pairs import Draw, Pair, pair
from honest.trial import Row, Trial

Array = NDArray[np.float64]


def _eye(change: Callable[[Array], Array]) -> Callable[[Pair, np.random.Generator], Pair]:
    return lambda one, rng: replace(one, B=change(one.B))


def _either(change: Callable[[Array], Array]) -> Callable[[Pair, np.random.Generator], Pair]:
    def changed(one: Pair, rng: np.random.Generator) -> Pair:
        if rng.random() < 0.5:
            return replace(one, A=change(one.A))
        return replace(one, B=change(one.B))

    return changed


def _transposed(T: Array) -> Array:
    """Rotations read column by column."""
    seen = T.copy()
    seen[:, :3, :3] = np.swapaxes(T[:, :3, :3], 1, 2)
    return seen


def _outliers(one: Pair, rng: np.random.Generator) -> Pair:
    bad = np.flatnonzero(rng.random(len(one.B)) < rng.uniform(0.05, 0.3))
    B = one.B.copy()
    B[bad, :3, 3] += 0.05 * rng.normal(size=(len(bad), 3))
    B[bad, :3, :3] = B[bad, :3, :3] @ lie.exp_so3(0.3 * rng.normal(size=(len(bad), 3)))
    return replace(one, B=B)


def _shrunk(one: Pair, rng: np.random.Generator) -> Pair:
    """A target that was printed in another size."""
    factor = float(rng.choice([0.9, 0.97, 1.03, 1.1]))
    return replace(one, B=sights.scaled(factor)(one.B))


def _other_mount(one: Pair, rng: np.random.Generator) -> Pair:
    return replace(one, said="base" if one.eye_on == "hand" else "hand")


def _lens(one: Pair, rng: np.random.Generator) -> Pair:
    """A camera whose lens is bent otherwise than it says: a few mm at the edge."""
    B = one.B.copy()
    off = B[:, :3, 3] - B[:, :3, 3].mean(axis=0)
    bent = off * (off**2).sum(axis=1, keepdims=True)
    B[:, :3, 3] += bent * rng.uniform(1e-3, 5e-3) / np.linalg.norm(bent, axis=1).max()
    return replace(one, B=B)


def trial(
    draw: Draw, change: Callable[[Pair, np.random.Generator], Pair], rng: np.random.Generator
) -> Trial:
    """What the public function is given, and what is true of it."""
    one = change(pair(draw, rng), rng)
    about = f"eye on the {one.eye_on}, {len(one.B)} pairs"
    more: dict[str, Any] = {} if one.times is None else {"times": one.times}
    return Trial(
        about,
        lambda: bs.learn_hand_eye(one.A, one.B, one.said, **more),
        lambda answer: stated_and_true(answer, one),
        single=True,
    )


def stated_and_true(answer: bs.Answer, one: Pair) -> tuple[float, float]:
    """Of the eye's place, m; by its standard deviations where no error is stated."""
    X, Y = answer.details["frames"]
    frame = X if one.said == "hand" else Y
    stated = answer.predicted_95
    if stated is None:
        std = 1e-3 * np.array(frame["std_mm"])
        stated = length_quantile([np.diag(std**2)], np.inf, 0.95)
    return float(stated), one.off(np.array(frame["T_parent_child"]))


def _unchanged(one: Pair, rng: np.random.Generator) -> Pair:
    return one


def _row(name: str, draw: Draw | None = None, change: Any = _unchanged, **more: Any) -> Row:
    return Row("hand-eye", name, partial(trial, draw or Draw(), change), **more)


MM = sights.scaled(1000.0)

ROWS = (
    _row("none", good=True, weight=3),
    _row("none (streams)", Draw((100, 200), streams=True), good=True, weight=2),
    _row("3-6 pairs", Draw((3, 4, 5, 6))),
    _row("outliers 5-30 %", change=_outliers),
    _row("6 postures x 10 frames", Draw((60,), repeats=10, noise=sights.by_posture(10))),
    _row("turns about one axis", Draw(one_axis=True)),
    _row("hardly turned", Draw(tilt=0.05)),
    _row("mm", change=_either(MM)),
    _row("inverse", change=_either(lie.inverse)),
    _row("wrong mount", change=_other_mount),
    _row("quaternion order", change=_either(sights.reordered)),
    _row("transposed", change=_either(_transposed)),
    _row("mirror", change=_eye(sights.mirrored)),
    _row("target's scale", change=_shrunk),
    _row("eye bumped half way", Draw(bumped=True)),
    _row("late 50 ms", Draw((100,), smooth=True, late=0.05)),
    _row("AR noise", Draw((40, 80), noise=sights.remembered(0.9))),
    _row("robot 2 mm off", Draw((20, 40), warp=2e-3)),
    _row("clock runs 0.2 % fast", Draw((200,), streams=True, skew=2e-3), apart=True),
    _row("lens", change=_lens, apart=True),
)
