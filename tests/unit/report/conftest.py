"""Calibrations to report on, made once: seen twice, with an outlier, with names that need care."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from bodyschema import Answer, Body, calibrate, lie
from bodyschema.report.evidence import Evidence
from bodyschema.senses.sense import Sense
from simulated import points, poses, postures

CAMERA = "<b>eye</b> & $x$"
"""A frame's name that would break the page, or a chart, if it were not escaped."""
RUN = {
    "robot": "/robots/<i>arm</i>.urdf",
    "recording": ["data.csv"],
    "frames": {CAMERA: {"parent": "base", "known": "no"}},
    "senses": [{"kind": "points", "columns": ["x", "y", "z"]}],
    "command": "bodyschema calibrate '<u>run</u>.toml'",
    "sha256": {"data.csv": "0" * 64},
    "versions": {"python": "3.11"},
}


@dataclass(frozen=True)
class Case:
    """What `report_html` needs."""

    calibration: Answer
    nominal: Body
    senses: tuple[Sense, ...]
    run: dict[str, Any]

    @property
    def evidence(self) -> Evidence:
        return Evidence(self.calibration, self.nominal, self.senses, self.run)


def made(groups: tuple[str, ...], noise: float, n: int = 30) -> Case:
    """An arm of four joints, seen by a camera as a point and as a pose; row 7 is spoiled."""
    rng = np.random.default_rng(3)
    nominal = Body.random_chain(4, rng)
    body = nominal.attach(CAMERA, "base").attach("tool", "tip")
    T_base_camera = lie.transform(lie.exp_so3([0.3, -2.0, 0.5]), [0.2, 1.0, 0.7])
    truth = body.with_placement(CAMERA, T_base_camera)
    truth = replace(truth, offset=rng.uniform(-0.08, 0.08, 4) if groups else np.zeros(4))
    q = postures(n, body, rng)
    seen = points(truth, q, rng, noise, CAMERA, "tool")
    seen.position[7] += 0.3
    posed = poses(truth, q, rng, (noise, 3 * noise), CAMERA, "tool")
    found = calibrate(body, [seen, posed], {CAMERA: "no"}, groups, folds=3)
    return Case(found, nominal, (seen, posed), RUN)


@pytest.fixture(scope="session")
def case() -> Case:
    """Offsets and axes are wrong, with an outlier."""
    return made(("offsets", "axes"), 1e-3)


@pytest.fixture(scope="session")
def cases(case: Case) -> dict[str, Case]:
    """All kinds of answers."""
    late = replace(case.calibration.clock, p_value=1e-4, late_rows=(3, 4))
    refused = replace(case.calibration, verdict="refused", clock=late)
    unsettled = replace(case.calibration, fit=replace(case.calibration.fit, converged=False))
    everything = tuple(range(case.calibration.n_rows))
    return {
        "calibrated": case,
        "only frames": made((), 1e-3),
        "exact": made(("offsets",), 0.0),
        "refused": replace(case, calibration=refused),
        "not settled": replace(case, calibration=unsettled),
        "only outliers": replace(case, calibration=replace(case.calibration, outliers=everything)),
        "bare run": replace(case, run={}),
    }
