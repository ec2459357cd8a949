"""Boards that were numbered from either end are turned as the robot's postures tell."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.seeds.turned_boards import board_turns
from bodyschema.vision.targets.target import Target

Array = NDArray[np.float64]


def random_poses(n: int, rng: np.random.Generator) -> Array:
    return lie.transform(lie.exp_so3(rng.normal(0, 0.6, (n, 3))), rng.normal(0, 0.3, (n, 3)))


@pytest.mark.parametrize(
    "target", [Target("chessboard", 9, 7, 0.02), Target("circles", 9, 9, 0.02)]
)
@pytest.mark.parametrize("seed", range(4))
def test_every_board_is_turned_alike(target: Target, seed: int) -> None:
    """Up to one turn of all, with 2 mm and half a degree of noise and a fifth of another board."""
    rng = np.random.default_rng(seed)
    F = [motion for _, motion in target.turns]
    K, X, Y = random_poses(20, rng), random_poses(1, rng)[0], random_poses(1, rng)[0]
    T = lie.inverse(X) @ K @ Y
    T[:, :3, 3] += rng.normal(0, 0.002, (20, 3))
    T[:, :3, :3] = T[:, :3, :3] @ lie.exp_so3(rng.normal(0, 0.01, (20, 3)))
    T[:4] = random_poses(4, rng)
    true = rng.integers(0, len(F), 20)
    seen = np.stack([T[i] @ lie.inverse(F[k]) for i, k in enumerate(true)])
    turns = board_turns(K, seen, F)
    # T F_k with k found is T of truth, times one motion that all share.
    apart = [lie.inverse(T[i]) @ seen[i] @ F[turns[i]] for i in range(4, 20)]
    assert np.ptp(np.array(apart), axis=0).max() < 1e-9


def test_too_few_pictures_stay_as_they_are() -> None:
    rng = np.random.default_rng(0)
    F = [motion for _, motion in Target("chessboard", 9, 7, 0.02).turns]
    assert (board_turns(random_poses(3, rng), random_poses(3, rng), F) == 0).all()
