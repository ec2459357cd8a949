"""Hand and eye: from one tracked point, from pairs of poses, and on other people's data."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import bodyschema as bs
import kinhec_tracks
import recordings
from bodyschema import lie
from bodyschema.studies.registry import study_class
from bodyschema.studies.runner import run_study
from key_figures.figure import Skipped, Values

SEED = 140
"""Of the scenes, which no other benchmark uses."""

RIGS, PAIRS = 30, 40
NOISE = (1e-3, np.deg2rad(0.2))
"""m and rad, of what the eye sees."""

WRONG = 0.2
"""Share of pairs in which the eye mistook something else for the target."""

TRACKS = ("motion", "outliers", "temporal")
"""Three of KinHEC's eight."""


def points(data: Path) -> Values:
    """Six scenes, 30 s of motion each."""
    study = study_class("nabeshima", "hand-eye")(runs=6, seed=SEED)
    found = study.summary(run_study(study, 1))
    return {
        "camera": found["better"]["camera_mm"]["median"],
        "turn": found["better"]["rotation_deg"]["median"],
        "tip": found["better"]["tip_mm"]["median"],
        "certified": found["certificate"]["seconds_median"],
        "false": found["certificate"]["false_share"],
        "nees": found["nees"],
    }


def poses(data: Path) -> Values:
    """Rigs with a fifth of wrong pairs; and rigs that turn about one axis only."""
    errors, inside, told, flagged = [], [], [], []
    for rig in range(RIGS):
        rng = np.random.default_rng([SEED, rig])
        X, answer = solved(rng, np.eye(3))
        away = answer.X[:3, 3] - X[:3, 3]
        errors.append(1e3 * float(np.linalg.norm(away)))
        # The covariance is that of a twist in X's own frame.
        local = X[:3, :3].T @ away
        square = local @ np.linalg.solve(answer.covariance[:3, :3], local)
        inside.append(square < 7.815)  # 95 % of chi-square with 3 degrees of freedom
        told.append(answer.determined)
        if rig < 10:
            flagged.append(not solved(rng, np.diag([0.0, 0.0, 1.0]))[1].determined)
    return {
        "eye": float(np.median(errors)),
        "eye_worst": float(np.max(errors)),
        "coverage_off": abs(float(np.mean(inside)) - 0.95),
        "determined": float(np.mean(told)),
        "one_axis_flagged": float(np.mean(flagged)),
    }


def solved(rng: np.random.Generator, axes: np.ndarray) -> tuple[np.ndarray, bs.HandEye]:
    """True X of a rig with the eye on its hand, and the answer; `axes` (3, 3) it turns about."""
    X, Y = (
        lie.transform(lie.exp_so3(rng.normal(size=3)), reach * rng.normal(size=3))
        for reach in (0.05, 0.8)
    )
    turns = lie.exp_so3(rng.normal(size=(PAIRS, 3)) @ axes)
    T_base_hand = lie.transform(turns, rng.uniform(-0.4, 0.4, (PAIRS, 3)))
    T_eye_target = lie.inverse(T_base_hand @ X) @ Y
    T_eye_target[:, :3, 3] += NOISE[0] * rng.normal(size=(PAIRS, 3))
    T_eye_target[:, :3, :3] = (
        lie.exp_so3(NOISE[1] * rng.normal(size=(PAIRS, 3))) @ T_eye_target[:, :3, :3]
    )
    wrong = rng.permutation(PAIRS)[: round(WRONG * PAIRS)]
    T_eye_target[wrong, :3, 3] += rng.uniform(-0.3, 0.3, (len(wrong), 3))
    T_eye_target[wrong, :3, :3] = lie.exp_so3(rng.normal(size=(len(wrong), 3)))
    return X, bs.solve_hand_eye(T_base_hand, T_eye_target, eye_on="hand")


def recorded(data: Path) -> Values:
    """Recordings of real rigs: scatter of what stands still."""
    pairs, streams = recordings.ur5_artag(data), recordings.eth(data)
    return {
        "ur5": pairs["inlier_rms_mm"],
        "ur5_median": pairs["median_mm"],
        "eth": streams["robot_arm_real"]["median_mm"],
        "eth_lag": 1e3 * streams["robot_arm_real"]["lag_s"],
        "eth_apart": streams["two_recordings_apart_mm"],
    }


def kinhec(data: Path) -> Values:
    """Three tracks of KinHEC's smallest tier, made anew from its own seeds."""
    try:
        import kinhec  # noqa: F401
    except ImportError:
        raise Skipped("needs KinHEC: pip install kinhec") from None
    with tempfile.TemporaryDirectory() as place:
        folder = kinhec_tracks.generated(Path(place), "smoke", TRACKS)
        table = kinhec_tracks.solved(folder, Path(place), TRACKS, ["ours"], progress=False)
    found = {t: kinhec_tracks.own(kinhec_tracks.judged(rows, str(t)))
             for t, rows in table.groupby("track")}  # fmt: skip
    return {
        "motion": found["motion"]["median_mm"],
        "motion_unflagged": found["motion"]["worst_unflagged_mm"],
        "outliers": found["outliers"]["median_mm"],
        "outliers_mean": found["outliers"]["mean_mm"],
        "temporal": found["temporal"]["median_mm"],
        "false_flags": max(one["false_flags"] for one in found.values()),
    }
