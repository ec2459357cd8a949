"""Calibrations: every fault of a recording through `bodyschema.calibrate`."""

from __future__ import annotations

from functools import partial

import numpy as np

import bodyschema as bs
from honest.drawing import draw
from honest.faults import FAULTS, Fault
from honest.scene import Scene
from honest.trial import Row, Trial

GROUPS = (None, None, ("offsets",), ("offsets", "axes", "links"))
"""What a user asks for: mostly to be told which."""

FOLDS = 3


def trial(fault: Fault, rng: np.random.Generator) -> Trial:
    """What the public function is given, and what is true of it."""
    scene = fault.change(draw(fault.plan, rng), rng)
    senses, groups = scene.senses(rng), asked(scene, rng)
    words = "free choice" if groups is None else "groups " + "+".join(groups)
    return Trial(
        f"{scene.about}, {words}",
        lambda: bs.calibrate(scene.given, senses, scene.frames, groups, folds=FOLDS),
        lambda answer: (answer.stated_95, scene.error(answer.body, rng)),
        sense=scene.sense,
    )


def asked(scene: Scene, rng: np.random.Generator) -> tuple[str, ...] | None:
    """Groups that a sensible user would name for such a robot and so much data."""
    groups = GROUPS[int(rng.integers(len(GROUPS)))]
    if groups == ("offsets",) and "offsets off" not in scene.about:
        return None
    numbers = len(scene.motion) * {"points": 3, "poses": 6, "pixels": 2}[scene.sense]
    needed = 6 * len(scene.arm.home) + 12
    return None if groups is not None and len(groups) > 1 and numbers < 2 * needed else groups


ROWS = tuple(
    Row("calibrate", fault.name, partial(trial, fault), fault.good, fault.apart, fault.weight)
    for fault in FAULTS
)
