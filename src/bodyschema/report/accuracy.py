"""Accuracy before and after, of each sense, and of every model that was tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.estimation.held_out import Errors
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Candidate, describe_groups
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.units import ABSENT, millimetres, read_as, shown, significant


@dataclass(frozen=True)
class AccuracySection:
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
            heads=_heads(c.held_out),
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

    def _model(self, candidate: Candidate) -> tuple[str, str, str, str, bool]:
        return (
            describe_groups(candidate.groups),
            str(candidate.n_parameters),
            shown(candidate.accuracy.main[2].rms, candidate.accuracy.main[1]),
            f"{candidate.behind:.1f}",
            candidate.groups == self.evidence.calibration.groups,
        )


def _heads(accuracy: Accuracy) -> list[str]:
    """Column titles: three for what the answer speaks of, two for each other component."""
    heads: list[str] = []
    for i, (name, unit) in enumerate(accuracy.errors):
        word = (
            read_as(unit)[1] if name in ("position", "rotation") else f"{name} {read_as(unit)[1]}"
        )
        kinds = ("rms", "median", "largest") if i == 0 else ("rms", "largest")
        heads += [f"{kind} {word}" for kind in kinds]
    return heads


def _cells(accuracy: Accuracy) -> tuple[str, ...]:
    cells: list[str] = []
    for i, ((_, unit), errors) in enumerate(accuracy.errors.items()):
        values = (errors.rms, errors.median, errors.max) if i == 0 else (errors.rms, errors.max)
        scale = read_as(unit)[0]
        write = (
            millimetres if unit == "m" else lambda value, scale=scale: significant(scale * value)
        )
        cells += [write(value) for value in values]
    return tuple(cells)


def _percent(share: float | None) -> str:
    return ABSENT if share is None else f"{100 * share:.0f} %"
