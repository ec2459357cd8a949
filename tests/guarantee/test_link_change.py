"""The link monitor: its stated chance, its patience, and what it forgets."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.learner import run
from bodyschema.learners.smoother import Foresight
from bodyschema.monitoring.innovations import Candidate, InnovationTest
from bodyschema.monitoring.link_change import NOTHING, LinkMonitor, log_likelihood
from bodyschema.studies.held_tool import CANDIDATES, TIP, Change, Setting, arm, freed
from simulated import free_all, seen_arm

SETTING = Setting(noise=0.05, outliers=0.05, motion="smooth", arm_error=1.0)


def test_candidates_share_the_stated_chance() -> None:
    rng, chance, trials, over = np.random.default_rng(0), 0.05, 3000, 0
    variables = free_all(seen_arm(4, rng))
    names = [name for name in variables.names if name.endswith("offset")]
    candidates = [Candidate(name, (name,), 100.0) for name in names]
    test = InnovationTest.of(candidates, variables, chance)
    for _ in range(trials):
        state = test.start()
        for _ in range(2):
            u, J = rng.normal(size=3), rng.normal(size=(3, len(variables)))
            state, finding = test.step(state, Foresight(u, u, J, 0.0))
        over += finding.ratio >= 1
    assert over <= trials * chance + 3 * np.sqrt(trials * chance)
    assert over > 0.3 * trials * chance


def test_outliers_raise_no_alarm() -> None:
    """With a sample in twenty off by a decimetre, and none of it taken for a change."""
    monitor = LinkMonitor(CANDIDATES)
    for seed in range(2):
        scene = SETTING.scene(np.random.default_rng(seed), 500)
        for _, report in run(monitor, monitor.start(arm(), freed(True)), [scene.seen]):
            assert not report.alarm


def test_a_belief_that_began_with_outliers_is_given_time() -> None:
    setting = Setting(noise=0.05, outliers=0.4, motion="smooth", arm_error=1.0)
    monitor, alarms = LinkMonitor(CANDIDATES, chance=1e-3), 0
    for seed in range(12):
        scene = setting.scene(np.random.default_rng(seed), 31)
        reports = run(monitor, monitor.start(arm(), freed(True)), [scene.seen])
        alarms += sum(report.alarm for _, report in reports)
    assert not alarms


def test_an_alarm_by_chance_blames_nobody() -> None:
    monitor = LinkMonitor(CANDIDATES, chance=0.02, longest=40)
    verdicts = []
    for seed in (5, 6):
        scene = SETTING.scene(np.random.default_rng(seed), 200)
        reports = run(monitor, monitor.start(arm(), freed(True)), [scene.seen])
        verdicts += [report.verdict for _, report in reports if report.verdict]
    assert len(verdicts) >= 3
    assert set(verdicts) == {NOTHING}


@pytest.mark.parametrize(("part", "size"), [("tool", 0.34), ("upper arm", 0.10)])
def test_what_changed_is_named_and_learned_anew(part: str, size: float) -> None:
    change = Change(part, size, 60)
    for seed in range(2):
        scene = SETTING.scene(np.random.default_rng(seed), 160, change)
        monitor = LinkMonitor(CANDIDATES)
        steps = list(run(monitor, monitor.start(arm(), freed(True)), [scene.seen]))
        alarms = [i for i, (_, report) in enumerate(steps) if report.alarm]
        verdicts = [report.verdict for _, report in steps if report.verdict]
        assert verdicts == [part]
        assert 60 <= alarms[0] < 75
        assert scene.miss(steps[-1][0].body, scene.places(159, TIP), TIP) < 0.02


def test_an_outlier_decides_nothing() -> None:
    wild = np.full(3, 50.0)
    near, far = (Foresight(wild, wild, np.zeros((3, 1)), volume) for volume in (0.0, 5.0))
    assert log_likelihood(near) == pytest.approx(log_likelihood(far), abs=1e-9)
