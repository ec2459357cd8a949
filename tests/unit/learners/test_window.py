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
        for batch in window.batches:
            same = [sample for sample in plain if sample.label == batch.label]
            assert batch.time.tolist() == [float(sample.time[0]) for sample in same]
        assert list(window.order) == [sample.label for sample in plain]
