"""Postures and moments: what belongs together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bodyschema.estimation.moments import moments_of, postures
from simulated import points, poses, seen_arm
from simulated import postures as random_postures


def test_near_readings_are_one_posture_and_slow_movements_are_not() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    q = np.repeat(random_postures(5, body, rng), 4, axis=0)
    (found,) = postures([points(body, q + rng.uniform(-4e-5, 4e-5, q.shape), rng)])
    assert len(np.unique(found)) == 5
    assert (found.reshape(5, 4) == found[::4, None]).all()
    slowly = np.cumsum(np.full((400, 3), 3e-5), axis=0)
    (found,) = postures([points(body, slowly, rng)])
    assert 40 < len(np.unique(found)) < 400


def test_postures_are_shared_by_senses_and_other_joints_do_not_count() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    q = random_postures(6, body, rng)
    a, b = postures([points(body, q, rng), poses(body, q[2:], rng)])
    assert (a[2:] == b).all()
    shaken = q.repeat(2, axis=0)
    shaken[:, 2] += rng.normal(size=12)
    seen = [points(body, shaken, rng, seen="link_2")]
    assert len(np.unique(postures(seen)[0])) == 12
    assert len(np.unique(postures(seen, body=body)[0])) == 6


def test_rows_of_one_number_or_one_posture_are_one_moment() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(3, rng)
    q = random_postures(4, body, rng)
    seen = points(body, q[[0, 1, 2, 0]], rng)
    other = replace(poses(body, q[[3, 2]], rng), rows=np.array([1, 9]))
    rows, moment = moments_of([seen, other])
    assert rows.tolist() == [0, 1, 2, 3, 9]
    assert moment[0] == moment[3]
    assert moment[2] == moment[4]
    assert len(np.unique(moment)) == 3
