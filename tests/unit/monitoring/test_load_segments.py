"""Stretches of a wrist's recording and the loads in them; the lag of its clock."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.payload.clock_lag import shifted
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.monitoring.load_segments import (
    declared_segments,
    found_segments,
    on_one_clock,
)
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_declaration import LoadSegments
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.loads import (
    Held,
    draw_load,
    draw_motion,
    draw_sensor,
    joined,
    record,
    wire_box,
)

MEANS = Averaging().means


@pytest.fixture(scope="module")
def grasp() -> WristSamples:
    """A gripper that takes a box after twelve seconds."""
    rng = np.random.default_rng(7)
    grip = draw_load(rng, 0.4)
    motion, sensor = draw_motion(rng, 20.0, 0.5, 100.0), draw_sensor(rng, 0.02)
    return record(motion, [Held(0.0, grip), Held(12.0, joined(grip, wire_box()))], sensor, rng)


def test_a_grasp_cuts_the_recording(grasp: WristSamples) -> None:
    events, parts = found_segments(MEANS(grasp), LoadLearner())
    assert [event.event for event in events] == ["identified", "grasp"]
    assert [part.loads for part in parts] == [("load 1",), ("load 2",)]
    assert parts[0].means.time[-1] < 12.0 < parts[1].means.time[0]


def test_declared_segments_tell_gripper_and_object_apart(grasp: WristSamples) -> None:
    parts = declared_segments(grasp, LoadSegments((0.0, 11.0), ([13.0, 16.0], [17.0, 20.0])), MEANS)
    assert [part.loads for part in parts] == [("gripper",), *[("gripper", "object")] * 2]
    alone = declared_segments(grasp, LoadSegments(loaded=(13.0, 20.0)), MEANS)
    assert [part.loads for part in alone] == [("load",)]
    both = declared_segments(grasp, LoadSegments(), MEANS, grasp)
    assert [part.loads for part in both] == [("gripper",), ("gripper", "object")]


@pytest.mark.parametrize("span", [(5.0, 1.0), (1.0,), (90.0, 99.0)])
def test_a_segment_that_is_none_is_refused(grasp: WristSamples, span: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match="segment loaded"):
        declared_segments(grasp, LoadSegments(loaded=span), MEANS)


def test_a_late_wrench_is_put_on_the_clock_of_the_motion() -> None:
    rng = np.random.default_rng(5)
    motion, sensor = draw_motion(rng, 10.0, 0.5, 100.0), draw_sensor(rng, 0.01)
    samples = record(motion, [Held(0.0, wire_box())], sensor, rng)
    late = shifted(samples, -0.03)
    mended, lag = on_one_clock(late, LoadLearner(), Averaging())
    assert lag == pytest.approx(0.03, abs=0.002)
    assert len(mended) < len(late)
    same, none = on_one_clock(samples, LoadLearner(), Averaging())
    assert none == 0.0
    assert same is samples
