"""Neighbours that err alike, halves that disagree, outliers of one cause."""

from __future__ import annotations

import numpy as np

from bodyschema.trust.alike import outliers_alike, two_heaps
from bodyschema.trust.halves import halves
from bodyschema.trust.scores import Scores
from bodyschema.trust.whiteness import whiteness
from faulty import autoregressive, bumped, recorded


def scored(case):
    return Scores.of(case.fit, case.problem.senses)


def test_noise_has_no_neighbours():
    p = np.array(
        [whiteness(scored(recorded(seed, groups=("offsets", "axes")))) for seed in range(10)]
    )
    # Links that are off and not freed follow the posture: only the full model leaves noise.
    full = np.array([whiteness(scored(recorded(seed))) for seed in range(10)])
    assert (full > 0.0026).all()
    assert 0.2 < np.median(full[:, 0]) < 0.9
    assert np.median(p[:, 1]) < np.median(full[:, 1])


def test_slow_noise_has():
    noise = autoregressive(100, 0.9, 5e-4, np.random.default_rng(0))
    time, _ = whiteness(scored(recorded(0, n=100, smooth=True, noise=noise)))
    assert time < 1e-4


def test_a_wave_in_the_gear_follows_the_posture():
    wavy = recorded(1, n=300, turned=lambda q: q + 0.01 * np.sin(2 * q), noise=1e-4)
    assert whiteness(scored(wavy))[1] < 0.0026


def test_halves_of_one_robot_agree_and_of_two_do_not():
    for seed in range(6):
        assert all(half.p_value > 1e-3 for half in halves(scored(recorded(seed, n=80))))
    two = halves(scored(recorded(0, n=80, moved=bumped(np.array([0.0, 0.0, 0.008])))))
    assert two[0].words.startswith("the first half")
    assert two[0].p_value < 1e-6
    # Neighbours in posture were seen both before and after.
    assert all(half.p_value > 1e-4 for half in two[1:])


def test_outliers_of_one_cause_point_one_way():
    rng = np.random.default_rng(3)
    random, alike = np.zeros((60, 3)), np.zeros((60, 3))
    random[:12] = 0.02 * rng.normal(size=(12, 3))
    alike[:12] = [0.02, 0.01, 0.0]
    for shift, same in ((random, False), (alike, True)):
        case = recorded(8, moved=lambda p, shift=shift: p + shift, groups=("offsets",))
        out = np.arange(60) < 12
        p = outliers_alike(case.fit, case.problem.senses[0], out)
        assert (p < 1e-4) == same


def test_two_heaps():
    rng = np.random.default_rng(4)
    heap = 1e-3 * rng.normal(size=(200, 3))
    assert not two_heaps(heap)
    assert not two_heaps(rng.uniform(-1, 1, (400, 3)))
    assert two_heaps(heap + np.where(np.arange(200) % 2, 0.01, -0.01)[:, None] * [1, 0, 0])
