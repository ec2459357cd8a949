"""Whether what a result folder holds fits together, before anything is computed with it.

`export.record` has seen to the type of every entry. Here arrays are held against each other: how
many parameters, joints, frames, samples; indices within their arrays; numbers finite where they are
computed with. Compiled loops follow these indices unchecked.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.details import check_details
from bodyschema.errors import InputError
from bodyschema.estimation.discrepancy import Discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.body_check import array_of, check_body, check_variables

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer

Array = NDArray[np.float64]

ASYMMETRY = 1e-9
"""Of an information matrix, in units of its largest entry: it is the sum of J^T J."""


def checked(answer: Answer) -> Answer:
    """The answer, if all of it fits together.

    Args:
        answer: as decoded, without its run.

    Raises:
        InputError: the first thing that does not fit.
    """
    if answer.described is not None:
        check_body(answer.described, "described")
    answer = replace(answer, fit=_estimate(answer.fit))
    n, known = len(answer.fit.x), answer.identifiability
    if n != len(known.open_share) and not (n == 0 == known.open_share.size):
        raise InputError(f"identifiability.open_share has {known.open_share.shape}, expected {n}.")
    array_of(np.ravel(known.open_share), (n,), "identifiability.open_share")
    if answer.n_rows < 0 or any(row < 0 for row in answer.outliers):
        raise InputError("rows are counted from 0.")
    for label, field in answer.fields.items():
        _check_field(field, len(answer.fit.reference.joints), f"fields[{label}]")
    for what in ("nominal_residuals", "residuals"):
        for residual in getattr(answer, what):
            array_of(residual, residual.shape[:2], what)
    if len(answer.compared) not in (0, 2):
        raise InputError("compared names what errors are of, before and after.")
    if len(answer.predicted) != len(answer.predicted_anywhere):
        raise InputError("predicted and predicted_anywhere are of the same pairs of frames.")
    if answer.weighing is not None and not answer.weighing.widening > 0:
        raise InputError(f"weighing widens by {answer.weighing.widening}, expected more than 0.")
    check_details(answer.verb, answer.details)
    return answer


def _estimate(fit: Estimate) -> Estimate:
    """The belief, checked; one without parameters has the shapes of none."""
    check_body(fit.reference, "fit.reference")
    check_variables(fit.variables, fit.reference, "fit.variables")
    n = len(fit.variables.names)
    if n == 0 and fit.data_information.size == 0 == fit.x.size:
        # Earlier versions wrote an array of shape (0, 0) as [].
        return replace(fit, x=np.zeros(0), data_information=np.zeros((0, 0)))
    array_of(fit.x, (n,), "fit.x")
    array_of(fit.data_information, (n, n), "fit.data_information")
    information, largest = fit.data_information, np.abs(fit.data_information).max()
    if not np.abs(information - information.T).max() <= ASYMMETRY * largest:
        raise InputError("fit.data_information is not symmetric.")
    if not (np.diag(information) >= -ASYMMETRY * largest).all():
        raise InputError("fit.data_information has a negative diagonal.")
    if not (np.abs(fit.x) <= 10 * fit.variables.bound).all():
        raise InputError("fit.x lies beyond the bounds of its variables.")
    for key, levels in (("noise", fit.noise), ("model_error", fit.model_error)):
        if not all(np.isfinite(level) and level >= 0 for level in (levels or {}).values()):
            raise InputError(f"fit.{key} must be 0 or more.")
    if not all(level > 0 for one in fit.levels for level in np.ravel(one)):
        raise InputError("fit.levels must be above 0.")
    if not all(freedom > 0 for freedom in fit.freedom):
        raise InputError("fit.freedom must be above 0.")
    return fit


def _check_field(field: Discrepancy, joints: int, where: str) -> None:
    array_of(field.q, (len(field.q), joints), f"{where}.q")
    if field.coefficients.ndim != 2:
        raise InputError(f"{where}.coefficients has the shape {field.coefficients.shape}.")
    array_of(field.coefficients, (len(field.q), field.coefficients.shape[1]), where)
    sizes = [field.length, *field.amplitude, *field.noise]
    if not (np.isfinite(sizes).all() and field.length > 0 and min(sizes) >= 0):
        raise InputError(f"{where}: length, amplitude and noise must be finite and not negative.")
