"""What the hand holds, and where it is touched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import payload
from bodyschema.studies.registry import study_class
from bodyschema.studies.runner import run_study
from key_figures.figure import Values


def held(data: Path) -> Values:
    """A held box at half speed, its sensor's offset left in, six motions."""
    study = study_class("nabeshima", "payload")(runs=6)
    found = study.summary(run_study(study, 1))["better_outside"]
    return {
        "known_s": found["seconds_to_1pct_1mm"]["median"],
        "certified_s": found["certified_s"],
        "mass": found["mass_pct"],
        "centre": found["com_mm"],
        "coverage_off": abs(found["coverage"] - 0.95),
        "physical": found["physical_share"],
    }


def changes(data: Path) -> Values:
    """Things that are grasped, swapped and released; and half an hour in which nothing is."""
    found = payload.changes(8)
    return {
        "delay": found["delay_s"]["median"],
        "missed": found["missed"],
        "named": found["named_share"],
        "again": found["certified_again_s"]["median"],
        "false_alarms": sum(payload.false_alarms(1 / 6).values()) / 6,
    }


def touched(data: Path) -> Values:
    """20 touches of 1 N a thing; as many soft and moving ones by turns; free motion."""
    study = study_class("nabeshima", "touch")(runs=20, hours=0.1)
    tasks = [task for task in study.tasks() if task.settings.get("force", 1.0) == 1.0]
    found = [(task.settings["kind"], study.work(task)) for task in tasks]
    points: list[Any] = [result["identified"] for kind, result in found if kind == "point"]
    free = [result for kind, result in found if kind == "free"]
    verdicts = [v for kind, r in found if kind in ("soft", "moving") for v in r["verdicts"]]
    errors = 1e3 * np.concatenate([result["error"] for result in points])
    return {
        "place": float(np.median(errors)),
        "place_p95": float(np.quantile(errors, 0.95)),
        "unnoticed": sum(result["unnoticed"] for result in points),
        "held_off": abs(float(np.mean([h for r in points for h in r["held"]])) - 0.95),
        "refused": float(np.mean([verdict != "point" for verdict in verdicts])),
        "false": sum(result["identified"] for result in free),
    }
