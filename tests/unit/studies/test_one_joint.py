"""One joint: the averages behind Theorem 1, its failure for one fixed end point, and the condition
that holds when the end point varies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.touches import Touches
from bodyschema.studies.hersch2008_theorem1 import REACHES_DEG, widest
from bodyschema.studies.one_joint import Swing, bowl, fixed_energy, settle, varied_energy

Array = NDArray[np.float64]


def unit(*numbers: float) -> Array:
    return np.array(numbers) / np.linalg.norm(numbers)


def grid(reach: float, n: int = 1001) -> Array:
    """Midpoints of equal steps: averages over them are integrals."""
    return reach * ((np.arange(n) + 0.5) / n * 2 - 1)


def averaged(a: Array, true: Array, points: Array, reach: float) -> float:
    """<1/2 |e|^2> by brute force over angles and points, with the best l."""
    theta = grid(reach)[:, None, None, None]
    turn, turn_true = (lie.exp_so3(theta[..., 0, 0, :] * axis) for axis in (a, true))
    e = np.einsum("tij,nj->tni", turn_true - turn, points)
    return 0.5 * float(np.mean(np.sum((e - e.mean(axis=(0, 1))) ** 2, axis=-1)))


@pytest.mark.parametrize("reach", [0.4, np.pi / 2, np.pi])
def test_averages_of_a_uniform_joint(reach: float) -> None:
    theta, swing = grid(reach), Swing.uniform(reach)
    assert swing.s == pytest.approx(np.mean(np.sin(theta) ** 2), abs=1e-6)
    assert swing.c == pytest.approx(np.var(np.cos(theta)), abs=1e-6)
    assert swing.k == pytest.approx(np.mean((1 - np.cos(theta)) ** 2), abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_reduced_energies_are_the_averages_of_the_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, true, v = (unit(*rng.normal(size=3)) for _ in range(3))
    swing = Swing.uniform(1.2)
    fixed = averaged(a, true, v[None], 1.2)
    assert fixed_energy(a[None], true, v, swing)[0] == pytest.approx(fixed, abs=1e-5)
    # The six corners of an octahedron average every quadratic form as the whole sphere does.
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    varied = averaged(a, true, corners, 1.2)
    assert varied_energy(np.array(a @ true), swing) == pytest.approx(varied, abs=1e-5)


TRUE, POINT, REACH = unit(0.3, 0.0, 1.0), unit(0.0, 0.0, 1.0), np.pi / 2
"""A joint whose end point lies 17 degrees off its axis."""


def false_minimum() -> Array:
    """Where the descent from the mirrored axis comes to rest."""
    a = TRUE - 2 * (POINT @ TRUE) * POINT
    swing = Swing.uniform(REACH)
    assert settle(TRUE, POINT, swing.s, swing.c, a)
    return a


def test_theorem_1_as_printed_has_a_counterexample() -> None:
    swing, a = Swing.uniform(REACH), false_minimum()
    assert swing.as_printed
    assert a @ TRUE < 0
    assert bowl(a, TRUE, POINT, swing) > 0.01
    here = averaged(a, TRUE, POINT[None], REACH)
    assert here > 1e-4
    for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        b1, b2 = np.linalg.svd(a[None])[2][1:]
        near = unit(*(a + 0.02 * (np.cos(angle) * b1 + np.sin(angle) * b2)))
        assert averaged(near, TRUE, POINT[None], REACH) > here


def taught(start: Array, reach: float, varied: bool) -> Array:
    """The axis after 8000 samples of a joint about TRUE, begun at an axis with the true link."""
    rng = np.random.default_rng(0)
    body = Body.random_chain(1, rng)
    skeleton = Skeleton.of(body)
    truth = replace(skeleton, axes=np.array([TRUE] * 3)).into(body)
    guess = replace(skeleton, axes=np.array([start] * 3)).into(body)
    v = rng.normal(size=(8000, 3)) if varied else np.tile(POINT, (8000, 1))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    q = rng.uniform(-reach, reach, (8000, 1))
    seen = Touches.make(q, np.zeros_like(v), v, "base", "link_1").imagined(truth, q)
    learner = OnlineGradient(0.02, length=1.0)
    state = learner.start(guess, free_joints(guess, ("axes", "links")))
    state, _ = learner.descend(state, SkeletonSamples.of(seen, guess, state.R0))
    return state.body.axis[1]


def test_the_learner_stays_in_the_false_minimum_unless_the_end_point_varies() -> None:
    start = false_minimum()
    assert taught(start, REACH, varied=False) @ start > 0.98
    assert taught(start, REACH, varied=True) @ TRUE > 1 - 1e-9


def test_the_opposite_axis_is_a_minimum_where_k_is_above_s() -> None:
    """With v varied; the change comes where the two are equal, at 122.6 degrees."""
    almost = unit(*(-TRUE + np.array([0.05, 0.05, 0.0])))
    narrow, wide = Swing.uniform(widest() - 0.01), Swing.uniform(widest() + 0.01)
    assert narrow.single
    assert not wide.single
    g = np.linspace(-1, 1, 20001)
    for swing in (narrow, wide):
        falls = np.diff(varied_energy(g, swing)) < 0
        assert falls.all() == swing.single
        assert np.mean(~falls) == pytest.approx(swing.caught, abs=1e-4)
    assert taught(almost, 0.8 * widest(), varied=True) @ TRUE > 1 - 1e-9
    assert taught(almost, np.pi, varied=True) @ TRUE < -0.9


def test_the_printed_condition_holds_for_every_range_of_the_study() -> None:
    assert all(Swing.uniform(np.deg2rad(reach)).as_printed for reach in REACHES_DEG)
