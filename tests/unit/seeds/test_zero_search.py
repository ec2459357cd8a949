"""Joint zeros that are wrong by up to half a turn: found, and zeros that nothing shows stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds.zero_search import search_zeros
from bodyschema.senses.sense import Sense
from simulated import points, poses, postures, random_poses, seen_arm

UNKNOWN = {"tracker": "no", "tool": "no"}


def turned(body: Body, zeros: list[float]) -> Body:
    """The real robot, its zeros off by so many degrees."""
    return replace(body, offset=np.deg2rad(zeros))


def fitted(body: Body, sense: Sense) -> tuple[float, Body]:
    """Median residual in m after a search and a fit."""
    found = search_zeros(body, [sense], body.joints)
    assert found is not None
    zeros = {j: float(o) for j, o in zip(body.joints, found.offset, strict=True) if o}
    problem = Problem(body, (sense,), dict(UNKNOWN), body.joints, zeros=zeros)
    estimate = problem.fit(problem.variables(("offsets",)), problem.senses)
    left = sense.residual(estimate.body)[:, :3]
    return float(np.median(np.linalg.norm(left, axis=1))), estimate.body


@pytest.mark.parametrize("kind", [points, poses])
def test_zeros_off_by_quarter_and_eighth_turns_are_fitted(kind: type) -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(6, rng)
    truth = turned(body, [0, 90, -45, 90, 45, 0])
    sense = kind(truth, postures(40, body, rng), rng)
    left, found = fitted(body, sense)
    assert left < 2.5e-3
    q = postures(50, body, rng)
    shown, true = (relative_pose(b, q, "tracker", "tool")[:, :3, 3] for b in (found, truth))
    assert np.linalg.norm(shown - true, axis=1).max() < 0.02


def test_a_zero_of_half_a_turn_may_end_a_little_beyond() -> None:
    rng = np.random.default_rng(6)
    body = seen_arm(5, rng)
    sense = poses(turned(body, [0, 0, 190, 0, 0]), postures(30, body, rng), rng)
    zeros = {body.joints[2]: 3.0}
    problem = Problem(body, (sense,), dict(UNKNOWN), body.joints, zeros=zeros)
    found = problem.fit(problem.variables(("offsets",)), problem.senses)
    assert np.rad2deg(found.x[2]) == pytest.approx(190, abs=0.5)
    frames = problem.fit(problem.variables(()), problem.senses)
    assert (frames.body.offset == body.offset).all()


@pytest.mark.parametrize("kind", [points, poses])
def test_outliers_do_not_stop_the_search(kind: type) -> None:
    rng = np.random.default_rng(1)
    body = seen_arm(6, rng)
    truth = turned(body, [100, -150, 60, 170, -80, 20])
    sense = kind(truth, postures(30, body, rng), rng)
    bad = np.arange(len(sense)) % 5 == 0
    shown = sense.observed.copy()
    if shown.ndim == 3:
        shown[bad] = random_poses(int(bad.sum()), rng)
    else:
        shown[bad] += rng.uniform(-0.3, 0.3, (int(bad.sum()), 3))
    left, _ = fitted(body, replace(sense, observed=shown))
    assert left < 3e-3


def test_right_zeros_stay() -> None:
    rng = np.random.default_rng(2)
    body = seen_arm(6, rng)
    sense = poses(body, postures(30, body, rng), rng)
    found = search_zeros(body, [sense], body.joints)
    assert found is not None
    assert not found.found
    assert found.before < 0.02


def test_zeros_that_nothing_shows_stay() -> None:
    """The zeros of the first and of the last joint are those of the unknown frames."""
    rng = np.random.default_rng(3)
    body = seen_arm(5, rng)
    sense = poses(turned(body, [170, 0, 90, 0, -120]), postures(30, body, rng), rng)
    found = search_zeros(body, [sense], body.joints)
    assert found is not None
    assert found.found
    assert found.offset[[0, 4]] == pytest.approx(0.0)


def test_only_named_joints_are_turned() -> None:
    rng = np.random.default_rng(4)
    body = seen_arm(5, rng)
    sense = poses(turned(body, [0, 0, 90, 0, 0]), postures(30, body, rng), rng)
    found = search_zeros(body, [sense], [body.joints[1]])
    assert found is not None
    assert found.offset[2] == 0


def test_a_sense_without_closed_form_says_nothing() -> None:
    rng = np.random.default_rng(5)
    body = seen_arm(4, rng)
    few = poses(body, postures(3, body, rng), rng)
    assert search_zeros(body, [few], body.joints) is None
