"""How far an answer to hand and eye is off, and whether certificates keep what they promise.

A certificate says that rotation, camera and tip are known to 0.2 degrees, 5 mm and 2 mm, each at
99 %. Over many scenes

    false_share          of the certificates: those at whose moment any of the three errors is
                         larger than its demand
    wrong_basin_share    those whose rotation is another minimum altogether
    nees                 mean of d^T P^-1 d at the certificate, d the true error and P the stated
                         covariance: 6 + 3 K for K points when P is right
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bodyschema import lie
from bodyschema.learners.hand_eye.chart import from_transform
from bodyschema.simulation.katana import Scene
from bodyschema.studies.nabeshima_figure9 import quantiles
from bodyschema.studies.study import Result

DEMAND = {"rotation_deg": 0.2, "camera_mm": 5.0, "tip_mm": 2.0}
"""What the certificate promises."""

WRONG_BASIN = 5.0
"""degrees: an answer so far off is another minimum, not noise."""


def errors(T_world_cam: Any, points: Any, scene: Scene) -> dict[str, float]:
    """Of the camera's rotation and place, and of the first point."""
    R, S = T_world_cam, scene.T_world_cam
    turn = np.linalg.norm(lie.log_so3(R[:3, :3] @ S[:3, :3].T))
    away = np.linalg.norm(points - scene.points[: len(points)], axis=1)
    return {
        "rotation_deg": float(np.degrees(turn)),
        "camera_mm": float(1e3 * np.linalg.norm(R[:3, 3] - S[:3, 3])),
        "tip_mm": float(1e3 * away[0]),
    }


def nees(theta: Any, covariance: Any, scene: Scene) -> float:
    """Squared error over its own covariance: 6 + 3 K on average when that is right."""
    away = from_transform(scene.T_world_cam, scene.points).away_from(theta)
    return float(away @ np.linalg.solve(covariance, away))


def spread(errors: Sequence[Mapping[str, float]]) -> Result:
    """Median and 90 % of each error, and its root mean square."""
    return {
        key: quantiles([each[key] for each in errors])
        | {"rms": float(np.sqrt(np.mean([each[key] ** 2 for each in errors]))) if errors else None}
        for key in DEMAND
    }


def certificates(held: Sequence[Result | None]) -> Result:
    """When they came, and how many were false."""
    given = [each for each in held if each is not None]
    false = [each for each in given if any(each[key] > most for key, most in DEMAND.items())]
    seconds = quantiles([each["seconds"] for each in given])
    count = max(len(given), 1)
    return {
        "seconds_median": seconds["median"],
        "seconds_p90": seconds["p90"],
        "false_share": len(false) / count,
        "wrong_basin_share": sum(each["rotation_deg"] > WRONG_BASIN for each in given) / count,
        "given_share": len(given) / len(held),
        "nees": float(np.mean([each["nees"] for each in given])) if given else None,
        "worst": {key: max((each[key] for each in given), default=None) for key in DEMAND},
    } | spread(given)
