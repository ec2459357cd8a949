"""Compiled runs of chains: the same as the learner, sample by sample, and the figures of a few."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.model.variables import free_frame, free_joints, join
from bodyschema.senses.touches import Touches
from bodyschema.studies.gradient_chains import BLOCK, STREAK, Protocol, gradient_run
from bodyschema.studies.random_chains import (
    chain_body,
    direction,
    draw_chain,
    draw_untaught,
    fill,
    length_of,
    run_generator,
)

N = 2


def by_the_learner(protocol: Protocol, seed: int, run: int) -> int:
    """What `gradient_run` does, through the learner's protocol: slow, and plain to read."""
    rng = run_generator(seed, N, run)
    drawn = [np.empty((N + 2, 3)) for _ in range(4)]
    draw_chain(rng, *drawn[:2])
    draw_untaught(rng, *drawn[2:])
    if protocol.reading != "learnt":
        drawn[3][-1] = drawn[1][-1]
    truth, start = chain_body(*drawn[:2]), chain_body(*drawn[2:])
    free = free_joints(start, ("axes", "links"))
    if protocol.reading == "learnt":
        free = join(free, free_frame(start, "tip", turn_std=None))
    rule = "normalised" if protocol.normalised else "constant"
    learner = OnlineGradient(protocol.epsilon, rule, length=1.0)
    state, near, random = learner.start(start, free), 0, np.empty((BLOCK, N + 3))
    seen = "link_2" if protocol.reading == "varied" else "tip"
    for t in range(protocol.limit):
        if t % BLOCK == 0:
            fill(rng, random)
        u, v = random[t % BLOCK], np.zeros(3)
        if protocol.reading == "varied":
            direction(u[N], u[N + 1], v)
            v *= 0.5 + u[N + 2]
        q = [protocol.reach * (2 * u[:N] - 1)]
        sample = Touches.make(q, np.zeros((1, 3)), v, "base", seen).imagined(truth, q)
        state, (miss,) = learner.step(state, (sample,))
        near = near + 1 if miss.distance < protocol.threshold * length_of(drawn[1]) else 0
        if near == STREAK:
            return t + 1
    return -1


@pytest.mark.parametrize(
    "protocol",
    [
        Protocol("varied"),
        Protocol("known", reach=1.0),
        Protocol("learnt", epsilon=1.0, normalised=True),
        Protocol("varied", threshold=1e-6, limit=600),
    ],
)
def test_a_compiled_run_is_the_learner_sample_by_sample(protocol: Protocol) -> None:
    short = replace(protocol, limit=min(protocol.limit, 2500))
    run = next(i for i in range(9) if gradient_run(short, N, 1, i) > 0 or short.limit == 600)
    assert gradient_run(short, N, 1, run) == by_the_learner(short, 1, run)


def test_chains_are_as_they_are_described() -> None:
    axes, links = np.empty((4000, 3)), np.empty((4000, 3))
    rng = run_generator(0, 1, 0)
    draw_chain(rng, axes, links)
    length = np.linalg.norm(links[1:], axis=1)
    assert np.linalg.norm(axes, axis=1) == pytest.approx(np.ones(4000))
    assert 0.5 <= length.min() < 0.51
    assert 1.49 < length.max() <= 1.5
    assert np.abs(axes.mean(axis=0)).max() < 0.04
    assert np.cov(axes.T) == pytest.approx(np.eye(3) / 3, abs=0.03)
    assert (links[0] == 0).all()
    draw_untaught(rng, axes, links)
    assert links[1:].std() == pytest.approx(0.05, rel=0.05)


def test_runs_depend_on_their_own_number_alone() -> None:
    runs = [gradient_run(Protocol(), 3, 0, i) for i in (5, 6, 5)]
    assert runs[0] == runs[2] != runs[1]


def test_one_joint_always_learns_when_the_end_point_is_known_and_varies() -> None:
    steps = np.array([gradient_run(Protocol(), 1, 0, i) for i in range(200)])
    assert steps.min() > STREAK
    assert 700 < np.median(steps) < 1000


def test_one_joint_often_fails_when_the_end_point_is_known_and_fixed() -> None:
    """About one in six; the published theorem says none."""
    short = Protocol("known", limit=20_000)
    steps = np.array([gradient_run(short, 1, 0, i) for i in range(200)])
    assert 0.08 < np.mean(steps < 0) < 0.3
