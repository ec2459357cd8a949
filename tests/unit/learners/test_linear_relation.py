"""The published relation: exact on exact data, its reliability, its rules."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.learners.hand_eye.stereo_points import head_eye, triangulated_rows
from bodyschema.learners.published.linear_relation import Moments, PaperRelation, Relation
from bodyschema.simulation.katana import project_points, stereo
from watched import seen


def moments_of(scene, stream, pixels):
    """The sums of the paper's rows, and the last rows."""
    total = Moments.empty(16)
    for T, c in zip(stream.T_world_hand, stereo().triangulate(pixels[:, 0]), strict=True):
        total = total.add(triangulated_rows(T, c))
    return total


@pytest.mark.parametrize("scale", ["rotation", "last"])
def test_exact_data_give_the_exact_answer(scale):
    scene, stream = seen(0, 10)
    exact = project_points(scene, stream.T_world_hand, stereo())
    found = PaperRelation(16, scale=scale).solve(moments_of(scene, stream, exact))
    assert np.abs(found.rotation - scene.T_world_cam[:3, :3]).max() < 1e-10
    assert np.abs(found.x[9:12] - scene.T_world_cam[:3, 3]).max() < 1e-9
    assert np.abs(found.x[12:15] - scene.points[0]).max() < 1e-9
    assert found.x[15] == pytest.approx(1, abs=1e-9)
    assert found.squares[0] < 1e-16
    assert found.closeness < 1e-18


def test_rotation_of_nearly_exact_moments_has_twelve_digits():
    # Rows of exact points, not of pixels: only the normal form's own rounding is left.
    rng = np.random.default_rng(1)
    R, r_o, r = lie.exp_so3(rng.normal(size=3)), rng.normal(size=3), rng.normal(size=3)
    total = Moments.empty(16)
    for _ in range(200):
        T = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
        point = T[:3, :3] @ r + T[:3, 3]
        total = total.add(triangulated_rows(T, R.T @ (point - r_o)))
    assert np.abs(PaperRelation(16).solve(total).rotation - R).max() < 1e-12


def test_closeness_tells_the_angle_as_the_paper_leaves_it():
    """SSD 0.1, 0.01, 0.001 mean about 9, 3 and 0.9 degrees, whatever the noise."""
    pairs = []
    for seed in range(24):
        scene, stream = seen(seed, 40, noise=0.7)
        total = Moments.empty(16)
        c = stereo().triangulate(stream.pixels[:, 0])
        for i, T in enumerate(stream.T_world_hand):
            total = total.add(triangulated_rows(T, c[i]))
            if i > 60 and i % 15 == 0:
                found = PaperRelation(16).solve(total)
                turn = lie.log_so3(found.rotation @ scene.T_world_cam[:3, :3].T)
                pairs.append((found.closeness, np.degrees(np.linalg.norm(turn))))
    closeness, angle = np.array(pairs).T
    for at, expected in ((0.1, 9.0), (0.01, 3.0), (0.001, 0.9)):
        near = (closeness > at / 1.5) & (closeness < at * 1.5)
        assert near.sum() >= 8
        assert expected / 1.5 < np.median(angle[near]) < expected * 1.5


def test_a_mirror_is_not_a_rotation():
    values = np.ones(16)
    # The smallest direction is a mirror: diag(1, 1, -1) and a positive last entry.
    v = np.zeros(16)
    v[[0, 4, 15]], v[8] = 1.0, -1.0
    v /= np.linalg.norm(v)
    C = np.diag(values) - np.outer(v, v)
    found = PaperRelation(16).solve(Moments(C, 1))
    assert found.closeness == np.inf
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    # The sign of an eigenvector is chance; ours has a positive last entry.
    assert found.x[15] > 0


def test_ten_samples_in_a_row_above_the_limit_start_anew():
    learner = PaperRelation(2, rotation=False)
    state = Relation(Moments.empty(2), np.array([1.0, 1.0]), 0.5)
    good, bad = np.array([[1.0, -1.0]]), np.array([[1.0, 0.0]])
    for _ in range(9):
        state, (look,) = learner.step(state, (bad,))
        assert not look.event
    state, (look,) = learner.step(state, (good,))
    assert state.above == 0
    for _ in range(10):
        state, (look,) = learner.step(state, (bad,))
    assert look.event == "changed"
    assert state.x is None
    assert state.moments.count == 0


def test_the_two_limits_differ_by_the_scale():
    _, stream = seen(3, 30)
    c = stereo().triangulate(stream.pixels[:, 0])
    limits = {}
    for limit in ("literal", "consistent"):
        learner = PaperRelation(16, limit=limit, closest=0.01)
        state, i = learner.start(), 0
        while state.x is None:
            state, (look,) = learner.step(state, (triangulated_rows(stream.T_world_hand[i], c[i]),))
            i += 1
        limits[limit] = state.limit
    assert limits["consistent"] / limits["literal"] == pytest.approx(look.direction.scale**2)


def test_a_camera_on_the_head_is_the_same_relation():
    rng = np.random.default_rng(2)
    T_head_cam = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
    q = rng.normal(size=3)
    total = Moments.empty(16)
    for i in range(100):
        T_world_head = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
        c = lie.inverse(T_world_head @ T_head_cam) @ np.append(q, 1)
        moment = head_eye(float(i), T_world_head, np.zeros((1, 3)))
        total = total.add(triangulated_rows(moment.T_world_hand, c[:3]))
    found = PaperRelation(16).solve(total)
    assert np.abs(found.rotation - T_head_cam[:3, :3]).max() < 1e-10
    assert np.abs(found.x[9:12] - T_head_cam[:3, 3]).max() < 1e-9
    assert np.abs(found.x[12:15] - q).max() < 1e-9
