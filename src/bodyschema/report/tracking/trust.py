"""What the stated uncertainty counts, what it does not, and what speaks for or against it here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.report.page import render
from bodyschema.report.tracking.evidence import TrackEvidence


@dataclass(frozen=True)
class Trust:
    """Reasons, and the numbers of each camera."""

    evidence: TrackEvidence
    title: str = "How far to trust it"

    def render(self) -> str:
        """See `Section`."""
        fit = self.evidence.fit
        doubts = fit.model.doubts
        return render(
            "tracking/trust.html",
            focal=f"{100 * doubts.focal:g} %",
            centre=f"{doubts.centre:g} pixel{'s' * (doubts.centre != 1)}",
            turn=f"{np.rad2deg(doubts.turn):.2g} deg",
            shape=f"{1e3 * doubts.shape:g} mm",
            edge=f"{doubts.edge:g} pixel{'s' * (doubts.edge != 1)}",
            matched=f"{100 * fit.matched:.0f} %",
            residual=f"{fit.residual:.2f}" if np.isfinite(fit.residual) else "",
            iou=f"{fit.iou:.3f}" if np.isfinite(fit.iou) else "",
            used=f"{int(fit.weights.used.sum())} of {int(np.isfinite(fit.weights.pictures).sum())}",
            widened=f"{np.sqrt(fit.disagreement.kappa):.1f}",
            causes=[
                ("links", f"{fit.disagreement.by_piece:.1f}"),
                ("moments", f"{fit.disagreement.by_moment:.1f}"),
                ("disjoint halves", f"{fit.disagreement.by_half:.1f}"),
                ("what was said of lens, mounting and meshes", f"{fit.disagreement.by_doubt:.1f}"),
            ],
            cameras=_shares(self.evidence.cameras, fit.weights.cameras),
            pieces=_shares(fit.model.surface.frames, fit.weights.pieces),
            biases=[
                (camera, f"{bias:+.2f}")
                for camera, bias in zip(self.evidence.cameras, fit.bias, strict=True)
            ],
        )


def _shares(names: Sequence[str], weights: NDArray[np.float64]) -> list[tuple[str, str]]:
    """Names with their weights."""
    shown = np.nan_to_num(weights).tolist()
    return [(name, f"{weight:.2f}") for name, weight in zip(names, shown, strict=True)]
