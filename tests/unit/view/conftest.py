"""An arm whose answer is looked at: seen as a point and as a pose, with names that bite."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from bodyschema import Answer, Body, calibrate, lie
from bodyschema.model.tree import Visual
from bodyschema.senses.sense import Sense
from bodyschema.view.scene import Scene, scene_of
from simulated import points, poses, postures

NASTY = "</script ><img onerror=alert(1)>"
"""A joint's and a frame's name that would run, if it ever were markup."""


@dataclass(frozen=True)
class Seen:
    """An answer with what it was made from."""

    answer: Answer
    senses: Sequence[Sense]
    visuals: tuple[Visual, ...]

    def scene(self, **changes: Any) -> Scene:
        given = {"senses": self.senses, "visuals": self.visuals, **changes}
        return scene_of(self.answer, "A title", **given)


@pytest.fixture(scope="session")
def seen() -> Seen:
    """Offsets of four joints are wrong; row 7 is an outlier."""
    rng = np.random.default_rng(3)
    nominal = Body.random_chain(4, rng)
    joint = f"joint {NASTY}"
    nominal = replace(
        nominal,
        joints=(joint, *nominal.joints[1:]),
        carriers=("", joint, *nominal.carriers[2:]),
    )
    body = nominal.attach(NASTY, "base").attach("tool", "tip")
    T_base_camera = lie.transform(lie.exp_so3([0.3, -2.0, 0.5]), [0.2, 1.0, 0.7])
    truth = replace(body, offset=rng.uniform(-0.08, 0.08, 4)).with_placement(NASTY, T_base_camera)
    q = postures(30, body, rng)
    seen = points(truth, q, rng, 1e-3, NASTY, "tool")
    seen.position[7] += 0.3
    posed = poses(truth, q, rng, (1e-3, 3e-3), NASTY, "tool")
    answer = calibrate(body, [seen, posed], {NASTY: "no"}, ["offsets"], folds=3)
    box = Visual(nominal.frames[1], np.eye(4), "box", (0.05, 0.05, 0.2))
    return Seen(answer, (seen, posed), (box,))
