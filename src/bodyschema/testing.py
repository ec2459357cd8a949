"""What a sense of your own has to keep, as one call for your tests.

    from bodyschema.testing import check_sense

    def test_my_sense_keeps_the_contract():
        check_sense(my_samples, my_body, my_variables)

Every promise that the rest of the house builds on is tried on the samples that are given: that a
sense predicts what it would see, that its derivatives are those of its residual, that it changes
nothing, that its samples can be taken apart and joined, that it refuses what is no number, and that
its words and its noise fit its residual. The first that is broken raises AssertionError and says
what was expected.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.kernels import FIXED
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame
from bodyschema.senses.sense import DIFFERENCE, PLACEMENT, Linearized, Sense, concatenate

Array = NDArray[np.float64]

DEVIATION = 0.1
"""Of the prior: how far from the body as given the derivatives are tried too."""

SLOPE = 1e-5
"""Largest relative difference between a derivative and a difference quotient."""

ROUNDING = 1e-13
"""Relative error of a prediction, which a quotient divides by its step."""


def check_sense(sense: Sense, body: Body, variables: Variables, seed: int = 0) -> None:
    """Try every promise of a sense.

    Args:
        sense: three samples or more, noisy or not.
        body: has the frames and parts that the sense names; near it the samples make sense.
        variables: all that the sense may depend on, of joints, frames and parts.
        seed: of the deviations at which derivatives are tried.

    Raises:
        AssertionError: a promise is broken; the text says which and how.
    """
    _require(len(sense) >= 3, "give at least three samples, so that some can be left out")
    x = DEVIATION * variables.scale * np.random.default_rng(seed).normal(size=len(variables))
    check_noise(sense)
    check_prediction(sense, body)
    check_purity(sense, body, variables, x)
    for at in (np.zeros(len(variables)), x):
        check_derivatives(sense, body, variables, at)
    check_selection(sense, body, variables)
    check_imagined(sense, body)
    check_refusals(sense)
    check_ends(sense, body)


def check_noise(sense: Sense) -> None:
    """Its name, its components and its believed noise belong to one residual."""
    d = len(sense.covariance)
    _require(bool(sense.label.strip()), "`label` is empty; messages and reports need a name")
    _require(
        sense.covariance.shape == (d, d)
        and (sense.covariance == sense.covariance.T).all()
        and np.linalg.eigvalsh(sense.covariance).min() > 0,
        "`covariance` is not symmetric and positive",
    )
    covered = [row for _, _, part in sense.components for row in range(d)[part]]
    _require(
        sorted(covered) == list(range(d)),
        f"`components` should cover each of the {d} rows once; they cover {covered}",
    )
    names = [name for name, _, _ in sense.components]
    _require(len(set(names)) == len(names), f"two components share a name: {names}")
    _require(
        all(name and unit for name, unit, _ in sense.components),
        'each component needs a name and a unit; write "1" for a number without one',
    )


def check_prediction(sense: Sense, body: Body) -> None:
    """Seen as predicted, nothing is left over; shapes and numbers are as stated."""
    predicted = np.asarray(sense.predict(body))
    _require(
        predicted.shape == sense.observed.shape,
        f"`predict` gives {predicted.shape}, what was observed has {sense.observed.shape}",
    )
    _require(bool(np.isfinite(predicted).all()), "`predict` gives numbers that are not finite")
    n, d = len(sense), len(sense.covariance)
    left = replace(sense, observed=predicted).residual(body)
    _require(left.shape == (n, d), f"`residual` should have shape {(n, d)}, it has {left.shape}")
    largest = float(np.abs(left).max())
    _require(
        largest <= 1e-9 * max(1.0, float(np.abs(predicted).max())),
        f"of samples that are exactly as predicted, `residual` leaves {largest:g}",
    )


def check_purity(sense: Sense, body: Body, variables: Variables, x: Array) -> None:
    """Asked twice, it answers the same, and what it was asked with is as before."""
    fields = {name: getattr(sense, name).copy() for name in (*sense.arrays, "covariance")}
    placement, at = body.placement.copy(), x.copy()
    first, second = (sense.linearize(body, variables, x) for _ in range(2))
    once, twice = sense.residual(body), sense.residual(body)
    _require(
        _same(once, twice) and all(map(_same, _numbers(first), _numbers(second))),
        "asked twice with the same body, it does not answer the same",
    )
    changed = [name for name, before in fields.items() if not _same(getattr(sense, name), before)]
    changed += [] if _same(body.placement, placement) and _same(x, at) else ["the body or x"]
    _require(not changed, f"predicting has changed {', '.join(changed)}; work on copies")


def check_derivatives(sense: Sense, body: Body, variables: Variables, x: Array) -> None:
    """`linearize` is the residual and its derivatives by every variable and every reading."""
    n, d, moved = len(sense), len(sense.covariance), body.with_variables(variables, x)
    linear = sense.linearize(body, variables, x)
    shapes = [part.shape for part in _numbers(linear)]
    wanted = [(n, d), (n, d, len(variables)), (n, d, sense.q.shape[1])]
    _require(shapes == wanted, f"`linearize` should give shapes {wanted}, it gives {shapes}")
    size = max(1.0, float(np.abs(linear.residual).max()), float(np.abs(sense.observed).max()))
    _require(
        bool(np.abs(linear.residual - sense.residual(moved)).max() <= 1e-9 * size),
        "the residual of `linearize` is not that of `residual`",
    )
    for i, name in enumerate(variables.names):
        step = DIFFERENCE * variables.scale[i] * (np.arange(len(x)) == i)
        there = [sense.residual(body.with_variables(variables, x + s * step)) for s in (1, -1)]
        _require_slope(f"variable {name}", linear.by_parameter[:, :, i], there, step.sum(), size)
    for j in range(sense.q.shape[1]):
        step = DIFFERENCE * (np.arange(sense.q.shape[1]) == j)
        there = [replace(sense, q=sense.q + s * step).residual(moved) for s in (1, -1)]
        _require_slope(f"reading {body.joints[j]}", linear.by_joint[:, :, j], there, 1e-5, size)


def check_selection(sense: Sense, body: Body, variables: Variables) -> None:
    """Some of the samples are what they were among all; joined again they are all."""
    n, residual = len(sense), sense.residual(body)
    zero = np.zeros(len(variables))
    every = np.arange(n)
    for rows in ([n - 1, 0], [0], [], every[1:], every % 2 == 0):
        some = sense.take(rows)
        _require(type(some) is type(sense), f"`take` makes a {type(some).__name__} of it")
        wanted, have = residual[rows], some.residual(body)
        _require(
            have.shape == wanted.shape and bool(np.abs(have - wanted).max(initial=0.0) < 1e-9),
            f"samples {rows} alone have other residuals than among all; is a field that has one "
            "row a sample missing from `arrays`, or one that is `shared` taken apart?",
        )
        linear = some.linearize(body, variables, zero)
        _require(len(linear.by_parameter) == len(some), f"`linearize` fails for samples {rows}")
    joined = concatenate([sense.take(np.arange(2)), sense.take([]), sense.take(np.arange(2, n))])
    _require(
        type(joined) is type(sense) and _same(joined.residual(body), residual),
        "taken apart and joined again, the samples have other residuals",
    )


def check_imagined(sense: Sense, body: Body) -> None:
    """Imagined samples are of the same kind, at the postures asked for, and fit the body."""
    q = np.concatenate([sense.q, sense.q[:2]])
    there = sense.imagined(body, q)
    _require(
        type(there) is type(sense) and there.label == sense.label and _postures(there, q),
        "`imagined` should give the same sense at the postures that are asked for, their samples "
        "in this order and their number as row",
    )
    left = float(np.abs(there.residual(body)).max())
    size = max(1.0, float(np.abs(there.observed).max()))
    _require(left <= 1e-9 * size, f"what was imagined of a body is {left:g} off that body")


def check_refusals(sense: Sense) -> None:
    """A value that is not a number is refused, with the sense and the row."""
    row = int(sense.rows[2])
    for name in sense.arrays:
        spoiled = np.array(getattr(sense, name), copy=True)
        if not np.issubdtype(spoiled.dtype, np.floating):
            continue
        spoiled[2] = np.nan
        changed: dict[str, Any] = {name: spoiled}
        try:
            replace(sense, **changed)
        except InputError as error:
            words = str(error)
            _require(
                sense.label in words and f"row {row}" in words,
                f"refusing a {name} that is no number, it should name '{sense.label}' and row "
                f"{row}; it says: {words}",
            )
            continue
        raise AssertionError(f"it takes a {name} that is no number; call `check_samples` on it")


def check_ends(sense: Sense, body: Body) -> None:
    """It begins and ends in frames of the body, and tells of them what it says that it shows."""
    for pair in sense.pairs:
        for frame, shown in zip(pair, sense.shows, strict=True):
            node = body.frame_index(frame)
            unknown = set(shown) - set(PLACEMENT)
            _require(not unknown, f"`shows` names {unknown}, which no placement has")
            if node == 0 or body.kind[node] != FIXED or (body.parent == node).any():
                continue
            _require_enough(sense, body, frame, shown)
    unmoved = sense.start(body, ())
    _require(unmoved is None, "`start` should give None when none of its frames is unknown")


def _require_enough(sense: Sense, body: Body, frame: str, shown: Iterable[str]) -> None:
    """Raise when a component that `shows` leaves out moves the residual as no other one does."""
    free = free_frame(body, frame)
    by = sense.linearize(body, free, np.zeros(len(free))).by_parameter.reshape(-1, len(free))
    kept = np.isin(PLACEMENT, list(shown))
    explained = by[:, kept] @ np.linalg.lstsq(by[:, kept], by[:, ~kept], rcond=None)[0]
    left = np.abs(by[:, ~kept] - explained).max(axis=0, initial=0.0)
    told = np.array(PLACEMENT)[~kept][left > SLOPE * max(1.0, float(np.abs(by).max()))]
    _require(not len(told), f"`shows` leaves out {', '.join(told)} of {frame}, which it tells")


def _require_slope(
    what: str, slope: Array, there: Iterable[Array], step: float, size: float
) -> None:
    """Raise unless a derivative is the quotient of two residuals, a step either way."""
    forth, back = there
    quotient = (forth - back) / (2 * step)
    allowed = SLOPE * np.abs(quotient).max() + ROUNDING * size / step
    error = np.abs(slope - quotient)
    if error.max() > allowed:
        row, component = np.unravel_index(np.argmax(error), error.shape)
        raise AssertionError(
            f"the derivative by {what} is {slope[row, component]:g} in sample {row}, row "
            f"{component} of the residual; differences say {quotient[row, component]:g}"
        )


def _postures(there: Sense, q: Array) -> bool:
    """Whether the samples are of postures q, one or more of each, in order."""
    return (
        _same(np.unique(there.rows), np.arange(len(q)))
        and _same(there.q, q[there.rows])
        and bool((np.diff(there.rows) >= 0).all())
    )


def _numbers(linear: Linearized) -> tuple[Array, Array, Array]:
    return linear.residual, linear.by_parameter, linear.by_joint


def _same(a: NDArray[np.generic], b: NDArray[np.generic]) -> bool:
    return a.shape == b.shape and bool((a == b).all())


def _require(kept: bool, broken: str) -> None:
    if not kept:
        raise AssertionError(f"{broken}.")
