"""All that steps through a stream, with a short stream of its own: one line each.

A learner that joins gives a line to `STEPPERS`; a learner of a body one to `LEARNERS` of
`contract/test_learners.py` too, which asks that it learns and knows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bodyschema.attention.finder import BodyFinder
from bodyschema.attention.frames import Frame
from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.learners.filter import Filter
from bodyschema.learners.hand_eye.clock import ClockSearch, LatePoints
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.images.contour_tracker import ContourTracker
from bodyschema.learners.learner import Learner, moments
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.published.linear_relation import PaperRelation
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.published.paper_payload import UNKNOWNS, PaperPayload
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.learners.replay import Replay
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.learners.smoother import Smoother
from bodyschema.learners.touch.finder import TouchFinder
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.learners.watched_body import WatchedBody
from bodyschema.learners.watched_images import WatchedImages
from bodyschema.learners.watched_smoother import Block, WatchedSmoother
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame, free_joints, join
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.wrench_means import Averaging
from bodyschema.simulation import icub
from bodyschema.simulation.katana import stereo
from bodyschema.simulation.loads import Held, draw_motion, draw_sensor, record, wire_box
from imagined_hand import hand, masks, posture
from linear_learner import Linear, Stream
from simulated import free_all, points, postures, seen_arm
from watched import seen

Moments = list[tuple[Any, ...]]


@dataclass(frozen=True)
class Stepper:
    """A learner, how it starts and what it is shown."""

    learner: Learner[Any, Any, Any]
    stream: Callable[[], Moments]
    about: tuple[Any, ...] = ()
    """What its `start` is told."""

    def start(self) -> Any:
        """The state before the first moment."""
        return self.learner.start(*self.about)  # type: ignore[attr-defined]


ARM: Body = seen_arm(3, np.random.default_rng(0))
FREE = free_all(ARM, turns=False)
VECTORS = join(free_joints(ARM, ("axes", "links")), free_frame(ARM, "tool", turn_std=None))
TOOL = Block("tool", ("tool.link_x", "tool.link_y"), 0.1)
CLOCK = ClockSearch(HandEyePoints(stereo()), (0.0, 0.03, 0.06))
LINEAR = Linear({"a": [0, 1], "b": [2]})


def tips() -> Moments:
    """Points on the tool, one a moment."""
    rng = np.random.default_rng(1)
    return list(moments([points(ARM, postures(40, ARM, rng), rng)]))


def tracked() -> Moments:
    """A point before a stereo camera."""
    stream = seen(0, 2)[1]
    return [(stream.sample(i),) for i in range(len(stream))]


def late() -> Moments:
    """The same with the hand where it was a while ago."""
    stream = seen(0, 2)[1]
    lags = range(len(CLOCK.lags))
    return [
        (LatePoints(stream.T_world_hand[[i - k for k in lags]], stream.pixels[i]),)
        for i in range(len(CLOCK.lags), len(stream))
    ]


def means() -> Moments:
    """Wrenches of a box that is waved about."""
    rng = np.random.default_rng(2)
    motion = draw_motion(rng, 5.0, 0.5, 100.0)
    felt = Averaging().means(record(motion, [Held(0.0, wire_box())], draw_sensor(rng, 0.02), rng))
    return [(felt.take(slice(k, k + 1)),) for k in range(len(felt))]


def touched() -> Moments:
    """A push of half a second."""
    rng, n = np.random.default_rng(3), 150
    wrench = 0.02 * rng.normal(size=(n, 6))
    wrench[60:110, 2] += 2.0
    return list(Unexplained(np.arange(n) / 100, wrench, np.zeros((n, 6, 0))).moments())


def rows(size: tuple[int, int]) -> Callable[[], Moments]:
    """Rows of a linear relation."""
    rng = np.random.default_rng(4)
    return lambda: [(rng.normal(size=size),) for _ in range(20)]


def looks() -> Moments:
    """Masks of a hand in both eyes."""
    return [(masks(posture(step)),) for step in (0.0, 0.05, 0.1)]


def frames() -> Moments:
    """A picture that shifts with a joint."""
    rng, q = np.random.default_rng(5), 0.3 * np.sin(np.arange(24) / 4)
    wall = rng.integers(0, 256, (144, 192)).astype(np.uint8)
    shifted = [np.roll(wall, round(20 * a), axis=1) for a in q]
    return [(Frame(i / 30, shifted[i], q[i : i + 1]),) for i in range(len(q))]


def linear() -> Moments:
    """What `Linear` learns from."""
    stream = Stream(LINEAR, np.zeros(3), 6)
    return [(stream.draw(8.0 * (i > 60)),) for i in range(90)]


STEPPERS = {
    "filter": Stepper(Filter(), tips, (ARM, FREE)),
    "smoother": Stepper(Smoother(), tips, (ARM, FREE)),
    "pool": Stepper(Pool(), tips, (ARM, VECTORS)),
    "replay": Stepper(Replay(size=15), tips, (ARM, VECTORS)),
    "online_gradient": Stepper(OnlineGradient(1.0, "normalised"), tips, (ARM, VECTORS)),
    "watched_body": Stepper(WatchedBody(ARM, FREE, Filter(burn_in=20)), tips),
    "watched_smoother": Stepper(WatchedSmoother(ARM, FREE, (TOOL,), Smoother(12)), tips),
    "hand_eye_points": Stepper(HandEyePoints(stereo(), buffer=40), tracked),
    "clock_search": Stepper(CLOCK, late),
    "load_learner": Stepper(LoadLearner(), means),
    "touch_finder": Stepper(TouchFinder(4e-4 * np.eye(6)), touched),
    "paper_relation": Stepper(PaperRelation(16), rows((3, 16))),
    "paper_payload": Stepper(PaperPayload(), rows((6, UNKNOWNS))),
    "particle_filter": Stepper(
        ParticleFilter(hand(), particles=12), looks, (icub.nominal_icub(), icub.RIGHT_ARM)
    ),
    "contour_tracker": Stepper(
        ContourTracker(hand(), seeds=16, keys=2), looks, (icub.nominal_icub(), icub.RIGHT_ARM)
    ),
    "watched_images": Stepper(
        WatchedImages(
            icub.nominal_icub(), icub.RIGHT_ARM, icub.HAND, ParticleFilter(hand(), particles=12)
        ),
        looks,
    ),
    "body_finder": Stepper(BodyFinder(("turn",)), frames, ((192, 144),)),
    "onset_coincidence": Stepper(OnsetCoincidence(("turn",)), frames, ((192, 144),)),
    "monitor": Stepper(Monitor(LINEAR), linear),
    "monitored_load": Stepper(Monitor(LoadLearner()), means),
    "monitored_smoother": Stepper(
        Monitor(WatchedSmoother(ARM, FREE, (TOOL,), Smoother(12)), samples=50.0), tips
    ),
    "monitored_hand_eye": Stepper(Monitor(HandEyePoints(stereo(), buffer=40)), tracked),
}
