"""What was learned without markers, where other programs read it.

robot.urdf          the user's own file with the changed numbers, byte by byte otherwise
kinematics.yaml     the joint frames, for xacro
transforms.yaml     cameras whose place was looked for, if any

Offsets that the pictures do not tell stay as modelled, and the others are what they are if that is
right: with A the information of the estimate x, o what is not told and d the rest,

    x_o = 0,    x_d + A_dd^-1 A_do x_o

An offset that goes together with the place of a camera is kept as it came: then the camera of
transforms.yaml and the robot of robot.urdf fit each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.export.calibration_yaml import OPEN
from bodyschema.export.documents import yaml_text
from bodyschema.export.kinematics_yaml import kinematics_text
from bodyschema.export.static_transforms import (
    HEADING,
    PREFIX,
    estimated_frames,
    placed_frames,
)
from bodyschema.export.urdf_edits import described, urdf_edits
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf, urdf_text

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settled:
    """A fit as it is written: what is not told stays as modelled."""

    fit: MarkerlessFit
    x: Array
    """(n_parameters,) deviations that are written."""
    kept: tuple[str, ...]
    """Variables that stay as modelled."""

    @classmethod
    def of(cls, fit: MarkerlessFit) -> Settled:
        """Decide what is written."""
        estimate, known = fit.estimate, fit.identifiability
        variables = estimate.variables
        cameras = {
            name
            for name, group in zip(variables.names, variables.groups, strict=True)
            if group.startswith(PREFIX)
        }
        still = np.array(
            [
                share > OPEN and not cameras.intersection((name, *known.partners(name)))
                for name, share in zip(variables.names, known.open_share, strict=True)
            ],
            dtype=bool,
        )
        A, x = estimate.information, estimate.x.copy()
        x[~still] += np.linalg.solve(A[np.ix_(~still, ~still)], A[np.ix_(~still, still)] @ x[still])
        x[still] = 0.0
        return cls(fit, x, tuple(variables.names[i] for i in np.flatnonzero(still)))

    @property
    def body(self) -> Body:
        """The corrected robot with its cameras."""
        estimate = self.fit.estimate
        return estimate.reference.with_variables(estimate.variables, self.x)

    @property
    def corrections(self) -> dict[str, float]:
        """Offsets that are written, by parameter, rad or m; cameras are left out."""
        variables = self.fit.estimate.variables
        return {
            name: float(value)
            for name, group, value in zip(variables.names, variables.groups, self.x, strict=True)
            if not group.startswith(PREFIX)
        }

    @property
    def transforms(self) -> list[dict[str, Any]]:
        """Places of the cameras that were looked for, see `placed_frames`."""
        variables = self.fit.estimate.variables
        return placed_frames(self.body, variables, estimated_frames(variables))

    def files(self, source: Path, nominal: Body) -> dict[str, bytes]:
        """Contents of the files by name.

        Args:
            source: the URDF or xacro file, which is read again and never touched.
            nominal: the robot as described.
        """
        text = urdf_text(source, {})
        corrected = described(nominal, self.body)
        edits = urdf_edits(parse_urdf(text, source, {}), corrected)
        texts = {"kinematics.yaml": kinematics_text(corrected)}
        transforms = self.transforms
        if transforms:
            texts["transforms.yaml"] = yaml_text({"transforms": transforms}, HEADING)
        return {"robot.urdf": patch_urdf(text, edits)} | {k: v.encode() for k, v in texts.items()}
