"""Lines that were taken one after the other: told where corners move, and not blamed otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.answers.rolling_shutter import rolling_shutters
from bodyschema.estimation.problem import Problem
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import pixels
from bodyschema.model.parts import clock, lens
from bodyschema.senses.pixels import Pixels
from bodyschema.simulation.wrist_camera import WristCamera, simulate_wrist_camera, with_camera
from bodyschema.vision.targets.target import Target

K = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
CORNERS = Target("charuco", 7, 5, 0.02, 0.015, "4X4_50").corners - [0.07, 0.05, 0.0]
LINE = 60e-6


def fitted(tau: float, lag: float = 0.0, clocked: bool = False) -> tuple[bs.Estimate, Pixels]:
    """An arm in motion that sees a board, lines `tau` s apart and stamps `lag` s late."""
    recorded = simulate_wrist_camera(WristCamera(25, 3, 0.0))
    body = with_camera(recorded.believed).with_part("lens", lens(Camera("c", "c", 640, 480, K)))
    body = body.with_part("clock", clock())
    chosen = np.arange(25, len(recorded.joints.q) - 25, 40)
    q, time = recorded.joints.q[chosen], recorded.joints.time[chosen]
    rate = np.gradient(recorded.joints.q, recorded.joints.time, axis=0)[chosen]
    each = np.repeat(np.arange(len(q)), len(CORNERS))
    target, image = np.tile(CORNERS, (len(q), 1)), np.zeros((len(each), 2))
    for _ in range(4):
        taken = q[each] + rate[each] * (tau * (image[:, 1] - 240) - lag)[:, None]
        T = relative_pose(body, taken, "camera", "board")
        image = pixels(
            body.part("lens").values, np.einsum("nij,nj->ni", T[:, :3, :3], target) + T[:, :3, 3]
        )
    noisy = image + 0.1 * np.random.default_rng(0).normal(size=image.shape)
    sense = Pixels.make(
        q[each], noisy, "camera", "board", "lens", target, time=time[each], rows=each,
        rate=rate[each], clock="clock" if clocked else "",
    )  # fmt: skip
    parts = {"lens": None, **({"clock": None} if clocked else {})}
    frames = {"camera": "roughly", "board": "roughly"}
    problem = Problem(body, (sense,), frames, recorded.believed.joints[1:-1], parts=parts)
    return problem.fit(problem.variables(("offsets",)), (sense,)), sense


def test_lines_of_a_moving_board_tell_the_shutter() -> None:
    fit, sense = fitted(LINE)
    (said,) = rolling_shutters(fit, [sense])
    assert said.startswith("The lines of the pictures of 'camera'")
    told = float(said.split(" us a line")[0].split(", ")[1].split(" ±")[0])
    assert told == pytest.approx(1e6 * LINE, rel=0.1)


def test_a_whole_picture_at_once_is_not_blamed() -> None:
    fit, sense = fitted(0.0)
    assert rolling_shutters(fit, [sense]) == ()


def test_a_late_clock_is_no_shutter() -> None:
    fit, sense = fitted(0.0, lag=0.03, clocked=True)
    assert rolling_shutters(fit, [sense]) == ()
    fit, sense = fitted(0.0, lag=0.03)
    assert all(said.startswith("Perhaps") for said in rolling_shutters(fit, [sense]))


def test_a_shutter_that_hardly_matters_is_not_worth_a_word() -> None:
    """0.2 us a line are certain, and explain hardly anything of what is left."""
    fit, sense = fitted(2e-7)
    assert rolling_shutters(fit, [sense]) == ()


def test_lines_that_disagree_from_picture_to_picture_are_no_shutter() -> None:
    """Pictures sheared to and fro: one slope explains some of it by chance, each another thing."""
    fit, sense = fitted(0.0)
    sense = sense.take(sense.rows < 25)
    linear = sense.linearize(fit.reference, fit.variables, fit.x)
    assert sense.rate is not None
    speed = -np.einsum("nij,nj->ni", linear.by_joint, sense.rate)
    by_line = speed * (sense.observed[:, 1] - sense.observed[:, 1].mean())[:, None]
    for seed in (1, 4, 5):
        shear = LINE * np.random.default_rng(seed).normal(size=25)[sense.rows]
        sheared = replace(sense, observed=sense.observed + shear[:, None] * by_line)
        assert rolling_shutters(replace(fit, outliers=()), [sheared]) == ()


def test_a_clock_that_explains_more_leaves_a_perhaps() -> None:
    fit, sense = fitted(20e-6, lag=0.03)
    (said,) = rolling_shutters(fit, [sense])
    assert said.startswith("Perhaps lines")


def test_an_arm_at_rest_tells_nothing() -> None:
    fit, sense = fitted(LINE)
    still = replace(sense, rate=np.zeros_like(sense.q))
    assert rolling_shutters(fit, [still]) == ()
    assert rolling_shutters(fit, [replace(sense, rate=None)]) == ()
