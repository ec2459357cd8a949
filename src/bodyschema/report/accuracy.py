"""Accuracy before and after, of each sense, and of every model that was tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.answers import calibration as answer
from bodyschema.estimation.held_out import Errors
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.report.units import ABSENT, millimetres, shown, significant


@dataclass(frozen=True)
class Accuracy:
    """Tables of held-out errors."""

    evidence: Evidence
    title: str = "Accuracy before and after"

    def render(self) -> str:
        """See `Section`."""
        c = self.evidence.calibration
        bodies = (
            (c.before, c.nominal),
            (c.after, c.held_out),
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
        evidence = self.evidence
        listed: list[tuple[str, tuple[str, ...]]] = []
        for i, (sense, predicted) in enumerate(
            zip(evidence.senses, evidence.calibration.predicted, strict=True)
        ):
            good, levels = evidence.good[i], evidence.calibration.fit.levels[i]
            bounds = {
                "position": predicted.position_overall,
                "rotation": predicted.rotation_overall,
            }
            for (name, unit, part), level in zip(sense.components, levels, strict=True):
                before, after = (Errors.of(e[good]) for e in evidence.errors(name)[i])
                noise = level * float(np.sqrt(np.mean(np.diag(sense.covariance)[part])))
                listed.append(
                    (
                        evidence.label(sense, name),
                        (
                            shown(before.rms, unit),
                            shown(after.rms, unit),
                            shown(noise, unit),
                            shown(bounds.get(name), unit, 2),
                            _percent(evidence.within[i].get(name)),
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
    cells = [millimetres(v) for v in (position.rms, position.median, position.max)]
    if rotation is not None:
        cells += [significant(np.degrees(v)) for v in (rotation.rms, rotation.max)]
    return tuple(cells)


def _percent(share: float | None) -> str:
    return ABSENT if share is None else f"{100 * share:.0f} %"
