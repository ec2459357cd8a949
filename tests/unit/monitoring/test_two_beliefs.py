"""Two beliefs of the same numbers: the rate of false alarms, and who is blamed."""

from __future__ import annotations

import numpy as np

from bodyschema.monitoring.two_beliefs import two_beliefs

NAMES = ("a.x", "a.y", "b.x")
PARTS = {"a": (0, 1), "b": (2,)}


def test_the_rate_of_false_alarms_is_kept() -> None:
    rng, alarms, n = np.random.default_rng(0), 0, 4000
    root = np.array([[1.0, 0.0, 0.0], [0.8, 0.5, 0.0], [0.3, -0.2, 2.0]])
    C = root @ root.T
    for _ in range(n):
        alarms += two_beliefs(root @ rng.normal(size=3), C, PARTS, NAMES, 0.05).changed
    assert 0.03 < alarms / n < 0.055


def test_the_part_that_moved_is_blamed() -> None:
    test = two_beliefs(np.array([0.1, 0.2, 9.0]), np.eye(3), PARTS, NAMES, 0.01)
    assert test.changed
    assert [suspect.part for suspect in test.suspects] == ["b"]
    np.testing.assert_array_equal(test.suspects[0].change, [9.0])
    assert test.suspects[0].names == ("b.x",)
    assert not two_beliefs(np.full(3, 0.5), np.eye(3), PARTS, NAMES, 0.01).suspects
