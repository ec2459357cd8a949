"""The odds of cells whose flow is made up here: driven by joints, moving by themselves, still."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.attention.contingency import Contingency, called_me, probability, weigh
from bodyschema.attention.visual_jacobian import MotionSums, empty, faded, joined

J, LAGS, LAG = 4, 4, 2
PRECISION = 1 / 100.0**2
NOISE = 0.03
"""pixels/frame"""
KINDS = ("driven", "swing", "wander", "imitator", "still")
EACH = 40
OWN, NONE = np.arange(J), np.array([], dtype=np.int64)


def motions(rng: np.random.Generator, count: int) -> list[np.ndarray]:
    """(n, J) rad a frame: rests of 15 frames, then a smooth bump of a random set of joints."""
    found = []
    for _ in range(count):
        s = np.linspace(0, 1, 20)
        bump = np.diff(s**3 * (10 - 15 * s + 6 * s * s))
        turn = rng.uniform(0.05, 0.15, J) * rng.choice([-1, 1], J) * (rng.uniform(size=J) < 0.6)
        turn[rng.integers(J)] = 0.1
        found.append(np.vstack([np.zeros((15, J)), bump[:, None] * turn, np.zeros((12, J))]))
    return found


def flows(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """(n, cells, 2) pixels/frame of EACH cells of every kind, along a whole course x (n, J)."""
    n, time = len(x), np.arange(len(x)) / 30
    K = rng.uniform(30, 150, (EACH, 2, J)) * rng.choice([-1, 1], (EACH, 2, J))
    late = np.vstack([np.zeros((LAG, J)), x[:-LAG]])
    later = np.vstack([np.zeros((20, J)), x[:-20]])
    driven = np.einsum("tj,ncj->tnc", late, K)
    imitator = np.einsum("tj,ncj->tnc", later, K)
    rate, phase = rng.uniform(0.3, 1.2, EACH), rng.uniform(0, 6.28, (EACH, 1))
    swing = 2.0 * np.cos(2 * np.pi * rate * time[:, None] + phase[:, 0])[..., None] * [1.0, 0.4]
    steps = np.repeat(rng.normal(size=(n // 15 + 1, EACH, 2)), 15, axis=0)[:n]
    y = np.concatenate([driven, swing, steps, imitator, np.zeros((n, EACH, 2))], axis=1)
    return y + NOISE * rng.normal(size=y.shape)


def judged(seed: int, count: int) -> tuple[Contingency, MotionSums, np.ndarray]:
    """Odds and belief after some motions, and each motion's score of the lags."""
    rng = np.random.default_rng(seed)
    parts = motions(rng, count)
    x = np.vstack(parts)
    y = flows(rng, x)
    cells = y.shape[1]
    belief, odds, scores, at = empty(LAGS, J, cells), Contingency(np.zeros((LAGS, cells))), [], 0
    for part in parts:
        sums = empty(LAGS, J, cells)
        for t in range(at, at + len(part)):
            delayed = np.array([x[t - lag] if t >= lag else np.zeros(J) for lag in range(LAGS)])
            sums = sums.add(delayed / NOISE, y[t] / NOISE)
        before = faded(belief, 0.95)
        odds, score = weigh(odds, before, sums, len(part) / 30, OWN, NONE, PRECISION)
        belief, at = joined(before, sums), at + len(part)
        scores.append(score)
    return odds, belief, np.array(scores)


def by_kind(P: np.ndarray) -> dict[str, np.ndarray]:
    return dict(zip(KINDS, P.reshape(len(KINDS), EACH), strict=True))


@pytest.fixture(scope="module")
def late() -> tuple[Contingency, MotionSums, np.ndarray]:
    return judged(0, 12)


def test_what_the_joints_drive_is_me_and_nothing_else(late):
    P = by_kind(probability(late[0].log_odds[LAG]))
    assert (P["driven"] > 0.99).all()
    for kind in KINDS[1:]:
        assert (P[kind] < 0.5).mean() > 0.97, kind


def test_one_motion_tells_something_and_stays_careful():
    P = by_kind(probability(judged(1, 1)[0].log_odds[LAG]))
    assert P["driven"].mean() > 0.5
    assert np.mean([P[kind].mean() for kind in KINDS[1:]]) < 0.15


def test_no_more_are_wrong_than_is_stated():
    """Over scenes: of the cells that are named at 5 %, at most so many are not driven."""
    named = wrong = 0
    for seed in range(8):
        mask = called_me(probability(judged(seed, 6)[0].log_odds[LAG]), 0.05)
        named, wrong = named + int(mask.sum()), wrong + int(mask[EACH:].sum())
    assert named > 200
    assert wrong <= 0.05 * named


def test_the_true_lag_scores_highest(late):
    assert late[2].sum(axis=0).argmax() == LAG


def test_what_is_let_go_stops_being_me():
    """A cell that followed the joints for six motions hangs still from the seventh on."""
    rng = np.random.default_rng(3)
    belief, odds, K = empty(1, J, 1), Contingency(np.zeros((1, 1))), rng.uniform(50, 150, (2, J))
    history = []
    for k, part in enumerate(motions(rng, 10)):
        sums = empty(1, J, 1)
        for x in part:
            y = (K @ x if k < 6 else np.zeros(2)) + NOISE * rng.normal(size=2)
            sums = sums.add(x[None] / NOISE, y[None] / NOISE)
        before = faded(belief, 0.95)
        odds, _ = weigh(odds, before, sums, len(part) / 30, OWN, NONE, PRECISION)
        belief = joined(before, sums)
        history.append(float(probability(odds.log_odds[0])[0]))
    assert history[5] > 0.99
    assert history[8] < 0.5


def test_a_cell_in_which_nothing_ever_moves_is_never_me():
    """Not even one without any noise, after many motions that foretell and cost nothing."""
    rng = np.random.default_rng(5)
    belief, odds = empty(1, J, 1), Contingency(np.zeros((1, 1)))
    for part in motions(rng, 20):
        sums = empty(1, J, 1)
        for x in part:
            sums = sums.add(x[None] / NOISE, np.zeros((1, 2)))
        before = faded(belief, 0.95)
        odds, _ = weigh(odds, before, sums, len(part) / 30, OWN, NONE, PRECISION)
        belief = joined(before, sums)
        assert probability(odds.log_odds[0])[0] < 0.1


def test_joints_that_carry_the_camera_make_nothing_me():
    """The flow follows joint 0 alone; it counts as evidence only if that joint moves the body."""
    rng = np.random.default_rng(4)
    parts = motions(rng, 12)
    for camera, expected in ((NONE, True), (np.array([0]), False)):
        belief, odds = empty(1, J, 1), Contingency(np.zeros((1, 1)))
        for part in parts:
            sums = empty(1, J, 1)
            for x in part:
                y = np.array([100.0, -40.0]) * x[0] + NOISE * rng.normal(size=2)
                sums = sums.add(x[None] / NOISE, y[None] / NOISE)
            before, own = faded(belief, 0.95), np.setdiff1d(OWN, camera)
            odds, _ = weigh(odds, before, sums, len(part) / 30, own, camera, PRECISION)
            belief = joined(before, sums)
        assert (probability(odds.log_odds[0])[0] > 0.9) == expected


def test_the_share_of_wrong_cells_is_the_mean_of_what_is_doubted():
    P = np.array([[0.999, 0.6], [0.98, 0.2]])
    assert called_me(P, 0.02).tolist() == [[True, False], [True, False]]
    assert called_me(P, 0.3).tolist() == [[True, True], [True, False]]
    assert not called_me(np.full((2, 2), 0.1), 0.5).any()


def odds_of(parts: list[tuple[int, float, bool]], noise: float = NOISE) -> np.ndarray:
    """Log odds after each of some motions of one cell that the first joint moves, at one lag.

    Args:
        parts: (joint that turns, by how much, whether the cell is seen to move).
        noise: of the flow while the cell moves, pixels/frame.
    """
    rng, K = np.random.default_rng(3), np.zeros((2, J))
    K[:, 0] = 80.0, -50.0
    belief, odds, found = empty(1, J, 1), Contingency(np.zeros((1, 1))), []
    s = np.linspace(0, 1, 20)
    bump = np.diff(s**3 * (10 - 15 * s + 6 * s * s))
    for joint, turn, seen in parts:
        x, sums = np.zeros((46, J)), empty(1, J, 1)
        x[15:34, joint] = turn * bump
        for t in range(46):
            y = K @ x[t] + noise * rng.normal(size=2) if seen else 0.2 * NOISE * rng.normal(size=2)
            sums = sums.add(x[None, t] / NOISE, y[None] / NOISE)
        before = faded(belief, 0.95)
        odds, _ = weigh(odds, before, sums, 46 / 30, OWN, NONE, PRECISION)
        belief = joined(before, sums)
        found.append(float(odds.log_odds[0, 0]))
    return np.array(found)


def test_a_motion_that_leaves_still_what_it_should_says_next_to_nothing():
    known = [(0, 0.1, True), (1, 0.1, False), (0, -0.1, True), (1, -0.1, False)]
    odds = odds_of([*known, (1, 0.1, False), (1, -0.1, False)])
    # Faded by 3 % each time, and by little beside.
    assert odds[3:] == pytest.approx([10.9] * 3, abs=1.3)
    assert (np.diff(odds[3:]) > -0.03 * odds[3:-1] - 0.4).all()


def test_a_motion_made_again_with_the_same_blind_spot_is_counted_once():
    known = [(0, 0.1, True), (1, 0.1, False), (0, -0.1, True)]
    again = odds_of([*known, (0, 0.1, False), (0, -0.1, False), (0, 0.1, False)])
    between = odds_of([*known, (0, 0.1, False), (1, 0.1, False), (0, -0.1, False)])
    assert again[3] < again[2] - 2.5
    assert (np.diff(again[3:]) > -0.03 * again[3:-1] - 0.4).all()
    # What another motion comes between is a miss of its own.
    assert between[5] < between[4] - 2.5


def test_what_is_foretold_by_less_than_it_may_be_off_is_not_missed():
    """Flow that fits badly leaves a little of every joint in the belief, which means nothing."""
    known = [(0, 0.1, True), (1, 0.1, True), (0, -0.1, True), (1, -0.1, True)]
    odds = odds_of([*known, (0, 0.1, True), (1, 0.1, False)], noise=8 * NOISE)
    assert odds[5] > odds[4] - 1.5
