"""A window of samples of two senses against a plain list."""

from __future__ import annotations

import numpy as np

from bodyschema.learners.window import Window
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense


def test_it_is_a_list_that_is_never_changed() -> None:
    rng = np.random.default_rng(0)
    window, plain = Window(), list[Sense]()
    for t in range(60):
        old, kept = window, (window.batches, window.order)
        if plain and rng.random() < 0.4:
            window, plain = window.without_oldest(), plain[1:]
        else:
            seen = f"hand_{rng.integers(2)}"
            sample = Points.make([[t]], rng.normal(size=(1, 3)), "eye", seen, time=[t])
            window, plain = window.with_sample(sample), [*plain, sample]
        assert (old.batches, old.order) == kept
        assert len(window) == len(plain)
        assert all(len(batch) for batch in window.batches)
        n = int(rng.integers(len(plain) + 1))
        older, newest = window.split(n)
        assert [_key(s) for s in newest] == [_key(s) for s in plain[len(plain) - n :]]
        assert older.order == tuple(s.label for s in plain[: len(plain) - n])
        whole, none = older.split(len(older))
        assert [_key(s) for s in none] == [_key(s) for s in plain[: len(plain) - n]]
        assert not whole.batches


def _key(sample: Sense) -> tuple[str, float]:
    return sample.label, float(sample.time[0])
