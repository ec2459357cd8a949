"""What `check` says of the size of errors: each in the unit of what was seen."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bodyschema import Body, Points, Solver, free_joints, lie
from bodyschema.answers.recheck import recheck_senses
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.monitoring.change import detect_change
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense

ENDS = ("eye", "tip")


def watched(rng: np.random.Generator) -> tuple[Body, Pixels, Points]:
    """An arm, its tip in pictures to 0.2 px an axis, and as points to 1 mm an axis."""
    arm = Body.random_chain(3, rng)
    q = rng.uniform(-1, 1, (60, 3))
    tip = relative_pose(arm, q, "base", "tip")[:, :3, 3]
    arm = arm.attach("eye", "base", lie.transform(np.eye(3), tip.mean(axis=0) - [0, 0, 3]))
    K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])
    arm = arm.with_part("lens", parts.lens(Camera("eye", "eye", 640, 480, K, np.zeros(5))))
    at = np.zeros((60, 3))
    blank = Pixels.make(q, np.zeros((60, 2)), *ENDS, "lens", at)
    image = blank.predict(arm) + 0.2 * rng.normal(size=(60, 2))
    seen = relative_pose(arm, q, *ENDS)[:, :3, 3] + 1e-3 * rng.normal(size=(60, 3))
    return arm, Pixels.make(q, image, *ENDS, "lens", at), Points.make(q, seen, *ENDS, 1e-3)


def told(arm: Body, senses: list[Sense]) -> Any:
    fit = Solver().fit(arm, free_joints(arm, ("offsets",)), senses)
    stored: Any = SimpleNamespace(check=lambda new, rate, least: detect_change(fit, new))
    return recheck_senses(stored, senses, 0.01)[0]


def test_pixels_are_no_millimetres() -> None:
    arm, pixels, points = watched(np.random.default_rng(2))
    found = told(arm, [pixels])
    assert found.test.typical["px"] == pytest.approx(0.2 * np.sqrt(2), rel=0.25)
    assert found.size == f"{found.test.typical['px']:.3f} px typical error over 60 postures"
    assert np.isnan(found.test.position_rms)
    both = told(arm, [pixels, points])
    assert both.test.position_rms == pytest.approx(1e-3 * np.sqrt(3), rel=0.25)
    assert both.size == (
        f"{both.test.typical['px']:.3f} px and {1e3 * both.test.position_rms:.2f} mm "
        "typical error over 60 postures"
    )
