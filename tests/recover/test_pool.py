"""A pool learns chains and trees from nothing, through the learner protocol."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.learners.learner import run
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.learners.skeletons.pool_state import PoolState
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints, free_skeleton
from bodyschema.senses.points import Points
from bodyschema.senses.touches import Touches
from bodyschema.simulation.humanoid import humanoid
from bodyschema.studies.pool_chains import PoolProtocol, noisy_pool_run, pool_run
from bodyschema.studies.self_watching import CASES, SelfWatching
from simulated import points, postures

Array = NDArray[np.float64]


def arrangement(n: int) -> Body:
    """A body whose axes and links mean nothing."""
    return Body.random_chain(n, np.random.default_rng(1000 + n))


def learned(pool: Pool, guess: Body, senses: list[Points] | list[Touches]) -> PoolState:
    *_, (state, _) = run(pool, pool.start(guess, free_skeleton(guess)), senses)
    return state


def error(body: Body, truth: Body, n: int = 100) -> float:
    q = postures(n, truth, np.random.default_rng(7), 1.6)
    ours, true = (relative_pose(one, q, "base", "tip")[:, :3, 3] for one in (body, truth))
    return float(np.sqrt(np.mean(np.sum((ours - true) ** 2, axis=1))))


@pytest.mark.parametrize("n", [1, 3, 5])
def test_a_chain_is_exact_after_a_few_samples_and_then_known(n: int) -> None:
    rng = np.random.default_rng(n)
    truth = Body.random_chain(n, rng)
    seen = points(truth, postures(40, truth, rng, 1.6), rng, 0.0, "base", "tip")
    state = learned(Pool(), arrangement(n), [seen])
    assert state.phase == "known"
    assert state.samples == ()
    assert error(state.body, truth) < 1e-9
    repeated = learned(Pool(), arrangement(n), [seen])
    np.testing.assert_array_equal(repeated.estimate.x, state.estimate.x)
    np.testing.assert_array_equal(repeated.body.axis, state.body.axis)


def test_noise_and_outliers_leave_an_error_of_the_size_that_it_states() -> None:
    ratios = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        truth = Body.random_chain(3, rng)
        seen = points(truth, postures(200, truth, rng, 1.6), rng, 2e-3, "base", "tip")
        bad = rng.random(200) < 0.05
        seen.position[bad] += rng.uniform(-0.5, 0.5, (int(bad.sum()), 3))
        state = learned(Pool(), arrangement(3), [seen])
        assert state.phase == "known"
        q = postures(60, truth, rng, 1.6)
        fresh = points(truth, q, rng, 0.0, "base", "tip")
        estimate = state.estimate
        linear = fresh.linearize(estimate.reference, estimate.variables, estimate.x)
        C = linear.by_parameter @ estimate.covariance @ linear.by_parameter.transpose(0, 2, 1)
        ratios.append(np.sum(linear.residual**2) / np.trace(C, axis1=1, axis2=2).sum())
    assert 0.4 < np.mean(ratios) < 2.0


def test_a_humanoid_learns_itself_from_its_hands_and_feet() -> None:
    body = humanoid()
    watching = SelfWatching(body, CASES["ends"])
    rng = np.random.default_rng(0)
    state = learned(Pool(size=16), body, watching.senses(watching.postures(18, rng)))
    assert state.phase == "known"
    assert watching.worst(state.body, watching.postures(40, rng)) < 1e-3


def test_known_points_of_a_limb_teach_as_well() -> None:
    rng = np.random.default_rng(4)
    truth = Body.random_chain(2, rng)
    q, v = postures(30, truth, rng, 1.6), rng.normal(size=(30, 3)) * 0.1
    T = relative_pose(truth, q, "base", "tip")
    position = np.einsum("nij,nj->ni", T[:, :3, :3], v) + T[:, :3, 3]
    state = learned(Pool(), arrangement(2), [Touches.make(q, position, v, "base", "tip")])
    assert state.phase == "known"
    assert error(state.body, truth) < 1e-9


def test_another_robot_on_the_same_wires_is_noticed_and_learned() -> None:
    rng = np.random.default_rng(5)
    old, new = Body.random_chain(2, rng), Body.random_chain(2, rng)
    parts = [points(b, postures(80, b, rng, 1.6), rng, 1e-3, "base", "tip") for b in (old, new)]
    pool = Pool()
    state = learned(pool, arrangement(2), [parts[0]])
    assert state.phase == "known"
    steps = list(run(pool, state, [parts[1]]))
    assert "searching" in [info.phase for _, (info,) in steps[:25]]
    assert error(steps[-1][0].body, new) < 5e-3


def test_parameters_without_axes_and_links_are_refused() -> None:
    body = arrangement(2)
    with pytest.raises(InputError, match="use free_skeleton"):
        Pool().start(body, free_joints(body, ("offsets",)))


def test_compiled_runs_converge_and_repeat() -> None:
    runs = [pool_run(PoolProtocol(), 3, 0, run) for run in range(20)]
    assert runs == [pool_run(PoolProtocol(), 3, 0, run) for run in range(20)]
    coarse = np.array(runs)[:, 0]
    assert coarse.min() >= 3
    assert np.median(coarse) <= 7
    assert coarse.max() < 25


def test_noisy_runs_reach_the_bound() -> None:
    protocol = PoolProtocol(noise=0.01, outliers=0.05)
    ratios = np.array([noisy_pool_run(protocol, 3, 0, run)[-1, 0] for run in range(12)])
    assert 0.8 < np.median(ratios) < 1.3
    assert ratios.max() < 3
