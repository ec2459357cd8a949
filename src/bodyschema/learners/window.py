"""The newest samples of several senses: one batch a sense, and the order in which they came."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.senses.sense import Sense, concatenate


@dataclass(frozen=True)
class Window:
    """Samples in order of arrival; nothing is changed in place."""

    batches: tuple[Sense, ...] = ()
    """One for each sense that has samples in the window."""
    order: tuple[str, ...] = ()
    """Labels of the samples, oldest first."""

    def __len__(self) -> int:
        return len(self.order)

    def with_sample(self, sample: Sense) -> Window:
        """One sample (a batch of one) more."""
        order = (*self.order, sample.label)
        if sample.label not in self.order:
            return Window((*self.batches, sample), order)
        batches = (
            concatenate([batch, sample]) if batch.label == sample.label else batch
            for batch in self.batches
        )
        return Window(tuple(batches), order)

    def without_oldest(self) -> Window:
        """One sample less."""
        label = self.order[0]
        batches = (
            batch.take(np.arange(1, len(batch))) if batch.label == label else batch
            for batch in self.batches
            if batch.label != label or len(batch) > 1
        )
        return Window(tuple(batches), self.order[1:])
