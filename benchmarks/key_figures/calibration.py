"""Calibration on recordings of real arms, and whether what it says can be believed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import arms
import null_cases
import recordings
import trust
from key_figures.figure import Values

SIZES = {"clean": 0.0, "outliers_3cm": 0.03, "outliers_20cm": 0.2}
"""m: by how much 15 % of FR3's training poses are off."""

SAMPLES, SEEDS = 30, 8
"""Of coverage."""


def fr3(data: Path) -> Values:
    """Body alone, with the two poses of one posture in one fold."""
    folds = recordings.twins_together(recordings.peers_folds())
    alone = {name: recordings.fr3_batch(data, size, folds)[1] for name, size in SIZES.items()}
    return {
        **{name: score.json()["rms_mm"] for name, score in alone.items()},
        "median": alone["clean"].json()["median_mm"],
        "nominal": recordings.fr3_nominal(data),
    }


def fr3_peers(data: Path) -> Values:
    """By the protocol that others were measured with; and in one pass."""
    both = {name: recordings.fr3_batch(data, size) for name, size in SIZES.items()}
    return {
        **{name: alone.json()["rms_mm"] for name, (_, alone) in both.items()},
        "with_field": both["clean"][0].json()["rms_mm"],
        "one_pass": recordings.fr3_recursive(data).json()["rms_mm"],
    }


def talos(data: Path) -> Values:
    """Offsets, the model that is chosen, and the skeleton from nothing."""
    offsets, chosen = recordings.talos(data, ["offsets"]), recordings.talos(data, None)
    return {
        "nominal": chosen["nominal_rms_mm"],
        "offsets": offsets["rms_mm"],
        "chosen": chosen["rms_mm"],
        "from_nothing": recordings.talos_skeleton(data)["rms_mm"],
    }


def talos_one_pass(data: Path) -> Values:
    """The recursive learners with the full model."""
    found = recordings.talos_online(data)
    return {
        "filter": found["gauss_newton_full"]["rms_mm"],
        "smoother": found["smoother_full"]["rms_mm"],
    }


def tiago(data: Path) -> Values:
    """A recording with a clock fault, on which a simple model is the best."""
    found = recordings.tiago(data)
    return {
        "chosen": found["frames_only_rms_mm"],
        "clock_fault_p": found["clock_fault_p"],
        "bad_rows": len(found["bad_rows"]),
    }


def coverage(data: Path) -> Values:
    """How far the share of true errors within the stated 95 % bound is off 95 %."""
    by_share = {
        share: np.mean([trust.coverage(arm, share, SAMPLES, SEEDS) for arm in arms.ARMS])
        for share in (0.0, 0.15)
    }
    shares = {
        "clean": by_share[0.0],
        "outliers": by_share[0.15],
        "fr3": trust.fr3_coverage(data),
    }
    return {name: abs(float(share) - 0.95) for name, share in shares.items()}


def check(data: Path) -> Values:
    """A joint's zero half a degree off, ten times; no change, twenty times; null directions."""
    arm = arms.ARMS[2]
    offset, none = trust.check(arm, "offset_deg", 0.5, 10), trust.check(arm, "none", 0.0, 20)
    null = null_cases.measure()
    return {
        "detected": offset["detected"],
        "blamed": offset["blamed"],
        "false_alarms": none["detected"],
        "null_named": null["named"],
        "null_invented": null["invented"],
    }
