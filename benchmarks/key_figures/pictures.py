"""The body in pictures: found, followed, and calibrated without markers."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

import markerless
from bodyschema.studies.registry import study_class
from bodyschema.studies.runner import run_study
from bodyschema.studies.study import Task
from bodyschema.studies.watched_scenes import shares
from key_figures.figure import Values
from watched_arms import vislab

MOTIONS = 5
"""In a film."""

STARTS = 4
"""Random starts of vislab."""

TOLD = slice(1, 6)
"""Joints of the KUKA arm whose zeros pictures can tell: not its first, nor its last."""


def found_body(data: Path) -> Values:
    """Which cells are me: an arm and a humanoid, three films each."""
    study = study_class("nabeshima", "find-body")(motions=MOTIONS)
    films = product(enumerate(("arm", "humanoid")), ("none", "always", "lagged"))
    tasks = [Task("", {"run": run, "robot": robot, "kind": kind}) for (run, robot), kind in films]
    found = [study.work(task)["better"] for task in tasks]
    score = shares([film["after"][str(MOTIONS)] for film in found])
    late = [1e3 * abs(film["lag_error"]) for film in found if film["lag_error"] is not None]
    return {
        "precision": score["precision"],
        "recall": score["recall"],
        "joint": score["joint_right_share"],
        "delay": float(np.median(late)) if late else None,
    }


def tracker(data: Path) -> Values:
    """A hand on its way, by the robot's own model and by one that is a little wrong."""
    study = study_class("vicente2016", "table1")(
        method="track", runs=3, frames=60, closed_frames=10
    )
    own = study.summary(run_study(study, 1))
    wrong = own["mismatched"]
    return {
        "own": own["estimation"]["position_mm"]["mean"],
        "own_turn": own["estimation"]["orientation_deg"]["mean"],
        "wrong": wrong["estimation"]["position_mm"]["mean"],
        "wrong_turn": wrong["estimation"]["orientation_deg"]["mean"],
        "reaching": wrong["reaching"]["position_mm"]["mean"],
        "wrong_nees": wrong["nees"],
    }


def vislab_icub(data: Path) -> Values:
    """Joint offsets of a simulated hand from five pairs of masks, random starts."""
    watched = vislab(data / "vislab_icub_sim", faces=500)
    found = markerless.vislab_figures(watched, STARTS, 5)
    return {
        "converged": found["converged"],
        "repeatability": found["repeatability_mm"],
        "to_published": found["to_published_mm"],
        "iou": found["iou"],
    }


def med7(data: Path) -> Values:
    """A real KUKA arm: camera and joint offsets from five pairs; how far from the injected ones
    (`offsets`), and how far from what is found without an injection (`repeat`)."""
    found = markerless.med7_figures(data / "roboreg_med7_zed2i", True)
    error, repeat = (
        np.abs(list(found[f"injected_{name}_deg"].values()))[TOLD] for name in ("error", "repeat")
    )
    return {
        "offsets": float(error.max()),
        "repeat": float(repeat.max()),
        "iou": found["iou"],
        "residual": found["residual_px"],
    }
