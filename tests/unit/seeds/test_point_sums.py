"""Turns on sums are turns on all samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bodyschema import lie
from bodyschema.seeds.closed_forms import align_points
from bodyschema.seeds.point_sums import PointSums
from simulated import random_poses

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_frame_and_point_are_those_of_the_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 30))
    K, p, w, y = (
        random_poses(n, rng),
        rng.normal(size=(n, 3)),
        rng.uniform(0.1, 1, n),
        rng.normal(size=3),
    )
    sums = PointSums.of(K, p, w)
    X = lie.transform(*sums.frame(y))
    there = K[:, :3, :3] @ y + K[:, :3, 3]
    assert pytest.approx(align_points(p, there, w), abs=1e-9) == X
    seen = p @ X[:3, :3].T + X[:3, 3]
    local = np.einsum("nab,na->nb", K[:, :3, :3], seen - K[:, :3, 3])
    assert pytest.approx(w @ local / w.sum(), abs=1e-9) == sums.point(X[:3, :3], X[:3, 3])
