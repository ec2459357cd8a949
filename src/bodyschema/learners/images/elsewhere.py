"""Whether cameras stand where they are said to: the rival of a fit that takes their word for it.

The same pictures are fitted once more with the places c of all such cameras freed, in units of
ROUGHLY. With A what the pictures say of c, by the noise that this fit itself shows (`disagreement`)
and offsets and doubts marginalised, V the directions that A tells, x the estimate of c, and D the
turns by which mountings are doubted anyway,

    d = V^T A^-1 (A + 1) x,     surprise = d^T (V^T (A^-1 + D) V)^-1 d

which is chi-square if every camera is where it is said to be. A turn of a camera about the first
joint's axis is no such direction: the joint's offset undoes it. The surprise alone does not tell
the camera from a wrong lens or wrong meshes, which push it too: those are freed in its place, and
what pictures and pieces then still contradict each other is compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.images.disagreement import TOLD, Disagreement
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.markerless import FINE_REACH, Markerless, refine
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.picture_weights import PictureWeights
from bodyschema.learners.images.rim_fit import RimModel
from bodyschema.learners.images.rim_information import LEAST_EFFECT, without
from bodyschema.learners.images.sight import Sight
from bodyschema.model.kernels import FIXED
from bodyschema.model.variables import Variables, free_frame, join
from bodyschema.senses.images import Images

Array = NDArray[np.float64]

ROUGHLY = (0.05, float(np.radians(5)))
"""m and rad, one standard deviation of each component: what `known = "roughly"` takes."""

UNLIKELY = 0.01
"""Chance of the surprise from which a camera is doubted. Of 52 good simulated arms none comes
there, as real masks are better than LEAST_EFFECT; of 56 whose camera stands 1 to 4 cm elsewhere one
does not."""

REACH = (7.0, 5.0, 4.0, 4.0, 4.0)
"""pixels, step by step from the fit that is doubted."""

WRONG_LENS: dict[str, Any] = {"focal": 0.1, "centre": 20.0}
WRONG_MESHES: dict[str, Any] = {"shape": 5e-3}
"""Doubts (share, pixels, m) that let lens or meshes be as wrong as they like."""


@dataclass(frozen=True)
class Elsewhere:
    """The fit with cameras freed, beside the one that takes them at their word."""

    estimate: Estimate
    """Of what was asked for, and of the cameras' places."""
    cameras: tuple[str, ...]
    """Frames that were freed."""
    surprise: float
    """Chi-square of the cameras' shifts."""
    freedom: int
    """Its degrees of freedom: directions that the pictures tell."""
    left: float
    """What pictures and pieces still contradict each other with the cameras freed."""
    rivals: Mapping[str, float] = field(default_factory=dict)
    """The same with the lens or the meshes freed in their place; empty if nothing surprises."""

    @property
    def p_value(self) -> float:
        """Chance of so much where every camera is where it is said to be."""
        return float(chdtrc(self.freedom, self.surprise)) if self.freedom else 1.0

    @property
    def doubted(self) -> bool:
        """Whether some camera seems to stand elsewhere."""
        return self.p_value < UNLIKELY

    def shift(self, camera: str) -> tuple[float, float]:
        """m and rad by which the pictures move a camera."""
        x = self.estimate.x[_of(self.estimate.variables, [camera])]
        return float(np.linalg.norm(x[:3])), float(np.linalg.norm(x[3:]))


def elsewhere(
    learner: Markerless, fit: MarkerlessFit, frames: Sequence[Images]
) -> Elsewhere | None:
    """Free the cameras that are said to be known; None if there are none, or the body is lost.

    Args:
        learner: that made the fit.
        fit: to be doubted.
        frames: that it was made of.
    """
    model = fit.model
    body, wanted = model.body, model.wanted
    mounted = [
        name
        for name in dict.fromkeys(camera.frame for camera in frames[0].cameras)
        if (node := body.frame_index(name)) > 0
        and body.kind[node] == FIXED
        and f"frame:{name}" not in wanted.groups
    ]
    if fit.lost or not mounted:
        return None
    sights = learner.sights(model, fit.z, frames)
    placed = join(wanted, *(free_frame(body, name, *ROUGHLY) for name in mounted))
    freed = _Refit.of(fit, placed, model.doubts, sights)
    surprise, freedom = _surprise(freed.estimate, mounted, model.doubts.turn)
    found = Elsewhere(
        freed.estimate, tuple(mounted), surprise, freedom, freed.disagreement.contradiction
    )
    if not found.doubted:
        return found
    rivals = {
        name: _Refit.of(fit, wanted, doubts, sights).disagreement.contradiction
        for name, doubts in (
            ("lens", replace(model.doubts, **WRONG_LENS)),
            ("meshes", replace(model.doubts, **WRONG_MESHES)),
        )
    }
    return replace(found, rivals=rivals)


@dataclass(frozen=True)
class _Refit:
    """A fit begun at another one, with more in doubt."""

    estimate: Estimate
    disagreement: Disagreement

    @classmethod
    def of(
        cls, fit: MarkerlessFit, wanted: Variables, doubts: Doubts, sights: Sequence[Sight]
    ) -> _Refit:
        """With other unknowns or other doubts."""
        old = fit.model
        model = RimModel.of(old.surface, old.body, wanted, sights[0].cameras, doubts)
        names, n = list(old.variables.names), len(model.variables)
        begun = [
            fit.z[names.index(name)] if name in names else 0.0 for name in model.variables.names
        ]
        z = refine(model, sights, np.concatenate([begun, fit.z[len(names) :]]), REACH, 1, True)
        seen = [model.rows(sight, z, FINE_REACH[-1]) for sight in sights]
        rows = PictureWeights.of(seen).on(seen)
        apart = Disagreement.of(model, rows, z, fit.masked)
        H = np.sum([r.H for r in rows], axis=0) / LEAST_EFFECT
        said = without(H, model.scale, n) / apart.kappa
        return cls(Estimate(model.body, model.variables, z[:n], said), apart)


def _surprise(estimate: Estimate, cameras: Sequence[str], turn: float) -> tuple[float, int]:
    """Chi-square of the module's text, and its degrees of freedom."""
    at = _of(estimate.variables, cameras)
    scale, x = estimate.variables.scale[at], estimate.x[at]
    C = estimate.covariance[np.ix_(at, at)] / np.outer(scale, scale)
    precision = np.linalg.inv((C + C.T) / 2)
    values, axes = np.linalg.eigh(precision - np.eye(len(at)))
    told = values > TOLD
    V, values = axes[:, told], values[told]
    turns = np.array([unit == "rad" for unit in np.array(estimate.variables.units)[at]])
    D = np.diag((turn * turns / scale) ** 2)
    d = V.T @ (precision @ (x / scale)) / values
    return float(d @ np.linalg.solve(np.diag(1 / values) + V.T @ D @ V, d)), int(told.sum())


def _of(variables: Variables, cameras: Sequence[str]) -> NDArray[np.int64]:
    """Where the places of cameras stand among variables."""
    groups = {f"frame:{name}" for name in cameras}
    return np.flatnonzero([group in groups for group in variables.groups])
