"""The monitor: a change is found and blamed on the right part, the arm stays, no false alarms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.learners.learner import run
from bodyschema.learners.smoother import Foresight, Smoother
from bodyschema.monitoring.innovations import LONGEST, Candidate, InnovationTest
from bodyschema.monitoring.link_change import NOTHING, LinkMonitor, log_likelihood
from bodyschema.studies.held_tool import CANDIDATES, TIP, Change, Setting, arm, freed
from bodyschema.studies.tool_runs import changing, steps_below
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
    monitor = LinkMonitor(CANDIDATES)
    state = monitor.start(arm(), freed(True))
    ratios = []
    for _, report in run(monitor, state, [scene.seen]):
        assert not report.alarm
        ratios.append(report.ratio)
    assert 0.4 < max(ratios) < 1


def test_an_alarm_without_a_change_ends_with_nothing_blamed() -> None:
    """With a level so low that chance alone passes it."""
    monitor = LinkMonitor(CANDIDATES, chance=0.02, longest=60)
    scene = SETTING.scene(np.random.default_rng(5), 350)
    state = monitor.start(arm(), freed(True))
    reports = [report for _, report in run(monitor, state, [scene.seen])]
    verdicts = [report.verdict for report in reports if report.verdict]
    assert sum(report.alarm for report in reports) >= len(verdicts) > 2
    assert set(verdicts) == {NOTHING}


def test_a_camera_that_turned_is_told_from_a_bent_tool_by_poses() -> None:
    """Candidates are any parameters and senses are any: here six of a frame, seen as poses."""
    rng = np.random.default_rng(4)
    nominal = seen_arm(4, rng)
    variables = free_all(nominal)
    parts = {
        frame: tuple(n for n in variables.names if n.startswith(f"{frame}."))
        for frame in ("tracker", "tool")
    }
    monitor = LinkMonitor(tuple(Candidate(name, rows, 0.1) for name, rows in parts.items()))
    q = postures(160, nominal, rng)
    for part in parts:
        x = np.zeros(len(variables))
        x[[variables.names.index(name) for name in parts[part]]] = 0.01 * rng.normal(size=6)
        changed = nominal.with_variables(variables, x)
        before, after = poses(nominal, q[:100], rng), poses(changed, q[100:], rng)
        quiet = list(run(monitor, monitor.start(nominal, variables), [before]))
        assert not any(report.alarm for _, report in quiet)
        states, reports = zip(*run(monitor, quiet[-1][0], [after]), strict=True)
        assert [report.verdict for report in reports if report.verdict] == [part]
        assert next(k for k, report in enumerate(reports) if report.alarm) < 6
        estimate = states[-1].estimate
        gap = (estimate.x - x) / estimate.std
        assert np.abs(gap).max() < 5


def test_the_statistic_is_that_of_the_definition() -> None:
    """Against sums over the whole history, for two candidates of different size."""
    rng = np.random.default_rng(0)
    nominal = seen_arm(3, rng)
    variables = free_all(nominal)
    candidates = (
        Candidate("offset", ("joint_2.offset",), 0.2, odds=3.0),
        Candidate("tool", tuple(f"tool.link_{c}" for c in "xyz"), 0.1),
    )
    test = InnovationTest.of(candidates, variables, 0.01)
    state, history = test.start(), []
    for t in range(40):
        u, J = 2 * rng.normal(size=3), rng.normal(size=(3, len(variables)))
        state, finding = test.step(state, Foresight(u, u, J, 0.0))
        history.append((u * min(1, 3 / np.linalg.norm(u)), J))
        best = (0.0, 0, 0)
        for c, candidate in enumerate(candidates):
            rows = candidate.rows(variables)
            for w in range(2, min(t + 1, LONGEST) + 1):
                s = sum(J[:, rows].T @ v for v, J in history[-w:])
                F = sum(J[:, rows].T @ J[:, rows] for _, J in history[-w:])
                F = F + np.eye(len(rows)) / candidate.spread**2
                best = max(best, (s @ np.linalg.solve(F, s) / test.level[c], c, w))
        assert finding.ratio == pytest.approx(best[0], rel=1e-9)
        if t:
            assert (finding.candidate, finding.window) == best[1:]


def test_an_outlier_costs_every_explanation_the_same() -> None:
    wild = np.full(3, 50.0)
    near, far = (Foresight(wild, wild, np.zeros((3, 1)), volume) for volume in (0.0, 5.0))
    assert log_likelihood(near) == pytest.approx(log_likelihood(far), abs=1e-9)
    good = Foresight(0 * wild, 0 * wild, np.zeros((3, 1)), 1.0)
    assert log_likelihood(good) == pytest.approx(-1.0, abs=1e-3)


def test_a_candidate_that_is_not_learnt_is_refused() -> None:
    monitor = LinkMonitor((replace(CANDIDATES[0], members=("tip.lnk_x",)),))
    with pytest.raises(InputError, match=r"'tool' has the parameter 'tip\.lnk_x'.*tip\.link_x"):
        monitor.start(arm(), freed(True))


def test_a_window_too_short_for_the_test_is_refused() -> None:
    with pytest.raises(InputError, match=r"16 samples.*last 31"):
        LinkMonitor(CANDIDATES, Smoother(16)).start(arm(), freed(True))


def test_steps_below_counts_from_the_last_time_above() -> None:
    assert steps_below([3, 1, 3, 1, 1], 2) == 4
    assert steps_below([1, 1], 2) == 1
    assert steps_below([3, 1, 3], 2) is None
