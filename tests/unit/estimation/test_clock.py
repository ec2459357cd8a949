"""Rows seen after the robot had begun to move on are found, and only those."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.clock import (
    FALSE_ALARM,
    SHUFFLES,
    ClockCheck,
    _by_row,
    chance,
    check_clock,
)
from bodyschema.estimation.solver import Solver
from bodyschema.model.variables import free_joints
from bodyschema.senses.sense import Sense
from simulated import points, poses, postures, seen_arm

Array = NDArray[np.float64]
SENSES = {"points": points, "poses": poses}
ROWS = 40


def recorded(kinds: list[str], seed: int, late: list[int], share: float) -> ClockCheck:
    """The check of a recording in which some rows were seen a share of the next step later."""
    rng = np.random.default_rng(seed)
    body = seen_arm(5, rng)
    body = body.attach("other", "link_3")
    q = postures(ROWS, body, rng)
    true = q.copy()
    true[late] += share * (q[np.array(late, dtype=int) + 1] - q[late])
    senses: list[Sense] = []
    for kind, seen in zip(kinds, ("tool", "other"), strict=False):
        senses.append(replace(SENSES[kind](body, true, rng, seen=seen), q=q))
    fit = Solver().fit(body, free_joints(body, ["offsets"]), senses)
    return check_clock(fit, senses)


@pytest.mark.parametrize("kinds", [["points"], ["poses"], ["points", "poses"]])
@pytest.mark.parametrize("seed", range(4))
def test_late_rows_are_found_and_named(seed: int, kinds: list[str]) -> None:
    late = np.sort(np.random.default_rng(seed).choice(ROWS - 1, 9, replace=False)).tolist()
    check = recorded(kinds, seed, late, 0.05)
    assert check.faulty
    assert check.p_value < 0.005
    assert len(set(late) & set(check.late_rows)) >= 8
    # z > 0 by chance costs an honest row its name now and then; most are cleared.
    assert len(set(check.late_rows) - set(late)) <= 6


@pytest.mark.parametrize("sense", SENSES)
def test_without_a_fault_p_values_are_as_good_as_random(sense: str) -> None:
    p = np.array([recorded([sense], seed, [], 0.0).p_value for seed in range(40)])
    assert np.sum(p < FALSE_ALARM) <= 2
    assert np.sum(p < 0.1) <= 9
    assert 0.35 < p.mean() < 0.65
    assert p.max() > 0.8


def test_an_honest_recording_has_no_late_rows() -> None:
    check = recorded(["points"], 3, [], 0.0)
    assert not check.faulty
    assert check.late_rows == ()


def test_few_rows_are_not_judged() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    seen = [points(body, postures(10, body, rng), rng)]
    fit = Solver().fit(body, free_joints(body, ["offsets"]), seen)
    assert check_clock(fit, seen) == ClockCheck(1.0, ())


def test_the_same_seed_gives_the_same_answer() -> None:
    assert recorded(["points"], 1, [3, 8], 0.1) == recorded(["points"], 1, [3, 8], 0.1)


def test_a_robot_that_stood_still_is_no_fault() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    seen = [points(body, np.tile(postures(1, body, rng), (20, 1)), rng)]
    fit = Solver().fit(body, free_joints(body, ["offsets"]), seen)
    assert check_clock(fit, seen).p_value == 1.0


def several(counts: Array, late: list[int], seed: int) -> ClockCheck:
    """As `recorded`, each row, from 100, seen in so many samples, as a picture's corners are."""
    rng = np.random.default_rng(seed)
    body = seen_arm(5, rng)
    q = postures(len(counts), body, rng)
    true = q.copy()
    true[late] += 0.05 * (q[np.array(late, dtype=int) + 1] - q[late])
    rows = np.repeat(np.arange(len(counts)), counts)
    seen = replace(points(body, true[rows], rng), q=q[rows], rows=rows + 100)
    fit = Solver().fit(body, free_joints(body, ["offsets"]), [seen])
    return check_clock(fit, [seen])


@pytest.mark.parametrize("seed", range(3))
def test_samples_of_one_row_are_one_row(seed: int) -> None:
    rng = np.random.default_rng(seed)
    late = np.sort(rng.choice(ROWS - 1, 9, replace=False)).tolist()
    check = several(rng.integers(2, 8, ROWS), late, seed)
    assert check.p_value < 0.005
    assert len({row + 100 for row in late} & set(check.late_rows)) >= 8


def test_an_honest_recording_of_many_samples_a_row_is_no_fault() -> None:
    rng = np.random.default_rng(0)
    p = np.array([several(rng.choice([1, 12], ROWS), [], seed).p_value for seed in range(30)])
    assert np.sum(p < 0.1) <= 7
    assert 0.35 < p.mean() < 0.65


def test_a_row_of_many_samples_has_the_noise_of_one() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(5, rng)
    counts = np.tile([1, 4, 25], 200)
    rows = np.repeat(np.arange(600), counts)
    q = postures(600, body, rng)[rows]
    seen = replace(points(body, q, rng), rows=rows)
    fit = Solver().fit(body, free_joints(body, ()), [seen])
    batch = _by_row(fit, seen, fit.levels[0])
    assert batch.rows.tolist() == list(range(600))
    assert (batch.q == q[np.searchsorted(rows, np.arange(600))]).all()
    for count in (1, 4, 25):
        assert np.std(batch.residual[counts == count]) == pytest.approx(1.0, abs=0.1)
    # n samples show a motion as clearly as one would whose noise is smaller by the root of n.
    single = _by_row(fit, seen.take(np.flatnonzero(rows < 3)), fit.levels[0]).slope
    alone = _by_row(fit, seen.take(np.searchsorted(rows, [0, 1, 2])), fit.levels[0]).slope
    assert single == pytest.approx(alone * np.sqrt([1.0, 4.0, 25.0])[:, None, None])


@pytest.mark.parametrize(("kept", "tested"), [(0.5, 40), (0.95, 38)])
def test_a_sense_of_fewer_rows_is_left_out_or_joined(kept: float, tested: int) -> None:
    """Poses of half of the rows must not hide late rows of the other half (SHARED)."""
    rng = np.random.default_rng(2)
    body = seen_arm(5, rng).attach("other", "link_3")
    q = postures(ROWS, body, rng)
    late = list(range(20, 39, 2))
    true = q.copy()
    true[late] += 0.05 * (q[np.array(late) + 1] - q[late])
    all_rows = replace(points(body, true, rng), q=q)
    few = replace(poses(body, true, rng, seen="other"), q=q).take(np.arange(round(kept * ROWS)))
    fit = Solver().fit(body, free_joints(body, ["offsets"]), [few, all_rows])
    check = check_clock(fit, [few, all_rows])
    assert check.p_value < 0.005
    assert len({row for row in late if row < tested - 1} & set(check.late_rows)) >= 7
    assert max(check.late_rows) < tested


def unit(motion: Array) -> Array:
    return np.asarray(motion / np.linalg.norm(motion, axis=1, keepdims=True))


@pytest.mark.parametrize("late", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_the_chance_is_that_of_all_shuffles(seed: int, late: float) -> None:
    rng = np.random.default_rng(seed)
    motion = unit(rng.normal(size=(60, 3)))
    residual = rng.normal(size=(60, 3)) + late * motion

    def agreement(order: NDArray[np.int64]) -> float:
        z = np.sum(residual[order] * motion, axis=1)
        return float(np.sum(np.maximum(z, 0) ** 2))

    real = agreement(np.arange(60))
    reached = np.sum([agreement(rng.permutation(60)) >= real for _ in range(SHUFFLES)])
    expected = (reached + 1) / (SHUFFLES + 1)
    p_value, spread = chance(residual, motion, np.random.default_rng(seed))
    assert abs(p_value - expected) < 0.002 + 0.5 * expected
    assert spread == pytest.approx(1.0, abs=0.15)


def slow(n: int, columns: int, rng: np.random.Generator) -> Array:
    """Numbers that change slowly along a recording, (n, columns)."""
    turns = rng.uniform(1, 6, columns) * np.arange(n)[:, None] / n
    return np.asarray(np.sin(2 * np.pi * (turns + rng.random(columns))))


@pytest.mark.parametrize("error", [0.0, 1.0, 3.0], ids=["exact", "bent", "very-bent"])
def test_a_smooth_movement_of_a_wrong_model_is_no_fault(error: float) -> None:
    """False alarms of a model error that changes as slowly as the movement does."""
    p = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        residual = rng.normal(size=(300, 3)) + error * slow(300, 3, rng)
        p.append(chance(residual, unit(slow(300, 3, rng)), rng)[0])
    # 1 % is promised; permuting single rows would alarm in up to 17 %.
    assert np.mean(np.array(p) < FALSE_ALARM) <= 0.04


def test_the_memory_is_that_of_a_few_shuffles() -> None:
    rng = np.random.default_rng(0)
    residual, motion = rng.normal(size=(50_000, 3)), unit(rng.normal(size=(50_000, 3)))
    tracemalloc.start()
    chance(residual, motion, rng)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6
