"""calibration.yaml: everything that a calibration found, for people and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bodyschema.export.documents import rounded, versions, yaml_text
from bodyschema.export.load_entry import load_entries
from bodyschema.export.static_transforms import place_entries
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration, Candidate
from bodyschema.judging.places import OPEN
from bodyschema.judging.settled import settled

HEADING = """\
What a calibration found, written by bodyschema.
transforms: the frames that were asked for; std and 95 % with all that may be wrong with the robot;
not_determined says what a place goes along with, determined_in where it is known nevertheless.
offsets: the true joint value is its reading plus the offset (rad; m for prismatic joints).
skeleton: of a robot that nobody had measured, axis and link (m) of each joint in its parent, with
the axis' standard deviation (rad); null where a model was corrected.
held_out: errors on samples that the fit had not seen, before and after, which are what "compared"
says.
predicted: errors of the corrected body stay below this with 95 %, where seen and anywhere;
agreement is the share of held-out positions within their bounds, noise included.
parameters: deviations from the model, of a frame that nobody measured from its first guess (where
it came to be is under transforms); std is null where the data do not determine the value;
combined_with names the parameters that it cannot be told apart from. written is what the files
have, zero for what is not determined or unchanged within its error; written_std is its error
where all of these are as modelled."""


def calibration_text(calibration: Calibration, notes: Sequence[str] = ()) -> str:
    """calibration.yaml; see `calibration_document`."""
    return yaml_text(calibration_document(calibration, notes), HEADING)


def calibration_document(calibration: Calibration, notes: Sequence[str] = ()) -> dict[str, Any]:
    """The answer of `calibrate` in plain values, in a fixed order.

    Args:
        calibration: the answer.
        notes: sentences on what was done with it.
    """
    body = settled(calibration).body
    document: dict[str, Any] = {
        "robot": body.name,
        "transforms": place_entries(calibration),
        "verdict": calibration.verdict,
        "explanation": calibration.explanation,
        "trust": calibration.trust.document,
        "tone": calibration.tone,
        "predicted_95_mm": millimetres_95(calibration),
        "wanted": [list(pair) for pair in calibration.wanted],
        "uncertainty": uncertainty(calibration),
        "notes": [*calibration.notes, *notes],
        "findings": list(calibration.findings),
        "learner": calibration.learner,
        "groups": list(calibration.groups),
        "skeleton": skeleton_entries(calibration),
        "compared": [calibration.before, calibration.after],
        "held_out": {
            "before": _accuracy(calibration.nominal),
            "after": _accuracy(calibration.held_out),
            "after_with_residual_field": _accuracy(calibration.with_field),
        },
        "predicted": predicted_errors(calibration),
        "agreement": rounded(calibration.agreement),
        "offsets": {j: rounded(o) for j, o in zip(body.joints, body.offset, strict=True)},
        "gears": {j: rounded(g) for j, g in zip(body.joints, body.gear, strict=True) if g},
        "loads": calibration.details.get("loads") or load_entries(calibration.estimate),
        "parameters": _parameters(calibration),
        "not_determined": list(calibration.identifiability.sentences),
        "models": [_candidate(candidate) for candidate in calibration.candidates],
        "rows": calibration.n_rows,
        "outlier_rows": list(calibration.outliers),
        "late_rows": list(calibration.clock.late_rows),
        "clock_p_value": rounded(calibration.clock.p_value),
        "instead_of_late": calibration.clock.instead,
        "noise": {
            name: rounded(level) for name, level in (calibration.estimate.noise or {}).items()
        },
        "converged": calibration.fit.converged,
        "details": {k: v for k, v in calibration.details.items() if k not in ("loads", "notes")},
        "versions": versions(),
    }
    return document


def skeleton_entries(calibration: Calibration) -> dict[str, dict[str, Any]] | None:
    """Axis and link of each joint of a skeleton that was learned; None for a corrected model."""
    if not calibration.from_nothing:
        return None
    body, estimate = calibration.body, calibration.estimate
    std = dict(zip(estimate.variables.names, estimate.std, strict=True))
    return {
        carrier: {
            "parent": body.frames[body.parent[k]],
            "axis": [rounded(float(a)) for a in body.axis[k]],
            "axis_std": rounded(
                float(np.hypot(std[f"{carrier}.axis_1"], std[f"{carrier}.axis_2"]))
            ),
            "link": [rounded(float(c)) for c in body.placement[k, :3, 3]],
        }
        for k, carrier in enumerate(body.carriers)
        if f"{carrier}.axis_1" in std
    }


def millimetres_95(calibration: Calibration) -> float | None:
    """The error that what was asked for stays below with 95 %, mm; None where none is stated."""
    stated = calibration.stated_95
    return None if stated is None else rounded(1e3 * stated)


def uncertainty(calibration: Calibration) -> dict[str, Any] | None:
    """The stated 95 % and what it is made of, mm; None where nothing was weighed."""
    weighing = calibration.weighing
    if weighing is None:
        return None
    noise, common, total = (1e3 * v for v in (weighing.stated, weighing.core, weighing.total))
    causes = [
        {key: rounded(value) if isinstance(value, float) else value for key, value in c.items()}
        for c in weighing.causes
    ]
    return {
        "noise_mm_95": rounded(noise),
        "with_common_errors_mm_95": rounded(common),
        "total_mm_95": rounded(total),
        "causes": causes,
    }


def predicted_errors(calibration: Calibration) -> list[dict[str, Any]]:
    """Predicted 95 % errors of what each sense looks at, where it was seen and anywhere."""
    pairs = zip(calibration.predicted, calibration.predicted_anywhere, strict=True)
    return [
        {
            "seen": seen.seen,
            "seen_from": seen.seen_from,
            "position_mm_95": rounded(1e3 * seen.position_overall),
            "rotation_deg_95": rounded(float(np.degrees(seen.rotation_overall))),
            "anywhere_position_mm_95": rounded(1e3 * anywhere.position_overall),
            "anywhere_rotation_deg_95": rounded(float(np.degrees(anywhere.rotation_overall))),
        }
        for seen, anywhere in pairs
    ]


def _parameters(calibration: Calibration) -> list[dict[str, Any]]:
    estimate, known = calibration.estimate, calibration.identifiability
    variables = estimate.variables
    if not len(variables):
        return []
    std, shares, kept = estimate.std, known.open_share, settled(calibration)
    listed = []
    for i, name in enumerate(variables.names):
        determined = bool(shares[i] <= OPEN)
        listed.append(
            {
                "name": name,
                "value": rounded(float(estimate.x[i])),
                "std": rounded(float(std[i])) if determined else None,
                "written": rounded(float(kept.x[i])),
                "written_std": rounded(float(kept.std[i])) if kept.changed[i] else None,
                "unit": variables.units[i],
                "prior_std": rounded(float(variables.prior_std[i])),
                "group": variables.groups[i],
                "identifiable": determined,
                "combined_with": list(known.partners(name)),
            }
        )
    return listed


def _accuracy(accuracy: Accuracy) -> dict[str, Any]:
    seen = {
        name: {k: rounded(v) for k, v in errors.items()}
        for name, errors in accuracy.document().items()
    }
    return {"rotation_deg": None, **seen} if "position_mm" in seen else seen


def _candidate(candidate: Candidate) -> dict[str, Any]:
    return {
        "groups": list(candidate.groups),
        "n_parameters": candidate.n_parameters,
        "score": rounded(candidate.score),
        "behind_best": rounded(candidate.behind),
        "rms": {k: rounded(v["rms"]) for k, v in candidate.accuracy.document().items()},
    }
