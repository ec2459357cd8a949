"""The compiled fit of skeletons: derivatives, ranks, convergence, stages."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.learners.skeletons.fit import improve, slide
from bodyschema.learners.skeletons.growth import Look, plan, stacked
from bodyschema.learners.skeletons.sight import Routes, Sightings, foresee, tangents, work_for
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import BETWEEN, ENDS, EYE, humanoid

Array = NDArray[np.float64]


def forked() -> Body:
    """Two limbs and a neck; one node shifts, and the eye and both ends are fixed."""
    kind = [FIXED, REVOLUTE, REVOLUTE, FIXED, REVOLUTE, PRISMATIC, FIXED, REVOLUTE, FIXED]
    return Body.build(
        name="forked",
        frames=["root", "neck", "tilt", "eye", "a1", "a2", "hand", "b1", "foot"],
        carriers=["", *(f"j{k}" for k in range(1, 9))],
        parent=[-1, 0, 1, 2, 0, 4, 5, 0, 7],
        kind=kind,
        axis=np.tile([0.0, 0.0, 1.0], (9, 1)),
        placement=np.tile(np.eye(4), (9, 1, 1)),
    )


def random_skeleton(nodes: int, rng: np.random.Generator) -> tuple[Array, Array]:
    axes = rng.normal(size=(nodes, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True), rng.normal(size=(nodes, 3))


def random_sightings(routes: Routes, n: int, rng: np.random.Generator) -> Sightings:
    theta = rng.uniform(-1.5, 1.5, (n, len(routes.kind)))
    sine = np.where(routes.kind == PRISMATIC, theta, np.sin(theta))
    route = np.arange(n) % len(routes.length)
    return Sightings(np.cos(theta), sine, route, rng.normal(size=(n, 3)), np.zeros((n, 3)))


def moved(
    routes: Routes, axes: Array, links: Array, p: int, step: float, unit: float
) -> tuple[Array, Array]:
    axes, links = axes.copy(), links.copy()
    basis = np.empty((len(axes), 2, 3))
    tangents(axes, basis)
    for k in range(len(axes)):
        at = p - routes.axis_column[k]
        if routes.axis_column[k] >= 0 and at in (0, 1):
            slide(axes[k], step * basis[k, at])
        at = p - routes.link_column[k]
        if routes.link_column[k] >= 0 and at in (0, 1, 2):
            links[k, at] += unit * step
    return axes, links


def test_derivatives_agree_with_finite_differences() -> None:
    rng = np.random.default_rng(0)
    body = forked()
    looks = [Look("eye", "hand", True), Look("eye", "foot", True), Look("hand", "foot", True)]
    routes = plan(body, free_skeleton(body), looks)
    axes, links = random_skeleton(9, rng)
    sightings, N, unit, h = random_sightings(routes, 12, rng), int(routes.columns[-1]), 0.7, 1e-6
    J, levers = np.zeros((12, 3, N)), np.empty((9, 3))
    stacked(routes, sightings, axes, links, unit, J)
    for p in range(N):
        ahead, behind = (moved(routes, axes, links, p, s, unit) for s in (h, -h))
        for i in range(12):
            there, here = (foresee(routes, sightings, i, *at, levers) for at in (ahead, behind))
            slope = (np.array(there) - np.array(here)) / (2 * h)
            np.testing.assert_allclose(J[i, :, p], slope, atol=3e-9)


def test_tangent_steps_stay_on_the_sphere() -> None:
    rng = np.random.default_rng(1)
    axes, _ = random_skeleton(50, rng)
    axes[0], axes[1] = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
    basis = np.empty((50, 2, 3))
    tangents(axes, basis)
    triads = np.concatenate([basis, axes[:, None]], axis=1)
    np.testing.assert_allclose(
        triads @ triads.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)), atol=1e-14
    )
    before = axes[5].copy()
    slide(axes[5], 0.8 * basis[5, 0])
    assert np.linalg.norm(axes[5]) == pytest.approx(1, abs=1e-15)
    assert before @ axes[5] == pytest.approx(np.cos(0.8))


@pytest.mark.parametrize("n", [1, 3, 7])
def test_a_chain_has_rank_4n_plus_3(n: int) -> None:
    body = Body.random_chain(n, np.random.default_rng(n))
    routes = plan(body, free_skeleton(body), [Look("base", "tip")])
    assert routes.columns.tolist() == [5 * n + 3]
    assert routes.rank.tolist() == [4 * n + 3]


def test_a_humanoid_is_learned_limb_by_limb_and_its_ranks_are_counted() -> None:
    body = humanoid()
    ends = plan(body, free_skeleton(body), [Look(EYE, m) for m in ENDS])
    assert ends.stage.tolist() == [0, 1, 2, 3]
    assert (ends.columns[-1], ends.rank[-1]) == (135, 108)
    both = plan(body, free_skeleton(body), [Look(EYE, m) for m in (*ENDS, *BETWEEN)])
    assert both.rank[-1] == 115
    # The waist and the shoulders come before the elbows, and those before the hands.
    assert both.stage[-3:].tolist() == [0, 0, 0]
    assert 0 < both.stage[4] < both.stage[0]


@pytest.mark.parametrize("freedom", [np.inf, 4.0])
def test_a_fit_from_nearby_finds_the_truth_in_any_unit(freedom: float) -> None:
    rng = np.random.default_rng(2)
    body = Body.random_chain(3, rng)
    routes = plan(body, free_skeleton(body), [Look("base", "tip")])
    axes, links = random_skeleton(5, rng)
    near_axes = axes + 0.1 * rng.normal(size=axes.shape)
    near_axes /= np.linalg.norm(near_axes, axis=1, keepdims=True)
    near_links = links + 0.1 * rng.normal(size=links.shape)
    levels = []
    for scale in (1.0, 1000.0):
        blank = random_sightings(routes, 40, np.random.default_rng(3))
        blank.point[:] = 0.0
        for i in range(40):
            blank.seen[i] = foresee(routes, blank, i, axes, scale * links, np.empty((5, 3)))
        if freedom < np.inf:
            blank.seen[:2] += 3.0 * scale
        found = near_axes.copy(), scale * near_links
        work = work_for(routes, 40)
        _, level, first = improve(
            routes, blank, np.arange(40), 0, *found, scale, 1.0, freedom, 60, work
        )
        levels.append((level / scale, first / scale))
        assert level < 1e-8 * scale
    assert levels[0][1] == pytest.approx(levels[1][1], rel=1e-9)
