"""Tracks: joint zeros from pictures without markers, through `bodyschema track`.

What counts is the place of the hand in the base, on fresh postures. Four zeros are found, and one
direction, the first joint's against the camera's turn, has most of the error: a run's 95 % over
postures is as good as a single draw, and is told as one (see `Outcome.single`). The command is run
as a user runs it, with --force, so that what it would not write can be compared too.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.cli.track import Track
from bodyschema.estimation.prediction import predict_error
from bodyschema.model.kinematics import relative_pose
from honest.pictured import (
    SPREAD,
    Pictured,
    draw_pictured,
    longer,
    measured_by_hand,
    nudged,
)
from honest.trial import Row, Trial

Array = NDArray[np.float64]
Change = Callable[[Pictured, np.random.Generator], Pictured]

SEEDS = 128
"""First guesses: the zeros are a few degrees off."""

FRESH = 200


def trial(make: Callable[[np.random.Generator], Pictured], change: Change, rng: Any) -> Trial:
    """What the user gives, and what is true of it."""
    one = change(make(rng), rng)
    how = "masks" if one.masked else "colours"
    about = f"{len(one.q)} pictures, {how}, camera known {one.known}"
    return Trial(
        about,
        lambda: tracked(one),
        lambda answer: stated_and_true(answer, one, rng),
        single=True,
    )


def tracked(one: Pictured) -> bs.Answer:
    """The answer of the command."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = one.write(Path(folder)), Path(folder) / "tracked"
        verb = Track(path, out, seeds=SEEDS, overlays=0, force=True, json=True)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            verb.run()
        return bs.load(out)


def stated_and_true(
    answer: bs.Answer, one: Pictured, rng: np.random.Generator
) -> tuple[float, float]:
    """m, of the hand in the base; by the covariance where no error is stated."""
    low, high = one.q.min(axis=0), one.q.max(axis=0)
    q = rng.uniform(low, high, (FRESH, len(SPREAD)))
    there = relative_pose(answer.body, q, "base", "hand")[:, :3, 3]
    true = min(
        float(np.quantile(np.linalg.norm(there - state.hand(q), axis=1), 0.95))
        for state in (one, replace(one, offsets=one.angles[-1] - one.q[-1]))
    )
    stated = answer.predicted_95
    if stated is None:
        stated = predict_error(answer.estimate, q, "base", "hand").position_overall
    return float(stated), true


def unchanged(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Nothing is wrong."""
    return one


def _lens(one: Pictured, rng: np.random.Generator) -> Pictured:
    return replace(one, focal=one.focal * (1 + rng.choice([-0.06, 0.04, 0.06])))


def _bent(one: Pictured, rng: np.random.Generator) -> Pictured:
    return replace(one, bent=float(rng.choice([-0.2, 0.1, 0.2])))


def _camera_off(one: Pictured, rng: np.random.Generator) -> Pictured:
    """It stands 1 to 4 cm and as many hundredths of a radian from where it is said to stand."""
    return replace(one, said_eye=nudged(one.T_base_eye, rng.uniform(0.01, 0.04), rng))


def _roughly(one: Pictured, rng: np.random.Generator) -> Pictured:
    """As far off as it is said to be."""
    return replace(one, said_eye=measured_by_hand(one.T_base_eye, rng), known="roughly")


def _bumped(one: Pictured, rng: np.random.Generator) -> Pictured:
    return replace(one, bumped=nudged(np.eye(4), rng.uniform(0.01, 0.03), rng))


def _mesh(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Boxes that are 3 to 8 mm larger or smaller than their meshes."""
    by = rng.uniform(3e-3, 8e-3) * rng.choice([-1.0, 1.0], one.sizes.shape)
    return replace(one, sizes=one.sizes + by)


def _scale(one: Pictured, rng: np.random.Generator) -> Pictured:
    return longer(one, float(rng.choice([0.96, 1.04])))


def _link(one: Pictured, rng: np.random.Generator) -> Pictured:
    """One link 1 to 2 cm longer than described."""
    places = one.places.copy()
    places[int(rng.integers(1, 4))] *= 1 + rng.uniform(0.06, 0.12)
    return replace(one, places=places)


def _slip(one: Pictured, rng: np.random.Generator) -> Pictured:
    """An encoder slips by 3 to 6 degrees half way."""
    late = np.arange(len(one.q)) >= len(one.q) / 2
    joint, by = int(rng.integers(3)), np.radians(rng.uniform(3, 6))
    return replace(one, turns=one.angles + by * late[:, None] * (np.arange(4) == joint))


def _columns(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Two columns swapped, or one that counts the other way."""
    q, turns = one.q.copy(), one.angles
    if rng.random() < 0.5:
        q[:, [1, 2]] = q[:, [2, 1]]
    else:
        q[:, int(rng.integers(3))] *= -1.0
    return replace(one, q=q, turns=turns)


def _late(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Every picture is that of the row before."""
    return replace(one, shown=np.maximum(np.arange(len(one.q)) - 1, 0))


def _shuffled(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Three of the pictures belong to other moments."""
    shown = np.arange(len(one.q))
    some = rng.choice(len(shown), 3, replace=False)
    shown[some] = shown[np.roll(some, 1)]
    return replace(one, shown=shown)


def _covered(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Something stands before a third of every other picture."""
    left = int(rng.integers(60, 180))

    def change(image: Array, i: int) -> Array:
        hidden = image.copy()
        if i % 2:
            hidden[:, left : left + 100] = 0
        return hidden

    return replace(one, spoilt=(change,))


def _thick(one: Pictured, rng: np.random.Generator) -> Pictured:
    """Masks that are three pixels too wide, or too narrow."""
    import cv2

    grow = cv2.dilate if rng.random() < 0.5 else cv2.erode

    def change(image: Array, i: int) -> Array:
        if image.ndim == 3:
            return image
        return np.asarray(grow(image.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0)

    return replace(one, spoilt=(change,))


def _mirrored(one: Pictured, rng: np.random.Generator) -> Pictured:
    return replace(one, spoilt=(lambda image, i: np.ascontiguousarray(image[:, ::-1]),))


def _colours(one: Pictured, rng: np.random.Generator) -> Pictured:
    return replace(one, masked=False)


def _row(name: str, change: Change = unchanged, make: Any = draw_pictured, **more: Any) -> Row:
    return Row("track", name, partial(trial, make, change), **more)


SMOOTH = partial(draw_pictured, n=14, smooth=True)

ROWS = (
    _row("none", good=True, weight=3),
    _row("none (camera known roughly)", _roughly, good=True, weight=2),
    _row("none (without masks)", _colours, good=True),
    _row("2-3 pictures", make=lambda rng: draw_pictured(rng, n=int(rng.integers(2, 4)))),
    _row("lens", _lens),
    _row("camera elsewhere", _camera_off),
    _row("camera bumped half way", _bumped),
    _row("mesh 3-8 mm", _mesh),
    _row("scale of the robot 4 %", _scale),
    _row("one link longer", _link),
    _row("encoder slips half way", _slip),
    _row("columns", _columns),
    _row("late by a picture", _late, SMOOTH),
    _row("three pictures of other moments", _shuffled),
    _row("covered in part", _covered),
    _row("masks too wide or narrow", _thick),
    _row("mirrored", _mirrored),
    _row("bent lens", _bent, apart=True),
)
