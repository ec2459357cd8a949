"""What everything that steps must keep: `step(state, moment) -> (state, info)`, and purity."""

from __future__ import annotations

import inspect
import pickle
from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest

pytest.importorskip("cv2")
pytest.importorskip("icub_models")

from same import same
from stepping import STEPPERS, Moments, Stepper


@pytest.fixture(scope="module", params=STEPPERS)
def stepper(request: pytest.FixtureRequest) -> Stepper:
    return STEPPERS[request.param]


@pytest.fixture(scope="module")
def stream(stepper: Stepper) -> Moments:
    return stepper.stream()


def test_it_steps_like_all_others(stepper: Stepper) -> None:
    assert list(inspect.signature(type(stepper.learner).step).parameters) == [
        "self",
        "state",
        "moment",
    ]


def test_settings_are_frozen(stepper: Stepper) -> None:
    for field in fields(stepper.learner):  # type: ignore[arg-type]
        with pytest.raises(FrozenInstanceError):
            setattr(stepper.learner, field.name, None)


def test_a_moment_is_a_tuple_and_a_step_gives_a_state_and_an_info(
    stepper: Stepper, stream: Moments
) -> None:
    state = stepper.start()
    for moment in stream[:3]:
        assert isinstance(moment, tuple)
        after = stepper.learner.step(state, moment)
        assert isinstance(after, tuple)
        assert len(after) == 2
        state = after[0]


def test_start_and_step_are_pure(stepper: Stepper, stream: Moments) -> None:
    """An old state still steps to the same result; nothing that was passed in has changed."""
    start = stepper.start()
    assert same(start, stepper.start())
    steps = [(start, None)]
    for moment in stream:
        steps.append(stepper.learner.step(steps[-1][0], moment))
    kept = pickle.dumps((steps, stream))
    for k in np.linspace(0, len(stream) - 1, 12).astype(int):
        assert same(stepper.learner.step(steps[k][0], stream[k]), steps[k + 1])
    assert pickle.dumps((steps, stream)) == kept


def test_a_state_that_was_saved_steps_on_as_before(stepper: Stepper, stream: Moments) -> None:
    state = saved = stepper.start()
    for k, moment in enumerate(stream):
        if k == len(stream) // 2:
            saved = pickle.loads(pickle.dumps(state))
        state = stepper.learner.step(state, moment)[0]
        if k >= len(stream) // 2:
            saved = stepper.learner.step(saved, moment)[0]
    assert same(saved, state)


def test_a_moment_in_which_nothing_was_seen_teaches_nothing(
    stepper: Stepper, stream: Moments
) -> None:
    if "monitor" in type(stepper.learner).__name__.lower():
        pytest.skip("a monitor counts moments")
    state = stepper.start()
    for moment in stream:
        state = stepper.learner.step(state, moment)[0]
    assert same(stepper.learner.step(state, ()), (state, ()))
