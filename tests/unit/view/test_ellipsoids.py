"""Ellipsoids hold what they say they hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.view.ellipsoids import carried, half_axes, touched, uncertain_frames


def test_95_of_100_lie_inside() -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    axes = half_axes(root @ root.T)
    inside = np.linalg.norm(np.linalg.solve(axes, root @ rng.normal(size=(3, 40_000))), axis=0) < 1
    assert inside.mean() == pytest.approx(0.95, abs=0.004)


def test_a_free_frame_is_as_unsure_as_the_belief_says(seen: Any) -> None:
    """Moved about by draws of the belief, its place lies inside 95 of 100 times."""
    estimate, rng = seen.answer.estimate, np.random.default_rng(1)
    q = seen.senses[0].q[:1]
    (e,) = uncertain_frames(estimate, q, [("base", seen.senses[0].seen_from)])
    draws = rng.multivariate_normal(estimate.x, estimate.covariance, 600)
    bodies = (estimate.reference.with_variables(estimate.variables, x) for x in draws)
    places = np.array([relative_pose(b, q[0], "base", e.name.split(" from ")[0]) for b in bodies])
    off = places[:, :3, 3] - e.centre[0]
    inside = np.linalg.norm(np.linalg.solve(e.axes[0], off.T), axis=0) < 1
    assert inside.mean() == pytest.approx(0.95, abs=0.03)


def test_a_load_is_drawn_as_the_body_that_moves_like_it() -> None:
    """A solid ellipsoid of half axes a, b, c comes back as itself, where it is."""
    mass, half = 2.0, np.array([0.1, 0.05, 0.2])
    moments = mass / 5 * np.diag(half @ half - half**2)
    R = lie.exp_so3([0.3, 0.2, -0.5])
    load = Inertia(mass, np.array([0.01, 0.02, 0.3]), R @ moments @ R.T)
    entry = {
        "name": "box",
        "not_told": [],
        "flange": {"mass": mass, "com": load.com.tolist(), "inertia": load.moments.tolist()},
    }
    T = lie.transform(lie.exp_so3([0.0, 1.0, 0.0]), [1.0, 2.0, 3.0])[None]
    (e,) = carried(entry, T)
    np.testing.assert_allclose(np.sort(np.linalg.norm(e.axes[0], axis=0)), np.sort(half))
    np.testing.assert_allclose(e.centre[0], T[0, :3, :3] @ load.com + T[0, :3, 3])
    assert carried({**entry, "not_told": [{"what": "mass"}]}, T) == ()


def test_every_place_of_a_touch() -> None:
    place = {"point": [0.0, 0.0, 0.1], "covariance": (1e-6 * np.eye(3)).tolist(), "chance": 0.5}
    both = touched({"begins": 3.0, "places": [place, place]}, np.eye(4)[None])
    assert [e.name for e in both] == ["touch at 3.00 s, 50 %"] * 2
    assert both[0].widest == pytest.approx(2.7955e-3)
