"""Runs of the replay learner on random chains: few samples, gone over many times.

The end point is fixed and learned, as for the pool. A run has converged when the predictions of
`STREAK` samples in a row, each before it was learned from, were within the threshold; the samples
count up to the first of them, as the others only test.
"""

from __future__ import annotations

import numpy as np

from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.replay import Replay
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.variables import free_skeleton
from bodyschema.senses.points import Points
from bodyschema.studies.gradient_chains import STREAK, Protocol
from bodyschema.studies.random_chains import (
    chain_body,
    draw_chain,
    draw_untaught,
    length_of,
    run_generator,
)

LIMIT = 1000
"""Samples until the first of the streak; a run that needs more has failed."""


def replay_run(protocol: Protocol, n_joints: int, seed: int, run: int) -> int:
    """Samples until convergence; -1 if the limit came first."""
    rng = run_generator(seed, n_joints, run)
    axes, links = np.empty((n_joints + 2, 3)), np.empty((n_joints + 2, 3))
    draw_chain(rng, axes, links)
    truth, small = chain_body(axes, links), protocol.threshold * length_of(links)
    draw_untaught(rng, axes, links)
    start = chain_body(axes, links)
    learner = Replay(OnlineGradient(1.0, "normalised", length=1.0))
    state, near = learner.start(start, free_skeleton(start)), 0
    for t in range(LIMIT + STREAK):
        q = rng.uniform(-protocol.reach, protocol.reach, (1, n_joints))
        position = relative_pose(truth, q, "base", "tip")[:, :3, 3]
        state, (miss,) = learner.step(state, (Points.make(q, position, "base", "tip"),))
        near = near + 1 if miss.distance < small else 0
        if near == STREAK:
            return t + 1 - STREAK
        if near == 0 and t >= LIMIT:
            break
    return -1
