"""From a quiet stretch and a recording to touches: what the parts of this room are for.

    quiet ──► load, offset, gains ──► noise of what they leave unexplained ──► finder
    recording ─────────────────────► unexplained wrench ─────────────────────► touches

The quiet stretch is free motion with the object in the hand, the one that the load was learned from
or another one.
"""

from __future__ import annotations

from dataclasses import dataclass

from bodyschema.learners.touch.finder import Touch, TouchFinder
from bodyschema.learners.touch.known_load import KnownLoad
from bodyschema.learners.touch.noise import measured_noise
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.model.solid import Solid
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples

WINDOW = Averaging(window=0.25)
"""Shorter than for learning the load: a touch lasts half a second."""


@dataclass(frozen=True)
class TouchSearch:
    """A load and a finder that know each other."""

    load: KnownLoad
    finder: TouchFinder
    averaging: Averaging = WINDOW

    @classmethod
    def taught(
        cls,
        quiet: WristSamples,
        load: KnownLoad,
        solid: Solid | None = None,
        gain_std: float = 0.01,
        false_per_hour: float = 0.1,
        averaging: Averaging = WINDOW,
        surface: float = 0.0,
    ) -> TouchSearch:
        """Learn from free motion what no touch looks like.

        Args:
            quiet: ten seconds of free motion or more, in postures like those to come.
            load: of `KnownLoad.of`, as learned.
            solid: the object in the sensor's frame; None if its shape is not known.
            gain_std: share of itself by which each reading may be off; 0 if they are exact.
            false_per_hour: touches an hour that may be felt where there are none.
            averaging: the windows over which wrench and motion are averaged.
            surface: m, one standard deviation that the object's surface may be off.

        Raises:
            InputError: too few samples, or a setting that makes no sense.
        """
        if gain_std > 0:
            load = load.with_gains(Averaging().means(quiet), gain_std)
        left = Unexplained.of(averaging.means(quiet), load)
        noise = measured_noise(left)
        finder = TouchFinder(
            noise.covariance, solid, left.rate, false_per_hour, noise.samples, surface=surface
        )
        return cls(load, finder, averaging)

    def unexplained(self, samples: WristSamples) -> Unexplained:
        """What the load does not explain of a recording, or of the last window of a stream."""
        return Unexplained.of(self.averaging.means(samples), self.load)

    def touches(self, samples: WristSamples) -> list[Touch]:
        """The touches of a recording."""
        return self.finder.touches(self.unexplained(samples))
