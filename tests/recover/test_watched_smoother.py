"""The smoother watched: a change is found and blamed on its part, the arm stays, no alarms else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.learner import moments, run
from bodyschema.learners.smoother import Smoother
from bodyschema.learners.watched_smoother import Block, WatchedSmoother
from bodyschema.monitoring.monitor import Monitor
from bodyschema.studies.held_tool import BLOCKS, TIP, Change, Setting, arm, freed
from bodyschema.studies.tool_runs import changing, steps_below
from linear_learner import watch
from simulated import free_all, poses, postures, seen_arm

SETTING = Setting(noise=0.05, outliers=0.05, motion="smooth", arm_error=1.0)


@pytest.mark.parametrize(
    ("part", "size", "notice"),
    [("tool", 0.34, 6), ("tool", 0.10, 12), ("upper arm", 0.10, 15), ("camera", 0.10, 12)],
)
def test_a_change_is_noticed_blamed_on_its_part_and_learnt(
    part: str, size: float, notice: int
) -> None:
    elbow = []
    for seed in range(3):
        change = Change(part, size, 150)
        scene = SETTING.scene(np.random.default_rng(seed), 270, change)
        found = changing(change, scene)
        assert found["false_alarms"] == 0
        assert found["noticed"] <= notice
        assert found["blamed"] == part
        assert found["tip"]["100"] < 0.02
        elbow.append(found["elbow_after"])
    if part == "tool":
        # Only what changed was learnt anew: the elbow is hardly worse than the prior, 7 mm.
        assert np.sqrt(np.mean(np.square(elbow))) < 0.008


def test_without_the_monitor_a_dropped_tool_is_never_learnt() -> None:
    """What the monitor is for: the smoother takes all new samples for outliers."""
    change = Change("tool", 0.34, 150)
    scene = SETTING.scene(np.random.default_rng(0), 300, change)
    learner = Smoother()
    *_, (state, _) = run(learner, learner.start(arm(), freed(True)), [scene.seen])
    assert scene.miss(state.body, scene.places(299, TIP), TIP) > 0.2


def test_no_alarm_on_a_long_quiet_run() -> None:
    scene = SETTING.scene(np.random.default_rng(7), 2500)
    monitor = Monitor(WatchedSmoother(arm(), freed(True), BLOCKS), 1e5)
    _, events = watch(monitor, monitor.start(), moments([scene.seen]))
    assert [event for _, event, _ in events] == ["identified"]


def test_a_camera_that_turned_is_told_from_a_bent_tool_by_poses() -> None:
    """Blocks are any variables and senses are any: here six of a frame, seen as poses."""
    rng = np.random.default_rng(4)
    nominal = seen_arm(4, rng)
    variables = free_all(nominal)
    parts = {
        frame: tuple(n for n in variables.names if n.startswith(f"{frame}."))
        for frame in ("tracker", "tool")
    }
    blocks = tuple(Block(name, rows, 0.1) for name, rows in parts.items())
    monitor = Monitor(WatchedSmoother(nominal, variables, blocks))
    q = postures(160, nominal, rng)
    for part in parts:
        x = np.zeros(len(variables))
        x[[variables.names.index(name) for name in parts[part]]] = 0.01 * rng.normal(size=6)
        changed = nominal.with_variables(variables, x)
        before, after = poses(nominal, q[:100], rng), poses(changed, q[100:], rng)
        state, quiet = watch(monitor, monitor.start(), moments([before]))
        assert [event for _, event, _ in quiet] == ["identified"]
        state, events = watch(monitor, state, moments([after]))
        assert [(event, block) for _, event, block in events][1] == ("changed", part)
        assert events[0][0] < 6
        estimate = state.belief.estimate
        gap = (estimate.x - x) / estimate.std
        assert np.abs(gap).max() < 5


def test_a_block_that_is_not_learned_is_refused() -> None:
    wrong = replace(BLOCKS[0], members=("tip.lnk_x",))
    with pytest.raises(InputError, match=r"'tool' has the variable 'tip\.lnk_x'.*tip\.link_x"):
        WatchedSmoother(arm(), freed(True), (wrong,))


def test_steps_below_counts_from_the_last_time_above() -> None:
    assert steps_below([3, 1, 3, 1, 1], 2) == 4
    assert steps_below([1, 1], 2) == 1
    assert steps_below([3, 1, 3], 2) is None
