"""A load on a wrist: changes noticed though small or slow, named right, and nothing else called."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import Inertia
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.wrench_means import Averaging
from bodyschema.simulation.loads import (
    RATE,
    Held,
    draw_load,
    draw_motion,
    draw_sensor,
    joined,
    record,
)

Events = list[tuple[float, str, Inertia | None]]


def felt(
    seed: int, held: list[Held], seconds: float, push: float = 0.0, speed: float = 0.5
) -> Events:
    """What the watch says, with its times; a push of so many newtons at 8 s for 0.6 s."""
    rng = np.random.default_rng([5, seed])
    motion = draw_motion(rng, seconds, speed, RATE)
    samples = record(motion, held, draw_sensor(rng, 0.02), rng)
    touched = (samples.time > 8.0) & (samples.time < 8.6)
    samples.wrench[touched, :3] += push
    means, monitor = Averaging().means(samples), Monitor(LoadLearner())
    state, events = monitor.start(), []
    for k in range(len(means)):
        state, info = monitor.step(state, (means.take(slice(k, k + 1)),))
        if info.event:
            events.append((float(means.time[k]), info.change or info.event, state.belief.load))
    return events


def gripper(seed: int, mass: float = 0.5) -> Inertia:
    return draw_load(np.random.default_rng([6, seed]), mass)


def thing(seed: int, mass: float) -> Inertia:
    return draw_load(np.random.default_rng([7, seed]), mass)


def taken(grip: Inertia, what: Inertia, since: float, over: float) -> list[Held]:
    """A grasp that takes a while: more and more of the weight hangs on the hand."""
    shares = np.linspace(0, 1, 13)[1:]
    return [
        Held(
            since + over * (share - shares[0]),
            joined(grip, Inertia(share * what.mass, what.com, share * what.moments)),
        )
        for share in shares
    ]


def test_a_thing_of_three_grams_taken_soon_is_noticed() -> None:
    """It shows late, and must not have been learned by then as if it were the gripper."""
    noticed = 0
    for seed in range(5):
        grip = gripper(seed)
        events = felt(seed, [Held(0, grip), Held(4.0, joined(grip, thing(seed, 0.003)))], 9.0)
        noticed += any(event == "alarm" and t > 3.7 for t, event, _ in events)
    assert noticed >= 4


@pytest.mark.parametrize("mass", [0.1, 0.3])
def test_a_grasp_that_takes_a_while_is_one_change(mass: float) -> None:
    for seed in range(2):
        grip = gripper(seed)
        events = felt(seed, [Held(0, grip), *taken(grip, thing(seed, mass), 8.0, 0.4)], 14.0)
        assert [event for _, event, _ in events] == ["identified", "alarm", "grasp"]
        load = events[-1][2]
        assert load is not None
        assert load.mass - grip.mass == pytest.approx(mass, abs=0.002)
        assert events[1][0] < 8.5


def test_a_push_is_no_load() -> None:
    for seed, mass in ((0, 0.5), (0, 0.1), (1, 0.1), (2, 0.1), (3, 0.1)):
        events = felt(seed, [Held(0, gripper(seed, mass))], 18.0, push=2.0)
        assert [event for _, event, _ in events[:2]] == ["identified", "alarm"]
        assert {event for _, event, _ in events[2:]} <= {"alarm", "same"}
        assert events[-1][1] == "same"


def test_the_same_weight_held_elsewhere_is_a_shift_and_its_return_too() -> None:
    grip, what = gripper(0), thing(0, 0.4)
    moved = Inertia(what.mass, what.com + np.array([0.0, 0.03, 0.0]), what.moments)
    held = [Held(0, joined(grip, what)), Held(8.0, joined(grip, moved))]
    assert [event for _, event, _ in felt(0, held, 14.0)] == ["identified", "alarm", "shift"]


def test_swap_and_release_are_told_from_a_grasp() -> None:
    grip = gripper(1)
    held = [Held(0, grip)]
    held += [Held(8.0, joined(grip, thing(1, 0.2))), Held(14.0, joined(grip, thing(2, 0.7)))]
    held += [Held(20.0, joined(grip, thing(1, 0.2))), Held(26.0, grip)]
    told = [event for _, event, _ in felt(1, held, 32.0) if event != "alarm"]
    assert told == ["identified", "grasp", "swap", "swap", "release"]


def test_what_is_known_of_the_sensor_makes_the_next_load_known_sooner() -> None:
    needed = []
    for seed in range(5):
        grip = gripper(seed)
        events = felt(seed, [Held(0, grip), Held(8.0, joined(grip, thing(seed, 0.2)))], 16.0)
        needed.append(next(time for time, event, _ in events if event == "grasp") - 8.0)
    assert np.mean(needed) < 3.2


def test_bounds_hold() -> None:
    """99 % bounds of mass and centre: of fifteen loads felt briefly, none lies outside."""
    inside, learner = [], LoadLearner()
    for seed in range(15):
        rng, grip = np.random.default_rng([8, seed]), gripper(seed)
        motion = draw_motion(rng, 3.0, 0.5, RATE)
        samples = record(motion, [Held(0, grip)], draw_sensor(rng, 0.02), rng)
        belief, _ = learner.step(learner.start(), (Averaging().means(samples),))
        found, load = learner.certificate(belief), belief.load
        assert load is not None
        inside.append(abs(load.mass - grip.mass) / found.bounds["mass"])
        inside.append(np.linalg.norm(load.com - grip.com) / found.bounds["centre of mass"])
    assert max(inside) < 1
    assert max(inside) > 0.3


def test_what_is_taken_before_anything_is_known_is_not_mixed_with_what_was() -> None:
    for seed in range(5):
        grip = gripper(seed)
        held = [Held(0, grip), Held(1.0, joined(grip, thing(seed, 0.2)))]
        told = [load for _, event, load in felt(seed, held, 9.0) if event == "identified"]
        assert told[0] is not None
        assert told[0].mass == pytest.approx(grip.mass + 0.2, rel=0.012)


def test_nothing_is_called_while_nothing_changes() -> None:
    for seed, speed in ((100, 0.5), (101, 0.5), (102, 0.15), (103, 0.15), (104, 0.15)):
        events = felt(seed, [Held(0, gripper(seed, 1.5))], 60.0, speed=speed)
        assert [event for _, event, _ in events] == ["identified"]
