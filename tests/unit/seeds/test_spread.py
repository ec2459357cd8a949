"""Some of many samples stand for all of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.seeds.spread import MOST, spread
from bodyschema.senses.points import Points

Array = NDArray[np.float64]


def seen(q: Array, time: Array | None = None, rows: Array | None = None) -> Points:
    return Points.make(q, np.zeros((len(q), 3)), "tracker", "tool", time=time, rows=rows)


def test_few_samples_are_all_kept() -> None:
    sense = seen(np.random.default_rng(0).normal(size=(MOST, 4)))
    assert spread(sense) is sense


@pytest.mark.parametrize("every", [2, 7, 10, 30])
def test_a_share_of_bad_rows_stays_the_share_that_it_is(every: int) -> None:
    """Whatever their rhythm: evenly spaced rows could meet all of them, or none."""
    sense = seen(np.random.default_rng(0).normal(size=(3000, 4)))
    kept = spread(sense, 300)
    assert 200 < len(kept) <= 300
    assert np.mean(kept.rows % every == 0) == pytest.approx(1 / every, abs=0.1)
    assert (np.diff(kept.rows) > 0).all()
    assert np.diff(kept.rows).max() < 60
    assert (spread(sense, 300).rows == kept.rows).all()


def test_a_robot_that_waits_is_not_asked_again_and_again() -> None:
    still = np.zeros((9000, 3))
    moving = np.cumsum(np.full((1000, 3), 1e-3), axis=0)
    kept = spread(seen(np.concatenate([still, moving])), 200)
    assert 90 < np.sum(kept.rows >= 9000) < 130


def test_slipped_encoders_count_no_more_than_others() -> None:
    rng = np.random.default_rng(0)
    q = np.cumsum(rng.normal(size=(5000, 3)), axis=0) * 1e-3
    slipped = rng.random(5000) < 0.02
    q[slipped] += 3.0
    kept = spread(seen(q), 300)
    assert np.mean(slipped[kept.rows]) < 0.06


def test_samples_of_one_moment_stay_together() -> None:
    moments, corners = 900, 5
    time = np.repeat(np.arange(float(moments)), corners)
    q = np.repeat(np.random.default_rng(0).normal(size=(moments, 3)), corners, axis=0)
    kept = spread(seen(q, time, np.repeat(np.arange(moments), corners)), 100)
    _, counts = np.unique(kept.time, return_counts=True)
    assert (counts == corners).all()
    assert 60 < len(counts) <= 100
