"""The peak of scores, and how well it is known."""

from __future__ import annotations

import numpy as np

from bodyschema.attention.lag import LagBelief, after_motion, peak


def scores(lag: float, height: float = 100.0) -> np.ndarray:
    return height * (1 - 0.05 * (np.arange(10) - lag) ** 2)


def test_a_parabola_is_found_between_the_candidates():
    assert np.isclose(peak(scores(3.3)), 3.3)
    assert peak(scores(-2.0)) == 0.0
    assert peak(np.array([1.0, 1.0, 1.0])) == 0.0


def test_scatter_of_the_motions_is_the_uncertainty():
    rng = np.random.default_rng(0)
    errors, claimed = [], []
    for _ in range(200):
        belief = LagBelief(np.zeros(10))
        for _ in range(8):
            belief = after_motion(belief, scores(4.0 + 0.3 * rng.normal()))
        errors.append(belief.lag() - 4.0)
        claimed.append(belief.sd())
    assert 0.6 < np.std(errors) / np.mean(claimed) < 1.6


def test_motions_that_say_nothing_leave_the_lag_unknown():
    belief = after_motion(LagBelief(np.zeros(10)), scores(4.0, height=1.0))
    assert not belief.known
    assert np.isnan(belief.lag())
    assert np.isnan(belief.sd())
    once = after_motion(belief, scores(4.0))
    assert abs(once.lag() - 4.0) < 0.1
    assert np.isnan(once.sd())
