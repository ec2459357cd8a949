"""A humanoid that watches itself: whose turn it is, what is measured, and the gradient's runs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.invisible import invisible_motions
from bodyschema.learners.learner import in_time_order
from bodyschema.learners.published.online_gradient import OnlineGradient, from_nothing, typical_link
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import BETWEEN, ENDS, EYE, humanoid
from bodyschema.studies.gradient_trees import STREAK, bin_ends, gradient_tree_run
from bodyschema.studies.schema_comparison import compare
from bodyschema.studies.self_watching import CASES, SelfWatching

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def watching() -> SelfWatching:
    return SelfWatching(humanoid(), CASES["alternating"])


def arm() -> Body:
    """A neck joint with the camera, and an arm of one joint: learned within a second."""
    placement = np.tile(np.eye(4), (5, 1, 1))
    placement[1, :3, 3], placement[2, :3, 3] = [0, 0, 0.1], [0.05, 0, 0.02]
    placement[3, :3, 3], placement[4, :3, 3] = [0, 0.1, 0], [0, 0, -0.1]
    return Body.build(
        "arm", ["pelvis", "neck", EYE, "shoulder", "r_hand"],
        ["", "neck", "eye_joint", "shoulder", "hand_joint"], [-1, 0, 1, 0, 3], [0, 1, 0, 1, 0],
        [[0, 0, 1]] * 3 + [[0, 1, 0]] * 2, placement,
        limits={"neck": (-1.5, 1.5), "shoulder": (-1.5, 1.5)},
    )  # fmt: skip


def test_groups_take_turns(watching: SelfWatching) -> None:
    q = watching.postures(5, np.random.default_rng(0))
    seen = watching.senses(q)
    assert [sense.seen for sense in seen] == [*ENDS, *BETWEEN]
    rows = {sense.seen: sense.rows.tolist() for sense in seen}
    assert rows["r_hand"] == [0, 2, 4]
    assert rows["waist"] == [1, 3]
    assert {sense.seen for sense in watching.at(q, 1)} == set(BETWEEN)
    assert {sense.seen for sense in watching.at(q, 2)} == set(ENDS)
    assert all(np.array_equal(sense.q[0], q[2]) for sense in watching.at(q, 2))


def test_the_path_s_length_is_the_sum_of_its_links() -> None:
    real = SelfWatching(arm(), (("r_hand",),))
    assert real.path_length("r_hand") == pytest.approx(0.1 + np.hypot(0.05, 0.02) + 0.1 + 0.1)


def test_errors_are_distances(watching: SelfWatching) -> None:
    body = watching.body
    q = watching.postures(4, np.random.default_rng(1))
    k = body.frame_index("r_hand")
    longer = body.placement[k].copy()
    longer[0, 3] += 0.02
    wrong = body.with_placement("r_hand", longer)
    errors = watching.errors(wrong, q)
    np.testing.assert_allclose(errors[:, 0], 0.02, atol=1e-12)
    np.testing.assert_allclose(errors[:, 1:], 0.0, atol=1e-12)
    assert watching.worst(wrong, q) == pytest.approx(0.02 / watching.path_length("r_hand"))


def test_bins_cover_every_iteration_once() -> None:
    ends = bin_ends(1000)
    assert ends[0] == 1
    assert ends[-1] == 1000
    assert (np.diff(ends) > 0).all()


def test_a_run_learns_and_says_when() -> None:
    real = SelfWatching(arm(), (("r_hand",),))
    run = gradient_tree_run(real, 0.05, 0.01, 100_000, np.random.default_rng(0))
    assert run.iterations is not None
    assert run.iterations > STREAK
    fresh = real.postures(100, np.random.default_rng(1))
    assert real.worst(run.body, fresh) < 0.01
    seen = run.curve[np.isfinite(run.curve[:, 0]), 0]
    assert seen[0] > 10 * seen[-1]
    again = gradient_tree_run(real, 0.05, 0.01, 100_000, np.random.default_rng(0))
    assert again.iterations == run.iterations
    np.testing.assert_array_equal(again.curve, run.curve)


def test_a_run_is_the_learner_sample_by_sample() -> None:
    """The compiled loop against `OnlineGradient`, for two groups of markers."""
    real = SelfWatching(humanoid(), CASES["alternating"])
    body, n = real.body, 40
    variables = free_skeleton(body)
    length = typical_link(Skeleton.of(body))
    run = gradient_tree_run(real, 0.05, 0.0, n, np.random.default_rng(3))
    rng = np.random.default_rng(3)
    learner = OnlineGradient(0.05, length=length)
    state = learner.start(from_nothing(body, variables, length, rng), variables)
    order = [int(body.driver[k]) for k in np.flatnonzero(body.kind)]
    q = np.empty((n, 24))
    for row in q:
        row[order] = rng.random(24)
    q = body.lower + (body.upper - body.lower) * q
    for i in range(n):
        for sample in in_time_order(real.at(q, i)):
            state, _ = learner.step(state, (sample,))
    np.testing.assert_allclose(
        Skeleton.of(run.body).links, Skeleton.of(state.body).links, atol=1e-12
    )
    assert run.iterations is None


def test_a_run_that_blows_up_has_not_converged() -> None:
    real = SelfWatching(humanoid(), CASES["ends"])
    run = gradient_tree_run(real, 0.5, 0.01, 3000, np.random.default_rng(0))
    assert run.iterations is None


def test_two_bodies_that_cannot_be_told_apart_differ_in_their_centres_alone() -> None:
    rng = np.random.default_rng(4)
    real = SelfWatching(humanoid(), CASES["ends"])
    variables = free_skeleton(real.body)
    rows = [m.row for m in invisible_motions(real.body, variables) if m.frame not in (EYE, *ENDS)]
    other = real.body.with_variables(variables, rng.normal(0, 0.1, len(rows)) @ np.array(rows))
    found = compare(real, other, real.postures(30, rng))
    assert found.prediction < 1e-12
    assert found.axes < 1e-12
    assert found.lines < 1e-12
    assert found.centres > 0.1 > found.centres_mean > 0.01
    turned = real.body.with_placement("r_hand", np.eye(4))
    assert compare(real, turned, real.postures(30, rng)).prediction == pytest.approx(0.1028)


def test_the_eye_sees_the_waist_ahead_and_below(watching: SelfWatching) -> None:
    """At rest, by hand: the waist's place less the eye's, in the eye's axes."""
    body, q = watching.body, np.zeros((2, len(watching.body.joints)))
    T_root = {name: chain(body, name) for name in (EYE, "waist")}
    expected = T_root[EYE][:3, :3].T @ (T_root["waist"][:3, 3] - T_root[EYE][:3, 3])
    (waist,) = [sense for sense in watching.at(q, 1) if sense.seen == "waist"]
    np.testing.assert_allclose(waist.position[0], expected, atol=1e-12)


def chain(body: Body, frame: str) -> Array:
    """(4, 4) of a frame in the root while all joints are at zero: placements, one after another."""
    T, k = np.eye(4), body.frame_index(frame)
    while k >= 0:
        T, k = body.placement[k] @ T, int(body.parent[k])
    return T
