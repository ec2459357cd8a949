"""Each verdict is reached by a recording that deserves it; answers are complete and repeatable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.answers.calibrate import MODELS, calibrate
from bodyschema.estimation.held_out import folds_of
from bodyschema.judging.calibration import Calibration, describe_groups
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.sense import Sense
from simulated import drawn, forgotten, points, poses, postures, seen_arm, spoiled

Array = NDArray[np.float64]
SENSES = {"points": points, "poses": poses}
UNKNOWN = {"tracker": "no", "tool": "no"}


def recording(
    kind: str, groups: Sequence[str], seed: int = 0, n: int = 60, outliers: float = 0.0
) -> tuple[Body, Sense, NDArray[np.bool_], Body]:
    """A body that knows neither tracker nor tool, what was seen, which rows are bad, the truth."""
    rng = np.random.default_rng(seed)
    nominal = seen_arm(5, rng)
    wrong = free_joints(nominal, groups)
    truth = nominal.with_variables(wrong, drawn(wrong, rng, 0.5))
    clean = SENSES[kind](truth, postures(n, truth, rng), rng)
    seen, bad = spoiled(clean, outliers, 0.1, rng)
    return forgotten(nominal, UNKNOWN), seen, bad, truth


@pytest.fixture(scope="module")
def wrong_offsets() -> tuple[Calibration, NDArray[np.bool_]]:
    body, seen, bad, _ = recording("poses", ["offsets"], outliers=0.1)
    return calibrate(body, [seen], UNKNOWN), bad


def test_wrong_offsets_are_calibrated(wrong_offsets: tuple[Calibration, Array]) -> None:
    answer, bad = wrong_offsets
    assert answer.verdict == "calibrated"
    assert answer.groups == ("offsets",)
    before, after = answer.nominal.position.rms, answer.held_out.position.rms
    assert after < 0.2 * before
    # Noise of 1 mm a coordinate, and what was learned from 48 samples.
    assert after == pytest.approx(np.sqrt(3) * 1e-3, rel=0.35)
    assert answer.held_out.rotation is not None
    assert answer.held_out.rotation.rms == pytest.approx(np.sqrt(3) * 3e-3, rel=0.35)
    assert answer.explanation == (
        f"The held-out error falls from {1e3 * before:.2f} to {1e3 * after:.2f} mm rms when joint "
        "offsets are corrected."
    )
    assert answer.outliers == tuple(np.flatnonzero(bad))
    assert not answer.clock.faulty
    assert answer.clock.late_rows == ()


def test_the_answer_holds_all_that_was_tried(wrong_offsets: tuple[Calibration, Array]) -> None:
    answer, _ = wrong_offsets
    assert [candidate.groups for candidate in answer.candidates] == list(MODELS)
    assert [c.n_parameters for c in answer.candidates] == [12, 17, 27, 42]
    assert min(abs(c.behind) for c in answer.candidates) == 0
    assert answer.candidates[0].behind > 2
    assert answer.n_rows == 60
    assert answer.estimate is answer.fit
    assert answer.body is answer.fit.body
    # The first offset and the tracker, the last offset and the tool: twice one of two.
    assert answer.identifiability.rank == 15
    assert "tracker.turn_z" in answer.identifiability.partners("joint_1.offset")


@pytest.mark.parametrize("kind", SENSES)
def test_a_right_body_only_gets_its_frames(kind: str) -> None:
    body, seen, _, truth = recording(kind, [], seed=1)
    answer = calibrate(body, [seen], UNKNOWN)
    assert answer.verdict == "only frames"
    assert answer.groups == ()
    assert "Correcting the joints does not help" in answer.explanation
    assert (answer.body.offset == 0).all()
    assert (answer.held_out.rotation is None) == (kind == "points")
    k = truth.frame_index("tracker")
    assert answer.body.placement[k] == pytest.approx(truth.placement[k], abs=5e-3)


def test_a_larger_model_that_is_better_by_chance_is_not_taken() -> None:
    body, seen, _, _ = recording("poses", [], seed=6, n=25)
    answer = calibrate(body, [seen], UNKNOWN)
    assert 0 < answer.candidates[0].behind < 2
    assert answer.groups == ()
    assert answer.verdict == "only frames"


def test_a_correction_that_makes_it_worse_is_refused() -> None:
    """Few noisy points, all geometry freed by command: the fit learns the noise."""
    rng = np.random.default_rng(3)
    body = seen_arm(5, rng)
    seen = points(body, postures(24, body, rng), rng, 0.01)
    answer = calibrate(
        forgotten(body, UNKNOWN), [seen], UNKNOWN, groups=["offsets", "gears", "axes", "links"]
    )
    assert answer.verdict == "refused"
    assert "makes the held-out error worse" in answer.explanation
    assert answer.held_out.position.rms > answer.nominal.position.rms


def test_wrong_axes_and_links_are_found_too() -> None:
    body, seen, _, _ = recording("poses", ["offsets", "axes", "links"], n=100)
    answer = calibrate(body, [seen], UNKNOWN)
    assert answer.verdict == "calibrated"
    assert answer.groups == ("offsets", "axes", "links")
    assert answer.held_out.position.rms < 0.3 * answer.nominal.position.rms


def test_the_user_may_choose_groups_and_joints() -> None:
    body, seen, _, _ = recording("poses", ["offsets"])
    answer = calibrate(body, [seen], UNKNOWN, groups=["offsets"], joints=["joint_2", "joint_3"])
    names = answer.fit.variables.where(["offsets"]).names
    assert names == ("joint_2.offset", "joint_3.offset")
    assert [candidate.groups for candidate in answer.candidates] == [(), ("offsets",)]


def test_a_frame_that_is_known_roughly_keeps_its_start() -> None:
    rng = np.random.default_rng(5)
    nominal = seen_arm(5, rng)
    offsets = free_joints(nominal, ["offsets"])
    truth = nominal.with_variables(offsets, drawn(offsets, rng, 0.5))
    shifted = nominal.placement[nominal.frame_index("tracker")].copy()
    shifted[:3, 3] += [0.02, -0.01, 0.01]
    seen = poses(truth, postures(50, truth, rng), rng)
    body = nominal.with_placement("tracker", shifted)
    answer = calibrate(body, [seen], {"tracker": "roughly"}, groups=["offsets"])
    assert answer.verdict == "calibrated"
    assert answer.held_out.position.rms < 2.5e-3
    # As modelled, the tracker stays where it was said to be.
    assert answer.nominal.position.rms > 0.02


def test_late_rows_are_reported() -> None:
    rng = np.random.default_rng(6)
    body = seen_arm(5, rng)
    q = postures(60, body, rng)
    late = [4, 11, 17, 23, 31, 40, 44, 52]
    true = q.copy()
    true[late] += 0.05 * (q[np.array(late) + 1] - q[late])
    seen = replace(poses(body, true, rng), q=q)
    answer = calibrate(forgotten(body, UNKNOWN), [seen], UNKNOWN, groups=["offsets"])
    assert answer.clock.faulty
    assert len(set(late) & set(answer.clock.late_rows)) >= 6


def test_the_same_seed_gives_the_same_numbers() -> None:
    body, seen, _, _ = recording("points", ["offsets"], n=30, outliers=0.1)
    groups = ["offsets", "axes"]
    one, same = (calibrate(body, [seen], UNKNOWN, groups, seed=7) for _ in range(2))
    assert (one.estimate.x == same.estimate.x).all()
    assert (one.estimate.covariance == same.estimate.covariance).all()
    assert one.held_out == same.held_out
    assert one.with_field == same.with_field
    assert one.candidates == same.candidates
    assert one.clock == same.clock
    assert one.outliers == same.outliers
    assert one.identifiability.sentences == same.identifiability.sentences


def test_exact_samples_are_calibrated() -> None:
    body, seen, _, truth = recording("poses", ["offsets"], n=40)
    answer = calibrate(body, [seen.imagined(truth, seen.q)], UNKNOWN)
    assert answer.verdict == "calibrated"
    assert answer.held_out.position.rms < 1e-6


def test_a_sense_that_a_fold_leaves_empty_is_no_obstacle() -> None:
    """Two samples of a second sense can both lie in the fold that is held out."""
    body, seen, _, truth = recording("poses", ["offsets"])
    rng = np.random.default_rng(0)
    few = points(truth, seen.q[:2], rng, seen="link_5")
    seed = next(
        seed for seed in range(9) if any(set(f) >= {0, 1} for f in folds_of([seen], 2, seed))
    )
    answer = calibrate(body, [seen, few], UNKNOWN, groups=["offsets"], folds=2, seed=seed)
    assert answer.verdict == "calibrated"


def test_progress_is_told() -> None:
    body, seen, _, _ = recording("poses", ["offsets"])
    said: list[str] = []
    calibrate(body, [seen], UNKNOWN, groups=["offsets"], progress=said.append)
    assert said[:2] == ["other declarations", "5-fold test of frames only"]
    assert said[-1] == "residual fields, and what disagrees"
    assert "5-fold test of joint offsets" in said


def test_models_have_names() -> None:
    assert describe_groups(()) == "frames only"
    assert describe_groups(("offsets", "axes")) == "joint offsets, axes"
