"""A calibration watched through a recording: the moment, the part and the size of a change."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.solver import Solver
from bodyschema.estimation.stream_noise import measured
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.monitoring.stream_check import check_stream, is_stream
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense, concatenate
from simulated import free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]

SENSES = {"points": points, "poses": poses}
BEGIN = 100.0
"""s: the recording's clock does not start at zero."""


def moving(n: int, body: Body, rng: np.random.Generator) -> Array:
    """A smooth motion, 30 samples a second, (n, n_joints)."""
    t = np.arange(n)[:, None] / 30
    turns = rng.uniform(0.15, 0.5, (1, len(body.joints)))
    return 1.2 * np.sin(2 * np.pi * turns * t + rng.uniform(0, 6, (1, len(body.joints))))


def calibrated(sense: str, seed: int) -> tuple[Body, Estimate, np.random.Generator]:
    """An arm and its calibration from 60 postures."""
    rng = np.random.default_rng(seed)
    truth = seen_arm(5, rng)
    seen = SENSES[sense](truth, postures(60, truth, rng), rng)
    variables = free_all(truth, turns=sense == "poses")
    return truth, Solver().fit(truth, variables, [seen]), rng


def timed(sense: Sense) -> Sense:
    """With times and rows of one recording."""
    n = len(sense)
    arrays = {name: getattr(sense, name) for name in sense.arrays}
    arrays |= {"time": BEGIN + np.arange(n) / 30, "rows": np.arange(n)}
    return type(sense)(
        seen_from=sense.seen_from, seen=sense.seen, covariance=sense.covariance, **arrays
    )


def recorded(sense: str, bodies: list[tuple[Body, int]], rng: np.random.Generator) -> Sense:
    """One stream during which the body becomes another."""
    n = sum(count for _, count in bodies)
    q, first, parts = moving(n, bodies[0][0], rng), 0, []
    for body, count in bodies:
        parts.append(SENSES[sense](body, q[first : first + count], rng))
        first += count
    return timed(concatenate(parts))


@pytest.mark.parametrize("sense", SENSES)
def test_a_joint_that_jumps_is_named_dated_and_measured(sense: str) -> None:
    truth, estimate, rng = calibrated(sense, 1)
    zeros = free_joints(truth, ("offsets",))
    joint = truth.joints[2]
    jump = np.deg2rad(1.0) * (np.arange(5) == 2)
    moved = truth.with_variables(zeros, jump)
    answer = check_stream(estimate, [recorded(sense, [(truth, 300), (moved, 300)], rng)])
    (change,) = answer.changes
    assert change.part == joint
    assert abs(change.row - 300) <= 3
    assert change.time == pytest.approx(BEGIN + change.row / 30)
    assert 0 <= change.noticed - BEGIN - 10 < 1.5
    assert change.names == (f"{joint}.offset",)
    assert abs(change.change[0] - jump[2]) < 3 * change.std[0]
    assert change.std[0] < 2e-3
    assert change.p_value < 1e-6


def test_a_tool_that_slips_is_named() -> None:
    truth, estimate, rng = calibrated("points", 2)
    k = truth.frame_index("tool")
    T = truth.placement[k].copy()
    T[:3, 3] += (0.02, -0.01, 0.015)
    moved = truth.with_placement("tool", T)
    answer = check_stream(estimate, [recorded("points", [(truth, 300), (moved, 400)], rng)])
    (change,) = answer.changes
    assert change.part == "tool"
    assert abs(change.row - 300) <= 3
    assert np.abs(np.array(change.change) - (0.02, -0.01, 0.015)).max() < 3e-3


def test_a_change_before_the_recording_is_dated_at_its_start() -> None:
    truth, estimate, rng = calibrated("points", 3)
    zeros = free_joints(truth, ("offsets",))
    moved = truth.with_variables(zeros, np.deg2rad(2.0) * (np.arange(5) == 1))
    answer = check_stream(estimate, [recorded("points", [(moved, 400)], rng)])
    assert answer.changes[0].part == truth.joints[1]
    assert answer.changes[0].row <= 3


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sense", SENSES)
def test_an_unchanged_body_stays_true(sense: str, seed: int) -> None:
    truth, estimate, rng = calibrated(sense, 10 + seed)
    answer = check_stream(estimate, [recorded(sense, [(truth, 600)], rng)])
    assert answer.changes == ()
    assert answer.seconds == pytest.approx(599 / 30)


def test_noise_is_measured_whatever_changes() -> None:
    """Correlation and size of AR(1) noise, while the parameters jump in the middle."""
    rng = np.random.default_rng(0)
    n, r = 3000, 0.8
    noise = np.zeros((n, 3))
    for i in range(1, n):
        noise[i] = r * noise[i - 1] + np.sqrt(1 - r * r) * rng.normal(size=3)
    t = np.arange(n)[:, None, None] / 30
    J = np.sin(t * rng.uniform(0.5, 3, (1, 3, 6)) + rng.uniform(0, 6, (1, 3, 6)))
    jump = (np.arange(n) > 1600)[:, None] * (J @ rng.normal(size=6) * 20)
    found = measured([1.5 * noise + jump], [J])
    assert found.correlation == pytest.approx(r, abs=0.08)
    assert found.level == pytest.approx(1.5**2, rel=0.25)


def test_postures_are_no_stream() -> None:
    truth, _, rng = calibrated("points", 4)
    few = points(truth, postures(60, truth, rng), rng)
    assert isinstance(few, Points)
    assert not is_stream([few])
    assert is_stream([recorded("points", [(truth, 300)], rng)])
