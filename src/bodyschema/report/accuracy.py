"""Accuracy before and after, of each sense, and of every model that was tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.learning import calibration as answer
from bodyschema.learning.held_out import Errors
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.report.units import shown, significant


@dataclass(frozen=True)
class Accuracy:
    """Tables of held-out errors."""

    evidence: Evidence
    title: str = "Accuracy before and after"

    def render(self) -> str:
        """See `Section`."""
        c = self.evidence.calibration
        bodies = (
            ("as modelled", c.nominal),
            (f"{answer.describe_groups(c.groups)} corrected", c.held_out),
            ("the same with the residual field", c.with_field),
        )
        return render(
            "accuracy.html",
            posed=c.held_out.rotation is not None,
            bodies=[(name, _cells(accuracy)) for name, accuracy in bodies],
            senses=self._senses(),
            models=[self._model(candidate) for candidate in c.candidates],
        )

    def _senses(self) -> list[tuple[str, tuple[str, ...]]]:
        """A row for each component of each sense."""
        evidence, listed = self.evidence, []
        for i, (sense, predicted) in enumerate(
            zip(evidence.senses, evidence.predictions, strict=True)
        ):
            good, levels = evidence.good[i], evidence.calibration.fit.levels[i]
            bounds = {"position": predicted.position_overall, "rotation": predicted.rotation_overall}
            for (name, unit, part), level in zip(sense.components, levels, strict=True):
                before, after = (Errors.of(e[good]) for e in evidence.errors(name)[i])
                noise = level * float(np.sqrt(np.mean(np.diag(sense.covariance)[part])))
                listed.append(
                    (
                        f"{sense.label}: {name}",
                        (
                            shown(before.rms, unit),
                            shown(after.rms, unit),
                            shown(noise, unit),
                            shown(bounds.get(name), unit, 2),
                            f"{100 * evidence.within[i][name]:.0f} %",
                        ),
                    )
                )
        return listed

    def _model(self, candidate: answer.Candidate) -> tuple[str, str, str, str, bool]:
        return (
            answer.describe_groups(candidate.groups),
            str(candidate.n_parameters),
            shown(candidate.accuracy.position.rms, "m"),
            f"{candidate.behind:.1f}",
            candidate.groups == self.evidence.calibration.groups,
        )


def _cells(accuracy: answer.Accuracy) -> tuple[str, ...]:
    position, rotation = accuracy.position, accuracy.rotation
    cells = [significant(1e3 * v) for v in (position.rms, position.median, position.max)]
    if rotation is not None:
        cells += [significant(np.degrees(v)) for v in (rotation.rms, rotation.max)]
    return tuple(cells)
