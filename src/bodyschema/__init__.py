"""bodyschema keeps a robot's model of its own body true while the robot works."""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

# One BLAS thread a process: threading slows the small matrices of kinematics many times over.
# Only what the user has not chosen is set, and only numpy's later import heeds it.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

if TYPE_CHECKING:
    from bodyschema.acting.next_poses import plan_poses
    from bodyschema.body.parameters import Parameters, free_frame, free_joints, join
    from bodyschema.body.tree import Body
    from bodyschema.errors import BodyschemaError, InputError, MissingExtraError
    from bodyschema.learning.batch import LevenbergMarquardt
    from bodyschema.learning.calibrate import calibrate
    from bodyschema.learning.calibration import Calibration
    from bodyschema.learning.estimate import Estimate
    from bodyschema.learning.gauss_newton import GaussNewton
    from bodyschema.monitoring.change import detect_change
    from bodyschema.recording.recording import Recording
    from bodyschema.senses.points import Points
    from bodyschema.senses.poses import Poses

_HOMES = {
    "Body": "body.tree",
    "Parameters": "body.parameters",
    "free_joints": "body.parameters",
    "free_frame": "body.parameters",
    "join": "body.parameters",
    "BodyschemaError": "errors",
    "InputError": "errors",
    "MissingExtraError": "errors",
    "Recording": "recording.recording",
    "Points": "senses.points",
    "Poses": "senses.poses",
    "Estimate": "learning.estimate",
    "LevenbergMarquardt": "learning.batch",
    "GaussNewton": "learning.gauss_newton",
    "Calibration": "learning.calibration",
    "calibrate": "learning.calibrate",
    "detect_change": "monitoring.change",
    "plan_poses": "acting.next_poses",
}

__all__ = [
    "Body",
    "BodyschemaError",
    "Calibration",
    "Estimate",
    "GaussNewton",
    "InputError",
    "LevenbergMarquardt",
    "MissingExtraError",
    "Parameters",
    "Points",
    "Poses",
    "Recording",
    "calibrate",
    "detect_change",
    "free_frame",
    "free_joints",
    "join",
    "plan_poses",
]


def __getattr__(name: str) -> Any:
    """Load a public name at its first use, so that importing the package stays quick."""
    if name not in _HOMES:
        raise AttributeError(f"module 'bodyschema' has no attribute '{name}'")
    return getattr(importlib.import_module(f"bodyschema.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
